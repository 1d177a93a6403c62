"""Equations of the two-link chain, in the coordinates of its joints.

State x = (q1, q2, q1', q2'[, s1, s2][, contact][, impacts, latch]): the first link's angle from the downward vertical, the
second link's angle against the first, their rates; for each joint a bristle's deflection (LuGre) or a mode (exact standstill);
last, which stop is touched, 1 the upper one, -1 the lower one, 0 none; or the number of impacts, and the side on which the latch
is, 0 where it holds. Friction acts in one joint each, so these coordinates make it diagonal; the absolute angles are q1, q1 + q2.
"""

from __future__ import annotations

import math

from ..core.friction import lugre_force, lugre_rate, smoothed_friction, stick_friction, stick_guard, stick_switch
from ..core.kernels import kernel

FIRST_TORQUE, SECOND_TORQUE = range(2)  # inputs


@kernel
def mass_matrix(q2, p):
    """(m11, m12, m22, determinant) of the symmetric mass matrix of (q1, q2), kg.m2.

    The determinant is a sum of terms that cannot be negative: the difference of products loses all digits in a stretched chain of
    point masses.
    """
    own = p.first_inertia + p.first_mass * p.first_centre * p.first_centre
    carried = p.second_mass * p.first_length * p.first_length
    second = p.second_inertia + p.second_mass * p.second_centre * p.second_centre
    coupling = p.second_mass * p.first_length * p.second_centre
    cosine, sine = math.cos(q2), math.sin(q2)
    determinant = own * second + carried * p.second_inertia + coupling * coupling * sine * sine
    return own + carried + 2.0 * coupling * cosine + second, coupling * cosine + second, second, determinant


@kernel
def stop_torque(q2, rate, contact, stops):
    """Torque of the stops on the second joint: a spring, with losses in proportion to its force (Hunt and Crossley, 1975)."""
    if contact == 0.0:
        return 0.0
    depth = q2 - stops.upper if contact > 0.0 else q2 - stops.lower
    return -stops.stiffness * depth * max(0.0, 1.0 + contact * stops.dissipation * rate)


@kernel
def loads(x, u, p, e):
    """Torques that move the two joints, N.m: motors, inertia, weight, and every loss that is a function of the state."""
    first = x[2]
    second = x[2] + x[3]
    inertial = p.second_mass * p.first_length * p.second_centre * math.sin(x[1])
    b2 = u[SECOND_TORQUE] - inertial * first * first
    b1 = u[FIRST_TORQUE] - u[SECOND_TORQUE] + b2 + inertial * second * second
    if e.gravity is not None:
        weight = p.second_mass * p.second_centre * e.gravity.acceleration * math.sin(x[0] + x[1])
        b1 -= (p.first_mass * p.first_centre + p.second_mass * p.first_length) * e.gravity.acceleration * math.sin(x[0]) + weight
        b2 -= weight
    if e.viscous is not None:
        b1 -= e.viscous.first * x[2]
        b2 -= e.viscous.second * x[3]
    if e.springs is not None:
        b1 -= e.springs.first_stiffness * (x[0] - e.springs.first_rest)
        b2 -= e.springs.second_stiffness * (x[1] - e.springs.second_rest)
    if e.smoothed_friction is not None:
        b1 -= smoothed_friction(x[2], e.smoothed_friction.first_level, e.smoothed_friction.width)
        b2 -= smoothed_friction(x[3], e.smoothed_friction.second_level, e.smoothed_friction.width)
    if e.stops is not None:
        b2 += stop_torque(x[1], x[3], x[-1], e.stops)
    return b1, b2


@kernel
def bristle_rate(rate, z, level, substep, lugre):
    """Rate of one joint's bristles; without friction there are none."""
    if level == 0.0:
        return 0.0
    return lugre_rate(rate, z, lugre.stiffness, level, lugre.static_ratio * level, lugre.stribeck_rate, 1.0 / substep)


@kernel
def bristle_torque(rate, z, bristle, level, lugre):
    """Friction of one joint's bristles."""
    if level == 0.0:
        return 0.0
    return lugre_force(rate, z, bristle, lugre.stiffness, lugre.damping, 0.0)


@kernel
def static_level(level, stick):
    """Torque that a joint at rest bears."""
    return stick.static_ratio * level


@kernel
def motion(x, u, p, e):
    """(q1'', q2'', c1, c2); c: rates of the bristles, or the torques that set joints at rest in motion, friction apart."""
    m11, m12, m22, determinant = mass_matrix(x[1], p)
    b1, b2 = loads(x, u, p, e)
    c1 = c2 = 0.0
    if e.lugre_friction is not None:
        c1 = bristle_rate(x[2], x[4], e.lugre_friction.first_level, p.substep, e.lugre_friction)
        c2 = bristle_rate(x[3], x[5], e.lugre_friction.second_level, p.substep, e.lugre_friction)
        b1 -= bristle_torque(x[2], x[4], c1, e.lugre_friction.first_level, e.lugre_friction)
        b2 -= bristle_torque(x[3], x[5], c2, e.lugre_friction.second_level, e.lugre_friction)
    if e.latch is not None:  # noqa: SIM102 - a branch of its own, which is gone where the effect is off
        if x[-1] == 0.0:
            if e.stick_friction is not None:
                if x[4] == 0.0:
                    return 0.0, 0.0, b1, 0.0
                b1 -= stick_friction(x[4], 0.0, e.stick_friction.first_level)
            return b1 / m11, 0.0, c1, c2
    if e.stick_friction is not None:
        if x[4] == 0.0 and x[5] == 0.0:
            return 0.0, 0.0, b1, b2
        if x[4] == 0.0:
            a2 = (b2 - stick_friction(x[5], 0.0, e.stick_friction.second_level)) / m22
            return 0.0, a2, b1 - m12 * a2, 0.0
        b1 -= stick_friction(x[4], 0.0, e.stick_friction.first_level)
        if x[5] == 0.0:
            a1 = b1 / m11
            return a1, 0.0, 0.0, b2 - m12 * a1
        b2 -= stick_friction(x[5], 0.0, e.stick_friction.second_level)
    return (m22 * b1 - m12 * b2) / determinant, (m11 * b2 - m12 * b1) / determinant, c1, c2


