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
from typing import Any, NamedTuple

from ..core.contract import Kernels
from ..core.kernels import DONE, NOT_CONVERGED, OWN, bind, inlined_kernel, kernel, kernel_tuple
from ..core.ode import SUBSTEP, finished, ode_initialize, rk4_step
from .geometry import cage_turn, diameter_share, spin_turn
from .races import TWO_PI, add_faults, highest_order, start_waves, wrapped

SPEED, LOAD, TRANSVERSE_LOAD = range(3)
X, Y, VELOCITY_X, VELOCITY_Y, ACCELERATION_X, ACCELERATION_Y, FORCE_X, FORCE_Y, MAX_LOAD, LOADED, INNER, CAGE = range(12)


# Rows of `s.balls`, (8, Z): direction of each ball seen from ball 0, and as workspace its gap and the gap's time derivative;
# then, in the first column, the greatest deformation of a contact since it was set to 0, and w' of the speed input:
# slope + growth * (t - since). One array, as each that is handed on costs as much as a ball.
COSINE, SINE, GAP, RATE, DEEPEST, SLOPE, GROWTH, SINCE = range(8)

CONSTANTS = 7  # elements of `s.constants`, those of `Constants`
TOLD = 3  # elements of `s.told`, numbers of a message

# Statuses; the last are of what a ball must not step over, in this order
LARGE_BALLS, DISPLACED_TOO_FAR, TOO_STIFF = OWN + 1, OWN + 2, OWN + 3
PASSED = OWN + 4
NARROW = ("inner_defect", "outer_defect", "ball_defect", "half a wave of inner_waviness of order {told[2]}",
          "half a wave of outer_waviness of order {told[2]}")


@kernel_tuple
class Constants(NamedTuple):
    """What follows from the parameters."""

    mass: float
    damping: float
    stiffness: float
    cage_ratio: float
    spin_ratio: float
    sharing: float  # how many balls resist one direction at most: the largest sum of their squared cosines
    pass_angle: float  # turn of the inner ring, rad, in which a ball passes a quarter of the narrowest pit or half wave


@kernel
def constants(s):
    """The elements of `s.constants`."""
    c = s.constants
    return Constants(c[0], c[1], c[2], c[3], c[4], c[5], c[6])


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
        # a ball ahead of its place meets what it would meet there were the cage turned further
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
    sum_along, sum_across, largest, loaded, deepest = 0.0, 0.0, 0.0, 0, balls[DEEPEST, 0]
    for j in range(balls.shape[1]):
        delta = along * balls[COSINE, j] + across * balls[SINE, j] - balls[GAP, j]
        if delta > 0.0:
            deepest = max(deepest, delta)
            load = k.stiffness * delta * math.sqrt(delta)
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
    k = constants(s)
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
    k, x, y, u = constants(s), s.x, s.y, s.u[0]
    speed, _ = ring_speed(t, u, e.speed_ramp)
    bearing_x, bearing_y, largest, loaded = ball_loads(x, speed, k, s.balls, s.inner_waves, s.outer_waves, e)
    y[X], y[Y], y[VELOCITY_X], y[VELOCITY_Y] = x[0], x[1], x[2], x[3]
    y[ACCELERATION_X], y[ACCELERATION_Y] = accelerations(t, x, u, bearing_x, bearing_y, k, s.balls, e)
    y[FORCE_X], y[FORCE_Y], y[MAX_LOAD], y[LOADED] = -bearing_x, -bearing_y, largest, loaded
    y[INNER], y[CAGE] = x[4], x[5]
    return DONE


# -- the start -------------------------------------------------------------------------------------------------------
@kernel
def put_constants(s, mass, damping, stiffness, ball_diameter, pitch_diameter, contact_angle):
    """What follows from a bearing's own parameters."""
    gamma = diameter_share(ball_diameter, pitch_diameter, contact_angle)
    s.constants[0], s.constants[1], s.constants[2] = mass, damping, stiffness
    s.constants[3], s.constants[4] = cage_turn(gamma), spin_turn(ball_diameter, pitch_diameter, gamma)


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
            s.told[0] = math.pi / n
            return DISPLACED_TOO_FAR
        at = TWO_PI * (e.cage_fault.ball - 1) / n + e.cage_fault.offset
        balls[COSINE, e.cage_fault.ball - 1], balls[SINE, e.cage_fault.ball - 1] = math.cos(at), math.sin(at)
    s.constants[5] = sharing(balls)
    start_waves(s, e)
    s.constants[6], _, _ = shortest_pass(s, e)
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
    k = constants(s)
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

    With the forces of the start; what comes later, a greater load or resonance, is checked at every step.
    """
    k, gap, speed = constants(s), radial_gap(e.clearance), s.u[0, SPEED]
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
        s.told[0], s.told[1], s.told[2] = three_digits(needed), speed, order
        return PASSED + which
    return DONE


bearing_initialize.parts = ("ode_initialize",)  # type: ignore[attr-defined]


# -- the run ---------------------------------------------------------------------------------------------------------
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


@kernel
def three_digits(value):
    """A positive number as messages say it."""
    if not 0.0 < value < math.inf:
        return value
    scale = 10.0 ** (2.0 - math.floor(math.log10(value)))
    return math.floor(value * scale + 0.5) / scale


def bearing_step(t, h, s, p, e):
    """Equal internal steps of the classic Runge-Kutta method from t to t + h, short enough for what balls pass; the outputs.

    Angles are brought back into [0, 2 pi), so that they keep their digits however long the run. A run whose contacts became
    too stiff for its internal steps ends: it would stay finite, and be wrong.
    """
    k, x, balls = constants(s), s.x, s.balls
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
        s.told[0], s.told[1], s.told[2] = balls[DEEPEST, 0], d, needed
        return TOO_STIFF
    return DONE


bearing_step.parts = ("rk4_step", "finished")  # type: ignore[attr-defined]


def bearing_kernels(module: str, start: Any) -> Kernels:
    """The kernels of a bearing with its own start; module: its `__name__`."""
    return Kernels(bind(bearing_initialize, module, start=start, stable=bearing_stable),
                   bind(bearing_step, module, derivatives=bearing_derivatives, outputs=bearing_outputs),
                   bearing_outputs, bearing_derivatives)


# -- statics ---------------------------------------------------------------------------------------------------------
@kernel
def elastic_force(x, s):
    """(Fx, Fy, kxx, kxy, kyy): sums of the balls' elastic loads for the gaps in s.balls, and their derivatives by x and y."""
    cosine, sine, stiffness, balls = math.cos(x[5]), math.sin(x[5]), constants(s).stiffness, s.balls
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


@kernel
def static_position(x, load_x, load_y, s, e):
    """Put x[0], x[1] where the balls carry the load at rest; NOT_CONVERGED where they cannot.

    The potential energy is convex, so Newton's method with steps shortened until they do not overshoot leads to its minimum
    if there is one. There is none where no ball stands on the side to which the load pushes. Across the line of a single
    loaded ball there is no stiffness: a trace of the identity keeps the matrix regular and moves nothing, as nothing pushes.
    """
    k, balls = constants(s), s.balls
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
