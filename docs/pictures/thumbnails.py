"""The pictures of the gallery, docs/pictures/scenes/NAME.png: `python docs/pictures/thumbnails.py [SCENE...]`.

Runs the scenes, all of them without a name, and photographs the first figure of each report. It needs playwright, Pillow and a
Chromium, and takes some minutes for all scenes; the pictures are kept, so that the site is built without them.
"""

from __future__ import annotations

import io
import shutil
import sys
import tempfile
from pathlib import Path

from cosimo import load_scene, run, write_report
from cosimo.orchestrator.scene.scene import scene_files
from PIL import Image
from playwright.sync_api import Page, sync_playwright

FOLDER = Path(__file__).resolve().parent / "scenes"
SIZE = (480, 300)  # pixels of a picture
COLOURS = 48


def first_figure(page: Page, report: Path) -> Image.Image:
    """The first figure of a report, without its bar of buttons."""
    page.goto(report.as_uri())
    page.wait_for_selector(".plot .main-svg")
    page.add_style_tag(content=".modebar-container { display: none !important; }")
    return Image.open(io.BytesIO(page.locator(".plot").first.screenshot()))


def fitted(picture: Image.Image) -> Image.Image:
    """At most SIZE, its upper part where it is tall, with few colours."""
    scale = SIZE[0] / picture.width
    small = picture.convert("RGB").resize((SIZE[0], round(picture.height * scale)), Image.Resampling.LANCZOS)
    return small.crop((0, 0, SIZE[0], min(small.height, SIZE[1]))).quantize(COLOURS)


def main(names: list[str]) -> None:
    """Make the pictures of the named scenes, or of all."""
    FOLDER.mkdir(exist_ok=True)
    browser = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
    with sync_playwright() as playwright, tempfile.TemporaryDirectory() as folder:
        page = playwright.chromium.launch(executable_path=browser, args=["--no-sandbox"]).new_page(
            viewport={"width": 760, "height": 900}, color_scheme="light"
        )
        for name in names or scene_files():
            report = write_report(run(load_scene(name), in_process=True), Path(folder) / name)
            fitted(first_figure(page, report)).save(FOLDER / f"{name}.png", optimize=True)
            print(name, flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
