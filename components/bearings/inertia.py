"""Balls with inertia: centrifugal force and gyroscopic moment, and with them other contact angles at the inner and the outer race.

A ball's centre is at v from the centre of the outer groove, and at w = g - v from that of the inner one, with the groove centres
g = (radial, axial) apart. Loads act along both lines, and the ball is at rest on its circle round the shaft:

    Q_i w/|w| - Q_o v/|v| + F_c (1, 0) + 2/5 F_c sin(alpha_o) (sin(alpha_o), -cos(alpha_o)) = 0,
    Q_i = K_i (|w| - l_i - gap/2)^1.5,  Q_o = K_o (|v| - l_o - gap/2)^1.5,  F_c = m dm omega_c² / 2,  tan(alpha_o) = v_z / v_r

The last force is the friction at the outer race that turns the ball's axis round the shaft. It follows from rolling without spin there:
the ball's spin then has the radial part omega_c dm/d sin(alpha_o), and its angular momentum, with the moment of inertia m d²/10,
the rate m d dm omega_c² sin(alpha_o) / 10, which the force supplies at the lever d/2. The model, control by the outer race, is that of
A. B. Jones, J. Basic Eng. 82 (1960) 309-320, and T. A. Harris, Rolling Bearing Analysis (from memory); the forces are derived here.

The ball follows at once: its own vibration between the races, some kHz, is not in it. omega_c is the cage's speed at a contact angle of 0.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ..core.component import Effect
from ..core.kernels import kernel, kernel_tuple
from ..core.variables import output, parameter
from .motion import EVERYTHING

ITERATIONS = 40  # of Newton's method for a ball; 7 have been enough for 20 000 balls at random, 3.6 in the mean
SETTLED = 1e-11  # of the groove centres' distance, the last step, behind which rounding is left
TRIALS = 40  # of the length of a step
NO_FORCE = 1e-10  # N; forces below it count as none. The approach of a ball that carries it is below 1e-13 m.
OVERSHOOT, LEFT = 0.3, 0.5  # of the unbalanced force along a step, that may be left behind it with the other, with its own sign
GYROSCOPIC = 0.4  # of the centrifugal force, times sin(alpha_o): the friction force of a solid ball


class BallInertia(Effect):
    """Centrifugal force and gyroscopic moment of the balls: they lie closer to the outer race, at other contact angles.

    The balls follow the rings at once. Control by the outer race; films and waves count by half at each race.
    """

    density = parameter(7800.0, "kg/m3", "density of the balls; steel, from memory; silicon nitride 3200", low=0.0, nominal=1e3)

    centrifugal_force = output("N", "centrifugal force of a ball", nominal=100.0, feedthrough=("speed",))
    outer_load = output("N", "largest load at the outer race", nominal=100.0, feedthrough=EVERYTHING)
    inner_angle = output("rad", "contact angle at the inner race of the ball with the largest load there", feedthrough=EVERYTHING)
    outer_angle = output("rad", "contact angle at the outer race of the same ball", feedthrough=EVERYTHING)


@kernel_tuple
class Inertia(NamedTuple):
    """Both contacts of a ball, and its centrifugal force at the present speed."""

    inner: float  # K_i, K_o, N/m^1.5
    outer: float
    inner_distance: float  # l_i, l_o, from a ball's centre to that of a groove when they just touch, m
    outer_distance: float
    force: float  # F_c, N


@kernel_tuple
class SeatedBall(NamedTuple):
    """A ball at rest between the races."""

    load: float  # of the inner race, N
    outer_load: float
    cos_inner: float
    sin_inner: float
    outer_angle: float
    energy: float  # J
    rr: float  # d(force of the inner race)/d(groove centres), N/m, (r, z) by (r, z)
    rz: float
    zr: float
    zz: float


@kernel
def centrifugal_factor(density, ball_diameter, pitch_diameter, cage_ratio):
    """F_c over the square of the speed of the inner ring, kg.m."""
    return density * math.pi / 12.0 * ball_diameter**3 * pitch_diameter * cage_ratio**2


@kernel
def balance(r, z, radial, axial, inner_length, outer_length, k):
    """Force on a ball at v = (r, z), N, and what it follows from: lengths of w and v, loads."""
    v, w = math.hypot(r, z), math.hypot(radial - r, axial - z)
    inner = k.inner * max(w - inner_length, 0.0) ** 1.5
    outer = k.outer * max(v - outer_length, 0.0) ** 1.5
    turning = GYROSCOPIC * k.force * z / (v * v)
    force_r = inner * (radial - r) / w - outer * r / v + k.force + turning * z
    return force_r, inner * (axial - z) / w - outer * z / v - turning * r, w, v, inner, outer


@kernel
def first_place(radial, axial, inner_length, outer_length, k):
    """Where Newton's method begins: on the line of the groove centres, or, of a ball in play, where it leans on both races."""
    apart = math.hypot(radial, axial)
    c, s = radial / apart, axial / apart
    leaning_out = outer_length + (k.force / k.outer) ** (2.0 / 3.0)
    leaning_in = inner_length + (k.force / k.inner) ** (2.0 / 3.0)
    if leaning_out + leaning_in > apart:
        along = 0.5 * (apart + (leaning_out - leaning_in) * (leaning_out + leaning_in) / apart)
        across = math.sqrt(max(leaning_out * leaning_out - along * along, 0.0))
        return along * c + across * abs(s), along * s - (across * c if s > 0.0 else -across * c)
    approach = apart - inner_length - outer_length
    softness = k.inner ** (-2.0 / 3.0) + k.outer ** (-2.0 / 3.0)
    load = (approach / softness) ** 1.5 + k.force * c
    out = outer_length + (load / k.outer) ** (2.0 / 3.0)
    return out * c, out * s


