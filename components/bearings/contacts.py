"""All ball contacts of a bearing together: force, moment and stiffness for a displacement of the inner ring.

Frame: x horizontal, y up, z along the shaft; beta from +x towards +y. The inner ring is displaced by
q = (x, y, z, tilt_x, tilt_y), m and rad (rotation vectors), the outer ring is fixed. The groove centres of ball j are apart by

    radial_j = radial + x cos(beta) + y sin(beta)
    axial_j  = axial + z + lever (tilt_x sin(beta) - tilt_y cos(beta)),      tan(phi_j) = axial_j / radial_j

and the races approach each other by delta_j = sqrt(radial_j² + axial_j²) - distance - gap_j, where `distance` is that of the
unloaded ball, (f_i + f_o - 1) d, and `gap` what waviness and defects take away and a film adds. Q_j = K delta_j^1.5 acts along
phi_j.

The lever of the tilts is the radius of the inner groove's centres, through which every Q_j passes. With the same lever for the
moments the bearing has a potential, sum 2/5 K delta^2.5, and its stiffness is symmetric. The potential is convex, because
delta_j is the length of a vector that is linear in q.

Source: the model of Sopanen & Mikkola, Proc. IMechE K 217 (2003), of which only the abstract was at hand: the formulas come
from public code of one of the authors; ISO/TS 16281.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..core.kernels import DONE, OUT_OF_RANGE, kernel, kernel_tuple
from .inertia import seated_ball

COS, SIN, GAP, LOAD = range(4)  # columns of `balls`
OUTER_LOAD, INNER_ANGLE, OUTER_ANGLE = range(4, 7)  # and of balls with inertia
LARGEST_CONTACT = 0.5  # semi-axis over the ball's radius, beyond which neither Hertz nor a half space is a model
ENERGY, MAX_LOAD, LOADED = 5, 6, 7  # elements of `sums` behind the two forces and moments


@kernel_tuple
class BallContacts(NamedTuple):
    """Constants of a bearing's ball contacts."""

    balls: int
    stiffness: float  # K of a ball between both races, N/m^1.5
    distance: float  # of the groove centres when an unloaded ball just touches both races, m
    radial: float  # radial and axial distance of the groove centres at q = 0, m
    axial: float
    lever: float  # radius of the inner groove's centres, m


@kernel
def groove_contacts(balls, stiffness, inner_conformity, outer_conformity, ball_diameter, pitch_diameter, angle, clearance):
    """Contacts of a bearing with K in N/m^1.5, lengths in m, the contact angle in rad, and the diametral clearance.

    With a contact angle the rings just touch at q = 0, shifted along z against the symmetric position. The clearance comes on
    top of that which the contact angle implies; negative: a preload.
    """
    distance = (inner_conformity + outer_conformity - 1.0) * ball_diameter
    radial = distance * math.cos(angle) - 0.5 * clearance
    lever = 0.5 * pitch_diameter + (inner_conformity - 0.5) * ball_diameter * radial / distance
    return BallContacts(balls, stiffness, distance, radial, distance * math.sin(angle), lever)


@kernel
def note_contacts(contacts, record):
    """Contacts into a record of the block."""
    record.balls, record.stiffness, record.distance = contacts.balls, contacts.stiffness, contacts.distance
    record.radial, record.axial, record.lever = contacts.radial, contacts.axial, contacts.lever


@kernel
def set_balls(balls, first):
    """Cosine and sine of the angles of balls (Z, 4) at equal distances, the first one at `first` rad; nothing else is touched."""
    for j in range(balls.shape[0]):
        beta = first + 2.0 * math.pi * j / balls.shape[0]
        balls[j, COS], balls[j, SIN] = math.cos(beta), math.sin(beta)


def place_balls(balls: int, first: float = 0.0, columns: int = 4) -> np.ndarray:
    """(Z, 4), with inertia (Z, 7): cos and sin of the balls' angles, the first one at `first` rad, no gap, no load."""
    placed = np.zeros((balls, columns))
    set_balls(placed, first)
    return placed


@kernel
def add_stiffness(k, c, s, along, turning, cos_phi, sin_phi):
    """Add a ball at cos, sin = c, s to the upper triangle of k (5, 5), tilts by a lever of 1 m.

    along, turning: stiffness in N/m in the direction of its contact and across it, phi its contact angle.
    """
    rr = along * cos_phi * cos_phi + turning * sin_phi * sin_phi
    rz = (along - turning) * sin_phi * cos_phi
    zz = along * sin_phi * sin_phi + turning * cos_phi * cos_phi
    k[0, 0] += rr * c * c
    k[0, 1] += rr * c * s
    k[1, 1] += rr * s * s
    k[0, 2] += rz * c
    k[1, 2] += rz * s
    k[2, 2] += zz
    k[0, 3] += rz * c * s
    k[1, 3] += rz * s * s
    k[2, 3] += zz * s
    k[3, 3] += zz * s * s
    k[0, 4] -= rz * c * c
    k[1, 4] -= rz * c * s
    k[2, 4] -= zz * c
    k[3, 4] -= zz * c * s
    k[4, 4] += zz * c * c


