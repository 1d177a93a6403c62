"""The two rows as four-bars: in one plane of motion they are one on a sphere, exactly, by closed form.

In flexion alone the hand's long axis d stays at right angles to z, in deviation alone to x; it is at right angles to the distal axis
n_d, too. So the axes are those of a spherical four-bar whose bars are arcs: ground from z (or x) to n_p, crank from n_p to n_d,
coupler from n_d to d, rocker from d to z (or x):

    flexion     e_p           e_p + e_d    90°    90°    tan F = sin(q1) tan(e) / (tan(e) cos(e_p) cos(q1) - sin(e_p))
    deviation   90° - e_p     e_p + e_d    90°    90°    tan D = sin(q1) tan(e) / (cos(e_p) + tan(e) sin(e_p) cos(q1)),   e = e_p + e_d

Both share the crank, which is the proximal row. `rocker_angle` is the general linkage; with short arcs it is the planar `FourBar`. The
hand turns about the point in which the great circles n_p to n_d and z to d (or x to d) meet, as by the theorem of three poles.

`PLANAR` is a planar linkage whose rocker follows the hand over ±60° of flexion: lengths over the ground's, and angles of crank and rocker
at rest, fitted by least squares outside of this project. No bone or ligament has such lengths.
"""

from __future__ import annotations

import math

import numpy as np

from ......components.wrist.kinematics import Axes, inverse, jacobian, pose
from ......components.wrist.linkage import Linkage, position
from .....harness.validation import Evidence, Runs
from .postures import DEGREES, DEVIATIONS, FLEXIONS, STANDARD, axes

RIGHT = 0.5 * math.pi
PLANAR = Linkage(6.5470, 2.8007, 7.7423, 1.0, 1.0, 0.0, 0.0)
AT_REST = (math.radians(336.200), math.radians(315.953))
PLANES = (FLEXIONS, DEVIATIONS)
PINS = ((0.0, 0.0, 1.0), (1.0, 0.0, 0.0))  # of the rockers: z and x


def measure(runs: Runs) -> Evidence:
    """Angles and axes of rotation of the rows against their four-bars, what the sum of both four-bars misses, and a planar one."""
    at = axes(STANDARD)
    rows = [{angle: inverse(*_posture(angle, plane), at)[:2] for angle in angles.tolist()} for plane, angles in enumerate(PLANES)]
    away, off = [], []
    for plane, angles in enumerate(PLANES):
        for angle in angles[angles != 0.0].tolist():
            q1, q2 = rows[plane][angle]
            crank, sign = (math.pi + q1, -1.0) if plane else (q1, 1.0)  # seen from x, the crank starts beyond the pin
            away.append(abs(math.remainder(rocker_angle(crank, sign, *arcs(plane, at)) - angle - RIGHT, 2.0 * math.pi)))
            off.append(_off_pole(q1, q2, plane, at))
    missed = [abs(inverse(f, d, at)[0] - rows[0][f][0] - rows[1][d][0]) for f in rows[0] for d in rows[1]]
    planar = [position(AT_REST[0] + q1, PLANAR)[0] - AT_REST[1] - f for f, (q1, _) in rows[0].items()]
    flat = [abs(math.remainder(v, 2.0 * math.pi)) for v in planar]
    return Evidence(
        {f"bars.{n}": DEGREES * max(v) for n, v in (("angle", away), ("pole", off), ("sum", missed), ("planar", flat))}
    )


def arcs(plane: int, at: Axes) -> tuple[float, float, float, float]:
    """Ground, crank, coupler and rocker, rad, of flexion (0) or deviation (1)."""
    return (RIGHT - at.proximal_tilt if plane else at.proximal_tilt, at.proximal_tilt + at.distal_tilt, RIGHT, RIGHT)


def rocker_angle(crank_angle: float, sign: float, ground: float, crank: float, coupler: float, rocker: float) -> float:
    """Angle of the rocker, rad, of a spherical four-bar: both from the ground, about axes out of the sphere; sign: -1 is `open`.

    The crank's end P, in axes of the rocker's pin, keeps cos(coupler) = cos(rocker) P_3 + sin(rocker) (P_1 cos psi + P_2 sin psi).
    """
    across = math.sin(crank) * math.cos(crank_angle)
    first = across * math.cos(ground) - math.cos(crank) * math.sin(ground)
    second = math.sin(crank) * math.sin(crank_angle)
    third = across * math.sin(ground) + math.cos(crank) * math.cos(ground)
    cosine = (math.cos(coupler) - math.cos(rocker) * third) / (math.sin(rocker) * math.hypot(first, second))
    return math.remainder(math.atan2(second, first) + sign * math.acos(cosine), 2.0 * math.pi)


def _posture(angle: float, plane: int) -> tuple[float, float]:
    return (0.0, angle) if plane else (angle, 0.0)


def _off_pole(q1: float, q2: float, plane: int, at: Axes) -> float:
    """Angle between the hand's axis of rotation in a plane and where both great circles meet, rad."""
    here = pose(q1, q2, at)
    rates = np.linalg.solve(jacobian(q1, q2, at)[:2], np.eye(2)[plane])
    turning = rates[0] * np.array(here.hand_1) + rates[1] * np.array(here.hand_2)
    pole = np.cross(np.cross(here.proximal_1, here.hand_2), np.cross(PINS[plane], here.hand))
    return math.asin(float(np.linalg.norm(np.cross(turning, pole)) / (np.linalg.norm(turning) * np.linalg.norm(pole))))
