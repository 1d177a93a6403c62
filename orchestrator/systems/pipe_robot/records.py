"""Pipe robots of a run: motion in the mean over a period of the exciter, modes of the friction, where the energy goes.

[analysis]
system = "pipe_robot"
transient = 2.0         # s, left out of tables, and where a motion that repeats is shown
average = 0.1           # s, of mean speeds; without it the exciter's period at each instant
detail = [8.0, 8.4]     # s, the part of the run that is shown in detail; the last four periods without it
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...harness.analysis.records import RecordedUnit, recorded_units
from ...harness.analysis.signals import accumulated
from . import PipeRobotKeys

if TYPE_CHECKING:
    from ...run.results import Result

TURN = 2.0 * np.pi
FREQUENCIES = ("unbalance.rate", "harmonic_force.frequency", "prescribed_motion.frequency")
SIGNALS = ("position", "velocity", "inner_position", "inner_velocity", "friction_force", "mode", "exciter_power", "dissipation",
           "route.slope", "route.weight_power", "tow.force")  # fmt: skip
SLOWEST = 0.05  # of the record; periods of an exciter that hardly turns are taken to be no longer
STEADY = 1e-6  # relative change of a period that is none


@dataclass(frozen=True)
class RobotRecord:
    """The recorded part of a robot of a run; arrays are (n,).

    signals: those of `SIGNALS` that were recorded.  frequency: of the exciter, rad/s, None where nothing tells.
    period: s, over which means are taken.  resonances: "free" and "stuck", natural frequencies of the inner mass, rad/s.
    """

    unit: str
    time: np.ndarray
    signals: Mapping[str, np.ndarray]
    frequency: np.ndarray | None
    period: np.ndarray
    resonances: Mapping[str, float]

    @property
    def stretch(self) -> np.ndarray | None:
        """Way of the inner mass from the body, m, None where it was not recorded."""
        inner = self.signals.get("inner_position")
        return None if inner is None else inner - self.signals["position"]

    @property
    def modes(self) -> np.ndarray:
        """1 forwards, -1 backwards, 0 at rest: as recorded, or the sign of the velocity."""
        mode = self.signals.get("mode")
        return np.sign(self.signals["velocity"]) if mode is None else np.round(mode)


def robots(result: Result) -> list[RobotRecord]:
    """The robots of a run whose position and velocity were recorded, in the order of the scene."""
    return [_robot(u) for u in recorded_units(result, "position", "velocity")]


def _robot(u: RecordedUnit) -> RobotRecord:
    component, time = u.component, u.time
    frequency = None
    for name in FREQUENCIES:
        if u.column(name):
            frequency = np.abs(u[name])
        elif component is not None and (name in component.parameters or name in component.inputs):
            frequency = np.full(time.size, float(component.get(name)))
    longest = SLOWEST * float(time[-1] - time[0])
    period = np.full(time.size, u.result.scene.analysis_as(PipeRobotKeys).average)
    if frequency is not None and not period.any():
        period = np.minimum(TURN / np.maximum(frequency, TURN / longest), longest)
    resonances = {}
    if component is not None and "inner_mass" in component.parameters:
        k, m1, m2 = (component.get(n) for n in ("stiffness", "body_mass", "inner_mass"))
        resonances = {"free": float(np.sqrt(k * (1.0 / m1 + 1.0 / m2))), "stuck": float(np.sqrt(k / m2))}
    return RobotRecord(u.name, time, u.recorded(SIGNALS), frequency, period, resonances)


def _ends(record: RobotRecord) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(half a period before every time, half a period after it, whether the record has both), (n,) each."""
    low, high = record.time - 0.5 * record.period, record.time + 0.5 * record.period
    edge = 1e-9 * record.period
    return low, high, (low >= record.time[0] - edge) & (high <= record.time[-1] + edge) & (record.period > 0.0)


