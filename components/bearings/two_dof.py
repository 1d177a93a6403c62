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

from ..core.integrators import SUBSTEP, finished, rk4_step
from ..core.kernels import DONE, OWN, inlined_kernel, kernel
from .races import TWO_PI, add_faults, wrapped

SPEED, LOAD, TRANSVERSE_LOAD = range(3)
X, Y, VELOCITY_X, VELOCITY_Y, ACCELERATION_X, ACCELERATION_Y, FORCE_X, FORCE_Y, MAX_LOAD, LOADED, INNER, CAGE = range(12)


# Rows of `s.balls`, (8, Z): direction of each ball seen from ball 0, and as workspace its gap and the gap's time derivative;
# then, in the first column, the greatest deformation of a contact since it was set to 0, and w' of the speed input:
# slope + growth * (t - since). One array, as each that is handed on costs as much as a ball.
COSINE, SINE, GAP, RATE, DEEPEST, SLOPE, GROWTH, SINCE = range(8)

MESSAGE = 3  # elements of `s.message`, numbers of a message

# Statuses; the last are of what a ball must not step over, in this order
LARGE_BALLS, DISPLACED_TOO_FAR, TOO_STIFF = OWN + 1, OWN + 2, OWN + 3
PASSED = OWN + 4
NARROW = (
    "inner_defect",
    "outer_defect",
    "ball_defect",
    "half a wave of inner_waviness of order {message[2]}",
    "half a wave of outer_waviness of order {message[2]}",
)


class Constants:
    """The record `s.constants`: what the parameters determine."""

    mass: float
    damping: float
    stiffness: float
    cage_ratio: float
    spin_ratio: float
    sharing: float  # how many balls resist one direction at most: the largest sum of their squared cosines
    pass_angle: float  # turn of the inner ring, rad, in which a ball passes a quarter of the narrowest pit or half wave


@kernel
def ring_speed(t, u, ramp):
    """(w, w') of the inner ring for the speed u[SPEED] and its ramp; the slope of that input is not in w'."""
    if ramp is not None:
        if 0.0 <= t < ramp.duration:
            return u[SPEED] + ramp.acceleration * t, ramp.acceleration
        return u[SPEED] + ramp.acceleration * min(max(t, 0.0), ramp.duration), 0.0
    return u[SPEED], 0.0


@kernel
def radial_gap(clearance):
    """Radial gap between ball and races with the rings concentric; negative: preload."""
    if clearance is not None:
        return clearance.radial_clearance
    return 0.0


@kernel
def fill_gaps_in_place(x, speed, k, balls, inner_waves, outer_waves, e):
    """The same with every ball in its place."""
    radial = radial_gap(e.clearance)
    for j in range(balls.shape[1]):
        balls[GAP, j] = radial
    if e.contact_damping is not None:
        for j in range(balls.shape[1]):
            balls[RATE, j] = 0.0
        add_faults(balls[GAP], balls[RATE], x[4:], speed, k, inner_waves, outer_waves, e)
    else:
        add_faults(balls[GAP], None, x[4:], speed, k, inner_waves, outer_waves, e)


@inlined_kernel
def fill_gaps(x, speed, k, balls, inner_waves, outer_waves, e):
    """The gaps of all balls and, with contact damping, their rates, in `balls`; k: `Constants`.

    inner_waves, outer_waves: see `races`.
    """
    if e.cage_fault is not None:
        # a ball ahead of its place meets a pit as if the cage had turned further
        ball, place = e.cage_fault.ball - 1, x[5]
        x[5] = place + e.cage_fault.offset
        fill_gaps_in_place(x, speed, k, balls, inner_waves, outer_waves, e)
        gap, rate = balls[GAP, ball], balls[RATE, ball]
        x[5] = place
        fill_gaps_in_place(x, speed, k, balls, inner_waves, outer_waves, e)
        balls[GAP, ball], balls[RATE, ball] = gap, rate
    else:
        fill_gaps_in_place(x, speed, k, balls, inner_waves, outer_waves, e)


