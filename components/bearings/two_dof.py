"""Kernels of the ball bearing with two degrees of freedom; `BallBearing` and its dimensionless form differ in numbers only.

State: x, y, x', y', angle of the inner ring, angle of the cage (of ball 0), and with a pit on a ball its spin.

    m x'' + c x' + sum of Q_j cos theta_j = W + m e (w² cos a + w' sin a)
    m y'' + c y' + sum of Q_j sin theta_j = W_y + m e (w² sin a - w' cos a)
    Q_j = K delta_j^1.5 (1 + 1.5 k delta_j') >= 0,   delta_j = x cos theta_j + y sin theta_j - gap_j, 0 if negative

a = inner ring's angle, theta_j = cage angle + 2 pi j / Z; w = a', cage angle' = cage_ratio w. Balls without mass roll without
slip, at equal distances but for one that a broken cage lets run ahead; the outer ring is fixed. w' is that of the ramp and,
during a step, of the speed input; at the end of a step the input's slope is used up, so that the acceleration given out there
is that of an input at rest. In the frame of the cage every ball has a fixed direction: position and velocity are turned there
once, so that a call costs one sine and cosine however many balls there are, and no power.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..core.integrators import rk4
from ..core.kernels import DONE, NOT_CONVERGED, bind, kernel, kernel_tuple
from .geometry import BallGeometry
from .races import TWO_PI, add_faults, wrapped

SPEED, LOAD, TRANSVERSE_LOAD = range(3)
X, Y, VELOCITY_X, VELOCITY_Y, ACCELERATION_X, ACCELERATION_Y, FORCE_X, FORCE_Y, MAX_LOAD, LOADED, INNER, CAGE = range(12)


# Rows of Constants.balls: direction of each ball seen from ball 0, and as workspace its gap and the gap's time derivative;
# then, in the first column, the greatest deformation of a contact since it was set to 0, and w' of the speed input:
# slope + growth * (t - since).
COSINE, SINE, GAP, RATE, DEEPEST, SLOPE, GROWTH, SINCE = range(8)


@kernel_tuple
class Constants(NamedTuple):
    """What the kernels need of the parameters, and their workspace."""

    mass: float
    damping: float
    stiffness: float
    cage_ratio: float
    spin_ratio: float
    balls: np.ndarray  # (8, Z): rows above; one array, as each that is handed on costs as much as a ball


@kernel_tuple
class Clearance(NamedTuple):
    """Radial gap between ball and races with the rings concentric; negative: preload."""

    gap: float


@kernel_tuple
class HuntCrossley(NamedTuple):
    """k of Q = K delta^1.5 (1 + 1.5 k delta')."""

    coefficient: float


@kernel_tuple
class Imbalance(NamedTuple):
    """Mass times eccentricity, and its angle on the inner ring."""

    moment: float
    phase: float


@kernel_tuple
class Harmonic(NamedTuple):
    """amplitude * sin(frequency * t + phase), frequency in rad per unit of time."""

    amplitude: float
    frequency: float
    phase: float


@kernel_tuple
class Ramp(NamedTuple):
    """Speed added: acceleration * time, up to the duration."""

    acceleration: float
    duration: float


def constants(mass: float, damping: float, stiffness: float, geometry: BallGeometry) -> Constants:
    """Constants of a bearing; workspace included."""
    at = TWO_PI * np.arange(geometry.balls) / geometry.balls
    balls = np.zeros((SINCE + 1, geometry.balls))
    balls[COSINE], balls[SINE] = np.cos(at), np.sin(at)
    return Constants(mass, damping, stiffness, geometry.cage_ratio, geometry.spin_ratio, balls)


@kernel
def ring_speed(t, u, ramp):
    """(w, w') of the inner ring for the speed u[SPEED] and its ramp; the slope of that input is not in w'."""
    if ramp is not None:
        if 0.0 <= t < ramp.duration:
            return u[SPEED] + ramp.acceleration * t, ramp.acceleration
        return u[SPEED] + ramp.acceleration * min(max(t, 0.0), ramp.duration), 0.0
    return u[SPEED], 0.0


@kernel
def fill_gaps_in_place(x, speed, p, e):
    """The same with every ball in its place."""
    radial = 0.0
    if e.clearance is not None:
        radial = e.clearance.gap
    for j in range(p.balls.shape[1]):
        p.balls[GAP, j] = radial
    if e.contact_damping is not None:
        for j in range(p.balls.shape[1]):
            p.balls[RATE, j] = 0.0
        add_faults(p.balls[GAP], p.balls[RATE], x[4:], speed, p, e)
    else:
        add_faults(p.balls[GAP], None, x[4:], speed, p, e)


@kernel
def fill_gaps(x, speed, p, e):
    """The gaps of all balls and, with contact damping, their rates, in p.balls."""
    if e.cage_fault is not None:
        # a ball ahead of its place meets what it would meet there were the cage turned further
        k, place = e.cage_fault.ball, x[5]
        x[5] = place + e.cage_fault.offset
        fill_gaps_in_place(x, speed, p, e)
        gap, rate = p.balls[GAP, k], p.balls[RATE, k]
        x[5] = place
        fill_gaps_in_place(x, speed, p, e)
        p.balls[GAP, k], p.balls[RATE, k] = gap, rate
    else:
        fill_gaps_in_place(x, speed, p, e)


@kernel
def ball_loads(x, speed, p, e):
    """(sum of Q cos theta, sum of Q sin theta, largest Q, number of loaded balls)."""
    fill_gaps(x, speed, p, e)
    balls = p.balls
    c, s = math.cos(x[5]), math.sin(x[5])
    along, across = c * x[0] + s * x[1], c * x[1] - s * x[0]  # position in the frame of the cage
    v_along, v_across = 0.0, 0.0
    if e.contact_damping is not None:
        turn = p.cage_ratio * speed
        v_along, v_across = c * x[2] + s * x[3] + turn * across, c * x[3] - s * x[2] - turn * along
    sum_along, sum_across, largest, loaded, deepest = 0.0, 0.0, 0.0, 0, balls[DEEPEST, 0]
    for j in range(balls.shape[1]):
        delta = along * balls[COSINE, j] + across * balls[SINE, j] - balls[GAP, j]
        if delta > 0.0:
            deepest = max(deepest, delta)
            load = p.stiffness * delta * math.sqrt(delta)
            if e.contact_damping is not None:
                approach = v_along * balls[COSINE, j] + v_across * balls[SINE, j] - balls[RATE, j]
                load = max(load * (1.0 + 1.5 * e.contact_damping.coefficient * approach), 0.0)  # a contact cannot pull
            sum_along += load * balls[COSINE, j]
            sum_across += load * balls[SINE, j]
            largest = max(largest, load)
            loaded += 1
    balls[DEEPEST, 0] = deepest
    return c * sum_along - s * sum_across, s * sum_along + c * sum_across, largest, loaded


@kernel
def accelerations(t, x, u, bearing_x, bearing_y, p, unbalance, variation, ramp):
    """(x'', y'') for the ball loads' sums; x, u as for the derivatives."""
    load = u[LOAD]
    if variation is not None:
        load += variation.amplitude * math.sin(variation.frequency * t + variation.phase)
    force_x, force_y = load - p.damping * x[2] - bearing_x, u[TRANSVERSE_LOAD] - p.damping * x[3] - bearing_y
    if unbalance is not None:
        w, dw = ring_speed(t, u, ramp)
        dw += p.balls[SLOPE, 0] + p.balls[GROWTH, 0] * (t - p.balls[SINCE, 0])
        c, s = math.cos(x[4] + unbalance.phase), math.sin(x[4] + unbalance.phase)
        force_x += unbalance.moment * (w * w * c + dw * s)
        force_y += unbalance.moment * (w * w * s - dw * c)
    return force_x / p.mass, force_y / p.mass


@kernel
def bearing_derivatives(t, x, u, dx, p, e):
    """dx/dt of x = (x, y, x', y', inner angle, cage angle[, spin])."""
    speed, _ = ring_speed(t, u, e.speed_ramp)
    bearing_x, bearing_y, _, _ = ball_loads(x, speed, p, e)
    dx[0], dx[1] = x[2], x[3]
    dx[2], dx[3] = accelerations(t, x, u, bearing_x, bearing_y, p, e.unbalance, e.load_variation, e.speed_ramp)
    dx[4], dx[5] = speed, p.cage_ratio * speed
    if e.ball_defect is not None:
        dx[6] = p.spin_ratio * speed


@kernel
def bearing_outputs(t, x, u, y, p, e):
    """Motion, forces on the shaft, angles."""
    speed, _ = ring_speed(t, u, e.speed_ramp)
    bearing_x, bearing_y, largest, loaded = ball_loads(x, speed, p, e)
    y[X], y[Y], y[VELOCITY_X], y[VELOCITY_Y] = x[0], x[1], x[2], x[3]
    y[ACCELERATION_X], y[ACCELERATION_Y] = accelerations(t, x, u, bearing_x, bearing_y, p, e.unbalance, e.load_variation,
                                                         e.speed_ramp)
    y[FORCE_X], y[FORCE_Y], y[MAX_LOAD], y[LOADED] = -bearing_x, -bearing_y, largest, loaded
    y[INNER], y[CAGE] = x[4], x[5]


@kernel
def end_of_step(t, x, u, y, p, e):
    """Angles back into [0, 2 pi), so that they keep their digits however long the run; inputs held; then the outputs."""
    for i in range(4, x.size):
        x[i] = wrapped(x[i])
    p.balls[SLOPE, 0] = 0.0
    p.balls[GROWTH, 0] = 0.0
    bearing_outputs(t, x, u, y, p, e)


advance = bind(rk4, __name__, derivatives=bearing_derivatives, outputs=end_of_step)


@kernel
def elastic_force(x, p):
    """(Fx, Fy, kxx, kxy, kyy): sums of the balls' elastic loads for the gaps in p.balls, and their derivatives by x and y."""
    c, s = math.cos(x[5]), math.sin(x[5])
    fx, fy, kxx, kxy, kyy = 0.0, 0.0, 0.0, 0.0, 0.0
    for j in range(p.balls.shape[1]):
        nx, ny = c * p.balls[COSINE, j] - s * p.balls[SINE, j], s * p.balls[COSINE, j] + c * p.balls[SINE, j]
        delta = x[0] * nx + x[1] * ny - p.balls[GAP, j]
        if delta > 0.0:
            root = p.stiffness * math.sqrt(delta)
            fx += root * delta * nx
            fy += root * delta * ny
            kxx += 1.5 * root * nx * nx
            kxy += 1.5 * root * nx * ny
            kyy += 1.5 * root * ny * ny
    return fx, fy, kxx, kxy, kyy


@kernel
def static_position(x, load_x, load_y, p, e):
    """Put x[0], x[1] where the balls carry the load at rest; NOT_CONVERGED where they cannot.

    The potential energy is convex, so Newton's method with steps shortened until they do not overshoot leads to its minimum
    if there is one. There is none where no ball stands on the side to which the load pushes. Across the line of a single
    loaded ball there is no stiffness: a trace of the identity keeps the matrix regular and moves nothing, as nothing pushes.
    """
    fill_gaps(x, 0.0, p, e)
    total = math.hypot(load_x, load_y)
    x[0], x[1] = 0.0, 0.0
    if total > 0.0:
        # where a single ball would carry the load, so far out that balls to both sides of it are in contact, too
        apart = math.pi / max(p.balls.shape[1], 3)
        if e.cage_fault is not None:
            apart += 0.5 * abs(e.cage_fault.offset)
        reach = (p.balls[GAP].max() + (total / p.stiffness) ** (2.0 / 3.0)) / math.cos(apart)
        x[0], x[1] = reach * load_x / total, reach * load_y / total
    fx, fy, kxx, kxy, kyy = elastic_force(x, p)
    for _ in range(200):
        gx, gy = fx - load_x, fy - load_y
        # a deformation is the difference of two lengths and has their rounding
        rounding = 1e-15 * (kxx + kyy) * (abs(x[0]) + abs(x[1]) + np.abs(p.balls[GAP]).max())
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
            fx, fy, kxx, kxy, kyy = elastic_force(x, p)
            if (fx - load_x) * step_x + (fy - load_y) * step_y <= -0.5 * slope:
                break
            share *= 0.5
        if x[0] == x0 and x[1] == y0:
            return DONE
    return NOT_CONVERGED
