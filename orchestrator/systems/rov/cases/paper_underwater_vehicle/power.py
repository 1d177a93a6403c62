"""Ideal power of both layouts for the same force, from the controller's own allocation."""

from __future__ import annotations

import numpy as np

from ......components.rov.allocation import allocate, allocation_of
from .....harness.charts.chart import Chart, Panel, Series
from .....harness.validation import Evidence, Runs
from .layouts import AHEAD, ASTERN, MATRICES, ideal_power
from .wrench_sets import circle, largest

FORCE = 30.0  # N, that both layouts give in every heading
ASKED = 1e3  # N, beyond every limit


def measure(runs: Runs) -> Evidence:
    """Nothing is simulated: thrusts of the controller's table for a force in every heading, and for lift."""
    heave = {name: ideal_power(thrusts(matrix, np.eye(6)[2])) for name, matrix in MATRICES.items()}
    level = {name: flat(matrix) for name, matrix in MATRICES.items()}
    along = {name: ideal_power(thrusts(m, FORCE * circle(0, 1)).T) for name, m in MATRICES.items()}
    plane = {name: ideal_power(thrusts(m, FORCE * circle(0, 1)).T) for name, m in level.items()}
    first = {name: given(matrix, ASKED * circle(0, 1)) for name, matrix in MATRICES.items()}
    measured = {
        "power.heave": heave["six"] / heave["eight"],
        "power.plane": float(plane["six"].mean() / plane["eight"].mean()),
        "power.offset": float(along["six"].mean() / along["eight"].mean()),
        **{f"power.{name}": float(values.mean()) for name, values in along.items()},
        **{f"saturation.{name}": float(values.min()) for name, values in first.items()},
    }
    angle = np.arange(len(along["six"])) * 360.0 / len(along["six"])
    force = {name: largest(m, circle(0, 1)) for name, m in MATRICES.items()}
    panels = (
        Panel(f"ideal power of {FORCE:g} N, W", tuple(Series(f"{n} thrusters", angle, v) for n, v in along.items())),
        Panel(
            "largest horizontal force, N",
            (
                *(Series(f"{n} thrusters, attainable", angle, v) for n, v in force.items()),
                *(Series(f"{n} thrusters, controller", angle, v) for n, v in first.items()),
            ),
        ),
    )
    chart = Chart(
        "Power and limit over the heading of a horizontal force",
        "heading in the body, degrees",
        panels,
        "The controller takes the smallest thrusts and scales the wrench as a whole when the first thruster is at its "
        "limit. Of eight thrusters that leaves a part of what they could give unused.",
    )
    return Evidence(
        measured,
        (chart,),
        notes=(
            "Thrust shared by more propellers costs less, as the square root of their number. The horizontal thrusters of the eight "
            "lie 0.085 m below the origin: the pitch that they cause is held by the vertical ones, which costs more than it saves.",
        ),
    )


def flat(matrix: np.ndarray) -> np.ndarray:
    """The layout with its horizontal thrusters at the height of the origin: no roll and pitch of horizontal thrusts."""
    level, horizontal = matrix.copy(), np.abs(matrix[2]) < 0.5
    level[3:5, horizontal] = 0.0
    return level


def table(matrix: np.ndarray) -> np.ndarray:
    """The controller's thrusts per wrench, all thrusters available, (n, 6)."""
    return allocation_of(matrix, np.ones(6), 2 ** matrix.shape[1] - 1)


def thrusts(matrix: np.ndarray, wrenches: np.ndarray) -> np.ndarray:
    """Thrusts of the controller's table for wrenches, (..., 6), all thrusters available, (..., n), N."""
    return wrenches @ table(matrix).T


def given(matrix: np.ndarray, wrenches: np.ndarray) -> np.ndarray:
    """Sizes of what the controller gives of wrenches, (k, 6), within the limits, (k,)."""
    per_wrench, thrust, results = table(matrix), np.zeros(matrix.shape[1]), np.zeros_like(wrenches)
    for wrench, result in zip(wrenches, results, strict=True):
        allocate(wrench, per_wrench, matrix, AHEAD, ASTERN, thrust, result)
    return np.linalg.norm(results, axis=1)
