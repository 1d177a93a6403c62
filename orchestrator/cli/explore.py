"""A scene as a page to play with."""

from __future__ import annotations

import webbrowser
from functools import partial
from pathlib import Path
from typing import Annotated

from typer import Option

from ...components.core.errors import BadInput
from .common import app, print_written, scene_of, status_spinner
from .options import Changes, Presets, SceneName, refuse


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
    serve: Annotated[
        bool, Option("--serve", help="Run the scene in a local process and show it in the browser. Default for scenes with FMUs.")
    ] = False,
    port: Annotated[int, Option(min=0, max=65535, help="With --serve: port of 127.0.0.1. Default: a free one.")] = 0,
    browser: Annotated[bool, Option("--browser/--no-browser", help="With --serve: open the browser.")] = True,
    values: Changes = None,
    presets: Presets = None,
) -> None:
    """Write a page that computes a scene. Example: cosimo explore en50318-2002 -o page.html

    One file, which needs no server and no network: sliders, effects, macro step; curves, figures with their errors, ranges.
    WebAssembly cannot run FMUs and units in Python: cosimo explore model.fmu holds the scene in a local process, and its page has
    inputs that move during the run, start values, curves, files and numerical errors. Needs the extra `serve`.
    """
    loaded = scene_of(scene, values, presets)
    foreign = any(kind.foreign for kind in loaded.kinds.values())
    if serve or (foreign and output is None):
        from ..harness.served import serve as serve_scene

        refuse({"--output": output, "--vary": vary, "--effects": effects}, "no effect with --serve", "Leave it out.")
        serve_scene(loaded, port, partial(_open, browser=browser))
        return
    refuse({"--port": port or None, "--no-browser": not browser}, "no effect without --serve")
    from ..systems import explore_page

    path = output or Path(f"{loaded.name}.html")
    with status_spinner("building the page") as say:
        explore_page(loaded, path, parameters=dict(map(_range, vary or ())) or None, effects=effects, say=say)
    print_written([path])


def _open(address: str, browser: bool) -> None:
    print(f"{address} shows the scene; Ctrl-C ends it", flush=True)
    if browser:
        webbrowser.open(address)


def _range(text: str) -> tuple[str, tuple[float, float] | None]:
    name, equals, ends = (part.strip() for part in text.partition("="))
    if not equals:
        return name, None
    try:
        low, high = map(float, ends.split(":"))
    except ValueError:
        raise BadInput("--vary", repr(text), "unit.parameter or unit.parameter=from:to") from None
    return name, (low, high)
