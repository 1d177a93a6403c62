"""Axes of a person's wrist from measured poses of its bones, with what they leave.

python -m cosimo.orchestrator.systems.wrist.measured_axes poses.csv
python -m cosimo.orchestrator.systems.wrist.measured_axes 66582 --side L

A row of the file is a posture: rotations of a bone of the proximal row and of the hand (capitate) from the neutral posture, as rotation
vectors (helical axis times angle) in the axes of the radius that `kinematics` has: x deviates, y is the long axis, z flexes. Or it
is a person's folder of matrices, see `bone_poses`: then the row is the mean of its three bones, and `row_rules` adds its figures.
Least squares over all postures of the rotations that are left between measured bones and Rot(n_p, q1), Rot(n_p, q1) Rot(n_d, q2);
the angles of each posture are unknown, too. Once with both axes across the forearm, as the model `Wrist` has them, once with any
directions: what the second one leaves less is what the model lacks.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ....components.core.columns import read_table
from ....components.core.errors import BadInput

COLUMNS = tuple(f"{bone}_{axis}" for bone in ("proximal", "hand") for axis in "xyz")
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


def main(arguments: Sequence[str] | None = None) -> None:
    """Of a CSV file or a person's folder: tilts with errors, what is left, settings of a `Wrist`. Exit code 2 for others."""
    parser = argparse.ArgumentParser(prog="python -m cosimo.orchestrator.systems.wrist.measured_axes", description=__doc__)
    parser.add_argument(
        "file", type=Path, help="CSV with the columns " + ", ".join(COLUMNS) + "; or a person's folder of matrices"
    )
    parser.add_argument("--side", choices=("L", "R"), default="", help="of a folder with both sides")
    given = parser.parse_args(arguments)
    further: dict[str, float] = {}
    try:
        if given.file.is_dir():
            from .bone_poses import proximal_row, read_bones
            from .row_rules import figures

            bones = read_bones(given.file, given.side)
            further = figures(bones)
            poses = np.hstack([proximal_row(bones).as_rotvec(), bones["cap"].as_rotvec()])
        else:
            table = read_table(given.file)
            poses = np.column_stack([table.numbers(name, "rad") for name in COLUMNS])
            poses = poses[np.isfinite(poses).all(axis=1)]
        axes, wide = (fit_axes(poses[:, :3], poses[:, 3:], free) for free in (False, True))
    except BadInput as error:
        print(f"cosimo: {error}", file=sys.stderr)
        raise SystemExit(2) from None
    for name, k in (("proximal", 0), ("distal", 1)):
        tilt, scatter, lean = (math.degrees(v) for v in (axes.tilts[k], axes.errors[k], wide.leans[k]))
        print(f"{name} axis: tilt {tilt:.2f} ± {scatter:.2f} degrees; free, it leans {lean:.2f} degrees along the forearm")
    row, hand = (math.degrees(v) for v in axes.left)
    print(f"left of {len(poses)} postures: {row:.3g} degrees of the proximal bone, {hand:.3g} of the hand (rms);")
    print(f"most in posture {axes.worst[0]}, {math.degrees(axes.worst[1]):.3g} degrees; with free axes", end=" ")
    print(" and ".join(f"{math.degrees(v):.3g}" for v in wide.left))
    tilts = zip(("proximal", "distal"), axes.tilts, strict=True)
    for figure, value in further.items():
        print(f"{figure},{value:.4g}")
    print(" ".join(f"--set wrist.morphology.{name}_tilt={tilt:.6f}" for name, tilt in tilts))


if __name__ == "__main__":
    main()
