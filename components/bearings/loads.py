"""Static equilibrium of a ball bearing: displacement, ball loads and contact angles under given forces and moments.

The equilibrium is the minimum of the potential less the work of the load. That function is convex (see contacts.py), but
only just: no stiffness at all in free play, none across the line of a single loaded ball, and for a contact angle of 0 without
clearance none along the shaft, where the energy grows with z^5. So Newton's matrix gets a multiple of the identity
(Levenberg, Marquardt), which starts large and is let go on the way: far from contact the steps grow by a factor of ten each
until a ball is met, near the solution it is Newton's method, and where nothing resists nothing moves.

Measured: 15 000 bearings of 5 to 24 balls under random loads from 1e-7 to 1 times the largest sensible one, with components
apart by a thousand, all converge, in 0.02 to 0.3 ms. Of 60 000 with 3 balls and more, down to 1e-9 times and apart by up to
1e6, 0.3 % do not: they carry less than 0.1 N or hang on three or four balls, and the status says so.
"""

from __future__ import annotations

import math
from collections.abc import Collection
from typing import NamedTuple

import numpy as np

from ..core.errors import BadInput
from ..core.kernels import DONE, NOT_CONVERGED, kernel
from .contacts import COS, GAP, INNER_ANGLE, LOAD, SIN, BallContacts, contact_forces, place_balls
from .inertia import LEFT, NO_FORCE, OVERSHOOT, Inertia

COORDINATES = ("x", "y", "z", "tilt_x", "tilt_y")
ITERATIONS = 200
TOLERANCE = 1e-10  # of the unbalanced force to the loads
FLOOR = 1e-11  # of the largest stiffness, that Newton's matrix keeps of the identity: above rounding, so that it stays definite
START = 0.05  # of the distance of the groove centres, the approach of a ball under the load from which a smaller one comes down
COARSE = 1e-3  # tolerance of the first iterations


class StaticLoads(NamedTuple):
    """An equilibrium; `status` is DONE or NOT_CONVERGED of `core.kernels`."""

    displacement: np.ndarray  # (5,) x, y, z in m, tilt_x, tilt_y in rad, of the inner ring
    ball_loads: np.ndarray  # (Z,) N
    contact_angles: np.ndarray  # (Z,) rad, from the plane of the bearing; of an unloaded ball that of the groove centres
    status: int


def static_loads(
    contacts: BallContacts,
    forces: np.ndarray,
    *,
    first_ball: float = 0.0,
    held: Collection[str] = (),
    gap: np.ndarray | float = 0.0,
    inertia: Inertia | None = None,
) -> StaticLoads:
    """Equilibrium of the inner ring under an external load on it; the outer ring is fixed.

    forces: (5,) Fx, Fy, Fz in N, Mx, My in N.m.  first_ball: angle of the first ball, rad.  held: coordinates of
    `COORDINATES` that stay 0, whatever their force or moment.  gap: m, one or (Z,), by which the surfaces at each
    ball are farther apart than in a perfect bearing.  inertia: of the balls, whose loads and angles are then those at the inner race.

    Without load and with clearance the ring stays in the middle. Raises `BadInput` for loads that are not five finite
    numbers, fewer than three balls, or an unknown coordinate in `held`.
    """
    forces = np.array(forces, dtype=float)
    if forces.shape != (5,) or not np.isfinite(forces).all():
        raise BadInput("static loads", f"forces {forces}", "five finite numbers: Fx, Fy, Fz, Mx, My")
    if contacts.balls < 3:
        raise BadInput("static loads", f"{contacts.balls} balls", "at least three, which hold a ring from all sides")
    for name in held:
        if name not in COORDINATES:
            raise BadInput("static loads", f"coordinate {name!r} held", "one of " + ", ".join(COORDINATES))
    balls = place_balls(contacts.balls, first_ball, 4 if inertia is None else 7)
    balls[:, GAP] = gap
    q, free = np.zeros(5), np.array([float(name not in held) for name in COORDINATES])
    status = int(equilibrium(forces, free, contacts, balls, q, workspace(), inertia))
    angles = contact_angles(q, contacts, balls) if inertia is None else balls[:, INNER_ANGLE].copy()
    return StaticLoads(q, balls[:, LOAD].copy(), angles, status)


def contact_angles(q: np.ndarray, contacts: BallContacts, balls: np.ndarray) -> np.ndarray:
    """Angle of each ball's contact line from the plane of the bearing at displacement q (5,), (Z,) rad."""
    c, s = balls[:, COS], balls[:, SIN]
    axial = contacts.axial + q[2] + contacts.lever * (q[3] * s - q[4] * c)
    return np.arctan2(axial, contacts.radial + q[0] * c + q[1] * s)