@inlined_kernel
def ball_loads(x, speed, k, balls, inner_waves, outer_waves, e):
    """(sum of Q cos theta, sum of Q sin theta, largest Q, number of loaded balls); as `fill_gaps`."""
    fill_gaps(x, speed, k, balls, inner_waves, outer_waves, e)
    cosine, sine = math.cos(x[5]), math.sin(x[5])
    along, across = cosine * x[0] + sine * x[1], cosine * x[1] - sine * x[0]  # position in the frame of the cage
    v_along, v_across = 0.0, 0.0
    if e.contact_damping is not None:
        turn = k.cage_ratio * speed
        v_along, v_across = cosine * x[2] + sine * x[3] + turn * across, cosine * x[3] - sine * x[2] - turn * along
    stiffness = k.stiffness  # not read anew behind each write to the balls
    sum_along, sum_across, largest, loaded, deepest = 0.0, 0.0, 0.0, 0, balls[DEEPEST, 0]
    for j in range(balls.shape[1]):
        delta = along * balls[COSINE, j] + across * balls[SINE, j] - balls[GAP, j]
        if delta > 0.0:
            deepest = max(deepest, delta)
            load = stiffness * delta * math.sqrt(delta)
            if e.contact_damping is not None:
                approach = v_along * balls[COSINE, j] + v_across * balls[SINE, j] - balls[RATE, j]
                load = max(load * (1.0 + 1.5 * e.contact_damping.coefficient * approach), 0.0)  # a contact cannot pull
            sum_along += load * balls[COSINE, j]
            sum_across += load * balls[SINE, j]
            largest = max(largest, load)
            loaded += 1
    balls[DEEPEST, 0] = deepest
    return cosine * sum_along - sine * sum_across, sine * sum_along + cosine * sum_across, largest, loaded


@inlined_kernel
def accelerations(t, x, u, bearing_x, bearing_y, k, balls, e):
    """(x'', y'') for the ball loads' sums; x, u as for the derivatives, k: `Constants`."""
    load = u[LOAD]
    if e.load_variation is not None:
        load += e.load_variation.amplitude * math.sin(TWO_PI * e.load_variation.frequency * t + e.load_variation.phase)
    force_x, force_y = load - k.damping * x[2] - bearing_x, u[TRANSVERSE_LOAD] - k.damping * x[3] - bearing_y
    if e.unbalance is not None:
        moment = k.mass * e.unbalance.eccentricity
        w, dw = ring_speed(t, u, e.speed_ramp)
        dw += balls[SLOPE, 0] + balls[GROWTH, 0] * (t - balls[SINCE, 0])
        cosine, sine = math.cos(x[4] + e.unbalance.phase), math.sin(x[4] + e.unbalance.phase)
        force_x += moment * (w * w * cosine + dw * sine)
        force_y += moment * (w * w * sine - dw * cosine)
    return force_x / k.mass, force_y / k.mass


@inlined_kernel
def bearing_derivatives(t, x, u, dx, s, p, e):
    """dx/dt of x = (x, y, x', y', inner angle, cage angle[, spin])."""
    k = s.constants
    speed, _ = ring_speed(t, u, e.speed_ramp)
    bearing_x, bearing_y, _, _ = ball_loads(x, speed, k, s.balls, s.inner_waves, s.outer_waves, e)
    dx[0], dx[1] = x[2], x[3]
    dx[2], dx[3] = accelerations(t, x, u, bearing_x, bearing_y, k, s.balls, e)
    dx[4], dx[5] = speed, k.cage_ratio * speed
    if e.ball_defect is not None:
        dx[6] = k.spin_ratio * speed


@kernel
def bearing_outputs(t, s, p, e):
    """Motion, forces on the shaft, angles."""
    k, x, y, u = s.constants, s.x, s.y, s.u[0]
    speed, _ = ring_speed(t, u, e.speed_ramp)
    bearing_x, bearing_y, largest, loaded = ball_loads(x, speed, k, s.balls, s.inner_waves, s.outer_waves, e)
    y[X], y[Y], y[VELOCITY_X], y[VELOCITY_Y] = x[0], x[1], x[2], x[3]
    y[ACCELERATION_X], y[ACCELERATION_Y] = accelerations(t, x, u, bearing_x, bearing_y, k, s.balls, e)
    y[FORCE_X], y[FORCE_Y], y[MAX_LOAD], y[LOADED] = -bearing_x, -bearing_y, largest, loaded
    y[INNER], y[CAGE] = x[4], x[5]
    return DONE


