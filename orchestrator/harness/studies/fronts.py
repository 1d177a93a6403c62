"""What is known of a scene's accuracy: measured fronts in the user's cache, shipped ones, and the setting they advise.

A front belongs to the physics of a scene: what is simulated, for how long, and what is looked at. How it is coupled and how
long internal steps are is what the front is about, and does not change whose it is. A shipped table is the accuracy.csv of
the shipped scene.
"""

from __future__ import annotations

import json
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from ....components.core.errors import BadInput
from ....fmus.loader import cache_root
from ...output import seal, unsealed
from ...run import run
from ...scene.files import shipped
from ...scene.scene import Scene
from ..code_digests import components_digest, short_digest
from .accuracy import Accuracy, Point
from .accuracy_table import read_points, write_points
from .quantities import TimeHistory, errors, quantities_of, recording
from .settings_axes import refined
from .timing import calibrate, scaled

SCENE, COMPONENTS = "scene digest", "components digest"
NOT_PHYSICS = {"title", "master", "record", "sweep", "analysis", "study"}


def scene_digest(scene: Scene) -> str:
    """Of what a scene simulates and of what is looked at; not of how it is computed."""
    data = scene.model_dump(mode="json", exclude=NOT_PHYSICS)
    for name, unit in data["units"].items():
        meshes = {m.removeprefix(f"{name}.") for m in scene.study.mesh if m.startswith(f"{name}.")}
        unit["parameters"] = {k: v for k, v in unit["parameters"].items() if k not in {"substep", *meshes}}
        if unit["fmu"]:
            unit["fmu"] = short_digest(Path(unit["fmu"]).read_bytes())
    looked_at = [(q.name, q.transient) for q in quantities_of(scene)]
    return short_digest(json.dumps([data, looked_at], sort_keys=True).encode())


@dataclass(frozen=True)
class Known:
    """A measured front. origin: where it comes from, in words.  stale: why it must not be used; empty where it may be."""

    measured: Accuracy
    origin: str
    stale: str = ""


def _path(scene: Scene) -> Path:
    return Path(cache_root()) / "fronts" / f"{scene_digest(scene)}-{components_digest(scene)}.csv"


def marked(scene: Scene, measured: Accuracy) -> Accuracy:
    """The measurement with the digests of the scene and of its components, which tell whose it is."""
    return replace(measured, marks={SCENE: scene_digest(scene), COMPONENTS: components_digest(scene)})


def keep(scene: Scene, measured: Accuracy) -> Path:
    """Put a measured front into the user's cache."""
    path = _path(scene)
    with suppress(BadInput):  # nothing can be written there: the next time it is measured again
        seal(path, write_points(measured, path.parent, path.name).read_text(encoding="utf-8"))
    return path


def known(scene: Scene) -> Known | None:
    """The front of the scene: measured here, or else shipped, with its times as they are expected here; None without either."""
    path = _path(scene)
    if unsealed(path) is not None:
        return Known(read_points(path), f"measured on this machine, {path}")
    tables = shipped("fronts", ".csv")
    if scene.name not in tables:
        return None
    measured = read_points(tables[scene.name])
    if measured.marks.get(SCENE) != scene_digest(scene):
        return None
    if measured.marks.get(COMPONENTS) != components_digest(scene):
        return Known(measured, "", f"the shipped table of {scene.name} was measured with an older version of its components")
    here = calibrate().seconds
    return Known(_expected_here(measured, here), f"shipped table, measured on {measured.machine}; times are scaled by "
                 f"{here / measured.calibration:.3g} to this machine (CPU time of a calibration workload)")


def _expected_here(measured: Accuracy, here: float) -> Accuracy:
    points = [replace(p, seconds=scaled(p.seconds, measured.calibration, here),
                      median=scaled(p.median, measured.calibration, here)) for p in measured.points]
    return replace(measured, points=tuple(points))


def choose(measured: Accuracy, tolerance: float) -> Point:
    """The setting on the front that is the quickest to keep the error within `tolerance`; raises `BadInput` where none does."""
    asked = f"{100.0 * tolerance:.3g} %"
    if tolerance < measured.smallest_known:
        raise BadInput("accuracy", asked, f"at least {100.0 * measured.smallest_known:.2g} %, the reference's own error",
                       f"It is {measured.reference}.")
    front = measured.front()
    for point in front:
        if point.error_with_finer <= tolerance:
            return point
    best = (f"the best setting measured has {100.0 * front[-1].error_with_finer:.3g} %" if front
            else "no setting measured comes to the end with a time that could be confirmed")
    raise BadInput("accuracy", asked, best, "Ask for less, or measure finer settings: cosimo accuracy with a larger --budget, "
                   "or a scene with a shorter macro step.")


def why(chosen: Point, front: Known, tolerance: float) -> dict[str, Any]:
    """What run.json says of a choice."""
    measured = front.measured
    others = [p for p in measured.points if p.outcome == "done"]
    return {
        "asked": tolerance, "setting": chosen.series, "size": chosen.size, "changes": dict(chosen.changes),
        "error": chosen.error, "error_with_finer": chosen.error_with_finer, "seconds": chosen.seconds, "measured": len(others),
        "from": front.origin, "reference": measured.reference, "shared_with_reference": measured.shares,
        "reference_error": measured.smallest_known,
        "reason": f"the quickest of {len(others)} measured settings whose error, and that of all finer ones of its series, "
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
    return errors(quantities_of(scene), TimeHistory(first.time, first.columns), TimeHistory(second.time, second.columns))
