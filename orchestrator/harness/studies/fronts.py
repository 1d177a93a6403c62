"""What is known of a scene's accuracy: measured fronts in the user's cache, shipped ones, and the setting they advise.

A front belongs to the physics of a scene: what is simulated, for how long, and what is looked at. How it is coupled and how
long internal steps are is what the front is about, and does not change whose it is. A shipped table is the accuracy.csv of
the shipped scene.
"""

from __future__ import annotations

import hashlib
import inspect
import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from ....components.catalogue import CATALOGUE
from ....components.core.errors import BadInput
from ....fmus.build import sources
from ....fmus.loader import cache_root
from ...run import run
from ...scene.files import shipped
from ...scene.scene import Scene
from ...units.component import find
from .accuracy import Accuracy, Point, read_points, write_points
from .knobs import refined
from .quantities import Course, errors, quantities_of, recording

SCENE, COMPONENTS = "scene digest", "components digest"
KNOBS = {"title", "master", "record", "sweep", "analysis", "study"}


def scene_digest(scene: Scene) -> str:
    """Of what a scene simulates and of what is looked at; not of how it is computed."""
    data = scene.model_dump(mode="json", exclude=KNOBS)
    for name, unit in data["units"].items():
        meshes = {m.removeprefix(f"{name}.") for m in scene.study.mesh if m.startswith(f"{name}.")}
        unit["parameters"] = {k: v for k, v in unit["parameters"].items() if k not in {"substep", *meshes}}
        if unit["fmu"]:
            unit["fmu"] = _digest(Path(unit["fmu"]).read_bytes())
    looked_at = [(q.name, q.transient) for q in quantities_of(scene)]
    return _digest(json.dumps([data, looked_at], sort_keys=True).encode())


def components_digest(scene: Scene) -> str:
    """Of the sources of the scene's components."""
    parts = []
    for name, unit in sorted(scene.units.items()):
        if unit.component in CATALOGUE:
            parts += [content for _, content in sorted(sources(CATALOGUE[unit.component]).items())]
        elif unit.component:
            parts.append(Path(inspect.getfile(find(unit.component, name))).read_bytes())
    return _digest(*parts)


def _digest(*parts: bytes) -> str:
    whole = hashlib.sha256()
    for part in parts:
        whole.update(hashlib.sha256(part).digest())
    return whole.hexdigest()[:16]


@dataclass(frozen=True)
class Known:
    """A measured front and where it comes from, in words."""

    measured: Accuracy
    origin: str


def _place(scene: Scene) -> Path:
    return Path(cache_root()) / "fronts" / f"{scene_digest(scene)}-{components_digest(scene)}.csv"


def marked(scene: Scene, measured: Accuracy) -> Accuracy:
    """The measurement with the digests of the scene and of its components, by which a front is found to be a scene's."""
    return replace(measured, marks={SCENE: scene_digest(scene), COMPONENTS: components_digest(scene)})


def keep(scene: Scene, measured: Accuracy) -> Path:
    """Put a measured front into the user's cache."""
    path = _place(scene)
    return write_points(measured, path.parent, path.name)


def known(scene: Scene) -> Known | None:
    """The front of the scene: measured here, or else shipped; None where neither is."""
    path = _place(scene)
    if path.is_file():
        return Known(read_points(path), f"measured on this machine, {path}")
    tables = shipped("fronts", ".csv")
    if scene.name not in tables:
        return None
    measured = read_points(tables[scene.name])
    if measured.marks.get(SCENE) != scene_digest(scene):
        return None
    same = measured.marks.get(COMPONENTS) == components_digest(scene)
    return Known(measured, f"shipped table, measured on {measured.machine}"
                 + ("" if same else "; the components have changed since, cosimo accuracy measures anew"))


def choose(measured: Accuracy, tolerance: float) -> Point:
    """The setting on the front that is the quickest to keep the error within `tolerance`; raises `BadInput` where none does."""
    if tolerance < measured.least:
        raise BadInput("accuracy", f"{100.0 * tolerance:.3g} %", f"at least {100.0 * measured.least:.2g} %, to which the "
                       "reference itself is known", f"It is {measured.how}.")
    front = measured.front()
    for point in front:
        if point.held <= tolerance:
            return point
    best = f"the best setting measured has {100.0 * front[-1].held:.3g} %" if front else "no setting measured comes to the end"
    raise BadInput("accuracy", f"{100.0 * tolerance:.3g} %", best, "Ask for less, or measure finer settings: cosimo accuracy "
                   "with a larger --budget, or a scene with a shorter macro step.")


def why(chosen: Point, found: Known, tolerance: float) -> dict[str, Any]:
    """What run.json says of a choice."""
    others = [p for p in found.measured.points if p.outcome == "done"]
    return {
        "asked": tolerance, "setting": chosen.line, "size": chosen.size, "changes": dict(chosen.changes),
        "error": chosen.error, "held": chosen.held, "seconds": chosen.seconds, "measured": len(others), "from": found.origin,
        "reference": found.measured.how, "agreement": found.measured.least,
        "reason": f"the quickest of {len(others)} measured settings whose error, and that of all finer ones of its line, "
                  f"stays within {100.0 * tolerance:g} %",
    }


def verify(scene: Scene) -> dict[str, float]:
    """Error of each quantity of a scene's run against a second one with half its macro step and internal steps.

    Raises `BadInput` where the second one cannot be run, or does not come to the end.
    """
    scene = recording(scene)
    finer = scene.with_changes({"master.step": 0.5 * scene.master.step, **refined(scene, 0.5)})
    first, second = (run(s, in_process=True) for s in (scene, finer))
    for result in (first, second):
        if result.outcome != "done":
            raise BadInput(f"{scene.name}: verification", f"a run that failed: {result.message}", "two that come to the end")
    return errors(quantities_of(scene), Course(first.time, first.columns), Course(second.time, second.columns))
