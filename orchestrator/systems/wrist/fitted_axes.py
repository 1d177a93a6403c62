"""Axes of both rows fitted to measured rotations of a bone of the proximal row and of the hand.

Least squares over all postures of the rotations that are left between measured bones and Rot(n_p, q1), Rot(n_p, q1) Rot(n_d, q2);
the angles of each posture are unknown, too. Once with both axes across the forearm, as the model `Wrist` has them, once with any
directions: what the second one leaves less is what the model lacks.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ....components.core.errors import BadInput

POSTURES = 4  # at least
TURNED = math.radians(10.0)  # least range of both angles: of a bone that hardly turns there is no axis
START = (math.radians(15.0), math.radians(45.0))  # tilts
PARALLEL = math.radians(5.0)  # least angle between the axes


@dataclass(frozen=True)
class MeasuredAxes:
    """Angles in rad. tilts, leans: of proximal and distal axis, from that of flexion towards deviation, and out of the plane across.

    errors: standard errors of the tilts, from what is left.  left: rms rotation left of the proximal bone and of the hand.
    worst: number of the posture with most left, from 1, and how much.  angles: (K, 2) of both rows.
    """

    tilts: tuple[float, float]
    leans: tuple[float, float]
    errors: tuple[float, float]
    left: tuple[float, float]
    worst: tuple[int, float]
    angles: np.ndarray


def fit_axes(proximal: np.ndarray, hand: np.ndarray, free: bool = False) -> MeasuredAxes:
    """Of rotation vectors, (K, 3) rad each; free: axes may lean out of the plane across the forearm.

    Raises `BadInput` for too few postures, for rows that hardly turn, and for axes that are nearly parallel.
    """
    from scipy.optimize import least_squares
    from scipy.spatial.transform import Rotation

    count = len(proximal)
    if count < POSTURES:
        raise BadInput("poses", f"{count} postures", f"{POSTURES} or more")
    bones, hands = Rotation.from_rotvec(proximal), Rotation.from_rotvec(hand)
    size = 4 if free else 2

    def rotations(x: np.ndarray) -> tuple[Rotation, Rotation]:
        first, second = directions(x[:2], x[2:size] if free else np.zeros(2))
        angles = x[size:].reshape(count, 2)
        row = Rotation.from_rotvec(np.outer(angles[:, 0], first))
        return row, row * Rotation.from_rotvec(np.outer(angles[:, 1], second))

    def remaining(x: np.ndarray) -> np.ndarray:
        row, whole = rotations(x)
        return np.concatenate([(row.inv() * bones).as_rotvec(), (whole.inv() * hands).as_rotvec()], axis=1).ravel()

    first, second = directions(np.array(START), np.zeros(2))
    between = (bones.inv() * hands).as_rotvec()
    start = np.column_stack([proximal @ first, between @ second])
    answer = least_squares(
        remaining, np.concatenate([START, np.zeros(size - 2), start.ravel()]), xtol=1e-14, ftol=1e-14, gtol=1e-14
    )
    angles = answer.x[size:].reshape(count, 2)
    first, second = directions(answer.x[:2], answer.x[2:size] if free else np.zeros(2))
    turned = np.ptp(proximal @ first), np.ptp(between @ second)
    if min(turned) < TURNED:
        spans = " and ".join(f"{math.degrees(s):.3g}" for s in turned)
        raise BadInput("poses", f"rows that turn over {spans} degrees", f"{math.degrees(TURNED):g} degrees or more")
    if abs(math.sin(answer.x[0] + answer.x[1])) < math.sin(PARALLEL):
        raise BadInput("poses", "axes of both rows that are nearly parallel", "postures in flexion and in deviation")
    squares = answer.fun.reshape(count, 2, 3) ** 2
    spread = 2.0 * answer.cost / max(answer.fun.size - answer.x.size, 1)
    errors = np.sqrt(spread * np.diag(np.linalg.pinv(answer.jac.T @ answer.jac)))[:2]
    left = np.sqrt(squares.sum(2).mean(0))
    each = np.sqrt(squares.sum(2).max(1))
    leans = answer.x[2:size] if free else np.zeros(2)
    worst = int(np.argmax(each))
    return MeasuredAxes(
        (answer.x[0], answer.x[1]),
        (leans[0], leans[1]),
        (errors[0], errors[1]),
        (left[0], left[1]),
        (worst + 1, each[worst]),
        angles,
    )


def directions(tilts: np.ndarray, leans: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Unit vectors of the proximal axis, and of the distal one in the proximal row at rest."""
    first, second = (
        np.array([sign * math.sin(t) * math.cos(lean), math.sin(lean), math.cos(t) * math.cos(lean)])
        for sign, t, lean in zip((1.0, -1.0), tilts, leans, strict=True)
    )
    return first, second
