"""Motion of the wrist's two rows: axes and angles of the hand from two coordinates, and back.

Axes in the radius, origin in the wrist's centre at rest: z flexes (positive: towards the palm), x deviates (positive: towards the
radius), y is the long axis, from the forearm to the fingers. Two ways in which the rows share the motion:

- `rules`: the proximal row turns by q1 about n_p = (sin e_p, 0, cos e_p), fixed in the radius; the distal row, and the hand
  with it, by q2 about n_d = (-sin e_d, 0, cos e_d), fixed in the proximal row. R_hand = Rot(n_p, q1) Rot(n_d, q2). So the
  proximal row flexes and the distal one extends in radial deviation, and both flex in flexion.
- `opensim_half`: each row makes half of the flexion q1 and half of the deviation q2, R_hand = R² with R = Rz(q1/2) Rx(q2/2): the
  equal shares of the wrist model of Gonzalez, Buchanan and Delp (1997) as it comes with OpenSim (wrist.osim, where the order of
  the four rotations was read; the proximal row's share of deviation is a curve there, one half at the end of radial and 37.5 %
  at the end of ulnar deviation). There the rows flex in no deviation, which contradicts the rule of Sandow (2020).

Flexion, deviation and roll are the angles of R_hand = Rz(flexion) Rx(deviation) Ry(roll). Small angles, rules:
(flexion, deviation) = A q, A = [[cos e_p, cos e_d], [sin e_p, -sin e_d]], det A = -sin(e_p + e_d).
Sources: that rows turn about two axes, the distal one carried, and the signs are of Sandow (2020), known to us by its abstract;
the axes' directions, their tilts and the formulas are ours.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..core.contract import Refusal
from ..core.errors import BadInput
from ..core.kernels import DONE, OWN, kernel, kernel_tuple
from ..core.rotation import to_world

RULES, OPENSIM_HALF = range(2)
COUPLING_MODELS = ("rules", "opensim_half")
PROXIMAL_TILT, DISTAL_TILT = math.radians(15.0), math.radians(45.0)
ROW_OFFSET = 0.02  # m, of the second axis along the long axis
LEAST_CROSSING = 0.02  # |sin| of the angle between the axes, below which flexion and deviation are no longer two motions
TILTED_HALF, PARALLEL = OWN + 1, OWN + 2  # statuses
Vector = tuple[float, float, float]


@kernel_tuple
class Axes(NamedTuple):
    """Where the two axes lie at rest, for kernels: tilts in rad, distance along the long axis in m."""

    model: int
    proximal_tilt: float
    distal_tilt: float
    offset: float


DEFAULT_AXES = Axes(RULES, PROXIMAL_TILT, DISTAL_TILT, 0.0)


@kernel_tuple
class Pose(NamedTuple):
    """Directions in the radius: rotation of rows per coordinate, long axes, and the angles of the hand with their derivatives.

    proximal_1, proximal_2: angular velocity of the proximal row at unit rate of q1, q2; hand_1, hand_2: of the hand.
    row, hand: the long axis of the proximal row and of the hand.  flexion_1 = d flexion / d q1, and so on.
    """

    proximal_1: Vector
    proximal_2: Vector
    hand_1: Vector
    hand_2: Vector
    row: Vector
    hand: Vector
    flexion: float
    deviation: float
    roll: float
    flexion_1: float
    flexion_2: float
    deviation_1: float
    deviation_2: float
    roll_1: float
    roll_2: float


@kernel
def dot(a, b):
    """Scalar product of two vectors."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel
