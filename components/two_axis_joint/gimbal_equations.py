"""Equations of the gimbal, for numbers only: the torques about the two axes, the accelerations, and the reactions of the base.

Body axes: y is the inner axis, z points from the crossing of the axes to the centre of mass and is the rotor's axis, x
completes them. The outer axis lies in the body's x-z plane; its direction (c, 0, s) is all that tells a vertical outer axis
(c = -sin beta, s = cos beta) from a horizontal one (c = cos beta, s = sin beta), except for gravity.
Base axes: x and y horizontal, z down; a horizontal outer axis is x, a vertical one is z, and the inner axis is y at alpha = 0.
"""

from __future__ import annotations

import math

from ..core.contact import stop_depth, stop_torque
from ..core.friction import lugre_force, lugre_rate, smoothed_friction, stick_friction, stick_guard
from ..core.kernels import kernel

ALPHA, BETA, OUTER, INNER, CONTACT = range(5)  # of the state: angles, rates, and the bristles or modes of both axes
OUTER_TORQUE, INNER_TORQUE = range(2)  # inputs
VERTICAL = 0  # of the choice of the outer axis


@kernel
def axis_in_body(beta, orientation):
    """(c, s): the outer axis in body axes is (c, 0, s)."""
    if orientation == VERTICAL:
        return -math.sin(beta), math.cos(beta)
    return math.cos(beta), math.sin(beta)


@kernel
def frame_rates(x, u, p, base):
    """Rates of the frame about the outer axis, the inner axis and the third, and what of their derivatives no angle's is.

    In a frame at rest this is (alpha', 0, 0, 0, 0, 0).
    """
    if base is None:
        return x[OUTER], 0.0, 0.0, 0.0, 0.0, 0.0
    rate, acceleration = u[base.u], u[base.u + 1]
    if p.axis_orientation == VERTICAL:
        return x[OUTER] + rate, 0.0, 0.0, acceleration, 0.0, 0.0
    sine, cosine = math.sin(x[ALPHA]), math.cos(x[ALPHA])
    about_y, about_z = rate * sine, rate * cosine
    return (x[OUTER], about_y, about_z, 0.0, acceleration * sine + about_z * x[OUTER], acceleration * cosine - about_y * x[OUTER])


@kernel
def body_rates(x, u, p, base):
    """Angular velocity of the body in body axes, rad/s."""
    c, s = axis_in_body(x[BETA], p.axis_orientation)
    about_outer, about_inner, about_third, _, _, _ = frame_rates(x, u, p, base)
    return c * about_outer - s * about_third, about_inner + x[INNER], s * about_outer + c * about_third


@kernel
def body_moment(c, s, x, u, alpha_2, beta_2, p, e):
    """Moment that the body's motion takes, I w' + w x (I w + h), in body axes, at the given accelerations of the angles."""
    about_outer, about_inner, about_third, outer_1, inner_1, third_1 = frame_rates(x, u, p, e.base_motion)
    wx, wy, wz = c * about_outer - s * about_third, about_inner + x[INNER], s * about_outer + c * about_third
    outer_1 += alpha_2
    wx_1 = c * outer_1 - s * third_1 - x[INNER] * wz
    wz_1 = s * outer_1 + c * third_1 + x[INNER] * wx
    wy_1 = inner_1 + beta_2
    lx, ly, lz = p.cross_inertia * wx, p.inner_inertia * wy, p.axial_inertia * wz
    if e.rotor is not None:
        lz += e.rotor.spin_momentum
    mx = p.cross_inertia * wx_1 + wy * lz - wz * ly
    my = p.inner_inertia * wy_1 + wz * lx - wx * lz
    mz = p.axial_inertia * wz_1 + wx * ly - wy * lx
    return mx, my, mz


@kernel
def specific_force(u, gravity, base):
    """Gravity less the acceleration of the base, in base axes, m/s²."""
    if base is None:
        return 0.0, 0.0, gravity.acceleration
    return -u[base.u + 2], -u[base.u + 3], gravity.acceleration - u[base.u + 4]


