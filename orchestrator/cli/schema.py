"""The JSON schema of scene files."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from ...components.core.errors import BadInput
from ...fmus.files import replaced
from .common import app
from .completion import scene_files

LINE = "#:schema"  # the first line of a scene, as Taplo and Even Better TOML read it
NAME = "scene.schema.json"


@app.command()
def schema(
    files: Annotated[list[Path] | None, typer.Argument(metavar="SCENE.toml...", autocompletion=scene_files, help=(
        "Scene files that are to be completed: the schema goes where their first line names it; without such a line beside them, "
        "and the line is added."))] = None,
    output: Annotated[Path | None, typer.Option("-o", "--output", help="File to write instead of printing it.")] = None,
) -> None:
    """The JSON schema of scene files, with which editors complete and check them. Example: cosimo schema my-scene.toml

    It is that of this version, with all components and their parameters: write it anew after an update.
    """
    from ..systems.scene_schema import scene_schema

    places = dict.fromkeys([*map(_place, files or ()), *([output] if output else [])])
    text = json.dumps(scene_schema(), indent=1)
    if not places:
        print(text)
    for place in places:
        with replaced(place) as file:
            file.write(text + "\n")
        print(f"wrote {place}")


def _place(scene: Path) -> Path:
    """Where an editor looks for the schema of a scene file, which gets the line that says so if it has none."""
    if scene.suffix != ".toml" or not scene.is_file():
        raise BadInput("schema", repr(str(scene)), "a scene file, .toml")
    try:
        content = scene.read_bytes().decode("utf-8")
    except UnicodeDecodeError:
        raise BadInput("schema", repr(str(scene)), "a text in UTF-8") from None
    first = content.partition("\n")[0].strip().removeprefix("\ufeff")
    if not first.startswith(LINE):
        with replaced(scene, "wb") as file:
            file.write(f"{LINE} {NAME}\n{content.removeprefix(chr(0xFEFF))}".encode())
        return scene.with_name(NAME)
    name = first.removeprefix(LINE).strip()
    if "://" in name or not name:
        raise BadInput("schema", f"{scene}: first line {first!r}", "the path of a file", f"Such as {LINE} {NAME}")
    return scene.parent / name
