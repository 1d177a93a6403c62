"""What a file or folder of a project is, by its content, and the commands that read it: for whoever gave it to another command."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ...components.core.errors import BadInput
from ...components.core.files import read_bytes
from ..loading import MOST_TOML

FILE_KINDS = {  # kind -> what it is, and what reads it
    "scene": ("a scene", "cosimo run FILE"),
    "line": ("the table of a line", "cosimo railway line FILE or cosimo new scene --line FILE"),
    "case": ("a validation case", "cosimo validate FILE"),
    "table": ("a table of limits", "cosimo run SCENE --limits FILE"),
    "plan": ("a plan of runs", "cosimo sweep SCENE --plan FILE"),
    "fit": ("the settings of a fit", "cosimo fit SCENE --plan FILE"),
    "design": ("the settings of a design", "cosimo design SCENE --plan FILE"),
    "FMU": ("an FMU", "cosimo run FILE or cosimo check FILE"),
    "SSP": ("an SSP system", "cosimo run FILE"),
    "OSP": ("a system structure of Open Simulation Platform", "cosimo run FILE"),
    "CSV": ("a CSV table", "the file or option that names it, such as cosimo new line, --droppers or file = of a curve"),
    "result": ("the results of a run", "cosimo compare DIR or cosimo open DIR"),
    "report": ("the results of a study", "cosimo open DIR"),
    "page": ("a page to read", "a browser"),
    "folder": ("a folder", ""),
}
SUFFIXES = {".fmu": "FMU", ".ssp": "SSP", ".ssd": "SSP", ".xml": "OSP", ".csv": "CSV", ".html": "page", ".pdf": "page"}
KEYS = {  # kind of a TOML file -> keys of which one shows it; the first kind that fits counts
    "scene": ("units",),
    "line": ("sections",),
    "case": ("scene",),
    "design": ("minimise", "maximise"),
    "fit": ("curves", "spectra", "targets", "runs"),
    "plan": ("vary", "method", "table"),
    "table": ("sources", "rows"),
}


def file_kind(path: Path) -> str:
    """A key of `FILE_KINDS`; "" for what is not recognised."""
    if path.is_dir():
        return "result" if (path / "run.json").exists() else "report" if (path / "report.html").exists() else "folder"
    if path.suffix.lower() in SUFFIXES and path.is_file():
        return SUFFIXES[path.suffix.lower()]
    try:
        return kind_of_data(tomllib.loads(read_bytes(path, "file", MOST_TOML).decode("utf-8-sig")))
    except ValueError:  # no file, none in TOML or UTF-8
        return ""


def kind_of_data(data: Mapping[str, Any]) -> str:
    """The same of the data of a TOML file."""
    return next((kind for kind, keys in KEYS.items() if any(key in data for key in keys)), "")


def refuse_other(path: str | Path, *wanted: str) -> None:
    """Raises `BadInput` for a file or folder that is recognised, and is none of the kinds `wanted`."""
    refuse_kind(path, file_kind(Path(path)), *wanted)


def refuse_kind(path: str | Path, kind: str, *wanted: str) -> None:
    """Raises `BadInput` for what is of a kind, and of none of those `wanted`."""
    if kind and kind not in wanted:
        text, commands = FILE_KINDS[kind]
        expected = " or ".join(FILE_KINDS[each][0] for each in wanted)
        raise BadInput(str(path), text, expected, f"It belongs to {commands}." if commands else "")
