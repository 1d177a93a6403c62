"""Where thrusters sit and which way they push: two arrangements, and the matrix from thrusts to the wrench on the body.

The Y-arrangement has three horizontal thrusters on one circle, each along the circle's tangent, and three vertical ones on
another, 120 degrees apart: six thrusters for six degrees of freedom. Body axes: x ahead, y to starboard, z down.
Source: Kabanov, Kramar, Ermakov, "Design and modeling of an experimental ROV with six degrees of freedom", Drones 5 (2021)
113: its table of positions, of which only magnitudes could be read, so that signs and the height of the last two vertical
thrusters are inferred from the layout. The columns printed there as (9), taken with those magnitudes, are no arrangement of 120
degrees (determinant -0.0172, condition 20); the matrix here is therefore built from positions and directions alone.

The arrangement of eight is that of a BlueROV2 Heavy, the usual layout for six degrees of freedom: four horizontal thrusters at 45
degrees to the axes, and four vertical ones. Places of the horizontal ones: a public allocation script for that vehicle, read;
of the vertical ones: von Benzon et al. (2022), from memory; which of them push downwards when they turn ahead: inferred, so that
the limits of neighbours, which differ ahead and astern, cancel.
"""

from __future__ import annotations

import math

import numpy as np

from ..core.contract import Refusal
from ..core.kernels import DONE, OWN, in_python, kernel

HORIZONTAL_RADIUS = 0.15125  # m
HORIZONTAL_HEIGHT = -0.00387  # m, above the origin
VERTICAL_RADIUS = 0.225  # m
NO_DIRECTION, NO_FURTHER_DIRECTION = OWN + 5, OWN + 6  # statuses
REFUSALS = {
    NO_DIRECTION: Refusal(
        "thruster {refused[0]} with the direction (0, 0, 0)",
        "a direction",
        "Set thruster_direction_x[{refused[0]}], _y[{refused[0]}], _z[{refused[0]}].",
    ),
    NO_FURTHER_DIRECTION: Refusal(
        "thruster {refused[0]} with the direction (0, 0, 0)",
        "a direction",
        "Set further_thrusters.thruster_direction_x[{refused[1]}], _y[{refused[1]}], _z[{refused[1]}].",
    ),
}
EIGHT = "BlueROV2 Heavy, eight thrusters"  # name of the preset of hull and controller


def y_arrangement() -> tuple[np.ndarray, np.ndarray]:
    """Positions in m and directions of thrust, (6, 3) each: three horizontal thrusters, then three vertical ones."""
    turns = 2.0 * math.pi / 3.0 * np.arange(3)
    around, along = np.c_[np.cos(turns), np.sin(turns)], np.c_[-np.sin(turns), np.cos(turns)]
    positions, directions = np.zeros((6, 3)), np.zeros((6, 3))
    positions[:3, :2], positions[:3, 2], directions[:3, :2] = HORIZONTAL_RADIUS * around, HORIZONTAL_HEIGHT, along
    positions[3:, :2], directions[3:, 2] = VERTICAL_RADIUS * around, 1.0
    return positions, directions


def eight_arrangement() -> tuple[np.ndarray, np.ndarray]:
    """Positions in m and directions of thrust, (8, 3) each, of a BlueROV2 Heavy: four horizontal thrusters, four vertical ones.

    Each four: starboard bow, port bow, starboard stern, port stern.
    """
    ahead, aside = np.array([1.0, 1.0, -1.0, -1.0]), np.array([1.0, -1.0, 1.0, -1.0])
    positions, directions = np.zeros((8, 3)), np.zeros((8, 3))
    positions[:4] = np.c_[0.156 * ahead, 0.111 * aside, np.full(4, 0.085)]
    positions[4:] = np.c_[0.120 * ahead, 0.218 * aside, np.zeros(4)]
    directions[:4] = np.c_[ahead, -aside, np.zeros(4)] * math.sqrt(0.5)
    directions[4:, 2] = ahead * aside
    return positions, directions


