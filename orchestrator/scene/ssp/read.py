"""A system of another tool as the data of a scene: an .ssd or .ssp file, or a structure of Open Simulation Platform.

SSP has elements for components, connectors, connections, parameters and stop time. Master, records, faults and the other
tables of a scene are in an annotation of cosimo, which other tools ignore. Without that annotation the step is that of
libcosim's or OMSimulator's annotation, with the algorithm of both: Jacobi with held inputs. Without any of these the step is
taken from the FMUs' default experiments, and a remark says so.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Collection
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ....components.core.errors import BadInput
from ...units.description import Description
from .flat import Flat
from .osp import Structure
from .package import find_all, opened
from .system import Document

ANNOTATION, NAMESPACE = "cosimo", "urn:cosimo:scene"
STRUCTURES = ".xml"
PART = 1e-3  # of the run: the step where nothing tells of one


@dataclass(frozen=True)
class System:
    """A scene's data, and what of the files could not be used."""

    data: dict[str, Any]
    remarks: tuple[str, ...]


def read(path: Path, given: Collection[str] = ()) -> System:
    """The scene of a system's file; `BadInput` for what cannot be read. given: as of `scene.files.read_file`."""
    package, name = opened(path)
    with closing(package):
        document = Structure(package, name) if path.suffix == STRUCTURES else Document(package, name)
        own = _annotation(document)
        flat = Flat(document.system(), own.get("elements", {}), bool(own))
    remarks, data = [*document.remarks, *flat.remarks], dict(own.get("scene", {}))
    start, stop = _times(document, flat, given, remarks)
    data |= {"stop_time": stop} | ({"start_time": start} if start else {})
    if "master" not in data:
        data["master"] = _master(document, flat, stop - start if stop > start else 1.0, given, remarks)
    data.setdefault("title", document.title)
    data["connections"] = flat.connections
    extra = own.get("units", {})
    data["units"] = {name: settings | extra.get(name, {}) for name, settings in flat.units.items()}
    if not own:
        for place, element in flat.components.items():
            every = _every(element.step_hint or 0.0, data["master"]["step"], element.where, remarks)
            if every > 1:
                data["units"][flat.names[place]]["every"] = every
    return System(data, tuple(dict.fromkeys(remarks)))


def _annotation(document: Document | Structure) -> dict[str, Any]:
    """What `write` has put into its annotation; empty where there is none."""
    for node in find_all(document.root, "ssd:DefaultExperiment", "ssd:Annotations", "ssc:Annotation"):
        if node.get("type") == ANNOTATION and len(node):
            where = f"{document.where}:{node.sourceline}"
            try:
                content = json.loads(node[0].text or "")
            except ValueError as error:
                raise BadInput(where, f"no JSON ({error})", "what was written, or no such annotation") from None
            tables = [content.get(k, {}) for k in ("scene", "units", "elements")] if isinstance(content, dict) else [None]
            tables += content.get("units", {}).values() if isinstance(content, dict) and isinstance(tables[1], dict) else []
            if not all(isinstance(t, dict) for t in tables):
                raise BadInput(where, "an annotation of another form", "what was written here, or no annotation")
            return content
    return {}


def _times(document: Document | Structure, flat: Flat, given: Collection[str], remarks: list[str]) -> tuple[float, float]:
    """Start and end of the run, s."""
    start, stop = document.times()
    if stop is not None:
        return start or 0.0, stop
    starts, stops = _defaults(flat, lambda d: d.time("startTime")), _defaults(flat, lambda d: d.time("stopTime"))
    if start is None:
        start = min(starts, default=0.0)
    stop = max((time for time in stops if time > start), default=start + 1.0)
    if "stop_time" not in given:
        remarks.append(
            f"{document.where}: no stop time is given; {stop:g} s is taken, "
            f"{'the longest default of its FMUs' if stop in stops else 'as nothing tells of one'}"
        )
    return start, stop


def _master(
    document: Document | Structure, flat: Flat, length: float, given: Collection[str], remarks: list[str]
) -> dict[str, Any]:
    """Co-simulation settings for a system of another tool; length: of the run, s."""
    if (step := document.step()) is not None:
        return {"step": min(step, length), "algorithm": "jacobi"} | ({"extrapolation": 0} if flat.connections else {})
    steps = _defaults(flat, lambda d: d.default_step)
    step = min(steps, default=PART * length)
    if "master.step" not in given:
        remarks.append(
            f"{document.where}: no macro step is given; {step:g} s is taken, "
            f"{'the shortest default of its FMUs' if steps else 'a thousandth of the run'}"
        )
    return {"step": min(step, length)}


def _every(hint: float, step: float, where: str, remarks: list[str]) -> int:
    """Macro steps of a unit's step as libcosim counts them: whole ones that fit into its hint, in nanoseconds.

    Source: libcosim (2025), src/cosim/algorithm/fixed_step_algorithm.cpp.
    """
    wanted, base = round(1e9 * hint), round(1e9 * step)
    if wanted <= 0 or base <= 0:
        return 1
    every = max(1, wanted // base)
    if every * base != wanted:
        remarks.append(
            f"{where}: a step of {hint:g} s is no multiple of {step:g} s; {every * step:g} s is taken, as libcosim does"
        )
    return every


def _defaults(flat: Flat, of: Callable[[Description], float | None]) -> list[float]:
    """What the FMUs say of a default, those that say something."""
    values = [of(element.description) for element in flat.components.values() if element.description is not None]
    return [value for value in values if value is not None]
