"""Where the thrusters sit and which way they push: the Y-arrangement, and the matrix from thrusts to the wrench on the body.

The Y-arrangement has three horizontal thrusters on one circle, each along the circle's tangent, and three vertical ones on
another, 120 degrees apart: six thrusters for six degrees of freedom. Body axes: x ahead, y to starboard, z down.
Source: Kabanov, Kramar, Ermakov, "Design and modeling of an experimental ROV with six degrees of freedom", Drones 5 (2021)
113: its table of positions, of which only magnitudes could be read, so that signs and the height of the last two vertical
thrusters are inferred from the layout. The columns printed there as (9), taken with those magnitudes, are no arrangement of 120
degrees (determinant -0.0172, condition 20); the matrix here is therefore built from positions and directions alone.
"""

from __future__ import annotations

import math

import numpy as np

from ..core.errors import BadInput

HORIZONTAL_RADIUS = 0.15125  # m
HORIZONTAL_HEIGHT = -0.00387  # m, above the origin
VERTICAL_RADIUS = 0.225  # m


def y_arrangement() -> tuple[np.ndarray, np.ndarray]:
    """Positions in m and directions of thrust, (6, 3) each: three horizontal thrusters, then three vertical ones."""
    turns = 2.0 * math.pi / 3.0 * np.arange(3)
    around, along = np.c_[np.cos(turns), np.sin(turns)], np.c_[-np.sin(turns), np.cos(turns)]
    positions, directions = np.zeros((6, 3)), np.zeros((6, 3))
    positions[:3, :2], positions[:3, 2], directions[:3, :2] = HORIZONTAL_RADIUS * around, HORIZONTAL_HEIGHT, along
    positions[3:, :2], directions[3:, 2] = VERTICAL_RADIUS * around, 1.0
    return positions, directions


def columns(table: np.ndarray) -> tuple[tuple[float, ...], ...]:
    """The columns of an array as tuples of numbers, for starts of declared variables; rounded to 1e-15."""
    return tuple(tuple(float(v) + 0.0 for v in column) for column in np.round(table, 15).T)


def wrench_matrix(positions: np.ndarray, directions: np.ndarray, where: str) -> np.ndarray:
    """Wrench (X, Y, Z, K, M, N) on the body per thrust, (6, n); a direction may have any length but 0, else `BadInput`."""
    lengths = np.linalg.norm(directions, axis=1)
    if not lengths.all():
        i = int(np.argmin(lengths)) + 1
        raise BadInput(where, f"thruster {i} with the direction (0, 0, 0)", "a direction",
                       f"Set thruster_direction_x[{i}], _y[{i}], _z[{i}].")
    axes = directions / lengths[:, None]
    return np.vstack((axes.T, np.cross(positions, axes).T))
