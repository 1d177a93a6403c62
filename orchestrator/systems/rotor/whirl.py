"""Whirl frequencies and critical speeds of a run's rotor, from its own matrices and its bearings' recorded tangents.

A bearing's tangent comes from snapshots of the output that drives the port, such as "left.linearisation.stiffness" in [record].
Read from [analysis]: critical_speeds = [rad/s ...], in place of the computed ones; campbell_speed = rad/s, end of the diagram.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ....components.rotor.modal import campbell, critical_speeds, critical_speeds_of
from ...harness.analysis.records import RecordedUnit
from ...run.key_results import after_transient
from . import RotorKeys
from .records import RotorRecord

if TYPE_CHECKING:
    from ....components.rotor.model import Matrices
    from ...run.results import Result

MODES = 8  # in the diagram
SPEEDS = 61
BEYOND = 1.25  # the diagram's end over the highest speed of the run
PLANE = (0, 1, 3, 4)  # of x, y, z, tilt_x, tilt_y: the coordinates of a rotor without axial motion


@dataclass(frozen=True)
class Whirl:
    """Campbell diagram: speed (k,) rad/s, frequency (k, m) rad/s, direction (k, m): 1 forward, -1 backward, 0 neither.

    critical: synchronous critical speeds, rad/s.  bearings: how the bearings enter, a sentence.
    """

    speed: np.ndarray
    frequency: np.ndarray
    direction: np.ndarray
    critical: np.ndarray
    bearings: str


def whirl(result: Result, record: RotorRecord) -> Whirl | None:
    """The diagram of a rotor that offers its matrices; None without them, or where a bearing's tangent was not recorded."""
    unit = RecordedUnit(result, record.unit)
    rotor: Any = unit.component
    if rotor is None or not hasattr(rotor, "matrices"):
        return None
    rotor.initialize(0.0)
    tangents = {port: _tangent(unit, port) for port in rotor.on if port.startswith("bearing_")}
    if any(t is None for t in tangents.values()):
        return None

    def at(speed: float) -> Matrices:
        matrices: Matrices = rotor.matrices(speed)
        stiffness = matrices.stiffness.copy()
        for port, tangent in tangents.items():
            first = 4 * int(np.abs(rotor.nodes - rotor.parameters[f"{port}.position"]).argmin())
            stiffness[first : first + 4, first : first + 4] += tangent
        return matrices._replace(stiffness=stiffness)

    keys = result.scene.analysis_as(RotorKeys)
    highest = keys.campbell_speed or BEYOND * float(np.abs(record.signals["speed"]).max())
    if not highest > 0.0:
        return None
    lowest, last = rotor.speeds_of_supports() if "support_table" in rotor.on else (-np.inf, np.inf)
    speed = np.linspace(max(lowest, 0.0), min(highest, last), SPEEDS)
    frequency, direction = campbell(at, speed, MODES)
    if keys.critical_speeds:
        critical = np.asarray(keys.critical_speeds, dtype=float)
    else:
        critical = critical_speeds_of(at, speed) if "support_table" in rotor.on else critical_speeds(at(highest))
    text = (
        (
            "Bearings: mean of their linearised stiffness over the record. It grows with the amplitude, so that a resonance "
            "may stand above its line."
        )
        if tangents
        else ""
    )
    return Whirl(speed, frequency, direction, critical[critical <= highest], text)


def _tangent(unit: RecordedUnit, port: str) -> np.ndarray | None:
    """Mean stiffness (4, 4) in x, y, tilt_x, tilt_y that a port was given after the transient; None if no snapshots hold it."""
    array = unit.source(f"{port}.stiffness[1]").removesuffix("[1]")
    if array not in unit.result.snapshots:
        return None
    snapshot, begin = unit.result.snapshots[array], unit.time[after_transient(unit.result).start]
    mean = snapshot.values[snapshot.time >= begin].mean(axis=0).reshape(5, 5)
    return mean[np.ix_(PLANE, PLANE)]
