"""Scenes packed for other tools."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from .common import Changes, app, change, warn


@app.command()
def ssp(
    scene: Annotated[str, typer.Argument(help="name of a shipped scene, or a scene file")],
    output: Annotated[Path | None, typer.Option("-o", "--output", help="File to write; default: the scene's name.")] = None,
    values: Changes = None,
) -> None:
    """Pack a scene with its FMUs for other tools (SSP 1.0). Example: cosimo ssp en50318-2002 -o en50318-2002.ssp"""
    from ..scene.ssp.write import write
    from ..systems import load_scene

    loaded = load_scene(scene)
    if values:
        loaded = loaded.with_changes(dict(change(loaded, value) for value in values))
    warn(loaded.remarks)
    print(f"wrote {write(loaded, output or Path(f'{loaded.name}.ssp'))}")
