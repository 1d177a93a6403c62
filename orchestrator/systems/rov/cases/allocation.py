"""Six thrusters in the Y-arrangement: what wrenches they can give, all six together and without one of them."""

from __future__ import annotations

import math

import numpy as np

from .....components.rov.allocation import allocate, allocation_of
from .....components.rov.arrangement import HORIZONTAL_HEIGHT, HORIZONTAL_RADIUS, VERTICAL_RADIUS, wrench_matrix, y_arrangement
from ....harness.validation import Evidence, Runs

FORWARD, REVERSE = 51.44, 39.90  # N, T200 at 16 V, ends of the maker's sheet
AXES = ("X", "Y", "Z", "K", "M", "N")
UNITS = ("N",) * 3 + ("N.m",) * 3
ASKED = 1e3  # N or N.m, beyond every limit
ALL = 2**6 - 1  # thrusters that are available, as bits


def measure(runs: Runs) -> Evidence:
    """Nothing is simulated: the matrix from thrusts to the wrench, its inverse and its limits."""
    matrix = wrench_matrix(*y_arrangement())
    values = np.linalg.svd(matrix, compute_uv=False)
    measured = {"determinant": abs(float(np.linalg.det(matrix))), "condition": float(values[0] / values[-1])}
    measured |= {f"singular.{i}": float(v) for i, v in enumerate(values, 1)}
    ranks = [int(np.linalg.matrix_rank(np.delete(matrix, i, axis=1))) for i in range(6)]
    measured |= {"rank": float(np.linalg.matrix_rank(matrix)), "rank.least": float(min(ranks)), "rank.most": float(max(ranks))}
    article = printed()
    measured |= {"printed.determinant": float(np.linalg.det(article)), "printed.condition": float(np.linalg.cond(article))}
    for j, axis in enumerate(AXES):
        for sign, word in ((1.0, "plus"), (-1.0, "minus")):
            measured[f"{axis}.{word}"] = largest(matrix, j, sign)
    rows = [(a, u, *(round(measured[f"{a}.{word}"], 3) for word in ("plus", "minus"))) for a, u in zip(AXES, UNITS, strict=True)]
    return Evidence(measured, data={"rows": rows})


def largest(matrix: np.ndarray, axis: int, sign: float) -> float:
    """Component that comes of asking far too much along one axis: the wrench is scaled as a whole."""
    wrench, thrust, given = np.zeros(6), np.zeros(6), np.zeros(6)
    wrench[axis] = sign * ASKED
    allocate(wrench, allocation_of(matrix, np.ones(6), ALL), matrix, FORWARD, REVERSE, thrust, given)
    return float(given[axis])


def printed() -> np.ndarray:
    """The columns of the article's equation (9) with the magnitudes of its table of positions, (6, 6)."""
    c, s = math.cos(math.pi / 6.0), 0.5
    far, near = (HORIZONTAL_RADIUS, VERTICAL_RADIUS), (0.5 * HORIZONTAL_RADIUS, 0.5 * VERTICAL_RADIUS)
    aside, z = (c * HORIZONTAL_RADIUS, c * VERTICAL_RADIUS), HORIZONTAL_HEIGHT
    return np.array(
        [
            [0.0, 1.0, 0.0, z, 0.0, far[0]],
            [c, s, 0.0, s * z, c * z, s * near[0] + c * aside[0]],
            [c, -s, 0.0, -s * z, c * z, -s * near[0] - c * aside[0]],
            [0.0, 0.0, 1.0, 0.0, far[1], 0.0],
            [0.0, 0.0, 1.0, -aside[1], -near[1], 0.0],
            [0.0, 0.0, 1.0, aside[1], -near[1], 0.0],
        ]
    ).T
