"""What a component or a scene consists of, as text."""

from __future__ import annotations

import inspect
import json
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ...components.core.errors import BadInput, StepFailed, nearest
from .common import (
    FAILED_RUN,
    AsJson,
    Changes,
    Presets,
    app,
    changes_of,
    listed,
    loaded_scene,
    parameters_of,
    preset_of,
    print_table,
    status_spinner,
    switched_on,
)
from .completion import anything

if TYPE_CHECKING:
    from ...components.core.component import Component
    from ..scene.drawing import Drawing

FILES = (".toml", ".ssd", ".ssp")
STEPS = 200  # of a measurement of time
STEPPED = "compiled loop, units called by address"


@app.command()
def show(
    name: Annotated[
        str,
        typer.Argument(
            autocompletion=anything,
            help=(
                "a component, module:Class, a shipped scene or case by its name, a scene file, or the table of an overhead line"
            ),
        ),
    ],
    effects: Annotated[
        list[str] | None,
        typer.Option(
            "--effects",
            metavar="EFFECT[,...]",
            help=("Effects that are on; of a scene unit.effect, beside its own. May be repeated."),
        ),
    ] = None,
    values: Changes = None,
    presets: Presets = None,
    timed: Annotated[
        bool,
        typer.Option(
            "--time",
            help=("Of a component: measure what each effect adds to a step; compiles each of them, which takes seconds."),
        ),
    ] = False,
    output: Annotated[Path | None, typer.Option("-o", "--output", help="Directory for a drawing as SVG.")] = None,
    as_json: AsJson = False,
) -> None:
    """What a component, a scene or a case consists of, and whether Python is in its steps. Example: cosimo show Pantograph"""
    from ...components.catalogue import CATALOGUE
    from ..output import ensure_directory
    from ..scene.scene import scene_files
    from ..systems import cases
    from ..systems.railway.line import is_line
    from ..systems.railway.line import read as read_line

    component = name in CATALOGUE or (":" in name and not name.endswith(FILES))
    scene = not component and (name in scene_files() or name.endswith(FILES))
    for option, given, possible in (("--preset", presets, component or scene), ("--time", timed, component)):
        if given and not possible:
            raise BadInput("show", f"{option} with {name!r}", "a component", "It would have no effect.")
    if name.endswith(".toml") and is_line(Path(name)):
        from .railway import show_line

        if output is not None:
            raise BadInput("show", "-o with the table of a line", "no directory", "cosimo railway has its drawing.")
        show_line(*read_line(Path(name), parameters_of(values or [])))
        return
    with status_spinner() as progress:
        progress("initializing, which compiles kernels where the cache has none")
        drawing = None
        if component:
            on = listed("--effects", effects) if effects else []
            shown, drawing = _component(name, on, preset_of(presets), parameters_of(values or []), timed)
        elif scene:
            shown, drawing = _scene(name, effects or [], values, presets)
            shown |= {"reference": _reference(name)} if name in cases() else {}
        elif name in cases():
            shown = {"title": f"{name}: {cases()[name].title}", "text": cases()[name].text, "reference": _reference(name)}
        else:
            raise BadInput(
                "show", repr(name), "a component, a scene or a case", nearest(name, [*CATALOGUE, *scene_files(), *cases()])
            )
    if output is not None:
        if drawing is None:
            raise BadInput("show", "-o with a case", "a component or a scene, which have a drawing")
        path = drawing.save(ensure_directory(output) / f"{name.rpartition(':')[2].rpartition('/')[2].partition('.')[0]}.svg")
    if as_json:
        print(json.dumps(shown, indent=2))
        return
    print(shown["title"], *([shown["text"]] if shown.get("text") else []), sep="\n\n", end="\n\n")
    for title, rows in shown.items():
        if isinstance(rows, list) and rows and isinstance(rows[0], dict):
            print_table(title.replace("_", " "), tuple(rows[0]), [tuple(map(_cell, row.values())) for row in rows])
    print(*(f"{key}: {_cell(shown[key])}" for key in ("states", "step") if shown.get(key) is not None), sep="\n")
    if output is not None:
        print(f"wrote {path}")


