"""Friction-wheel drives of a run, found by the sleeve they move: way and set point, wheels, contacts, moves, rest, energies.

[analysis]
system = "friction_drive"
feed_band = 1e-4        # m, error within which a move of the feed counts as settled
rotation_band = 0.01    # rad, the same of the rotation
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...harness.analysis.records import RecordedUnit, recorded_units
from ...harness.analysis.signals import accumulated

if TYPE_CHECKING:
    from ....components.core.component import Component
    from ...run.results import Result

AXES = ("feed", "rotation")
WHEELS = ("first", "second")
ELECTRICAL = ("voltage", "current", "electrical_power")  # of a motor
OF_DRIVE = ("margin", "contact_power", "mechanical_energy", "electrical_power")
BANDS = {"feed": 1e-4, "rotation": 0.01}  # m, rad
NEGLIGIBLE_CHANGE = 1e-9  # of the largest set point: changes below it are none
STAYS = 0.02  # s, a set point that stands shorter is still on its way
SHARE = 1e-3  # of the longest way, below which a change is no move


@dataclass(frozen=True)
class Wheel:
    """One of the wheels: what was recorded of it and its motor, (n,) each; slip and traction (2, n): along the axis, around."""

    name: str
    signals: Mapping[str, np.ndarray]  # of rate, torque, voltage, current, electrical_power
    slip: np.ndarray | None
    traction: np.ndarray | None


@dataclass(frozen=True)
class Drive:
    """A sleeve with its two wheels; arrays are (n,).

    way, wanted, error: by axis, in m and rad; wanted and error of those that a controller gives.
    level: kinetic friction of a contact at full preload, N; static: over it; NaN where they are not known.
    rests: name of a contact, shaft or seal -> 1 while it stands.
    signals: margin, contact_power, mechanical_energy, those that were recorded.
    """

    unit: str
    time: np.ndarray
    way: Mapping[str, np.ndarray]
    wanted: Mapping[str, np.ndarray]
    error: Mapping[str, np.ndarray]
    wheels: tuple[Wheel, Wheel]
    level: float
    static: float
    rests: Mapping[str, np.ndarray]
    signals: Mapping[str, np.ndarray]


@dataclass(frozen=True)
class Move:
    """A change of a set point and what followed, up to the next one or the end; in the axis's unit, times in s from its begin.

    lasts: of the change itself, 0 for a step.  settling_time: until the error stays within the band, None if it does not.
    overshoot: beyond the new set point, 0 if none.  left: error at the end.
    """

    axis: str
    begin: float
    lasts: float
    way: float
    settling_time: float | None
    overshoot: float
    left: float


def drives(result: Result) -> list[Drive]:
    """The drives of a run whose feed and rotation were recorded, in the order of the scene."""
    return [_drive(unit) for unit in recorded_units(result, *AXES)]


def _drive(unit: RecordedUnit) -> Drive:
    wheels: list[Wheel] = []
    rests: dict[str, np.ndarray] = {}
    for name in WHEELS:
        motor = unit.driven_by(f"{name}_rate")  # None where the whole drive is one unit
        signals = unit.recorded({n: f"{name}_{n}" for n in ("rate", "torque")})
        signals |= motor.recorded(ELECTRICAL) if motor else unit.recorded({n: f"{name}_{n}" for n in ELECTRICAL[:2]})
        wheels.append(Wheel(name, signals, *(_pair(unit, f"{name}_{what}") for what in ("slip", "traction"))))
        shaft = f"{name} shaft"
        rests |= unit.recorded({f"{name} contact": f"exact_slip.{name}_stuck", shaft: f"shaft_friction.{name}_stuck"})
        rests |= motor.recorded({shaft: "shaft_friction.stuck"}) if motor else {}
    rests |= unit.recorded({"seal": "trocar_friction.stuck"})
    controller, way = unit.driving("feed", "feed"), unit.recorded(AXES)
    wanted = controller.recorded({axis: f"wanted_{axis}" for axis in AXES}) if controller else {}
    error = {axis: wanted[axis] - way[axis] for axis in wanted}
    level, static = _levels(unit.component)
    return Drive(unit.name, unit.time, way, wanted, error, (wheels[0], wheels[1]), level, static, rests, unit.recorded(OF_DRIVE))


def _pair(unit: RecordedUnit, name: str) -> np.ndarray | None:
    """Components of a vector in the plane of contact, (2, n): along the axis, around it; None where one was not recorded."""
    recorded = unit.recorded((f"{name}_axial", f"{name}_around"))
    return np.array(list(recorded.values())) if len(recorded) == 2 else None


def _levels(component: Component | None) -> tuple[float, float]:
    """Kinetic friction of a contact, N, and the static one over it; NaN for a law without a limit, and for what is not known."""
    law = next((e for e in ("smoothed_slip", "lugre_slip", "exact_slip") if component is not None and e in component.on), "")
    if component is None or not law:
        return float("nan"), float("nan")
    ratio = f"{law}.static_ratio"
    level = component["friction"] * component["normal_force"]
    return level, level * component[ratio] if ratio in component.parameters else level


def moves(drive: Drive, bands: Mapping[str, float] = BANDS) -> list[Move]:
    """Every change of a set point, axis by axis; rows of a table that follow at once are one change."""
    records = []
    for axis, wanted in drive.wanted.items():
        size = float(np.abs(wanted).max(initial=0.0))
        changing = np.flatnonzero(np.abs(np.diff(wanted)) > NEGLIGIBLE_CHANGE * size)
        if not changing.size:
            continue
        breaks = np.flatnonzero(drive.time[changing[1:]] - drive.time[changing[:-1] + 1] > STAYS)
        firsts = changing[np.concatenate(([0], breaks + 1))]
        lasts = changing[np.concatenate((breaks, [changing.size - 1]))] + 1
        for k, (first, last) in enumerate(zip(firsts, lasts, strict=True)):
            end = int(firsts[k + 1]) if k + 1 < firsts.size else wanted.size - 1
            if abs(wanted[last] - wanted[first]) > SHARE * size:
                records.append(_move(drive, axis, int(first), int(last), end, bands[axis]))
    return sorted(records, key=lambda m: (m.begin, m.axis))


def _move(drive: Drive, axis: str, first: int, last: int, end: int, band: float) -> Move:
    time, error = drive.time, drive.error[axis]
    way = float(drive.wanted[axis][last] - drive.wanted[axis][first])
    begin = float(time[last]) if last == first + 1 else float(time[first])  # a step is there at its sample
    section = slice(last, end + 1)
    outside = np.flatnonzero(np.abs(error[section]) > band)
    lasts = 0.0 if last == first + 1 else float(time[last]) - begin
    settling_time = None
    if not outside.size:
        settling_time = lasts
    elif outside[-1] < error[section].size - 1:  # between the last row outside and the first inside, on a straight line
        row = last + int(outside[-1])
        edge = band if error[row] > 0.0 else -band
        settling_time = float(np.interp(edge, *_rising(error[row : row + 2], time[row : row + 2]))) - begin
    overshoot = max(0.0, float(np.max(-np.sign(way) * error[section])))
    return Move(axis, begin, lasts, way, settling_time, overshoot, float(error[end]))


def _rising(values: np.ndarray, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two values and their times in the order of the values."""
    return (values, time) if values[0] < values[1] else (values[::-1], time[::-1])


