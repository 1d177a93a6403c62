"""Reports in the browser."""

from __future__ import annotations

import webbrowser
from pathlib import Path
from typing import Annotated

from typer import Argument

from ...components.core.errors import BadInput
from .common import app


@app.command("open")
def open_(where: Annotated[Path, Argument(help="Directory with a report, or the report file.")] = Path()) -> None:
    """Open a report in the browser. Example: cosimo open out"""
    from ..scene.file_kinds import refuse_other

    refuse_other(where, "result", "report", "folder")
    page = where / "report.html" if where.is_dir() else where
    if page.suffix != ".html" or not page.is_file():
        raise BadInput("open", repr(str(where)), "a directory with a report.html, or the path of one", "Give a run -o DIR.")
    if not webbrowser.open(page.resolve().as_uri()):
        print(f"no browser starts here; the report is {page.resolve()}")