@kernel
def drives(x, u, p, e):
    """(inertia about the outer axis, torques that set the outer and the inner axis in motion, dry friction apart).

    inertia * alpha'' = first torque - friction, inner_inertia * beta'' = second torque - friction.
    """
    c, s = axis_in_body(x[BETA], p.axis_orientation)
    outer_1 = frame_rates(x, u, p, e.base_motion)[3]
    mx, my, mz = body_moment(c, s, x, u, 0.0, 0.0, p, e)
    inertia = p.frame_inertia + p.cross_inertia * c * c + p.axial_inertia * s * s
    outer, inner = u[OUTER_TORQUE] - c * mx - s * mz - p.frame_inertia * outer_1, u[INNER_TORQUE] - my
    if e.gravity is not None:
        fx, fy, fz = specific_force(u, e.gravity, e.base_motion)
        moment = e.gravity.mass * e.gravity.distance
        if p.axis_orientation == VERTICAL:
            along, across = fx, fy  # of the frame's plane, which stays as it is without a base in motion
            if e.base_motion is not None:
                sine, cosine = math.sin(x[ALPHA]), math.cos(x[ALPHA])
                along, across = fx * cosine + fy * sine, fy * cosine - fx * sine
            outer -= moment * across * c
            inner += moment * (along * s + fz * c)
        else:
            sine, cosine = math.sin(x[ALPHA]), math.cos(x[ALPHA])
            outer -= moment * (fy * cosine + fz * sine) * c
            inner += moment * (fx * c + (fy * sine - fz * cosine) * s)
    if e.viscous is not None:
        outer -= e.viscous.outer_coefficient * x[OUTER]
        inner -= e.viscous.inner_coefficient * x[INNER]
    if e.stops is not None:
        outer += stop_torque(x[ALPHA], x[OUTER], e.stops.outer_lower, e.stops.outer_upper, e.stops.stiffness, e.stops.dissipation)
        inner += stop_torque(x[BETA], x[INNER], e.stops.inner_lower, e.stops.inner_upper, e.stops.stiffness, e.stops.dissipation)
    if e.payload is not None:
        outer += c * u[e.payload.u] + s * u[e.payload.u + 2]
        inner += u[e.payload.u + 1]
    return inertia, outer, inner


@kernel
def bristle_rates(x, p, lugre):
    """Rates of the bristles' deflections at both axes, followed no faster than the substep allows."""
    k, ratio, fastest = lugre.stiffness, lugre.static_ratio, 1.0 / p.substep
    outer, inner = lugre.outer_level, lugre.inner_level
    return (
        lugre_rate(x[OUTER], x[CONTACT], k, outer, ratio * outer, lugre.stribeck_rate, fastest),
        lugre_rate(x[INNER], x[CONTACT + 1], k, inner, ratio * inner, lugre.stribeck_rate, fastest),
    )


@kernel
def accelerations(x, u, p, e):
    """(alpha'', beta''), dry friction included."""
    inertia, outer, inner = drives(x, u, p, e)
    if e.smoothed_friction is not None:
        outer -= smoothed_friction(x[OUTER], e.smoothed_friction.outer_level, e.smoothed_friction.width)
        inner -= smoothed_friction(x[INNER], e.smoothed_friction.inner_level, e.smoothed_friction.width)
    if e.lugre_friction is not None:
        first, second = bristle_rates(x, p, e.lugre_friction)
        outer -= lugre_force(x[OUTER], x[CONTACT], first, e.lugre_friction.stiffness, e.lugre_friction.damping, 0.0)
        inner -= lugre_force(x[INNER], x[CONTACT + 1], second, e.lugre_friction.stiffness, e.lugre_friction.damping, 0.0)
    if e.stick_friction is not None:
        outer -= stick_friction(x[CONTACT], outer, e.stick_friction.outer_level)
        inner -= stick_friction(x[CONTACT + 1], inner, e.stick_friction.inner_level)
    return outer / inertia, inner / p.inner_inertia


@kernel
def outer_momentum(x, u, p, e):
    """Angular momentum of body and frame about the outer axis, kg.m²/s."""
    c, s = axis_in_body(x[BETA], p.axis_orientation)
    wx, _, wz = body_rates(x, u, p, e.base_motion)
    momentum = p.frame_inertia * frame_rates(x, u, p, e.base_motion)[0] + c * p.cross_inertia * wx + s * p.axial_inertia * wz
    if e.rotor is not None:
        momentum += s * e.rotor.spin_momentum
    return momentum