@kernel
def seated_ball(radial, axial, gap, k):
    """The ball between groove centres that are (radial, axial) apart, m; gap: m, of both races together; k: `Inertia`.

    The forces of the races have a convex potential, so that the force along a step only falls, but for the small friction: a step is
    halved in until the force along it is left small, as in `loads.minimum`.
    """
    inner_length, outer_length = k.inner_distance + 0.5 * gap, k.outer_distance + 0.5 * gap
    r, z = outer_length + (k.force / k.outer) ** (2.0 / 3.0), 0.0
    in_play = math.hypot(radial, axial) <= inner_length + outer_length
    if math.hypot(radial - r, axial) <= inner_length or (in_play and k.force < NO_FORCE):  # the inner race is not reached
        return SeatedBall(0.0, k.force, 1.0, 0.0, 0.0, 0.4 * k.force * (r - outer_length), 0.0, 0.0, 0.0, 0.0)
    r, z = first_place(radial, axial, inner_length, outer_length, k)
    last = False
    in_rr, in_rz, in_zz, rr, rz, zr, zz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    force_r, force_z, w, v, inner, outer = balance(r, z, radial, axial, inner_length, outer_length, k)
    for _ in range(ITERATIONS):
        ci, si, co, so = (radial - r) / w, (axial - z) / w, r / v, z / v
        along_in, along_out = (
            1.5 * k.inner * math.sqrt(max(w - inner_length, 0.0)),
            1.5 * k.outer * math.sqrt(max(v - outer_length, 0.0)),
        )
        across_in, across_out = inner / w, outer / v
        in_rr = along_in * ci * ci + across_in * si * si
        in_rz = (along_in - across_in) * ci * si
        in_zz = along_in * si * si + across_in * ci * ci
        turning = GYROSCOPIC * k.force / v
        by_r, by_z = 2.0 * turning * so * co, -turning * (co * co - so * so)  # the friction's derivative by alpha_o, over |v|
        rr = in_rr + along_out * co * co + across_out * so * so + by_r * so
        rz = in_rz + (along_out - across_out) * co * so - by_r * co
        zr = in_rz + (along_out - across_out) * co * so + by_z * so
        zz = in_zz + along_out * so * so + across_out * co * co - by_z * co
        if last:
            break
        whole = rr * zz - rz * zr
        step_r, step_z = (zz * force_r - rz * force_z) / whole, (rr * force_z - zr * force_r) / whole
        before, length = force_r * step_r + force_z * step_z, math.hypot(step_r, step_z)
        longest = 0.25 * (inner_length + outer_length)
        share = longest / length if length > longest else 1.0
        near, far, to_r, to_z = 0.0, math.inf, r, z
        for _ in range(TRIALS):
            to_r, to_z = r + share * step_r, z + share * step_z
            force_r, force_z, w, v, inner, outer = balance(to_r, to_z, radial, axial, inner_length, outer_length, k)
            after = force_r * step_r + force_z * step_z
            if after < -OVERSHOOT * before:
                far = share
            elif after > LEFT * before and far < math.inf:
                near = share
            else:
                break
            share = 0.5 * (near + far)
        r, z = to_r, to_z
        last = not share * length > SETTLED * (inner_length + outer_length)
    whole = rr * zz - rz * zr
    # d(w)/d(groove centres) = 1 - (sum)^-1 inner
    a, b = 1.0 - (zz * in_rr - rz * in_rz) / whole, -(zz * in_rz - rz * in_zz) / whole
    c, d = -(rr * in_rz - zr * in_rr) / whole, 1.0 - (rr * in_zz - zr * in_rz) / whole
    energy = 0.4 * (inner * max(w - inner_length, 0.0) + outer * max(v - outer_length, 0.0))
    return SeatedBall(
        inner,
        outer,
        (radial - r) / w,
        (axial - z) / w,
        math.atan2(z, r),
        energy,
        in_rr * a + in_rz * c,
        in_rr * b + in_rz * d,
        in_rz * a + in_zz * c,
        in_rz * b + in_zz * d,
    )
