"""What is known of a scene's accuracy: measured fronts in the user's cache, shipped ones, and the setting they advise.

A front belongs to the physics of a scene: its model, its length, its quantities of interest. Coupling and internal steps are the
settings that the front compares; a scene with others has the same front. A front is stale when the scene at its own settings
gives other numbers than at the time of the measurement, whatever the reason.

A shipped table has errors and counted work, which do not depend on the machine. The times of candidate settings are measured on this
machine, in a part of the run.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np

from ....components.core import store
from ....components.core.errors import BadInput
from ....components.core.folders import cache_root
from ...code_digests import short_digest
from ...run.run import run
from ...scene.files import shipped
from ...scene.scene import Scene
from .accuracy import Accuracy, Point
from .accuracy_table import read_points, write_points
from .quantities import percent, quantities_of, recording
from .trial import trial

SCENE, NUMBERS = "scene digest", "rms of signals"
NOT_PHYSICS = {"title", "master", "record", "sweep", "analysis", "study", "explore", "interface", "limits", "connections"}
SAME = 1e-4  # of a signal's rms, or of a thousandth of its nominal value: what differs less is the same number
TIMED = 0.05  # of a run, whose time tells that of the whole, and at least `TIMED_STEPS` macro steps of each setting
TIMED_STEPS = 1000
CANDIDATES = 6  # settings whose times are measured: those with the least counted work
DEARER = 5.0  # times the least work, from which a setting does not come into question


def scene_digest(scene: Scene) -> str:
    """Of a scene's model, length and quantities of interest; not of its settings."""
    data = scene.model_dump(mode="json", exclude=NOT_PHYSICS)
    if not scene.start_time:  # fronts were measured before scenes had a start time
        del data["start_time"]
    for name, unit in data["units"].items():
        meshes = {m.removeprefix(f"{name}.") for m in scene.study.mesh if m.startswith(f"{name}.")}
        unit["parameters"] = {k: v for k, v in unit["parameters"].items() if k not in {"substep", *meshes}}
        if unit["fmu"]:
            unit["fmu"] = short_digest(Path(unit["fmu"]).read_bytes())
    coupling = scene.coupling  # its links are the same however the scene writes them
    data["links"] = sorted(
        [".".join(link.source), ".".join(link.target), link.factor, link.offset, *link.map] for link in coupling.links
    )
    data["texts"] = sorted([".".join(link.source), ".".join(link.target)] for link in coupling.texts)
    looked_at = [(q.name, q.transient) for q in quantities_of(scene)]
    return short_digest(json.dumps([data, looked_at], sort_keys=True).encode())


@dataclass(frozen=True)
class Known:
    """A measured front. origin: where it comes from, in words.  stale: why it must not be used; empty where it may be."""

    measured: Accuracy
    origin: str
    stale: str = ""


def _path(scene: Scene) -> Path:
    return Path(cache_root()) / "fronts" / scene_digest(scene)


def numbers_of(scene: Scene, changes: Mapping[str, Any]) -> dict[str, float]:
    """Rms of every recorded signal of the scene with changes, at every macro step. Raises `BadInput` for a run that fails."""
    scene = recording(scene).with_changes({**changes, "record.interval": None})
    result = run(scene, in_process=True).unless_stopped()
    if result.outcome != "done":
        raise BadInput(f"{scene.name}: accuracy", f"a run that failed: {result.message}", "one that comes to its end")
    return {name: float(np.sqrt(np.mean(np.square(x)))) for name, x in result.columns.items()}


def changed_number(scene: Scene, measured: Accuracy) -> str:
    """The first signal that has another rms than when the front was measured, in words; "" where there is none."""
    then: dict[str, float] = json.loads(measured.marks.get(NUMBERS, "{}"))
    now = numbers_of(scene, measured.own.changes)
    nominal = {f"{unit}.{name}": s.nominal for unit, i in scene.coupling.interfaces.items() for name, s in i.outputs.items()}
    for name in quantity_signals(scene):
        if name not in then:
            return f"{name} was not looked at"
        if not abs(now[name] - then[name]) <= SAME * max(abs(then[name]), 1e-3 * nominal[name]):
            return f"{name} has an rms of {now[name]:.6g}, and had {then[name]:.6g}"
    return ""


def quantity_signals(scene: Scene) -> list[str]:
    """The signals that the scene's quantities are of."""
    return list(dict.fromkeys(q.signal for q in quantities_of(scene)))


