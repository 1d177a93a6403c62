"""The JSON schema of scene files."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from .common import app


@app.command()
def schema(
    output: Annotated[Path | None, typer.Option("-o", "--output", help="File to write instead of printing it.")] = None,
) -> None:
    """The JSON schema of scene files, with which editors complete and check them. Example: cosimo schema -o scene.schema.json

    A scene names it in its first line: #:schema scene.schema.json
    """
    from ..systems.scene_schema import scene_schema

    text = json.dumps(scene_schema(), indent=1)
    if output is None:
        print(text)
        return
    output.write_text(text + "\n", encoding="utf-8")
    print(f"wrote {output}")
