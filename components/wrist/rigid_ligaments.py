"""Ligaments that do not give: the freedom that they leave to the rows.

In the two-row mechanism each of the five lengths depends on one of the two angles alone: trapezium-scaphoid on that of the distal
row, the other four on that of the proximal row. So five rigid ligaments are five conditions on two angles, and each of them is
either kept at every angle, since an end lies on the axis (isometric), and then asks nothing; or it holds its row where it is.
A row that is held is taken out of the equations: its angle stays to the last bit, no constraint is left that could drift, and
no least squares decide what conditions that contradict one another mean. What the ligaments of a held row bear together is
the row's reaction; its parts are not determined where there are several.
"""

from __future__ import annotations

from ..core.contract import Refusal
from ..core.kernels import DONE, OWN, kernel
from .kinematics import RULES
from .ligament_springs import COUNT, LIGAMENTS, SLACK, SPRING, STIFFNESS, TOE_STRAIN, TRAPEZIUM_SCAPHOID, ligament_length

ISOMETRIC = 1e-9  # largest change of length over the length of a ligament that counts as none: rounding is 1e-15
RANGE, ANGLES = 1.0, 9  # rad, both ways from rest; angles in this range that are looked at
# statuses: angles of both rows in every length, numbers of springs, a row held in motion, a wrong length, both rows held
COUPLED, SOFT_TOE, DAMPED, SPRINGY = OWN + 10, OWN + 11, OWN + 12, OWN + 13
MOVING, APART, BOTH_HELD = OWN + 20, OWN + 30, OWN + 40


@kernel
def holds(j, axes, ligaments):
    """Whether a rigid ligament holds its row: it changes its length when that turns."""
    rest = ligament_length(j, 0.0, 0.0, axes, ligaments)[0]
    shortest, longest = rest, rest
    for k in range(ANGLES):
        q = RANGE * (2.0 * k / (ANGLES - 1.0) - 1.0)
        q1, q2 = (0.0, q) if j == TRAPEZIUM_SCAPHOID else (q, 0.0)
        length = ligament_length(j, q1, q2, axes, ligaments)[0]
        shortest, longest = min(shortest, length), max(longest, length)
    return longest - shortest > ISOMETRIC * rest


@kernel
def make_rigid(axes, constraint, s):
    """Takes the springs away from ligaments and notes in s.held which rows they hold, for the state at the start; a status.

    Refused where they hold both rows, where they are longer or shorter at the start than they can be, where a row that is held is
    to move, and with the coupling model `opensim_half`, in which every length depends on both angles.
    """
    ligaments, x = s.ligaments, s.x
    if constraint.toe != TOE_STRAIN:
        return SOFT_TOE
    if constraint.damping != 0.0:
        return DAMPED
    for j in range(COUNT):
        if constraint.stiffness[j] != STIFFNESS:
            return SPRINGY + j
    if axes.model != RULES:
        return COUPLED
    which = 0
    for j in range(COUNT):
        if constraint.cut != j + 1 and holds(j, axes, ligaments):
            which += 1 << j
            s.held[1 if j == TRAPEZIUM_SCAPHOID else 0] = 1.0
    if s.held[0] != 0.0 and s.held[1] != 0.0:
        return BOTH_HELD + which
    for j in range(COUNT):
        slack, length = ligaments[j, SLACK], ligament_length(j, x[0], x[1], axes, ligaments)[0]
        if constraint.cut != j + 1 and abs(length / slack - 1.0) > ISOMETRIC:
            s.lengths[0], s.lengths[1] = 1e3 * slack, 1e3 * length
            return APART + j
    for i in range(2):
        if s.held[i] != 0.0 and x[2 + i] != 0.0:
            return MOVING + i
    for j in range(COUNT):
        ligaments[j, SPRING] = 0.0
    return DONE


def _names(which: int) -> str:
    return ", ".join(name.replace("_", "-") for j, name in enumerate(LIGAMENTS) if which >> j & 1)


def _soft(name: str) -> Refusal:
    return Refusal(
        f"{name} = {{{name}}} of rigid ligaments", "springs, or no such number", "Leave it out: rigid ligaments have none."
    )


REMEDY = "Set their off_axis to 0 and leave the axes where they are, cut one that holds, or take the springs."
RIGID_REFUSALS = {
    COUPLED: Refusal(
        "rigid ligaments with the coupling model 'opensim_half'",
        "the coupling model 'rules'",
        "Take the springs: there every length depends on both angles, and five conditions are too many.",
    ),
    SOFT_TOE: _soft("constraint.toe"),
    DAMPED: _soft("constraint.damping"),
    **{SPRINGY + j: _soft(f"constraint.stiffness[{j + 1}]") for j in range(COUNT)},
    **{
        MOVING + i: Refusal(f"start_{row}_rate = {{start_{row}_rate}} rad/s of a row that rigid ligaments hold", "0", REMEDY)
        for i, row in enumerate(("proximal", "distal"))
    },
    **{
        APART + j: Refusal(
            f"a rigid {_names(1 << j)} ligament of {{lengths[0]}} mm whose ends are {{lengths[1]}} mm apart at the start",
            "ends at its length",
            "Start at angles of zero with prestrain 0, or cut it.",
        )
        for j in range(COUNT)
    },
    **{
        BOTH_HELD + which: Refusal(f"rigid ligaments that hold both rows ({_names(which)})", "a row that is free to turn", REMEDY)
        for which in range(1 << COUNT)
        if which >> TRAPEZIUM_SCAPHOID & 1 and which != 1 << TRAPEZIUM_SCAPHOID
    },
}
