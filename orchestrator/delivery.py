"""How reports are delivered: with the library that draws their figures inside, beside or from a network; as a PDF, too."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from ..components.core.errors import BadInput

PAPERS = ("A4", "Letter")
PLACES = ("inside", "beside", "cdn")  # of the library
PROGRAMS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome", "msedge", "microsoft-edge")
INSTALLED = (  # where they are on systems that do not name them to a shell
    "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
    "/Applications/Chromium.app/Contents/MacOS/Chromium",
    "C:/Program Files/Google/Chrome/Application/chrome.exe",
    "C:/Program Files (x86)/Microsoft/Edge/Application/msedge.exe",
)
PATIENCE = 120.0  # s for a browser to print a page
PRINTED = "#print"  # behind the address of a page: all figures are drawn at once


@dataclass(frozen=True)
class Delivery:
    """plotly: where a report has the library of its figures.  browser: the program that prints a PDF of it; "" for none.

    paper: the sheet of its print.  si: whether readers see declared units, see `harness.preferred_units`.
    """

    plotly: str = "inside"
    browser: str = ""
    paper: str = "A4"
    si: bool = False


def usual_paper() -> str:
    """Letter where the locale is of the United States or Canada, A4 elsewhere."""
    name = next((os.environ[key] for key in ("LC_ALL", "LC_PAPER", "LANG") if os.environ.get(key)), "")
    return "Letter" if name.partition(".")[0].endswith(("_US", "_CA")) else "A4"


_ALONE = Delivery(paper=usual_paper())
DELIVERY: ContextVar[Delivery] = ContextVar("delivery", default=_ALONE)


@contextmanager
def delivered(plotly: str = "inside", pdf: bool = False, paper: str = "", si: bool = False) -> Iterator[None]:
    """Within the context reports are delivered so; raises `BadInput` for a PDF where there is no browser to print it.

    paper: one of `PAPERS`; "" for the usual one of the locale.
    """
    if paper not in ("", *PAPERS):
        raise BadInput("--paper", repr(paper), "one of " + ", ".join(PAPERS))
    token = DELIVERY.set(Delivery(plotly, browser() if pdf else "", paper or usual_paper(), si))
    try:
        yield
    finally:
        DELIVERY.reset(token)


def browser() -> str:
    """The path of a Chromium, Chrome or Edge; raises `BadInput` where there is none."""
    paths = [*map(shutil.which, PROGRAMS), *(path for path in INSTALLED if Path(path).is_file())]
    for path in filter(None, paths):
        return path
    raise BadInput(
        "--pdf", "no browser to print it", "Chromium, Chrome or Edge on the PATH", "Or print report.html from any browser."
    )


def print_pdf(page: Path, program: str) -> Path:
    """Print a page to a PDF beside it; raises `BadInput` where the browser does not."""
    path = page.with_suffix(".pdf")
    path.unlink(missing_ok=True)
    with TemporaryDirectory() as profile:
        command = [program, "--headless", "--disable-gpu", "--no-pdf-header-footer", f"--user-data-dir={profile}"]
        command += ["--virtual-time-budget=30000", f"--print-to-pdf={path.resolve()}"]
        if sys.platform == "linux" and os.geteuid() == 0:  # its sandbox refuses this user
            command.append("--no-sandbox")
        try:
            end = subprocess.run(
                [*command, page.resolve().as_uri() + PRINTED], capture_output=True, timeout=PATIENCE, check=False
            )
            reason = end.stderr.decode(errors="replace").strip().splitlines()[-1:] if end.returncode else []
        except (OSError, subprocess.TimeoutExpired) as error:
            reason = [str(error)]
    if reason or not path.is_file():
        raise BadInput("--pdf", f"{program} did not print {page}", "a browser that prints", " ".join(reason))
    return path
