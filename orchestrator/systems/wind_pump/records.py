"""Wind pumps of a run, by their connections: speeds, powers along the chain, starts and stops, water.

[analysis]
system = "wind_pump"
average = 2.0           # s, moving mean of speeds and powers before they are compared: a piston's pulsation is gone
standstill = 0.1        # rad/s, below which a shaft counts as standing
pause = 10.0            # s, a shorter standstill between two strokes is no stop
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from ...harness.analysis.records import RecordedUnit, recorded_units
from ...harness.analysis.signals import accumulated

if TYPE_CHECKING:
    from ...run.results import Result

TURN = 2.0 * np.pi
STANDSTILL, PAUSE = 0.1, 10.0  # rad/s; s
TURNING_POINTS = 6  # of the mean wind; with more of them there are no branches, rising and falling
NOTICED = 0.05  # of its range, below which a change of the wind is no turning point
STAGES = ("aerodynamic", "turbine_shaft", "pump_shaft", "hydraulic")  # powers along the chain, from the wind to the water
OF_TRANSMISSION = {"turbine_speed": "turbine_speed", "pump_speed": "speed"}
OF_TURBINE = ("power_coefficient", "tip_speed_ratio")
OF_PIPE = {"delivered": "delivered", "head": "head", "level": "tank.level"}


@dataclass(frozen=True)
class Chain:
    """A turbine, the transmission it drives, and what that drives; arrays are (n,), those that were recorded.

    name: of the transmission.  time: s.  wind: m/s, None where it was not recorded.
    signals: turbine_speed and pump_speed in rad/s, power_coefficient, tip_speed_ratio, flow in m³/s, delivered in m³, head
        and level in m.
    powers: of `STAGES`, W: what the wind does on the rotor, the turbine on the transmission, the transmission on the pump, the
        pump on the water.
    """

    name: str
    turbine: str
    time: np.ndarray
    wind: np.ndarray | None
    signals: Mapping[str, np.ndarray]
    powers: Mapping[str, np.ndarray]


@dataclass(frozen=True)
class Running:
    """A time in which a pump ran. begin, end: s; an end that the record does not show is None, and so is its wind, m/s."""

    begin: float | None
    end: float | None
    begin_wind: float | None
    end_wind: float | None
    turns: float


def chains(result: Result) -> list[Chain]:
    """The wind pumps of a run whose pump speed was recorded, in the order of the scene."""
    driven = [(unit, unit.driven_by("turbine_speed")) for unit in recorded_units(result, "speed")]
    return [_chain(unit, turbine) for unit, turbine in driven if turbine is not None]


def _chain(transmission: RecordedUnit, turbine: RecordedUnit) -> Chain:
    pump = transmission.driven_by("load_torque")
    pipe = pump.driving("flow", "flow") if pump is not None else None
    signals = transmission.recorded(OF_TRANSMISSION) | turbine.recorded(OF_TURBINE)
    torques = transmission.recorded(("turbine_torque", "load_torque"))
    powers = turbine.recorded({"aerodynamic": "power"})
    if "turbine_torque" in torques and "turbine_speed" in signals:
        powers["turbine_shaft"] = torques["turbine_torque"] * signals["turbine_speed"]
    if "load_torque" in torques:
        powers["pump_shaft"] = torques["load_torque"] * signals["pump_speed"]
    if pump is not None:
        signals |= pump.recorded(("flow",))
        powers |= pump.recorded({"hydraulic": "hydraulic_power"})
    if pipe is not None:
        signals |= pipe.recorded(OF_PIPE)
    return Chain(transmission.name, turbine.name, transmission.time, turbine.optional("wind"), signals, powers)


def moving_mean(time: np.ndarray, values: np.ndarray, width: float) -> np.ndarray:
    """Mean of values (n,) over `width` s around every time (n,), over what there is of it at the ends; trapezoids in between."""
    if width <= 0.0 or time.size < 2:
        return np.asarray(values, dtype=float)
    integral = accumulated(time, values)
    low, high = np.clip(time - 0.5 * width, time[0], time[-1]), np.clip(time + 0.5 * width, time[0], time[-1])
    return (_integral_at(time, values, integral, high) - _integral_at(time, values, integral, low)) / (high - low)


def _integral_at(time: np.ndarray, values: np.ndarray, integral: np.ndarray, at: np.ndarray) -> np.ndarray:
    """The integral of the values' polygon up to times between the samples."""
    k = np.clip(np.searchsorted(time, at, side="right") - 1, 0, time.size - 2)
    s = at - time[k]
    slope = (values[k + 1] - values[k]) / (time[k + 1] - time[k])
    return integral[k] + s * (values[k] + 0.5 * slope * s)