def sf_30k_arrangement() -> tuple[np.ndarray, np.ndarray]:
    """Positions in m and directions of thrust, (8, 3) each, of an SF 30k: four steep thrusters, then four level ones.

    Places and angles of the copy in the repository uuvsimulator/uuv_simulator (RexROV), whose axes are forward, port, up, read.
    """
    x, y, z = np.array([-0.890895, -0.890895, 0.890895, 0.890895]), np.array([1.0, -1.0, 1.0, -1.0]), 0.528822
    level = np.array([-0.412125, -0.412125, 0.412125, 0.412125])
    pitch = np.radians([-74.53, -74.53, -105.47, -105.47, 0.0, 0.0, 0.0, 0.0])
    yaw = np.radians([-53.21, 53.21, 53.21, -53.21, 45.0, -45.0, 135.0, -135.0])
    positions = np.vstack([np.c_[x, 0.334385 * y, np.full(4, z)], np.c_[level, 0.505415 * y, np.full(4, 0.129)]])
    directions = np.c_[np.cos(yaw) * np.cos(pitch), np.sin(yaw) * np.cos(pitch), -np.sin(pitch)]
    return positions * [1.0, -1.0, -1.0], directions * [1.0, -1.0, -1.0]


def eight_places(arrangement: tuple[np.ndarray, np.ndarray] | None = None) -> dict[str, float]:
    """An arrangement of eight, by default `eight_arrangement`, as parameters of a hull or a controller with `further_thrusters`."""
    names = [f"thruster_{a}" for a in "xyz"] + [f"thruster_direction_{a}" for a in "xyz"]
    values = np.hstack(arrangement or eight_arrangement())
    return {
        f"{n}[{i + 1}]" if i < 6 else f"further_thrusters.{n}[{i - 5}]": float(values[i, j])
        for j, n in enumerate(names)
        for i in range(8)
    }


def columns(table: np.ndarray) -> tuple[tuple[float, ...], ...]:
    """The columns of an array as tuples of numbers, for starts of declared variables; rounded to 1e-15."""
    return tuple(tuple(float(v) + 0.0 for v in column) for column in np.round(table, 15).T)


def wrench_matrix(positions: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """Wrench (X, Y, Z, K, M, N) on the body per thrust, (6, n), for positions in m and directions of thrust, (n, 3) each."""
    places = np.hstack((positions, directions)).tolist()
    return np.ascontiguousarray(np.array([in_python(wrench_of)(*place) for place in places]).T)


@kernel
def wrench_of(x, y, z, a, b, c):
    """Wrench (X, Y, Z, K, M, N) on the body per thrust at (x, y, z) in m along (a, b, c), which may have any length but 0."""
    length = math.sqrt(a * a + b * b + c * c)
    a, b, c = a / length, b / length, c / length
    return a, b, c, y * c - z * b, z * a - x * c, x * b - y * a


@kernel
def add_thrusters(matrix, first, places):
    """Columns of the matrix, (6, n), from `first` on, of some thrusters; returns the number of one without a direction, or 0."""
    for i in range(places.thruster_x.size):
        a, b, c = places.thruster_direction_x[i], places.thruster_direction_y[i], places.thruster_direction_z[i]
        if not a * a + b * b + c * c > 0.0:
            return i + 1
        column = wrench_of(places.thruster_x[i], places.thruster_y[i], places.thruster_z[i], a, b, c)
        for j in range(6):
            matrix[j, first + i] = column[j]
    return 0


@kernel
def arrange(matrix, refused, p, further):
    """Matrix of all thrusters, those of the effect `further_thrusters` or None behind the others; returns a status.

    refused: (2,) numbers of a refusal.
    """
    refused[0] = add_thrusters(matrix, 0, p)
    if refused[0] > 0.0:
        return NO_DIRECTION
    if further is not None:
        refused[1] = add_thrusters(matrix, p.thruster_x.size, further)
        if refused[1] > 0.0:
            refused[0] = p.thruster_x.size + refused[1]
            return NO_FURTHER_DIRECTION
    return DONE