@kernel
def gimbal_energy(x, u, p, e):
    """Kinetic energy relative to the ground, height above the hanging body, bending of bristles and stops, J."""
    wx, wy, wz = body_rates(x, u, p, e.base_motion)
    turning = frame_rates(x, u, p, e.base_motion)[0]
    twice = (
        p.frame_inertia * turning * turning + p.cross_inertia * wx * wx + p.inner_inertia * wy * wy + p.axial_inertia * wz * wz
    )
    if e.lugre_friction is not None:
        twice += e.lugre_friction.stiffness * (x[CONTACT] * x[CONTACT] + x[CONTACT + 1] * x[CONTACT + 1])
    if e.stops is not None:
        outer = stop_depth(x[ALPHA], e.stops.outer_lower, e.stops.outer_upper)
        inner = stop_depth(x[BETA], e.stops.inner_lower, e.stops.inner_upper)
        twice += e.stops.stiffness * (outer * outer + inner * inner)
    energy = 0.5 * twice
    if e.gravity is not None:
        down = math.cos(x[BETA])
        if p.axis_orientation != VERTICAL:
            down *= math.cos(x[ALPHA])
        energy += e.gravity.mass * e.gravity.acceleration * e.gravity.distance * (1.0 - down)
    return energy


@kernel
def body_to_base(vx, vy, vz, x, p):
    """A vector of body axes in base axes."""
    sa, ca, sb, cb = math.sin(x[ALPHA]), math.cos(x[ALPHA]), math.sin(x[BETA]), math.cos(x[BETA])
    fx, fz = cb * vx + sb * vz, cb * vz - sb * vx
    if p.axis_orientation == VERTICAL:
        return ca * fx - sa * vy, sa * fx + ca * vy, fz
    return fx, ca * vy - sa * fz, sa * vy + ca * fz


@kernel
def reactions_of_base(x, u, alpha_2, beta_2, p, e):
    """(force, moment about the crossing of the axes) of the base on the joint, in base axes, by Newton's and Euler's laws.

    The frame has inertia about the outer axis only, and no weight.
    """
    c, s = axis_in_body(x[BETA], p.axis_orientation)
    mx, my, mz = body_moment(c, s, x, u, alpha_2, beta_2, p, e)
    wx, wy, wz = body_rates(x, u, p, e.base_motion)
    about_outer, about_inner, about_third, outer_1, inner_1, third_1 = frame_rates(x, u, p, e.base_motion)
    wx_1 = c * (outer_1 + alpha_2) - s * third_1 - x[INNER] * wz
    m, d = e.gravity.mass, e.gravity.distance
    ax, ay, az = body_to_base(d * (inner_1 + beta_2 + wx * wz), d * (wy * wz - wx_1), -d * (wx * wx + wy * wy), x, p)
    gx, gy, gz = specific_force(u, e.gravity, e.base_motion)
    rx, ry, rz = body_to_base(0.0, 0.0, m * d, x, p)
    if e.payload is not None:
        mx -= u[e.payload.u]
        my -= u[e.payload.u + 1]
        mz -= u[e.payload.u + 2]
    # the frame: (outer, inner, third) moments of an inertia about its own axis alone
    turn = p.frame_inertia * (outer_1 + alpha_2)
    second, third = p.frame_inertia * about_outer * about_third, -p.frame_inertia * about_outer * about_inner
    mx += c * turn - s * third
    my += second
    mz += s * turn + c * third
    mx, my, mz = body_to_base(mx, my, mz, x, p)
    return (m * (ax - gx), m * (ay - gy), m * (az - gz), mx - ry * gz + rz * gy, my - rz * gx + rx * gz, mz - rx * gy + ry * gx)


@kernel
def level_of_axis(which, stick):
    """Static friction of the outer (0) or the inner axis."""
    return stick.static_ratio * (stick.outer_level if which == 0 else stick.inner_level)


@kernel
def axis_guard(which, drive, x, stick):
    """Guard: positive while the mode of one axis lasts under its drive, see `stick_guard`."""
    return stick_guard(x[CONTACT + which], x[OUTER + which], drive, level_of_axis(which, stick))
