"""A scene as a page to play with."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from typer import Option

from ...components.core.errors import BadInput
from .common import app, print_written, scene_of, status_spinner
from .options import Changes, Presets, SceneName


@app.command()
def explore(
    scene: SceneName,
    output: Annotated[
        Path | None, Option("-o", "--output", help="File for the page. Default: the scene's name with .html.")
    ] = None,
    vary: Annotated[
        list[str] | None,
        Option(
            metavar="UNIT.PARAMETER[=FROM:TO]",
            help="Parameter with a slider, and its range. May be repeated. Default: [explore], else the "
            "parameters that change the key results most.",
        ),
    ] = None,
    effects: Annotated[
        list[str] | None,
        Option(
            "--effects",
            metavar="UNIT.EFFECT",
            help="Effect with a switch. May be repeated, at most 3. Default: [explore], else the effects without which the scene runs.",
        ),
    ] = None,
    values: Changes = None,
    presets: Presets = None,
) -> None:
    """Write a page that computes a scene. Example: cosimo explore en50318-2002 -o page.html

    One file, which needs no server and no network: sliders, effects, macro step; curves, figures with their errors, ranges.
    """
    from ..systems import explore_page

    loaded = scene_of(scene, values, presets)
    path = output or Path(f"{loaded.name}.html")
    with status_spinner("building the page") as say:
        explore_page(loaded, path, parameters=dict(map(_range, vary or ())) or None, effects=effects, say=say)
    print_written([path])


def _range(text: str) -> tuple[str, tuple[float, float] | None]:
    name, equals, ends = (part.strip() for part in text.partition("="))
    if not equals:
        return name, None
    try:
        low, high = map(float, ends.split(":"))
    except ValueError:
        raise BadInput("--vary", repr(text), "unit.parameter or unit.parameter=from:to") from None
    return name, (low, high)