def runnings(chain: Chain, standstill: float = STANDSTILL, pause: float = PAUSE) -> list[Running]:
    """The times in which the pump's shaft was faster than `standstill` (rad/s) and made a turn or more.

    A piston that creeps up its stroke against a load it cannot overcome moves, but does not run; one that waits for no more than
    `pause` s before its stroke, while the turbine gathers speed, has not stopped.
    """
    time, speed = chain.time, chain.signals["pump_speed"]
    moving = np.concatenate(([False], speed > standstill, [False]))
    edges = np.flatnonzero(moving[1:] != moving[:-1])
    angle = accumulated(time, speed)
    joined: list[list[int]] = []
    for first, after in edges.reshape(-1, 2).tolist():
        if joined and time[first] - time[joined[-1][1]] <= pause:
            joined[-1][1] = after
        else:
            joined.append([first, after])
    records = []
    for first, after in joined:
        turns = float(angle[after - 1] - angle[first]) / TURN
        if turns >= 1.0:
            begin, end = first if first > 0 else None, after if after < time.size else None
            records.append(Running(_at(time, begin), _at(time, end), _at(chain.wind, begin), _at(chain.wind, end), turns))
    return records


def _at(values: np.ndarray | None, sample: int | None) -> float | None:
    return float(values[sample]) if values is not None and sample is not None else None


def branches(wind: np.ndarray) -> list[tuple[str, slice]]:
    """The stretches in which the wind rises and falls; none where it turns about too often to be followed, or stays."""
    size = float(np.ptp(wind))
    if size <= NOTICED * float(np.abs(wind).max(initial=0.0)):
        return []
    turns, least = [0], NOTICED * size
    extreme, sign = 0, 0.0
    for k in range(1, wind.size):
        change = float(wind[k] - wind[extreme])
        if sign * change >= 0.0 and (sign or abs(change) >= least):
            sign, extreme = sign or float(np.sign(change)), k
        elif sign * change <= -least and sign:
            turns.append(extreme)
            sign, extreme = -sign, k
            if len(turns) > TURNING_POINTS:
                return []
    ends = [*turns, wind.size - 1]
    return [("rising" if wind[b] > wind[a] else "falling", slice(a, b + 1)) for a, b in pairwise(ends)]


def efficiencies(chain: Chain, start: int = 0) -> list[tuple[str, float, float | None]]:
    """(stage, energy in J from the sample `start` on, share of the recorded stage before it); None for the first stage."""
    rows: list[tuple[str, float, float | None]] = []
    for stage in STAGES:
        if stage in chain.powers:
            energy = float(accumulated(chain.time[start:], chain.powers[stage][start:])[-1])
            before = rows[-1][1] if rows else 0.0
            rows.append((stage, energy, energy / before if before > 0.0 else None))
    return rows


def wind_energy(result: Result, chain: Chain, start: int = 0) -> float | None:
    """Energy of the air that would have passed the rotor's area, J; None where density or radius are not known."""
    component = RecordedUnit(result, chain.turbine).component
    if chain.wind is None or component is None:
        return None
    density, radius = (component.parameters.get(name) for name in ("density", "radius"))
    if not (isinstance(density, float) and isinstance(radius, float)):
        return None
    power = 0.5 * density * np.pi * radius**2 * chain.wind**3
    return float(accumulated(chain.time[start:], power[start:])[-1])