def workspace() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Room for `equilibrium`: stiffness (5, 5), Newton's matrix (5, 5), and vectors (5, 8)."""
    return np.zeros((5, 5)), np.zeros((5, 5)), np.zeros((5, 8))


@kernel
def equilibrium(forces, free, contacts, balls, q, work, inertia):
    """Move q (5,) from where it is to equilibrium with the external `forces` (5,); status DONE or NOT_CONVERGED.

    free: (5,) 1.0 for a coordinate that may move, 0.0 for one that is held.  balls: as for `contact_forces`; at the end with
    the loads.  work: of `workspace`.  A small load comes down from a large one, by a factor of ten a time.
    """
    load = 0.0
    for i in range(5):
        load = math.hypot(load, free[i] * forces[i] / (contacts.lever if i > 2 else 1.0))
    large = contacts.stiffness * (START * contacts.distance) ** 1.5
    times = max(1.0, large / load) if load > NO_FORCE else 1.0
    while times > 1.0:
        minimum(times, forces, free, contacts, balls, q, COARSE, work, inertia)  # only a way: it need not be gone to its end
        times *= 0.1
    return minimum(1.0, forces, free, contacts, balls, q, TOLERANCE, work, inertia)


@kernel
def minimum(times, forces, free, contacts, balls, q, tolerance, work, inertia):
    """`equilibrium` with `times` the forces, by Newton's method from where q is; tilts count by their way at the lever."""
    stiffness, matrix, rows = work
    sums, unbalanced, step, trial, scale = rows[0], rows[1, :5], rows[2, :5], rows[3, :5], rows[4, :5]
    longest = 0.25 * contacts.radial  # m, of a step; keeps every ball in its groove
    status = contact_forces(q, contacts, balls, sums, stiffness, None, None, None, inertia)
    if status != DONE:
        return status
    load = 0.0
    for i in range(5):
        scale[i] = free[i] / (contacts.lever if i > 2 else 1.0)
        load = math.hypot(load, times * scale[i] * forces[i])
    damping = 1.5 * (contacts.stiffness**2 * max(load, NO_FORCE)) ** (1.0 / 3.0)  # stiffness of one ball under the load
    for _ in range(ITERATIONS):
        carried, left, stiffest = 0.0, 0.0, 0.0
        for j in range(balls.shape[0]):
            carried += balls[j, LOAD]
        for i in range(5):
            unbalanced[i] = scale[i] * (times * forces[i] + sums[i])
            left = math.hypot(left, unbalanced[i])
            stiffest = max(stiffest, scale[i] * stiffness[i, i] * scale[i])
        if left <= tolerance * (load + carried) + NO_FORCE:
            return DONE
        damping = max(damping, FLOOR * stiffest)
        for i in range(5):
            for j in range(5):
                matrix[i, j] = scale[i] * stiffness[i, j] * scale[j]
            matrix[i, i] += damping
            step[i] = unbalanced[i]
        solve_positive(matrix, step)
        length, before = 0.0, 0.0
        for i in range(5):
            length = math.hypot(length, step[i])
            before += unbalanced[i] * step[i]
        # The unbalanced force along the step is minus the slope of a convex function, which can only fall. The step is halved
        # in until that force is left small, or still pushes on.
        share = longest / length if length > longest else 1.0
        near, far = 0.0, math.inf
        for _ in range(ITERATIONS):
            for i in range(5):
                trial[i] = q[i] + share * scale[i] * step[i]
            status = contact_forces(trial, contacts, balls, sums, stiffness, None, None, None, inertia)
            after = 0.0
            for i in range(5):
                after += scale[i] * (times * forces[i] + sums[i]) * step[i]
            if status != DONE or after < -OVERSHOOT * before:
                far = share
            elif after > LEFT * before and far < math.inf:
                near = share
            else:
                break
            share = 0.5 * (near + far)
        damping *= 0.1 if share == 1.0 else min(1.0 / share, 1e3)
        for i in range(5):
            q[i] = trial[i]
    return NOT_CONVERGED


@kernel
def solve_positive(a, b):
    """Solve a x = b for a symmetric positive definite a (n, n) by Cholesky's factors, in place; b becomes x."""
    n = b.size
    for i in range(n):
        for j in range(i + 1):
            value = a[i, j]
            for k in range(j):
                value -= a[i, k] * a[j, k]
            a[i, j] = math.sqrt(value) if i == j else value / a[j, j]
    for i in range(n):
        for k in range(i):
            b[i] -= a[i, k] * b[k]
        b[i] /= a[i, i]
    for i in range(n - 1, -1, -1):
        for k in range(i + 1, n):
            b[i] -= a[k, i] * b[k]
        b[i] /= a[i, i]
