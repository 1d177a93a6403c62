"""The pictures of README and documentation: `python docs/pictures/make.py [NAME...]` runs commands and photographs their pages.

It needs a Chromium, and takes some minutes for all of them.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
PAGES = {  # picture -> command, what it writes and where its page is, height in pixels
    "report": (("run", "en50318-2002", "--in-process"), "", "report.html", 900),
    "accuracy": (("accuracy", "en50318-2002", "--budget", "200"), "", "report.html", 960),
    "stability": (("stability", "mass-on-spring", "--algorithm", "jacobi,gauss-seidel"), "", "report.html", 1000),
    "effects": (("effects", "wind-pump-start", "--tolerance", "5%"), "", "report.html", 1160),
    "explore": (("explore", "en50318-2002", "--effects", "catenary.dropper_slackening"), "page.html", "page.html", 1350),
}


def photograph(page: Path, picture: Path, height: int) -> None:
    """The first `height` pixels of a page, 1300 wide, as PNG."""
    browser = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
    if browser is None:
        raise SystemExit("make.py: no Chromium found; expected chromium, chromium-browser or google-chrome on the path")
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


def main(names: list[str]) -> None:
    """Make the named pictures, or all."""
    with tempfile.TemporaryDirectory() as folder:
        for name in names or PAGES:
            command, written, page, height = PAGES[name]
            out = Path(folder) / name
            subprocess.run(["cosimo", *command, "-o", str(out / written)], check=True)
            photograph(out / page, HERE / f"{name}.png", height)


if __name__ == "__main__":
    main(sys.argv[1:])
