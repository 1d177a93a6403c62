"""The start of the ball bearing with two degrees of freedom: constants from the parameters, equilibrium, limits of the step.

Kernels; the equations stand in `two_dof`.
"""

from __future__ import annotations

import math
from typing import Any

from ..core.contract import Kernels
from ..core.integrators import SUBSTEP, ode_initialize
from ..core.kernels import DONE, NOT_CONVERGED, bind, kernel
from .geometry import cage_turn, diameter_share, spin_turn
from .races import TWO_PI, highest_order, start_waves, wrapped
from .two_dof import (
    COSINE,
    DISPLACED_TOO_FAR,
    GAP,
    LOAD,
    PASSED,
    SINE,
    SPEED,
    TRANSVERSE_LOAD,
    bearing_derivatives,
    bearing_outputs,
    bearing_step,
    elastic_force,
    fastest,
    fill_gaps,
    longest_passing,
    radial_gap,
    resolved_step,
)


@kernel
def put_constants(s, mass, damping, stiffness, ball_diameter, pitch_diameter, contact_angle):
    """Constants that a bearing's own parameters determine."""
    gamma = diameter_share(ball_diameter, pitch_diameter, contact_angle)
    k = s.constants
    k.mass, k.damping, k.stiffness = mass, damping, stiffness
    k.cage_ratio, k.spin_ratio = cage_turn(gamma), spin_turn(ball_diameter, pitch_diameter, gamma)


@kernel
def bearing_start(first_ball, s, e):
    """Places of balls and waves, and the equilibrium, or the given start; behind `put_constants`. first_ball: its angle, rad."""
    balls, x = s.balls, s.x
    n = balls.shape[1]
    for j in range(n):
        at = TWO_PI * j / n
        balls[COSINE, j], balls[SINE, j] = math.cos(at), math.sin(at)
    if e.cage_fault is not None:
        if abs(e.cage_fault.offset) >= math.pi / n:
            s.message[0] = math.pi / n
            return DISPLACED_TOO_FAR
        at = TWO_PI * (e.cage_fault.ball - 1) / n + e.cage_fault.offset
        balls[COSINE, e.cage_fault.ball - 1], balls[SINE, e.cage_fault.ball - 1] = math.cos(at), math.sin(at)
    s.constants.sharing = sharing(balls)
    start_waves(s, e)
    s.constants.pass_angle, _, _ = shortest_pass(s, e)
    x[5] = wrapped(first_ball)
    if e.given_start is not None:
        x[0], x[1] = e.given_start.x, e.given_start.y
        x[2], x[3] = e.given_start.velocity_x, e.given_start.velocity_y
    elif static_position(x, s.u[0, LOAD], s.u[0, TRANSVERSE_LOAD], s, e) != DONE:
        x[0], x[1] = 0.0, 0.0  # nothing carries the load: a fall from the middle
    return DONE


@kernel
def sharing(balls):
    """How many balls resist one direction at most: the largest sum of their squared cosines."""
    n, even, odd = balls.shape[1], 0.0, 0.0
    for j in range(n):
        c, s = balls[COSINE, j], balls[SINE, j]
        even += c * c - s * s
        odd += 2.0 * c * s
    uneven = math.hypot(even, odd)  # 0 for three and more at equal distances
    return 0.5 * (n + uneven) if uneven > 1e-9 * n else 0.5 * n


@kernel
def shortest_pass(s, e):
    """(turn of the inner ring, rad, during which a ball passes a quarter of the narrowest pit or half wave, its place in
    `NARROW`, its order)."""
    k = s.constants
    angle, which, order = math.inf, 0, 0
    if e.inner_defect is not None:
        angle = 0.25 * e.inner_defect.width / (1.0 - k.cage_ratio)
    if e.outer_defect is not None and 0.25 * e.outer_defect.width / k.cage_ratio < angle:
        angle, which = 0.25 * e.outer_defect.width / k.cage_ratio, 1
    if e.ball_defect is not None and 0.25 * e.ball_defect.width / k.spin_ratio < angle:
        angle, which = 0.25 * e.ball_defect.width / k.spin_ratio, 2
    if e.inner_waviness is not None:
        highest = highest_order(e.inner_waviness)
        if highest > 0 and 0.25 * math.pi / (highest * (1.0 - k.cage_ratio)) < angle:
            angle, which, order = 0.25 * math.pi / (highest * (1.0 - k.cage_ratio)), 3, highest
    if e.outer_waviness is not None:
        highest = highest_order(e.outer_waviness)
        if highest > 0 and 0.25 * math.pi / (highest * k.cage_ratio) < angle:
            angle, which, order = 0.25 * math.pi / (highest * k.cage_ratio), 4, highest
    return angle, which, order


