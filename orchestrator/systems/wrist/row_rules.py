"""What measured poses say of the rules of the two rows: figures beside a control of equal shares, by no model or held out.

Rotation left about one axis: of unit quaternions with vector parts v, the axis n that leaves least is the main direction of the v,
and 2 asin sqrt(|v|² - (v . n)²) is left of each (derived: Rot(n, a)^-1 q has the scalar part sqrt(w² + (v . n)²) at best).
"""

from __future__ import annotations

import math
import random
from collections.abc import Mapping
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from ....components.core.errors import BadInput
from ....components.wrist.kinematics import RULES, Axes, inverse
from .bone_poses import ROW, proximal_row
from .fitted_axes import fit_axes

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

MOST = 100  # ways to choose a half; of more, as many at random
DIRECTIONS = {
    "flexion": (1.0, 0.0, 1, 1),
    "extension": (-1.0, 0.0, -1, -1),
    "radial": (0.0, 1.0, 1, -1),
    "ulnar": (0.0, -1.0, -1, 1),
}


def left_about_one_axis(rotations: Rotation) -> float:
    """Root mean square of the rotation that the best single axis leaves, degrees."""
    vectors = rotations.as_quat()[:, :3]
    main = np.linalg.svd(vectors)[2][0]
    left = 2.0 * np.arcsin(np.sqrt(np.clip((vectors**2).sum(1) - (vectors @ main) ** 2, 0.0, 1.0)))
    return _rms(left)


def figures(bones: Mapping[str, Rotation]) -> dict[str, float]:
    """Figures by name; angles in degrees.

    error: rotation between capitate and hamate, which stand for one body.  control.left: of equal shares, half of the hand's.
    left.BONE, row.left: about one axis in the radius, over the control's.  carried.left: of the hand against the row, about an axis that
    the row carries, over the control's; carried.fixed: over that about an axis fixed in the radius.  toward.DIRECTION: the lesser
    flexion of both rows, as announced, in the posture nearest to the direction.  arc: row's flexion between these.
    share, per.deviation: flexion of the row per flexion and per radial deviation of the hand, by least squares, with errors.
    apart: angle between the row's axis in flexion and in deviation, with an error by leaving postures out.
    tilt.ROW: of the axes fitted to all postures, with errors.
    halves.error: of the row's flexion by axes of one half in the other one, halves.control: of equal shares, over all halves.
    """
    hand, row = bones["cap"], proximal_row(bones)
    axes = fit_axes(row.as_rotvec(), hand.as_rotvec())  # first, as it refuses what is too little
    half = type(hand).from_rotvec(0.5 * hand.as_rotvec())
    control, between = left_about_one_axis(half), row.inv() * hand
    carried = left_about_one_axis(between)
    postures = hand.as_euler("ZXY")[:, :2]
    turned, flexed = np.degrees(row.as_rotvec()), np.degrees(between.as_rotvec()[:, 2])
    measured = {
        "postures": float(len(hand)),
        "error": _rms((bones["cap"].inv() * bones["ham"]).magnitude()),
        "control.left": control,
    }
    measured |= {f"left.{bone}": left_about_one_axis(bones[bone]) / control for bone in ROW}
    measured |= {"row.left": left_about_one_axis(row) / control, "carried.left": carried / control}
    measured["carried.fixed"] = carried / left_about_one_axis(hand * row.inv())
    nearest = {}
    for name, (flexion, deviation, first, second) in DIRECTIONS.items():
        nearest[name] = k = int(np.argmax(postures @ (flexion, deviation) / np.linalg.norm(postures, axis=1)))
        measured[f"toward.{name}"] = float(min(first * turned[k, 2], second * flexed[k]))
    ends = [turned[k, 2] for k in nearest.values()]
    measured |= {"arc.flexion": float(ends[0] - ends[1]), "arc.deviation": float(ends[2] - ends[3])}
    by, errors = per_posture(postures, row.as_rotvec())
    measured |= {"share": by[0, 2], "share.error": errors[0, 2], "per.deviation": by[1, 2], "per.deviation.error": errors[1, 2]}
    kept = [np.delete(np.arange(len(hand)), k) for k in range(len(hand))]
    others = [apart(per_posture(postures[k], row[k].as_rotvec())[0]) for k in kept]
    for k, name in enumerate(("proximal", "distal")):
        measured |= {f"tilt.{name}": math.degrees(axes.tilts[k]), f"tilt.{name}.error": math.degrees(axes.errors[k])}
    measured |= {"apart": apart(by), "apart.error": math.sqrt(len(others) - 1.0) * float(np.std(others))}
    return measured | _halves(row.as_rotvec(), hand.as_rotvec(), postures)


def per_posture(postures: np.ndarray, turned: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rotation of the row per flexion and deviation of the hand, (2, 3), and its standard errors."""
    by, squares, *_ = np.linalg.lstsq(postures, turned, rcond=None)
    spread = np.diag(np.linalg.inv(postures.T @ postures))
    return by, np.sqrt(np.outer(spread, squares / (len(postures) - 2)))


def apart(by: np.ndarray) -> float:
    """Angle between the row's axes in flexion and in deviation, degrees."""
    first, second = by / np.linalg.norm(by, axis=1)[:, None]
    return math.degrees(math.acos(min(1.0, abs(float(first @ second)))))


def _halves(row: np.ndarray, hand: np.ndarray, postures: np.ndarray) -> dict[str, float]:
    """Errors of the row's flexion in the postures of a half by the axes of the other one, and of equal shares; halves that give none."""
    count = len(row)
    ways = math.comb(count, count // 2)
    rng = random.Random(0)
    chosen = (
        combinations(range(count), count // 2) if ways <= MOST else (rng.sample(range(count), count // 2) for _ in range(MOST))
    )
    missed, shared, refused = [], [], 0
    for half in map(list, chosen):
        others = np.delete(np.arange(count), half)
        try:
            tilts = fit_axes(row[half], hand[half]).tilts
            angles = [inverse(f, d, Axes(RULES, tilts[0], tilts[1], 0.0))[0] for f, d in postures[others].tolist()]
        except BadInput:
            refused += 1
            continue
        missed.append(np.array(angles) * math.cos(tilts[0]) - row[others, 2])
        shared.append(0.5 * hand[others, 2] - row[others, 2])
    if not missed:
        return {}
    return {"halves.error": _rms(np.array(missed)), "halves.control": _rms(np.array(shared)), "halves.refused": float(refused)}


def _rms(angles: np.ndarray) -> float:
    """Root mean square of angles in rad, degrees."""
    return math.degrees(math.sqrt(float(np.mean(angles**2))))