@kernel
def resolved_step(k, contact_damping, deepest):
    """1 / |eigenvalue| at a penetration, an eighth of the duration of an impact on one of eight balls.

    RK4 is stable up to 2.78 / |eigenvalue|, but loses energy where contacts open and close: in 260 impacts without any
    damping 95 % at 2.2 / |eigenvalue|, 44 % at 1.1, 2 % at 0.56 and a permille at 0.27 were measured.
    """
    damper = k.damping
    if contact_damping is not None:
        damper += 1.5 * contact_damping.coefficient * k.stiffness * deepest**1.5 * k.sharing
    rate = math.sqrt(1.5 * k.stiffness * math.sqrt(deepest) * k.sharing / k.mass) + damper / k.mass
    return 1.0 / rate if rate > 0.0 else math.inf


@kernel
def top_speed(t, h, u, ramp_acceleration, ramp_duration):
    """Largest speed within a step: input and ramp together are one parabola before the ramp's end and one after it."""
    speed, slope, half = u[0, SPEED], u[1, SPEED], u[2, SPEED]
    first, second = 0.0, 0.0
    if half != 0.0:
        first, second = -0.5 * slope / half, -0.5 * (slope + ramp_acceleration) / half
    top = 0.0
    for since in (0.0, h, ramp_duration - t, first, second):
        if 0.0 <= since <= h:
            ramped = ramp_acceleration * min(max(t + since, 0.0), ramp_duration)
            top = max(top, abs(speed + since * (slope + since * half) + ramped))
    return top


@kernel
def fastest(t, h, s, e):
    """Largest speed within a step."""
    if e.speed_ramp is not None:
        return top_speed(t, h, s.u, e.speed_ramp.acceleration, e.speed_ramp.duration)
    return top_speed(t, h, s.u, 0.0, 0.0)


@kernel
def longest_passing(pass_angle, speed):
    """Longest internal step at a speed that does not step over a defect or a wave."""
    return pass_angle / max(speed, 1e-300) if pass_angle < math.inf else math.inf


def bearing_step(t, h, s, p, e):
    """Equal internal steps of the classic Runge-Kutta method from t to t + h, short enough for what balls pass; the outputs.

    Angles are brought back into [0, 2 pi), so that they keep their digits however long the run. A run whose contacts became
    too stiff for its internal steps ends: it would stay finite, and be wrong.
    """
    k, x, balls = s.constants, s.x, s.balls
    substep = s.limits[SUBSTEP]
    if k.pass_angle < math.inf:
        substep = min(substep, longest_passing(k.pass_angle, fastest(t, h, s, e)))  # where the speed has grown since the start
    n = max(1, math.ceil(h / substep * (1.0 - 1e-9)))
    d = h / n
    balls[DEEPEST, 0] = 0.0
    if e.unbalance is not None:  # only an unbalance feels the speed's derivative
        balls[SLOPE, 0], balls[GROWTH, 0], balls[SINCE, 0] = s.u[1, SPEED], 2.0 * s.u[2, SPEED], t
    for i in range(n):
        rk4_step(t, i * d, d, x, x, s, p, e)
    s.counts[0] += n
    s.counts[1] += 4 * n
    for i in range(4, x.size):
        x[i] = wrapped(x[i])
    balls[SLOPE, 0], balls[GROWTH, 0] = 0.0, 0.0
    status = finished(t, h, s, p, e)
    if status != DONE:
        return status
    needed = resolved_step(k, e.contact_damping, balls[DEEPEST, 0])
    if needed < d * (1.0 - 1e-9):
        s.message[0], s.message[1], s.message[2] = balls[DEEPEST, 0], d, needed
        return TOO_STIFF
    return DONE


bearing_step.parts = ("rk4_step", "finished")  # type: ignore[attr-defined]


@kernel
def elastic_force(x, s):
    """(Fx, Fy, kxx, kxy, kyy): sums of the balls' elastic loads for the gaps in s.balls, and their derivatives by x and y."""
    cosine, sine, stiffness, balls = math.cos(x[5]), math.sin(x[5]), s.constants.stiffness, s.balls
    fx, fy, kxx, kxy, kyy = 0.0, 0.0, 0.0, 0.0, 0.0
    for j in range(balls.shape[1]):
        nx, ny = cosine * balls[COSINE, j] - sine * balls[SINE, j], sine * balls[COSINE, j] + cosine * balls[SINE, j]
        delta = x[0] * nx + x[1] * ny - balls[GAP, j]
        if delta > 0.0:
            root = stiffness * math.sqrt(delta)
            fx += root * delta * nx
            fy += root * delta * ny
            kxx += 1.5 * root * nx * nx
            kxy += 1.5 * root * nx * ny
            kyy += 1.5 * root * ny * ny
    return fx, fy, kxx, kxy, kyy