def standing(drive: Drive) -> float:
    """The time from which on no set point changes, s; the begin of the record where none ever does."""
    changes = [np.flatnonzero(np.abs(np.diff(w)) > NEGLIGIBLE_CHANGE * np.abs(w).max(initial=0.0)) for w in drive.wanted.values()]
    return float(drive.time[max((int(c[-1]) + 1 for c in changes if c.size), default=0)])


def at_rest(drive: Drive) -> int | None:
    """The first sample behind the last change of a set point at which all shafts stand; None where that does not happen."""
    shafts = [rest for name, rest in drive.rests.items() if "shaft" in name]
    if not shafts:
        return None
    still = np.flatnonzero(np.all(shafts, axis=0) & (drive.time >= standing(drive)))
    return int(still[0]) if still.size else None


def starts(rest: np.ndarray) -> int:
    """How often something that stands, (n,) 1 or 0, breaks loose."""
    return int(np.sum(np.diff(rest) < 0.0))


def energies(drive: Drive) -> dict[str, float]:
    """Energies over the record, J: into the motors, at the wheels, taken up by the contacts, gained by the sleeve."""
    time, given = drive.time, {}
    electrical = [s["electrical_power"] for s in (drive.signals, *(w.signals for w in drive.wheels)) if "electrical_power" in s]
    if electrical:
        given["motors"] = float(accumulated(time, np.sum(electrical, axis=0))[-1])
    if all({"rate", "torque"} <= w.signals.keys() for w in drive.wheels):
        power = np.sum([w.signals["rate"] * w.signals["torque"] for w in drive.wheels], axis=0)
        given["wheels"] = float(accumulated(time, power)[-1])
    if "contact_power" in drive.signals:
        given["contacts"] = float(accumulated(time, drive.signals["contact_power"])[-1])
    if "mechanical_energy" in drive.signals:
        given["sleeve"] = float(np.diff(drive.signals["mechanical_energy"][[0, -1]])[0])
    return given
