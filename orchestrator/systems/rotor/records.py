"""Rotors of a run: recorded motion, and forces and ball loads of the bearings that the scene connects with them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...harness.analysis.records import RecordedUnit, recorded_units

if TYPE_CHECKING:
    from ...run.results import Result

ROTOR = {"x": "displacement_x", "y": "displacement_y", "speed": "speed", "angle": "angle"}
CARRIED = ("force_x", "force_y", "max_ball_load", "rating_life.rate")  # by a bearing


@dataclass(frozen=True)
class RotorRecord:
    """The recorded part of a rotor of a run.

    signals: x, y, speed, angle, those that were recorded.  ports: name of a bearing's port -> x, y of the shaft there and, of
    the unit that drives the port, those of `CARRIED` that were recorded.
    """

    unit: str
    time: np.ndarray
    signals: Mapping[str, np.ndarray]
    ports: Mapping[str, Mapping[str, np.ndarray]]


def rotors(result: Result) -> list[RotorRecord]:
    """The rotors of a run: units with ports for bearings or a place that is watched, whose speed was recorded."""
    records = []
    for unit in recorded_units(result, "speed"):
        own = unit.recorded({k: n for k, n in ROTOR.items() if unit.has(n)})
        ports = {p: _port(unit, p) for p in (unit.component.on if unit.component else ()) if p.startswith("bearing_")}
        records.append(RotorRecord(unit.name, unit.time, own, {p: s for p, s in ports.items() if s}))
    return records


def _port(unit: RecordedUnit, port: str) -> dict[str, np.ndarray]:
    # The port may be driven by the force of a linearised bearing. The bearing's own force is another output of the same unit.
    bearing = unit.driven_by(f"{port}.force_x")
    carried = bearing.recorded(CARRIED) if bearing else {}
    return unit.recorded({n: f"{port}.displacement_{n}" for n in "xy"}) | carried
