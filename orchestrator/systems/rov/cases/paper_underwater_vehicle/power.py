"""Ideal power of both layouts for the same force, from the controller's own allocation."""

from __future__ import annotations

import numpy as np

from ......components.rov.allocation import THRUSTERS, allocate, allocation_of, share_out
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
    drawn = {
        "heading": angle,
        "powers": {f"{n} thrusters": v for n, v in along.items()},
        "attainable": {f"{n} thrusters, attainable": v for n, v in force.items()},
        "given": {f"{n} thrusters, controller": v for n, v in first.items()},
    }
    return Evidence(measured, data=drawn)


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
    n = matrix.shape[1]
    per_wrench, thrust, results = table(matrix), np.zeros(n), np.zeros_like(wrenches)
    for wrench, result in zip(wrenches, results, strict=True):
        scale = allocate(wrench, per_wrench, matrix, AHEAD, ASTERN, thrust, result)
        if n > THRUSTERS and scale < 1.0:
            room = np.zeros((n, 6)), np.zeros((4, n, n + 6)), np.zeros((6, n))
            share_out(wrench, np.ones(6), matrix, 2**n - 1, AHEAD, ASTERN, thrust, result, *room)
    return np.linalg.norm(results, axis=1)
