"""What a component or a scene consists of, as text."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any

from typer import Argument, Option

from ...components.core.errors import BadInput, nearest, visible_lines
from ..output import ensure_directory
from .common import app, print_table, print_written, status_spinner
from .completion import anything
from .options import AsJson, Changes, Presets, parameters_of
from .railway import show_line

HEADINGS = {"is": "causality", "text": "description", "as in": "value from", "times": "factor", "plus": "offset"}  # of keys
FILES = (".toml", ".ssd", ".ssp", ".xml", ".fmu")


@app.command()
def show(
    name: Annotated[
        str,
        Argument(
            autocompletion=anything,
            help="Component, module:Class, shipped scene or case, scene file, FMU, or table of an overhead line.",
        ),
    ],
    effects: Annotated[
        list[str] | None,
        Option(
            metavar="EFFECT[,...]", help="Effects to switch on; unit.effect for a scene, in addition to its own. May be repeated."
        ),
    ] = None,
    values: Changes = None,
    presets: Presets = None,
    timed: Annotated[
        bool,
        Option(
            "--time", help="Measure the time that each effect adds to a step of a component. Compiling takes seconds per effect."
        ),
    ] = False,
    output: Annotated[Path | None, Option("-o", "--output", help="Directory for an SVG drawing.")] = None,
    as_json: AsJson = False,
) -> None:
    """Show the parts of a component, a scene or a case. Example: cosimo show Pantograph"""
    from ...components.catalogue import CATALOGUE
    from ..scene.file_kinds import file_kind, refuse_other
    from ..scene.scene import scene_files
    from ..systems import cases
    from ..systems.railway.line import read as read_line
    from . import show_parts

    component = name in CATALOGUE or (":" in name and not name.endswith(FILES))
    if not component and name not in scene_files() and (Path(name).suffix or (Path(name).is_dir() and name not in cases())):
        refuse_other(name, "scene", "line", "FMU", "SSP", "OSP")
    scene = not component and (name in scene_files() or name.endswith(FILES))
    for option, given, possible in (("--preset", presets, component or scene), ("--time", timed, component)):
        if given and not possible:
            raise BadInput("show", f"{option} with {name!r}", "a component", "It would have no effect.")
    if name.endswith(".toml") and file_kind(Path(name)) == "line":
        if output is not None:
            raise BadInput("show", "-o with the table of a line", "no directory", "cosimo railway has its drawing.")
        show_line(*read_line(Path(name), parameters_of(values)))
        return
    with status_spinner("initializing, which compiles kernels where the cache has none"):
        drawing = None
        if component:
            shown, drawing = show_parts.of_component(name, effects, values, presets, timed)
        elif scene:
            shown, drawing = show_parts.of_scene(name, effects, values, presets)
        elif name in cases():
            shown = {"title": f"{name}: {cases()[name].title}", "text": cases()[name].text}
        else:
            raise BadInput(
                "show", repr(name), "a component, a scene or a case", nearest(name, [*CATALOGUE, *scene_files(), *cases()])
            )
    if not component and name in cases():
        shown["reference"] = show_parts.reference_rows(name)
    if output is not None:
        if drawing is None:
            raise BadInput("show", "-o with a case", "a component or a scene, which have a drawing")
        path = drawing.save(ensure_directory(output) / f"{name.rpartition(':')[2].rpartition('/')[2].partition('.')[0]}.svg")
    if as_json:
        print(json.dumps(shown, indent=2))
        return
    print(*(visible_lines(shown[key]) for key in ("title", "text") if key == "title" or shown.get(key)), sep="\n\n", end="\n\n")
    for title, rows in shown.items():
        if isinstance(rows, list) and rows and isinstance(rows[0], dict):
            print_table(
                title.replace("_", " "),
                [HEADINGS.get(str(key), str(key)) for key in rows[0]],
                [tuple(map(_cell, row.values())) for row in rows],
            )
    print(*(f"{key}: {_cell(shown[key])}" for key in ("states", "step") if shown.get(key) is not None), sep="\n")
    if output is not None:
        print_written([path])


def _cell(value: Any) -> Any:
    """A value of a table; a list as its items, and what a component has not as nothing."""
    if isinstance(value, list):
        return ", ".join(f"{v:g}" if isinstance(v, float) else str(v) for v in value)
    return {None: "", True: "yes", False: ""}.get(value, value) if isinstance(value, bool | None) else value