@kernel
def add_seated(k, c, s, lever, ball):
    """Add a ball with inertia at cos, sin = c, s to the whole of k (5, 5), which friction makes unsymmetric; ball: `SeatedBall`."""
    for i in range(5):
        radial, axial = (
            (c if i == 0 else s if i == 1 else 0.0),
            (1.0 if i == 2 else lever * s if i == 3 else -lever * c if i == 4 else 0.0),
        )
        by_r, by_z = radial * ball.rr + axial * ball.zr, radial * ball.rz + axial * ball.zz
        k[i, 0] += by_r * c
        k[i, 1] += by_r * s
        k[i, 2] += by_z
        k[i, 3] += by_z * lever * s
        k[i, 4] -= by_z * lever * c


@kernel
def finish_stiffness(k, lever):
    """The sum of `add_stiffness` with the tilts' lever in m, and its lower triangle."""
    for i in range(5):
        for j in range(max(i, 3), 5):
            k[i, j] *= lever * lever if i > 2 else lever
        for j in range(i):
            k[i, j] = k[j, i]


@kernel
def contact_forces(q, contacts, balls, sums, stiffness, velocity, damper, damping, inertia):
    """Forces of the balls on the inner ring; returns OUT_OF_RANGE if a ring is displaced beyond the grooves.

    q: (5,).  balls: (Z, 4) with cos, sin and gap in m; the load is written.  sums: (8,), written: force in N and moment in N.m
    (5), energy in J, largest ball load in N, number of loaded balls.  stiffness: (5, 5) or None, written: -d(force)/dq.

    damper: a time in s or None; each contact then has a damper of `damper` times its own stiffness, which vanishes at
    touch-down, and no contact pulls. It reads velocity (5,) = dq/dt and writes damping (5, 5), or None: -d(force)/d(velocity).
    The change of such a damper with q is left out of `stiffness`: it is infinite at touch-down.

    inertia: `Inertia`, or None for balls without. With it balls is (Z, 7), energy that of both races, the largest load that of either,
    and a damper acts at the inner race, in proportion to the stiffness of the ball between both; its line's turning with q is left out.
    """
    lever = contacts.lever
    fx, fy, fz, mx, my, energy, largest, loaded = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    if stiffness is not None:
        stiffness[:] = 0.0
    if damping is not None:
        damping[:] = 0.0
    for j in range(balls.shape[0]):
        c, s = balls[j, COS], balls[j, SIN]
        balls[j, LOAD] = 0.0
        radial = contacts.radial + q[0] * c + q[1] * s
        axial = contacts.axial + q[2] + lever * (q[3] * s - q[4] * c)
        if radial <= 0.0:
            return OUT_OF_RANGE
        if inertia is None:
            apart = math.sqrt(radial * radial + axial * axial)
            approach = apart - contacts.distance - balls[j, GAP]
            if approach <= 0.0:
                continue
            cos_phi, sin_phi = radial / apart, axial / apart
            root = contacts.stiffness * math.sqrt(approach)
            load = root * approach
            energy += 0.4 * load * approach
        else:
            ball = seated_ball(radial, axial, balls[j, GAP], inertia)
            cos_phi, sin_phi, load = ball.cos_inner, ball.sin_inner, ball.load
            balls[j, OUTER_LOAD], balls[j, INNER_ANGLE] = ball.outer_load, math.atan2(sin_phi, cos_phi)
            balls[j, OUTER_ANGLE] = ball.outer_angle
            energy += ball.energy
            largest = max(largest, ball.outer_load)
            if load <= 0.0:
                continue
            root = (cos_phi * cos_phi * ball.rr + cos_phi * sin_phi * (ball.rz + ball.zr) + sin_phi * sin_phi * ball.zz) / 1.5
        if damper is not None:
            rate = cos_phi * (velocity[0] * c + velocity[1] * s)
            rate += sin_phi * (velocity[2] + lever * (velocity[3] * s - velocity[4] * c))
            load += damper * 1.5 * root * rate
            if load <= 0.0:
                continue
            if damping is not None:
                add_stiffness(damping, c, s, damper * 1.5 * root, 0.0, cos_phi, sin_phi)
        if stiffness is not None:
            if inertia is None:
                add_stiffness(stiffness, c, s, 1.5 * root, load / apart, cos_phi, sin_phi)
            else:
                add_seated(stiffness, c, s, lever, ball)
        balls[j, LOAD] = load
        largest = max(largest, load)
        loaded += 1.0
        across, along = load * cos_phi, load * sin_phi
        fx -= across * c
        fy -= across * s
        fz -= along
        mx -= along * s
        my += along * c
    sums[0], sums[1], sums[2], sums[3], sums[4] = fx, fy, fz, lever * mx, lever * my
    sums[ENERGY], sums[MAX_LOAD], sums[LOADED] = energy, largest, loaded
    if stiffness is not None and inertia is None:
        finish_stiffness(stiffness, lever)
    if damping is not None:
        finish_stiffness(damping, lever)
    return DONE