@kernel
def chain_derivatives(t, x, u, dx, s, p, e):
    """dx/dt; modes do not change between events."""
    a1, a2, c1, c2 = motion(x, u, p, e)
    dx[0], dx[1], dx[2], dx[3] = x[2], x[3], a1, a2
    if e.lugre_friction is not None:
        dx[4], dx[5] = c1, c2
    if e.stick_friction is not None:
        dx[4], dx[5] = 0.0, 0.0
    if e.stops is not None:
        dx[-1] = 0.0
    if e.latch is not None:
        dx[-2], dx[-1] = 0.0, 0.0


@kernel
def chain_guards(t, x, u, g, s, p, e):
    """Of each joint its rate in the direction it slides, or at rest what is missing to break loose; of stops or latch way or depth."""
    g[0], g[1], g[2] = 1.0, 1.0, 1.0
    if e.stick_friction is not None:
        _, _, c1, c2 = motion(x, u, p, e)
        g[0] = stick_guard(x[4], x[2], c1, static_level(e.stick_friction.first_level, e.stick_friction))
        g[1] = stick_guard(x[5], x[3], c2, static_level(e.stick_friction.second_level, e.stick_friction))
    if e.stops is not None:
        if x[-1] == 0.0:
            g[2] = min(e.stops.upper - x[1], x[1] - e.stops.lower)
        else:
            g[2] = x[1] - e.stops.upper if x[-1] > 0.0 else e.stops.lower - x[1]
    if e.latch is not None:
        if x[-1] == 0.0:
            g[1] = 1.0  # whatever friction would do
        else:
            g[2] = x[-1] * (e.latch.angle - x[1])


@kernel
def impact(x, p, e):
    """The second joint at its rigid end: its rate jumps, or it is caught; the first one's follows from the moment of momentum."""
    m11, m12, _, _ = mass_matrix(x[1], p)
    momentum = m11 * x[2] + m12 * x[3]
    if abs(x[3]) <= e.latch.capture_rate:
        x[-1], x[3] = 0.0, 0.0
    else:
        x[3] = -e.latch.restitution * x[3]
    x[2] = (momentum - m12 * x[3]) / m11
    x[-2] += 1.0
    if e.stick_friction is not None:  # no friction bears an impact
        x[4], x[5] = math.copysign(1.0, x[2]) * (x[2] != 0.0), math.copysign(1.0, x[3]) * (x[3] != 0.0)


@kernel
def chain_switch(which, t, x, u, s, p, e):
    """A joint comes to rest, turns back or breaks loose, a stop is touched or left, or an impact.

    Other modes stay: where the change makes one impossible, its own guard sees it.
    """
    if which == 2:
        if e.stops is not None:
            nearest = 1.0 if e.stops.upper - x[1] < x[1] - e.stops.lower else -1.0
            x[-1] = nearest if x[-1] == 0.0 else 0.0
        if e.latch is not None:
            impact(x, p, e)
    elif e.stick_friction is not None:
        mode = x[4 + which]
        x[2 + which] = 0.0
        x[4 + which] = 0.0
        _, _, c1, c2 = motion(x, u, p, e)
        drive = c1 if which == 0 else c2
        level = e.stick_friction.first_level if which == 0 else e.stick_friction.second_level
        x[4 + which] = stick_switch(mode, drive, static_level(level, e.stick_friction))


@kernel
def chain_energy(x, p, e):
    """Kinetic energy, height above the hanging chain, bending of springs, bristles and stops, J."""
    m11, m12, m22, _ = mass_matrix(x[1], p)
    energy = 0.5 * (m11 * x[2] * x[2] + m22 * x[3] * x[3]) + m12 * x[2] * x[3]
    if e.gravity is not None:
        first = p.first_mass * p.first_centre + p.second_mass * p.first_length
        second = p.second_mass * p.second_centre
        energy += e.gravity.acceleration * (first * (1.0 - math.cos(x[0])) + second * (1.0 - math.cos(x[0] + x[1])))
    if e.springs is not None:
        energy += 0.5 * e.springs.first_stiffness * (x[0] - e.springs.first_rest) ** 2
        energy += 0.5 * e.springs.second_stiffness * (x[1] - e.springs.second_rest) ** 2
    if e.lugre_friction is not None:
        energy += 0.5 * e.lugre_friction.stiffness * (x[4] * x[4] + x[5] * x[5])
    if e.stops is not None:
        depth = max(x[1] - e.stops.upper, e.stops.lower - x[1], 0.0)
        energy += 0.5 * e.stops.stiffness * depth * depth
    return energy
