"""Every force and moment that six and eight thrusters can give within their limits, exactly: facets of a zonotope."""

from __future__ import annotations

from itertools import combinations
from typing import Any

import numpy as np

from .....harness.validation import Evidence, Runs
from .layouts import AHEAD, ASTERN, AXES, MATRICES

RESIDUAL = 0.01  # N or N.m per N or N.m asked for: what may be left over of a wrench that five thrusters give
PLANES = ((0, 1), (0, 2), (3, 4), (0, 5))
HORIZONTAL = {"six": 3, "eight": 4}  # thrusters, the first ones
SMALLEST = 1e-9


def measure(runs: Runs) -> Evidence:
    """Nothing is simulated: ranks, volumes and largest wrenches, of both layouts and after each loss."""
    measured: dict[str, float] = {}
    none = np.zeros_like(sphere())
    for name, matrix in MATRICES.items():
        values = np.linalg.svd(matrix, compute_uv=False)
        losses = [np.delete(matrix, i, axis=1) for i in range(matrix.shape[1])]
        measured |= {
            f"rank.{name}": float(np.linalg.matrix_rank(matrix)),
            f"condition.{name}": float(values[0] / values[-1]),
            f"volume.{name}": volume(matrix),
            f"rank.lost.{name}": float(min(np.linalg.matrix_rank(m) for m in losses)),
            f"force.horizontal.{name}": float(largest(matrix, circle(0, 1)).min()),
            f"force.any.{name}": float(largest(matrix, np.hstack((sphere(), none))).min()),
            f"moment.any.{name}": float(largest(matrix, np.hstack((none, sphere()))).min()),
        }
        weakest = np.min([weaker(m) for m in losses], axis=0)
        measured |= {f"lost.{axis}.{name}": float(weakest[j]) for j, axis in enumerate(AXES)}
    measured["volume.ratio"] = measured["volume.eight"] / measured["volume.six"]
    worst = {name: measured[f"force.horizontal.{name}"] for name in MATRICES}
    drawn: dict[str, Any] = {"worst": worst["six"] / worst["eight"]}
    for i, j in PLANES:
        drawn[f"{AXES[i]}.{AXES[j]}"] = {f"{name} thrusters": _outline(matrix, i, j) for name, matrix in MATRICES.items()}
    rows = []
    for name, matrix in MATRICES.items():
        left = {"none": matrix, **{str(k + 1): np.delete(matrix, k, axis=1) for k in range(matrix.shape[1])}}
        drawn[f"{name}.all"] = {"all": _outline(matrix, 0, 1)}
        drawn[f"{name}.lost"] = {f"without {k}": _outline(left[k], 0, 1) for k in list(left)[1 : HORIZONTAL[name] + 1]}
        for lost, m in left.items():
            ends = (round(float(end), 1) if end else "lost" for end in weaker(m))
            rows.append((name, lost, str(np.linalg.matrix_rank(m)), *ends))
    return Evidence(measured, data={**drawn, "rows": rows})


def volume(matrix: np.ndarray) -> float:
    """Volume of the set of wrenches, N³ (N m)³: the sum over six of n thrusters of |det| times the ranges of their thrusts."""
    width = AHEAD + ASTERN
    return float(sum(abs(np.linalg.det(matrix[:, list(c)])) for c in combinations(range(matrix.shape[1]), 6)) * width**6)


def largest(matrix: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """Largest multiples of wrenches, (k, 6), that thrusts within their limits give, (k,); 0 where a lost thruster took it away.

    Up to six thrusters: their thrusts are unique. More: the set is a zonotope, and each of its facets is spanned by five
    thrusters; along the facet's normal every other one gives what its limit allows.
    """
    if matrix.shape[1] <= 6:
        thrust = directions @ np.linalg.pinv(matrix).T
        left_over = np.abs(thrust @ matrix.T - directions).max(axis=1) > RESIDUAL * np.abs(directions).max(axis=1)
        multiple = (np.where(thrust > 0.0, AHEAD, ASTERN) / np.maximum(np.abs(thrust), SMALLEST)).min(axis=1)
        return np.where(left_over, 0.0, multiple)
    normals = _normals(matrix)
    share = normals @ matrix
    support = np.where(share > 0.0, AHEAD * share, -ASTERN * share).sum(axis=1)
    towards = directions @ normals.T
    return np.min(np.where(towards > SMALLEST, support, np.inf) / np.maximum(towards, SMALLEST), axis=1)


def weaker(matrix: np.ndarray) -> np.ndarray:
    """Largest pure force or moment along each axis, in the weaker sense, (6,)."""
    return np.minimum(largest(matrix, np.eye(6)), largest(matrix, -np.eye(6)))


def _normals(matrix: np.ndarray) -> np.ndarray:
    """Unit normals of the facets in both senses, (2 m, 6)."""
    spans = np.array([matrix[:, list(c)].T for c in combinations(range(matrix.shape[1]), 5)])
    _, values, rows = np.linalg.svd(spans)
    normals = rows[values[:, -1] > SMALLEST, -1]
    return np.vstack((normals, -normals))


def circle(i: int, j: int, count: int = 180) -> np.ndarray:
    """Directions in the plane of two axes, (count, 6)."""
    angle = 2.0 * np.pi * np.arange(count) / count
    directions = np.zeros((count, 6))
    directions[:, i], directions[:, j] = np.cos(angle), np.sin(angle)
    return directions


def sphere(count: int = 1500) -> np.ndarray:
    """Directions in space, evenly spread (Fibonacci's spiral), and the axes, (count + 6, 3)."""
    k = np.arange(count) + 0.5
    z, angle = 1.0 - 2.0 * k / count, np.pi * (1.0 + 5.0**0.5) * k
    spiral = np.c_[np.sqrt(1.0 - z * z) * np.cos(angle), np.sqrt(1.0 - z * z) * np.sin(angle), z]
    return np.vstack((spiral, np.eye(3), -np.eye(3)))


def _outline(matrix: np.ndarray, i: int, j: int) -> tuple[np.ndarray, np.ndarray]:
    ends = largest(matrix, circle(i, j))[:, None] * circle(i, j)[:, [i, j]]
    return np.r_[ends[:, 0], ends[:1, 0]], np.r_[ends[:, 1], ends[:1, 1]]
