"""Ligaments that do not give: what freedom they leave to the rows.

In the two-row mechanism each of the five lengths depends on one of the two angles alone: trapezium-scaphoid on that of the distal
row, the other four on that of the proximal row. So five rigid ligaments are five conditions on two angles, and each of them is
either kept at every angle, since an end lies on the axis (isometric), and then asks nothing; or it holds its row where it is.
A row that is held is taken out of the equations: its angle stays to the last bit, no constraint is left that could drift, and
no least squares decide what conditions that contradict one another mean. What the ligaments of a held row bear together is
the row's reaction; its parts are not determined where there are several.
"""

from __future__ import annotations

import numpy as np

from ..core.errors import BadInput
from .kinematics import RULES, Axes
from .ligament_springs import COUNT, LIGAMENTS, TRAPEZIUM_SCAPHOID, Ligaments, lengths

ISOMETRIC = 1e-9  # largest change of length over the length of a ligament that counts as none: rounding is 1e-15
RANGE = 1.0  # rad, both ways from rest


def holding(axes: Axes, ligaments: Ligaments, cut: int) -> list[int]:
    """Numbers, from 0, of the rigid ligaments that hold their row: those that change their length when it turns."""
    angles = np.linspace(-RANGE, RANGE, 9)
    rest = lengths(0.0, 0.0, axes, ligaments)[:, 0]
    rows = []
    turns = np.array([(lengths(q, 0.0, axes, ligaments)[:, 0], lengths(0.0, q, axes, ligaments)[:, 0]) for q in angles])
    for j in range(COUNT):
        there = turns[:, 1 if j == TRAPEZIUM_SCAPHOID else 0, j]
        if j != cut - 1 and np.ptp(there) > ISOMETRIC * rest[j]:
            rows.append(j)
    return rows


def rigid_ligaments(axes: Axes, ligaments: Ligaments, cut: int, start: np.ndarray, where: str) -> Ligaments:
    """The same ligaments without springs, and with the rows that they hold; start: (4,) angles and rates.

    `BadInput` where they hold both rows, where they are longer or shorter at the start than they can be, where a row that is held
    is to move, and with the coupling model `opensim_half`, in which every length depends on both angles.
    """
    if axes.model != RULES:
        raise BadInput(where, "rigid ligaments with the coupling model 'opensim_half'", "the coupling model 'rules'",
                       "Take the springs: there every length depends on both angles, and five conditions are too many.")
    indices = holding(axes, ligaments, cut)
    names = [LIGAMENTS[j].replace("_", "-") for j in indices]
    rows = {"distal" if j == TRAPEZIUM_SCAPHOID else "proximal" for j in indices}
    remedy = "Set their off_axis to 0 and leave the axes where they are, cut one that holds, or take the springs."
    if len(rows) == 2:
        raise BadInput(where, f"rigid ligaments that hold both rows ({', '.join(names)})", "a row that is free to turn", remedy)
    now = lengths(start[0], start[1], axes, ligaments)[:, 0]
    for j, length in enumerate(now):
        if j != cut - 1 and abs(length / ligaments.slack[j] - 1.0) > ISOMETRIC:
            actual = f"a rigid {LIGAMENTS[j].replace('_', '-')} ligament of {1e3 * ligaments.slack[j]:.6g} mm whose ends are "
            raise BadInput(where, actual + f"{1e3 * length:.6g} mm apart at the start", "ends at its length",
                           "Start at angles of zero with prestrain 0, or cut it.")
    for i, row in enumerate(("proximal", "distal")):
        if row in rows and start[2 + i] != 0.0:
            raise BadInput(where, f"start_{row}_rate = {start[2 + i]:g} rad/s of a row that rigid ligaments hold", "0", remedy)
    return ligaments._replace(stiffness=np.zeros(COUNT), locked_1="proximal" in rows, locked_2="distal" in rows)
