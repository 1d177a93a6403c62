"""Components, scenes and lists of them as plain data. Loaded when something is shown: components are initialized."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from time import process_time
from typing import Any

from ...components.catalogue import CATALOGUE, component_class
from ...components.core.component import Component
from ...components.core.contract import KernelComponent
from ...components.core.errors import BadInput, StepFailed
from ..harness.component_page import component_page
from ..harness.studies.full_model import with_required
from ..scene.drawing import Drawing
from ..scene.scene import Scene, read_toml, scene_files
from ..systems import cases
from ..units.description import read
from ..units.terminals import at_hand
from .common import changes_of, fail, loaded_scene, switched_on
from .options import listed, parameters_of, preset_of

STEPS = 200  # of a measurement of time
STEPPED = "compiled loop, units called by address"


def everything() -> dict[str, list[dict[str, Any]]]:
    """Names, titles and systems of all components, FMUs, scenes and cases; of components what they declare, too."""
    classes = {name: component_class(name) for name in CATALOGUE}
    return {
        "components": [
            {
                "name": name,
                "title": cls.title,
                "system": cls.system,
                "effects": list(cls.effects),
                "presets": list(cls.presets),
                "variables": [
                    {"name": v.name, "causality": v.causality.value, "unit": v.unit, "start": v.start, "text": v.text}
                    for v in cls.variables.values()
                ],
            }
            for name, cls in classes.items()
        ],
        "fmus": [{"name": name, "title": cls.title, "system": cls.system} for name, cls in classes.items()],
        "scenes": [
            {"name": name, "title": read_toml(path, "scene").get("title", ""), "system": path.parents[1].name}
            for name, path in scene_files().items()
        ],
        "cases": [{"name": name, "title": case.title, "system": case.system} for name, case in cases().items()],
    }


def of_component(
    name: str, effects: list[str] | None, values: list[str] | None, presets: list[str] | None, timed: bool
) -> tuple[dict[str, Any], Drawing]:
    """A component's title, text and tables, and its drawing. timed: with the time that each effect adds to a step."""
    cls = component_class(name, "show")
    parameters, preset = parameters_of(values), preset_of(presets)
    component = cls(listed("--effects", effects), parameters, preset=preset)
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
    from ..harness.studies.trial import Timing, repeated

    measured: dict[tuple[str, ...], Timing] = {}

    def timing(on: tuple[str, ...]) -> Timing:
        if on not in measured:
            component = cls(on, {n: v for n, v in parameters.items() if "." not in n or n.partition(".")[0] in on}, preset=preset)

            def measure() -> float:
                component.initialize(0.0)
                start = process_time()
                for k in range(STEPS):
                    component.step(k * cls.default_step, cls.default_step)
                return (process_time() - start) / STEPS

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


def reference_rows(name: str) -> list[dict[str, Any]]:
    """Rows of a case's table; none where its ranges are computed in the run."""
    from ..harness.validation.reference import load_table, table_files

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
        for r in (load_table(name).rows if name in table_files() else ())
    ]


def fmu_variables(path: str) -> list[dict[str, Any]]:
    """Inputs, outputs and parameters of an FMU, as its model description has them."""
    return [
        {
            "name": name,
            "is": scalar.variable.causality,
            "type": scalar.variable.type,
            "unit": scalar.unit,
            "start": scalar.start,
            "text": scalar.variable.description or "",
        }
        for name, scalar in read(path, "show").scalars.items()
        if scalar.variable.causality in ("input", "output", "parameter")
    ]


def _of_fmu(scene: Scene) -> dict[str, Any]:
    """Variables and ports of a scene that is one FMU."""
    ((unit, kind),) = scene.kinds.items()
    interface = scene.coupling.interfaces[unit]
    ports = []
    for name, terminal in interface.terminals.items():
        members = at_hand(terminal, (*interface.inputs, *interface.outputs)).members
        ways = ([m.name for m in members if m.variable in v] for v in (interface.inputs, interface.outputs))
        if members:  # not of an effect that is off
            ports.append({"name": name, **dict(zip(("inputs", "outputs"), ways, strict=True)), "matching": terminal.rule})
    return {"variables": fmu_variables(kind.file), "ports": ports}


def of_scene(
    name: str, effects: list[str] | None, values: list[str] | None, presets: list[str] | None
) -> tuple[dict[str, Any], Drawing]:
    """A scene's title and tables, and its drawing."""
    from ..judgement.dry_run import SteppingPath, not_executed, stepping_path, why_not_executed

    scene = loaded_scene(name)
    scene = scene.with_changes(switched_on(scene, effects))
    scene = scene.with_changes(changes_of(scene, values, presets))
    closed = not_executed(scene)
    try:
        path = SteppingPath((), ()) if closed else stepping_path(scene)
    except StepFailed as error:
        raise fail(error) from None
    interfaces, general = scene.coupling.interfaces, ", ".join(path.obstacles)
    given = scene.master
    master = given.model_dump(include={"algorithm", "step", "extrapolation"}) | given.model_dump(exclude_defaults=True)
    return {
        "title": f"{scene.name}: {scene.title or 'no title'}",
        "units": [
            {
                "name": unit,
                "what": kind.shown,
                "title": interfaces[unit].title,
                "effects": [e for e, why in interfaces[unit].effects.items() if why],
                "steps": "Python" if unit in path.python else "",
            }
            for unit, kind in scene.kinds.items()
        ],
        **(_of_fmu(scene) if name.endswith(".fmu") else {}),
        "connections": [
            {"from": ".".join(link.source), "to": ".".join(link.target), "times": link.factor, "plus": link.offset}
            | ({"map": dict(link.map)} if link.map else {})
            for link in scene.coupling.links
        ],
        "texts": [{"from": ".".join(link.source), "to": ".".join(link.target)} for link in scene.coupling.texts],
        "master": [{"setting": key, "value": value} for key, value in master.items()],
        "general_path_because_of": list(path.obstacles),
        "step": f"not known: {why_not_executed(closed)}"
        if closed
        else f"by general code, because of {general}"
        if general
        else STEPPED,
    }, scene.show()