def marked(scene: Scene, measured: Accuracy) -> Accuracy:
    """The measurement with the scene's digest, and its numbers at its own settings."""
    numbers = numbers_of(scene, measured.own.changes)
    kept = {name: float(f"{numbers[name]:.8g}") for name in quantity_signals(scene)}
    return replace(measured, marks={SCENE: scene_digest(scene), NUMBERS: json.dumps(kept)})


def keep(scene: Scene, measured: Accuracy) -> Path:
    """Put a measured front into the user's cache."""
    path = _path(scene)
    with suppress(BadInput):  # nothing can be written there: the next time it is measured again
        marks = measured if NUMBERS in measured.marks else marked(scene, measured)
        store.write_kept(path, write_points(marks, path.parent, path.name).read_bytes())
    return path


def known(scene: Scene) -> Known | None:
    """The front of the scene: measured here, or else shipped; None without either."""
    path, tables = _path(scene), shipped("fronts", ".csv")
    if (content := store.read_kept(path)) is not None:
        measured, origin = read_points(path, content.decode()), f"measured on this machine, {path}"
    elif scene.name in tables:
        measured, origin = read_points(tables[scene.name]), f"table that comes along with {scene.name}; times measured here"
        if measured.marks.get(SCENE) != scene_digest(scene):
            return None
    else:
        return None
    other = changed_number(scene, measured)
    return Known(
        measured, origin, f"the numbers of {scene.name} have changed since its accuracy was measured ({other})" if other else ""
    )


def choose(scene: Scene, measured: Accuracy, tolerance: float) -> Point:
    """The setting that is the quickest to keep the error within `tolerance`; raises `BadInput` where none does.

    Where the measurement has no times, those of the settings with the least counted work are measured here.
    """
    asked = percent(tolerance)
    if tolerance < measured.smallest_known:
        raise BadInput(
            "accuracy",
            asked,
            f"at least {100.0 * measured.smallest_known:.2g} %, the reference's own error",
            f"It is {measured.reference}.",
        )
    timed = any(isfinite(p.seconds) for p in measured.points)
    front = measured.front("seconds" if timed else "calls")
    within = [p for p in front if p.error_with_finer <= tolerance]
    if not within:
        best = (
            f"the best setting measured has {100.0 * front[-1].error_with_finer:.3g} %"
            if front
            else "no setting measured comes to the end with a time that could be confirmed"
        )
        raise BadInput(
            "accuracy",
            asked,
            best,
            "Ask for less, or measure finer settings: cosimo accuracy with a larger "
            "--budget, or a scene with a shorter macro step.",
        )
    return within[0] if timed else quickest_here(scene, [p for p in measured.points if _comes_into_question(p, tolerance)])


def _comes_into_question(point: Point, tolerance: float) -> bool:
    return point.outcome == "done" and point.axis != "effect" and point.error_with_finer <= tolerance and "calls" in point.work


def quickest_here(scene: Scene, points: Sequence[Point]) -> Point:
    """The quickest of some points, by the CPU time of a part of the run on this machine; with its time, s."""
    points = sorted(points, key=lambda p: p.work["calls"])
    cheap = [p for p in points[:CANDIDATES] if p.work["calls"] <= DEARER * points[0].work["calls"]]
    longest = max(scene.with_changes(point.changes).master.step for point in cheap)
    part = max(TIMED, min(1.0, TIMED_STEPS * longest / scene.duration))
    timed = []
    for point in cheap:
        run_of_part = trial(
            recording(scene), {**point.changes, "stop_time": scene.start_time + part * scene.duration}, confirm=True
        )
        timed.append(replace(point, seconds=run_of_part.seconds / part) if run_of_part.done else point)
    return min(timed, key=lambda p: p.seconds if isfinite(p.seconds) else float("inf"))


def why(chosen: Point, front: Known, tolerance: float) -> dict[str, Any]:
    """What run.json says of a choice."""
    measured = front.measured
    others = [p for p in measured.points if p.outcome == "done"]
    return {
        "asked": tolerance,
        "setting": chosen.series,
        "size": chosen.size,
        "changes": dict(chosen.changes),
        "error": chosen.error,
        "error_with_finer": chosen.error_with_finer,
        "seconds": chosen.seconds,
        "measured": len(others),
        "from": front.origin,
        "reference": measured.reference,
        "shared_with_reference": measured.shares,
        "reference_error": measured.smallest_known,
        "reason": f"the quickest of {len(others)} measured settings whose error, and that of all finer ones of its series, "
        f"stays within {100.0 * tolerance:g} %",
    }
