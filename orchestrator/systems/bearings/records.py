"""Bearings of a run: recorded motion and forces, speed of rotation, frequencies of races, balls and cage.

[analysis]
system = "bearings"     # or "rotor": which figures the report has
transient = 0.5         # s, left out of spectra, orbits and measures
bearing = "front"       # the bearings to show, a name or a list; all of them without it
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ....components.core.errors import pick
from ...harness.analysis.records import RecordedUnit
from ...harness.analysis.signals import uniform
from ...harness.analysis.spectra import TURN, turns_steadily
from ...run.key_results import after_transient
from . import BearingKeys

if TYPE_CHECKING:
    from ...run.results import Result

MOTION = ("displacement_x", "displacement_y", "velocity_x", "velocity_y", "acceleration_x", "acceleration_y")
BEARING = (*MOTION, "force_x", "force_y", "force_z", "max_ball_load", "cage_angle", "inner_angle")
STEADY = 0.02  # relative change of a speed, below which it has frequencies
SLIPS = "from the geometry and speed, without the slip of the cage", "from the speeds of shaft and cage"
DEFECTS = {"outer_defect": "outer", "inner_defect": "inner", "ball_defect": "ball"}


@dataclass(frozen=True)
class BearingRecord:
    """The recorded part of a bearing of a run, sampled evenly.

    signals: name as in the component -> (n,), those of `BEARING` that were recorded; an angle that after the transient stands
        or turns back, or was recorded less than four times a turn, is not among them.  measures: their units of measure.
    rotation: speed of the inner ring after the transient, turns per unit of time; NaN if it changes or was not recorded.
    frequencies: "cage", "outer", "inner", "ball" -> per unit of time, empty without rotation.  basis: what they follow from.
    defects: the races and balls that have a defect.
    """

    unit: str
    time: np.ndarray
    rate: float
    signals: Mapping[str, np.ndarray]
    measures: Mapping[str, str]
    rotation: float
    frequencies: Mapping[str, float]
    basis: str
    balls: int
    defects: tuple[str, ...]


def bearings(result: Result) -> list[BearingRecord]:
    """The bearings of a run whose displacement was recorded, in the order of the scene."""
    scene = result.scene
    given = scene.analysis_as(BearingKeys).bearing
    wanted = (given,) if isinstance(given, str) else given or tuple(scene.units)
    records = []
    for name in wanted:
        pick(name, scene.units, f"{scene.name}: analysis.bearing", "a unit of the scene")
        unit = RecordedUnit(result, name)
        if unit.column("displacement_x") and unit.column("displacement_y") and hasattr(unit.component, "geometry"):
            records.append(_bearing(unit))
    return records


def since(time: np.ndarray, begin: float) -> slice:
    """The samples at instants (n,) from one on."""
    return slice(int(np.searchsorted(time, begin - 1e-12)), None)


def _bearing(unit: RecordedUnit) -> BearingRecord:
    component: Any = unit.component
    values, kept = unit.recorded(BEARING), after_transient(unit.result)
    measures = {n: unit.result.measures.get(unit.column(n), "") for n in values}
    values = {n: v for n, v in values.items() if not n.endswith("_angle") or turns_steadily(v[kept])}
    angles = {n: np.unwrap(v) for n, v in values.items() if n.endswith("_angle")}  # a jump must not be interpolated over
    rate, time, signals = uniform(unit.time, *(values | angles).values())
    geometry = component.geometry
    slips = "cage_slip" in component.on
    rotation = _rotation(unit, values, None if slips else geometry.cage_ratio)
    known = bool(np.isfinite(rotation) and rotation)
    cage = _turns(values["cage_angle"][kept], unit.time[kept]) if known and slips and "cage_angle" in values else float("nan")
    own = abs(cage) if np.isfinite(cage) and cage * rotation > 0.0 else None
    return BearingRecord(
        unit.name, time, rate,
        dict(zip(values | angles, signals, strict=True)),
        measures,
        rotation,
        geometry.defect_frequencies(abs(rotation), own) if known else {},
        SLIPS[own is not None] if slips else "from the geometry and speed",
        geometry.balls,
        tuple(name for effect, name in DEFECTS.items() if effect in component.on),
    )  # fmt: skip


def _rotation(unit: RecordedUnit, values: Mapping[str, np.ndarray], cage_ratio: float | None) -> float:
    """Speed of the inner ring after the transient, turns per unit of time; NaN where it changes or was not recorded.

    cage_ratio: the cage's speed over it; None of a cage that slips.
    """
    kept = after_transient(unit.result)
    for name, ratio in (("inner_angle", 1.0), ("cage_angle", cage_ratio)):
        if name in values and ratio is not None:
            return _turns(values[name][kept], unit.time[kept]) / ratio
    speed = unit.optional("speed")
    if speed is None:
        return float("nan")
    turns = speed[kept] / TURN
    return _steady(turns, float(turns.mean()))


def _turns(angle: np.ndarray, time: np.ndarray) -> float:
    """Turns per unit of time of an angle; NaN where its halves differ."""
    turned = np.unwrap(angle) / TURN
    middle = turned.size // 2
    halves = [(turned[b] - turned[a]) / (time[b] - time[a]) for a, b in ((0, middle), (middle, -1)) if time[b] > time[a]]
    return _steady(np.array(halves), float((turned[-1] - turned[0]) / (time[-1] - time[0])))


def _steady(speeds: np.ndarray, mean: float) -> float:
    return mean if float(np.ptp(speeds)) <= STEADY * abs(mean) else float("nan")
