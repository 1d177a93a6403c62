"""The pictures of README and documentation: `python docs/pictures/make.py [NAME...]` runs commands and photographs their pages.

It needs a Chromium, and takes some minutes for all of them.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

HERE = Path(__file__).resolve().parent
PAGES = {  # picture -> command, what it writes and where its page is, height in pixels
    "report": (("run", "en50318-2002", "--in-process"), "", "report.html", 900),
    "accuracy": (("accuracy", "en50318-2002", "--budget", "200"), "", "report.html", 960),
    "stability": (("stability", "mass-on-spring", "--algorithm", "jacobi,gauss-seidel"), "", "report.html", 1000),
    "effects": (("effects", "wind-pump-start", "--tolerance", "5%"), "", "report.html", 1160),
}
# picture -> scene, what is done in its page (selector, and what is chosen there; "" is a click), what of the page is shown
IN_USE = {
    "explore": ("en50318-2002", (), ""),  # its beginning
    "explore-slope": ("en50318-2002", (("[id='s-pantograph.static_force']", ""),), ""),
    "explore-minimum": ("en50318-2002", (("#figure", "actual minimum"), ("#scanned", "uplift force of the drive")), "#moves"),
    "explore-slackening": ("en50318-2002", (("#pin", ""), ("[id='e-catenary.dropper_slackening']", "")), "#answers"),
    "explore-step": ("en50318-2002", (), "#costs"),
    "explore-motion": ("rov-station-keeping", (), "#motion0"),
    "explore-chaos": ("ball-bearing-clearance", (), "#moves"),
}


def photograph(page: Path, picture: Path, height: int) -> None:
    """The first `height` pixels of a page, 1300 wide, as PNG."""
    browser = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
    if browser is None:
        raise SystemExit("make.py: no Chromium found, expected chromium, chromium-browser or google-chrome on the path")
    with tempfile.TemporaryDirectory() as profile:
        subprocess.run(
            [
                browser,
                "--headless",
                "--no-sandbox",
                "--disable-gpu",
                "--no-first-run",
                "--hide-scrollbars",
                f"--user-data-dir={profile}",
                f"--screenshot={picture}",
                f"--window-size=1300,{height}",
                "--virtual-time-budget=10000",
                page.as_uri(),
            ],
            check=True,
            stderr=subprocess.DEVNULL,
        )


def photograph_in_use(page: Path, picture: Path, actions: Sequence[tuple[str, str]], shown: str) -> None:
    """A part of a page in which something was done, 1300 wide, as PNG."""
    from playwright.sync_api import sync_playwright

    path = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
    with sync_playwright() as playwright, playwright.chromium.launch(executable_path=path, args=["--no-sandbox"]) as browser:
        tab = browser.new_page(viewport={"width": 1300, "height": 3000})
        tab.goto(page.as_uri())
        for selector, choice in (*actions, ("", "")):
            tab.wait_for_function("Number(document.getElementById('results').dataset.scanned) === question", timeout=120_000)
            if choice:
                tab.select_option(selector, label=choice)
            elif selector:
                tab.click(selector)
        tab.wait_for_timeout(1000)
        if shown:
            tab.locator(shown).screenshot(path=picture)
        else:
            tab.screenshot(path=picture, clip={"x": 0, "y": 0, "width": 1300, "height": 1350})


def main(names: list[str]) -> None:
    """Make the named pictures, or all."""
    with tempfile.TemporaryDirectory() as folder:
        for name in names or (*PAGES, *IN_USE):
            out = Path(folder) / name
            if name in PAGES:
                command, written, page, height = PAGES[name]
                subprocess.run(["cosimo", *command, "-o", str(out / written)], check=True)
                photograph(out / page, HERE / f"{name}.png", height)
            else:
                scene, actions, shown = IN_USE[name]
                subprocess.run(["cosimo", "explore", scene, "-o", str(out / "page.html")], check=True)
                photograph_in_use(out / "page.html", HERE / f"{name}.png", actions, shown)


if __name__ == "__main__":
    main(sys.argv[1:])