def mean_over(record: RobotRecord, values: np.ndarray) -> np.ndarray:
    """Mean of values (n,) over a period around every time, (n,); NaN where the record does not have all of the period."""
    integral = accumulated(record.time, values)
    low, high, whole = _ends(record)
    gained = np.interp(high, record.time, integral) - np.interp(low, record.time, integral)
    return np.where(whole, gained / np.where(whole, record.period, 1.0), np.nan)


def mean_speed(record: RobotRecord) -> np.ndarray:
    """Way of the body within a period around every time, over the period, m/s, (n,); NaN as in `mean_over`.

    The velocity itself where nothing tells of a period.
    """
    if not record.period.any():
        return record.signals["velocity"]
    low, high, whole = _ends(record)
    way = np.interp(high, record.time, record.signals["position"]) - np.interp(low, record.time, record.signals["position"])
    return np.where(whole, way / np.where(whole, record.period, 1.0), np.nan)


def steady_speed(record: RobotRecord, kept: slice) -> float:
    """Way over time in the samples `kept`, m/s; in whole periods up to their end, if there are any of a constant length."""
    t, x = record.time[kept], record.signals["position"][kept]
    period = record.period[kept]
    begin = t[0]
    if period[-1] > 0.0 and np.ptp(period) <= STEADY * period[-1] and (count := int((t[-1] - t[0]) / period[-1] + 1e-9)):
        begin = t[-1] - count * period[-1]
    return float((x[-1] - np.interp(begin, t, x)) / (t[-1] - begin))


def amplitude(record: RobotRecord) -> np.ndarray | None:
    """Amplitude of the inner mass against the body, m, (n,): that of the sine with the same mean square over a period."""
    stretch = record.stretch
    if stretch is None:
        return None
    return np.sqrt(2.0 * np.maximum(mean_over(record, stretch**2) - mean_over(record, stretch) ** 2, 0.0))


def standing_since(record: RobotRecord) -> float | None:
    """The time from which on the body is at rest to the end of the record, s; None where it moves at the end."""
    moving = np.flatnonzero(record.signals["velocity"] != 0.0)
    first = 0 if moving.size == 0 else int(moving[-1]) + 1
    return float(record.time[first]) if first < record.time.size - 1 else None


def shares(record: RobotRecord, kept: slice) -> dict[int, float]:
    """Share of the time in each mode of the samples `kept`: 1, 0 and -1."""
    modes = record.modes[kept]
    return {m: float(np.mean(modes == m)) for m in (1, 0, -1)}


def switches(record: RobotRecord, kept: slice) -> float:
    """Changes of the mode a second in the samples `kept`; those between two samples are not seen."""
    modes, t = record.modes[kept], record.time[kept]
    return float(np.count_nonzero(np.diff(modes))) / float(t[-1] - t[0])


def energies(record: RobotRecord, kept: slice) -> dict[str, float]:
    """Energy in the samples `kept`, J: "exciter" gives, "lost", "lifted" and "towed" take; those that were recorded."""
    t, s = record.time[kept], record.signals
    flows = {"exciter": s.get("exciter_power"), "lost": s.get("dissipation"), "lifted": None, "towed": None}
    if "route.weight_power" in s:
        flows["lifted"] = -s["route.weight_power"]
    if "tow.force" in s:
        flows["towed"] = -s["tow.force"] * s["velocity"]
    return {n: float(accumulated(t, v[kept])[-1]) for n, v in flows.items() if v is not None}


def detail(record: RobotRecord, given: tuple[float, float] | None, periods: float = 4.0) -> slice:
    """The samples of a part of the run: the one given in s, or the last `periods` of the exciter."""
    begin, end = given if given is not None else (record.time[-1] - periods * record.period[-1], record.time[-1])
    first = max(int(np.searchsorted(record.time, begin - 1e-12)), 0)
    after = int(np.searchsorted(record.time, end + 1e-12))
    return slice(min(first, max(after - 2, 0)), after)
