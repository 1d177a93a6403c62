"""The JSON schema of scene files."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from ...components.core.store import replaced
from .common import app
from .completion import scene_files
from .schema_file import place_of


@app.command()
def schema(
    files: Annotated[
        list[Path] | None,
        typer.Argument(
            metavar="SCENE.toml...",
            autocompletion=scene_files,
            help=(
                "Scene files that are to be completed: the schema goes where their first line names it; without such a line beside them, "
                "and the line is added."
            ),
        ),
    ] = None,
    output: Annotated[Path | None, typer.Option("-o", "--output", help="File to write instead of printing it.")] = None,
) -> None:
    """The JSON schema of scene files, with which editors complete and check them. Example: cosimo schema my-scene.toml

    It is that of this version, with all components and their parameters: write it anew after an update.
    """
    from ..systems.scene_schema import scene_schema

    places = dict.fromkeys([*map(place_of, files or ()), *([output] if output else [])])
    text = json.dumps(scene_schema(), indent=1)
    if not places:
        print(text)
    for place in places:
        with replaced(place) as file:
            file.write(text + "\n")
        print(f"wrote {place}")