@kernel
def bearing_stable(t, s, p, e):
    """Longest step for the deepest penetration to which energy at the start and a fall through the clearance can lead.

    With the forces of the start; every step checks for a greater load or resonance.
    """
    k, gap, speed = s.constants, radial_gap(e.clearance), s.u[0, SPEED]
    force = math.hypot(s.u[0, LOAD], s.u[0, TRANSVERSE_LOAD])
    if e.load_variation is not None:
        force += abs(e.load_variation.amplitude)
    if e.unbalance is not None:
        force += k.mass * e.unbalance.eccentricity * speed**2
    energy, fall = 0.0, 2.0 * max(gap, 0.0)
    if e.given_start is not None:
        away = math.hypot(e.given_start.x, e.given_start.y)
        energy = 0.5 * k.mass * (e.given_start.velocity_x**2 + e.given_start.velocity_y**2)
        energy += 0.4 * k.stiffness * k.sharing * max(away - max(gap, 0.0), 0.0) ** 2.5
        fall = max(fall, away + max(gap, 0.0))
    deepest = (2.5 * force / k.stiffness) ** (2.0 / 3.0)
    for _ in range(20):  # 2/5 K d^2.5 = energy + force (d + fall), a contraction
        deepest = (2.5 / k.stiffness * (energy + force * (deepest + fall))) ** 0.4
    return resolved_step(k, e.contact_damping, deepest + max(-gap, 0.0))


def bearing_initialize(t, s, p, e):
    """A step too long for impacts is refused; one too long for a defect is so here only, while parameters can be changed.

    One that a growing speed makes too long is shortened instead: a run under way is not broken off for what it costs.
    """
    status = ode_initialize(t, s, p, e)
    if status != DONE:
        return status
    pass_angle, which, order = shortest_pass(s, e)
    speed = fastest(t, 0.0, s, e)
    needed = longest_passing(pass_angle, speed)
    if needed < s.limits[SUBSTEP]:
        s.message[0], s.message[1], s.message[2] = three_digits(needed), speed, order
        return PASSED + which
    return DONE


bearing_initialize.parts = ("ode_initialize",)  # type: ignore[attr-defined]


@kernel
def three_digits(value):
    """A positive number as messages say it."""
    if not 0.0 < value < math.inf:
        return value
    scale = 10.0 ** (2.0 - math.floor(math.log10(value)))
    return math.floor(value * scale + 0.5) / scale


def bearing_kernels(module: str, start: Any) -> Kernels:
    """The kernels of a bearing with its own start; module: its `__name__`."""
    return Kernels(
        bind(bearing_initialize, module, start=start, stable=bearing_stable),
        bind(bearing_step, module, derivatives=bearing_derivatives, outputs=bearing_outputs),
        bearing_outputs,
        bearing_derivatives,
    )


@kernel
def static_position(x, load_x, load_y, s, e):
    """Put x[0], x[1] where the balls carry the load at rest; NOT_CONVERGED where they cannot.

    The potential energy is convex, so Newton's method with steps shortened until they do not overshoot leads to its minimum
    if there is one. There is none where no ball stands on the side to which the load pushes. Across the line of a single
    loaded ball there is no stiffness: a trace of the identity keeps the matrix regular and moves nothing, as nothing pushes.
    """
    k, balls = s.constants, s.balls
    fill_gaps(x, 0.0, k, balls, s.inner_waves, s.outer_waves, e)
    widest, largest = -math.inf, 0.0
    for j in range(balls.shape[1]):
        widest, largest = max(widest, balls[GAP, j]), max(largest, abs(balls[GAP, j]))
    total = math.hypot(load_x, load_y)
    x[0], x[1] = 0.0, 0.0
    if total > 0.0:
        # where a single ball would carry the load, so far out that balls to both sides of it are in contact, too
        apart = math.pi / max(balls.shape[1], 3)
        if e.cage_fault is not None:
            apart += 0.5 * abs(e.cage_fault.offset)
        reach = (widest + (total / k.stiffness) ** (2.0 / 3.0)) / math.cos(apart)
        x[0], x[1] = reach * load_x / total, reach * load_y / total
    fx, fy, kxx, kxy, kyy = elastic_force(x, s)
    for _ in range(200):
        gx, gy = fx - load_x, fy - load_y
        # a deformation is the difference of two lengths and has their rounding
        rounding = 1e-15 * (kxx + kyy) * (abs(x[0]) + abs(x[1]) + largest)
        if math.hypot(gx, gy) <= rounding + 1e-15 * total:
            return DONE
        trace = 1e-12 * (kxx + kyy)
        if trace == 0.0:
            return NOT_CONVERGED
        a, b = kxx + trace, kyy + trace
        det = a * b - kxy * kxy
        step_x, step_y = -(b * gx - kxy * gy) / det, -(a * gy - kxy * gx) / det
        slope = gx * step_x + gy * step_y
        x0, y0 = x[0], x[1]
        share = 1.0
        for _ in range(60):
            x[0], x[1] = x0 + share * step_x, y0 + share * step_y
            fx, fy, kxx, kxy, kyy = elastic_force(x, s)
            if (fx - load_x) * step_x + (fy - load_y) * step_y <= -0.5 * slope:
                break
            share *= 0.5
        if x[0] == x0 and x[1] == y0:
            return DONE
    return NOT_CONVERGED