def cross(a, b):
    """Vector product."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@kernel
def combined(p, a, q, b):
    """p a + q b."""
    return p * a[0] + q * b[0], p * a[1] + q * b[1], p * a[2] + q * b[2]


@kernel
def rotation_about(x, y, z, angle):
    """Quaternion of a rotation about a unit vector."""
    s = math.sin(0.5 * angle)
    return math.cos(0.5 * angle), s * x, s * y, s * z


@kernel
def after(a, b):
    """Quaternion of the rotation b, and after it a: the product a b."""
    return (
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] + a[2] * b[0] + a[3] * b[1] - a[1] * b[3],
        a[0] * b[3] + a[3] * b[0] + a[1] * b[2] - a[2] * b[1],
    )


@kernel
def row_rotation(q1, q2, axes):
    """Quaternion of the proximal row in the radius."""
    if axes.model == RULES:
        return rotation_about(math.sin(axes.proximal_tilt), 0.0, math.cos(axes.proximal_tilt), q1)
    return after(rotation_about(0.0, 0.0, 1.0, 0.5 * q1), rotation_about(1.0, 0.0, 0.0, 0.5 * q2))


@kernel
def hand_rotation(row, q2, axes):
    """Quaternion of the distal row and the hand in the radius, from that of the proximal row."""
    if axes.model == RULES:
        return after(row, rotation_about(-math.sin(axes.distal_tilt), 0.0, math.cos(axes.distal_tilt), q2))
    return after(row, row)


@kernel
def turned(r, v):
    """A vector turned by a quaternion."""
    return to_world(r[0], r[1], r[2], r[3], v[0], v[1], v[2])


@kernel
def row_turning(q1, axes):
    """Angular velocities of the proximal row at unit rate of q1 and of q2, in the radius."""
    if axes.model == RULES:
        return (math.sin(axes.proximal_tilt), 0.0, math.cos(axes.proximal_tilt)), (0.0, 0.0, 0.0)
    return (0.0, 0.0, 0.5), (0.5 * math.cos(0.5 * q1), 0.5 * math.sin(0.5 * q1), 0.0)


@kernel
def hand_turning(first, second, row, axes):
    """The same of the hand, from those of the proximal row and its quaternion."""
    if axes.model == RULES:
        return first, turned(row, (-math.sin(axes.distal_tilt), 0.0, math.cos(axes.distal_tilt)))
    return combined(1.0, first, 1.0, turned(row, first)), combined(1.0, second, 1.0, turned(row, second))


@kernel
def angles(across, hand):
    """(flexion, deviation, roll), rad, of a hand whose x and long axis are these vectors in the radius."""
    palm = across[0] * hand[1] - across[1] * hand[0]  # z of the hand's third axis
    return math.atan2(-hand[0], hand[1]), math.asin(max(-1.0, min(1.0, hand[2]))), math.atan2(-across[2], palm)


@kernel
def angle_rates(flexion, deviation, turning):
    """Rates of (flexion, deviation, roll) of a hand with an angular velocity; infinite where the deviation is a right angle."""
    c, s = math.cos(flexion), math.sin(flexion)
    forward = c * turning[1] - s * turning[0]
    roll = forward / math.cos(deviation)
    return turning[2] - math.sin(deviation) * roll, c * turning[0] + s * turning[1], roll


@kernel
def pose(q1, q2, axes):
    """Everything the equations need of a position, see `Pose`."""
    row = row_rotation(q1, q2, axes)
    hand = hand_rotation(row, q2, axes)
    proximal_1, proximal_2 = row_turning(q1, axes)
    hand_1, hand_2 = hand_turning(proximal_1, proximal_2, row, axes)
    long = turned(hand, (0.0, 1.0, 0.0))
    flexion, deviation, roll = angles(turned(hand, (1.0, 0.0, 0.0)), long)
    flexion_1, deviation_1, roll_1 = angle_rates(flexion, deviation, hand_1)
    flexion_2, deviation_2, roll_2 = angle_rates(flexion, deviation, hand_2)
    return Pose(
        proximal_1,
        proximal_2,
        hand_1,
        hand_2,
        turned(row, (0.0, 1.0, 0.0)),
        long,
        flexion,
        deviation,
        roll,
        flexion_1,
        flexion_2,
        deviation_1,
        deviation_2,
        roll_1,
        roll_2,
    )


def forward(proximal: float, distal: float, axes: Axes = DEFAULT_AXES) -> Vector:
    """(flexion, deviation, roll) of the hand, rad, from the two coordinates, rad."""
    at = pose(proximal, distal, axes)
    return at.flexion, at.deviation, at.roll


def jacobian(proximal: float, distal: float, axes: Axes = DEFAULT_AXES) -> np.ndarray:
    """Derivatives of flexion, deviation and roll by the two coordinates, (3, 2)."""
    at = pose(proximal, distal, axes)
    return np.array([[at.flexion_1, at.flexion_2], [at.deviation_1, at.deviation_2], [at.roll_1, at.roll_2]])


def small_angle_matrix(axes: Axes = DEFAULT_AXES) -> np.ndarray:
    """A, (2, 2): (flexion, deviation) = A q for small angles."""
    return jacobian(0.0, 0.0, axes)[:2]


@kernel
def crossing(axes):
    """Sine of the angle between the two axes at rest, 1 for the axes of `opensim_half`."""
    return math.sin(axes.proximal_tilt + axes.distal_tilt) if axes.model == RULES else 1.0


@kernel
def axes_status(axes):
    """Refuses axes that are nearly parallel, and tilts given to a coupling model that has axes of its own."""
    if axes.model == OPENSIM_HALF:
        flat = axes.proximal_tilt == 0.0 and axes.distal_tilt == 0.0
        if not flat and not (axes.proximal_tilt == PROXIMAL_TILT and axes.distal_tilt == DISTAL_TILT):
            return TILTED_HALF
    return DONE if abs(crossing(axes)) >= LEAST_CROSSING else PARALLEL


def axes_refusals(proximal_tilt: str, distal_tilt: str, sine: str) -> dict[int, Refusal]:
    """The meaning of `axes_status`, with texts for the two tilts and the sine between the axes."""
    return {
        TILTED_HALF: Refusal(
            f"tilts of {proximal_tilt} and {distal_tilt} rad with the coupling model 'opensim_half'",
            "tilts with the coupling model 'rules' only",
            "Leave them out: the other one turns about the axes of flexion and deviation.",
        ),
        PARALLEL: Refusal(
            f"tilts of {proximal_tilt} and {distal_tilt} rad: axes that cross at a sine of {sine}",
            f"a sine of at least {LEAST_CROSSING:g}, either way",
            "Tilt one of the axes: about parallel ones the hand has one motion instead of two.",
        ),
    }


def inverse(flexion: float, deviation: float, axes: Axes = DEFAULT_AXES) -> Vector:
    """(proximal coordinate, distal coordinate, roll) of a hand with these angles, rad, on the branch through the rest position.

    Rules, closed form: with d the long axis of the hand, sin q2 = -(d . n_p) / sin(e_p + e_d), and q1 turns the long axis about
    n_p into d. Half and half: Newton's method from the coordinates themselves.
    `BadInput` where no position of the rows gives such angles, or the axes are nearly parallel.
    """
    if (status := axes_status(axes)) != DONE:
        texts = axes_refusals(f"{axes.proximal_tilt:g}", f"{axes.distal_tilt:g}", f"{crossing(axes):.2g}")[status]
        raise BadInput("inverse kinematics", *texts)
    c = math.cos(deviation)
    hand = np.array([-math.sin(flexion) * c, math.cos(flexion) * c, math.sin(deviation)])
    actual = f"flexion {flexion:g} and deviation {deviation:g} rad"
    refused = BadInput("inverse kinematics", actual, "angles that the rows can reach")
    if axes.model == RULES:
        n_p = np.array([math.sin(axes.proximal_tilt), 0.0, math.cos(axes.proximal_tilt)])
        sine = -float(hand @ n_p) / crossing(axes)
        if not abs(sine) <= 1.0:
            raise refused
        q2 = math.asin(sine)
        start = np.array(turned(hand_rotation((1.0, 0.0, 0.0, 0.0), q2, axes), (0.0, 1.0, 0.0)))
        q1 = math.atan2(n_p @ np.cross(start, hand), start @ hand - (start @ n_p) * (hand @ n_p))
        return q1, q2, forward(q1, q2, axes)[2]
    q = np.array([flexion, deviation])
    for _ in range(20):
        there = forward(q[0], q[1], axes)
        missing = np.array([flexion - there[0], deviation - there[1]])
        if np.abs(missing).max() < 1e-13:
            return float(q[0]), float(q[1]), there[2]
        q += np.linalg.solve(jacobian(q[0], q[1], axes)[:2], missing)
    raise refused