def _component(
    name: str, effects: list[str], preset: str, parameters: Mapping[str, Any], timed: bool
) -> tuple[dict[str, Any], Drawing]:
    from ...components.catalogue import component_class
    from ...components.core.contract import KernelComponent
    from ..harness.component_page import component_page

    cls = component_class(name, "show")
    component = cls(effects, parameters, preset=preset)
    component.initialize(0.0)
    page = component_page(name)
    costs = _costs(cls, parameters, preset) if timed else {}
    own = {row.name: row for row in page.variables}
    return {
        "title": f"{name}: {page.title}",
        "text": inspect.getdoc(cls) or "",
        "variables": [
            {
                "name": row.name + (f"[1..{row.size}]" if row.size else ""),
                "is": row.causality,
                "unit": row.unit,
                "default": list(row.default) if isinstance(row.default, tuple) else row.default,
                "limits": row.limits,
                "text": row.text,
                "as in": list(row.sources),
            }
            for row in page.variables
        ],
        "effects": [
            {
                "name": e.name,
                "on": e.name in component.on,
                "needs": list(e.needs),
                "excludes": list(e.excludes),
                "adds": [f"{own[v].causality} {v.removeprefix(e.name + '.')}" for v in e.variables],
                "states": e.states,
                **({"step": costs[e.name]} if timed else {}),
                "what": e.text.partition("\n\n")[0].replace("\n", " "),
            }
            for e in page.effects
        ],
        "ports": [
            {"name": port.name or "own signals", "inputs": list(port.inputs), "outputs": list(port.outputs)}
            for port in page.ports
        ],
        "presets": [{"name": p.name, "source": p.source, "provenance": p.provenance} for p in page.presets],
        "hard_cases": [{"name": c.name, "what": c.text, "holds": "; ".join(c.holds)} for c in page.hard_cases],
        "scenes": [{"name": scene, "title": title} for scene, title in page.scenes.items()],
        "states": page.states,
        "step": "compiled" if isinstance(component, KernelComponent) else "Python",
    }, page.sketch()


def _costs(cls: type[Component], parameters: Mapping[str, Any], preset: str) -> dict[str, str]:
    """Effect -> what it adds to a step of the component's own length, in words."""
    from time import process_time

    from ..harness.studies.full_model import with_required
    from ..harness.studies.timing import Timing, repeated

    measured: dict[tuple[str, ...], Timing] = {}

    def timing(on: tuple[str, ...]) -> Timing:
        if on not in measured:
            component = cls(on, {n: v for n, v in parameters.items() if "." not in n or n.partition(".")[0] in on}, preset=preset)

            def measure() -> float:
                component.initialize(0.0)
                began = process_time()
                for k in range(STEPS):
                    component.step(k * cls.default_step, cls.default_step)
                return (process_time() - began) / STEPS

            measured[on] = repeated(measure, repeats=5)
        return measured[on]

    costs = {}
    for effect in cls.effects:
        try:
            needed = with_required(cls, effect)
            more, without = timing(needed), timing(tuple(e for e in needed if e != effect))
        except (BadInput, StepFailed):
            costs[effect] = "needs other parameters"
            continue
        added = more.seconds - without.seconds
        noise = more.seconds * more.scatter + without.seconds * without.scatter
        words = f"{1e6 * added:+.2g} µs to {1e6 * without.seconds:.3g} µs"
        costs[effect] = words if abs(added) > noise else "less than the scatter"
    return costs


def _reference(name: str) -> list[dict[str, Any]]:
    """Rows of a case's table, and of the tables that start with its name; none where its ranges are computed in the run."""
    from ..harness.validation.reference import load_table, table_files

    names = [t for t in table_files() if t == name]
    return [
        {
            "quantity": r.quantity,
            "condition": r.condition,
            "unit": r.unit,
            "low": r.low,
            "high": r.high,
            "provenance": r.standing,
            "source": r.source,
        }
        for t in names
        for r in load_table(t).rows
    ]


def _scene(name: str, effects: list[str], values: list[str] | None, presets: list[str] | None) -> tuple[dict[str, Any], Drawing]:
    from ..judgement.dry_run import stepping_path

    scene = loaded_scene(name)
    scene = scene.with_changes({**switched_on(scene, effects), **changes_of(scene, values, presets)})
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
        "units": [
            {
                "name": unit,
                "what": settings.component or settings.fmu,
                "title": interfaces[unit].title,
                "effects": [e for e, why in interfaces[unit].effects.items() if why],
                "steps": "Python" if unit in path.python else "",
            }
            for unit, settings in scene.units.items()
        ],
        "connections": [
            {"from": ".".join(link.source), "to": ".".join(link.target), "times": link.factor, "plus": link.offset}
            for link in scene.coupling.links
        ],
        "texts": [{"from": ".".join(link.source), "to": ".".join(link.target)} for link in scene.coupling.texts],
        "master": [{"setting": key, "value": value} for key, value in master.items()],
        "general_path_because_of": list(path.obstacles),
        "step": f"by general code, because of {general}" if general else STEPPED,
    }, scene.show()


def _cell(value: Any) -> Any:
    """A value of a table; a list as its items, and what a component has not as nothing."""
    if isinstance(value, list):
        return ", ".join(f"{v:g}" if isinstance(v, float) else str(v) for v in value)
    return {None: "", True: "yes", False: ""}.get(value, value) if isinstance(value, bool | None) else value
