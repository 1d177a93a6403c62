"""What a component or a scene consists of, as text."""

from __future__ import annotations

import inspect
import json
import sys
from collections.abc import Mapping
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ...components.core.errors import BadInput, StepFailed, nearest
from .common import FAILED_RUN, AsJson, Changes, app, change, listed, parameters_of, print_table, status_spinner, switched_on

if TYPE_CHECKING:
    from ...components.core.component import Component
    from ...components.core.variables import Variable

STEPPED = "compiled loop, units called by address"


@app.command()
def show(
    name: Annotated[str, typer.Argument(help=(
        "a component, module:Class, the name of a shipped scene, a scene file, or the table of an overhead line"))],
    effects: Annotated[list[str] | None, typer.Option("--effects", metavar="EFFECT[,...]", help=(
        "Effects that are on; of a scene unit.effect, beside its own. May be repeated."))] = None,
    values: Changes = None,
    as_json: AsJson = False,
) -> None:
    """What a component or a scene consists of, and whether Python is in its steps. Example: cosimo show Pantograph"""
    from ...components.catalogue import CATALOGUE
    from ..scene.scene import scene_files
    from ..systems.railway.line import is_line

    if name.endswith(".toml") and is_line(Path(name)):
        from .railway import show_line

        show_line(Path(name), parameters_of(values or []))
        return
    with status_spinner() as progress:
        progress("initializing, which compiles kernels where the cache has none")
        if name in CATALOGUE or ":" in name:
            shown = _component(name, listed("--effects", effects) if effects else [], parameters_of(values or []))
        elif name in scene_files() or name.endswith((".toml", ".ssd", ".ssp")):
            shown = _scene(name, effects or [], values or [])
        else:
            raise BadInput("show", repr(name), "a component or a scene", nearest(name, [*CATALOGUE, *scene_files()]))
    if as_json:
        print(json.dumps(shown, indent=2))
        return
    print(shown["title"], *([shown["text"]] if "text" in shown else []), sep="\n\n", end="\n\n")
    for title, rows in shown.items():
        if isinstance(rows, list) and rows and isinstance(rows[0], dict):
            print_table(title.replace("_", " "), tuple(rows[0]), [tuple(map(_cell, row.values())) for row in rows])
    print(f"step: {shown['step']}")


def _component(name: str, effects: list[str], parameters: Mapping[str, Any]) -> dict[str, Any]:
    from ...components.catalogue import component_class
    from ..advice.stepping_path import python_of

    cls = component_class(name, "show")
    component = cls(effects, parameters)
    variables = [(v, v.name) for v in cls.own_variables]
    variables += [(v, f"{e}.{v.name}") for e, effect in cls.effects.items() for v in effect.variables]
    python = python_of(component)
    return {
        "title": f"{name}: {cls.title}", "text": inspect.getdoc(cls) or "",
        "variables": [_variable(v, full, component) for v, full in variables],
        "effects": [{"name": e, "on": e in component.on, "needs": list(effect.requires), "excludes": list(effect.excludes),
                     "adds": [f"{v.causality.value} {v.name}" for v in effect.variables], "what": _first_line(effect)}
                    for e, effect in cls.effects.items()],
        "presets": [{"name": n, "source": p.source, "provenance": p.standing} for n, p in cls.presets.items()],
        "step": "; ".join(f"Python in {hook}: {what}" for hook, what in python.items()) or "compiled",
    }


def _variable(variable: Variable, name: str, component: Component) -> dict[str, Any]:
    """A row of the table; `default` is that of the component's class."""
    elements = f"[1..{variable.size}]" if variable.size else ""
    limits = [f"{sign} {value:g}" for sign, value in ((">=", variable.low), ("<=", variable.high)) if isfinite(value)]
    output = variable.causality.value == "output"
    default = list(variable.start) if isinstance(variable.start, tuple) else variable.start
    return {"name": name + elements, "is": variable.causality.value, "unit": variable.unit,
            "default": None if output else default, "limits": ", ".join(variable.choices or limits), "text": variable.text}


def _first_line(effect: type) -> str:
    return (inspect.getdoc(effect) or "").partition("\n\n")[0].replace("\n", " ")


def _scene(name: str, effects: list[str], values: list[str]) -> dict[str, Any]:
    from ..advice.stepping_path import stepping_path
    from ..systems import load_scene

    scene = load_scene(name)
    scene = scene.with_changes({**switched_on(scene, effects), **dict(change(scene, text) for text in values)})
    try:
        path = stepping_path(scene)
    except StepFailed as error:
        print(f"cosimo: {error}", file=sys.stderr)
        raise SystemExit(FAILED_RUN) from None
    interfaces, general = scene.coupling.interfaces, ", ".join(path.obstacles)
    given = scene.master
    master = given.model_dump(include={"algorithm", "step", "extrapolation"}) | given.model_dump(exclude_defaults=True)
    return {
        "title": f"{scene.name}: {scene.title or 'no title'}",
        "units": [{"name": unit, "what": settings.component or settings.fmu, "title": interfaces[unit].title,
                   "effects": [e for e, why in interfaces[unit].effects.items() if why],
                   "Python in its steps": [f"{hook}: {what}" for hook, what in path.python.get(unit, {}).items()]}
                  for unit, settings in scene.units.items()],
        "connections": [{"from": ".".join(link.source), "to": ".".join(link.target), "times": link.factor, "plus": link.offset}
                        for link in scene.coupling.links],
        "texts": [{"from": ".".join(link.source), "to": ".".join(link.target)} for link in scene.coupling.texts],
        "master": [{"setting": key, "value": value} for key, value in master.items()],
        "general_path_because_of": list(path.obstacles),
        "step": f"by general code, because of {general}" if general else STEPPED,
    }


def _cell(value: Any) -> Any:
    """A value of a table; a list as its items, and what a component has not as nothing."""
    if isinstance(value, list):
        return ", ".join(f"{v:g}" if isinstance(v, float) else str(v) for v in value)
    return {None: "", True: "yes", False: ""}.get(value, value) if isinstance(value, bool | None) else value
