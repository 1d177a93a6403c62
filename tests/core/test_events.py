"""Runge-Kutta with events: a bouncing ball and dry friction against their closed forms, order, several events in a substep."""

import math
from collections import namedtuple

import numpy as np
import pytest
from cosimo.components.core.events import ROWS, rk4_events
from cosimo.components.core.kernels import DONE, NOT_CONVERGED, bind, kernel
from cosimo.tests.slopes import slope

pytestmark = pytest.mark.interpreted
STICK = 0.0
Memory = namedtuple("Memory", "u y x counts limits work guards")


@kernel
def ball_derivatives(t, x, u, dx, s, p, e):
    """x: height, velocity, bounces; p: gravity, restitution."""
    dx[0], dx[1], dx[2] = x[1], -p[0], 0.0


@kernel
def ball_guards(t, x, u, g, s, p, e):
    """The height."""
    g[0] = x[0]


@kernel
def ball_switch(which, t, x, u, s, p, e):
    """The velocity turns."""
    x[0] = 0.0
    x[1] = -p[1] * x[1]
    x[2] += 1.0


@kernel
def puller_derivatives(t, x, u, dx, s, p, e):
    """A block on a spring whose end is pulled; x: displacement, velocity, direction of slip; p: mass, spring, speed, F_s, F_c."""
    force = p[1] * (p[2] * t - x[0])
    dx[0], dx[2] = x[1], 0.0
    dx[1] = 0.0 if x[2] == STICK else (force - x[2] * p[4]) / p[0]


@kernel
def puller_guards(t, x, u, g, s, p, e):
    """What is left of the static friction, or the velocity in the direction of slip."""
    g[0] = p[3] - abs(p[1] * (p[2] * t - x[0])) if x[2] == STICK else x[2] * x[1]


@kernel
def puller_switch(which, t, x, u, s, p, e):
    """Breaks loose, or comes to rest and stays where the spring is weaker than the static friction."""
    force = p[1] * (p[2] * t - x[0])
    x[1] = 0.0
    if x[2] == STICK or abs(force) > p[3]:
        x[2] = 1.0 if force > 0.0 else -1.0
    else:
        x[2] = STICK


@kernel
def state_outputs(t, s, p, e):
    """The state."""
    s.y[:] = s.x
    return DONE


@kernel
def restless_switch(which, t, x, u, s, p, e):
    """Changes nothing: the guard stays below zero."""


@kernel
def watched_guards(t, x, u, g, s, p, e):
    """The height, and one that rests at zero."""
    g[0], g[1] = 0.0, x[0]


@kernel
def watched_switch(which, t, x, u, s, p, e):
    """The velocity turns; nothing else ever ends."""
    if which == 1:
        ball_switch(which, t, x, u, s, p, e)


ball = bind(
    rk4_events, f"{__name__}_ball", derivatives=ball_derivatives, guards=ball_guards, switch=ball_switch, outputs=state_outputs
)
puller = bind(
    rk4_events,
    f"{__name__}_puller",
    derivatives=puller_derivatives,
    guards=puller_guards,
    switch=puller_switch,
    outputs=state_outputs,
)
watched = bind(
    rk4_events,
    f"{__name__}_watched",
    derivatives=ball_derivatives,
    guards=watched_guards,
    switch=watched_switch,
    outputs=state_outputs,
)
restless = bind(
    rk4_events,
    f"{__name__}_restless",
    derivatives=ball_derivatives,
    guards=ball_guards,
    switch=restless_switch,
    outputs=state_outputs,
)


def run(advance, x, h, n, p, guards=1):
    """State after n substeps over h, the counters and the status."""
    s = Memory(
        np.zeros((3, 0)),
        np.zeros(3),
        np.array(x, dtype=float),
        np.zeros(3, dtype=np.int64),
        np.array([h / n, math.inf]),
        np.zeros((ROWS, 3)),
        np.zeros(guards),
    )
    status = advance(0.0, h, s, p, None)
    return s.x, s.counts, status


def bounced(t: float, gravity: float, restitution: float, height: float) -> tuple[float, float, int]:
    """Height, velocity and bounces of a ball that falls from rest: parabolas between impacts."""
    speed = math.sqrt(2.0 * gravity * height)
    t -= speed / gravity
    if t < 0.0:
        return height - 0.5 * gravity * (t + speed / gravity) ** 2, -gravity * (t + speed / gravity), 0
    bounces = 1
    while True:
        speed *= restitution
        if t < 2.0 * speed / gravity:
            return speed * t - 0.5 * gravity * t * t, speed - gravity * t, bounces
        t -= 2.0 * speed / gravity
        bounces += 1


@pytest.mark.parametrize("n", [1, 3, 50])
def test_a_ball_bounces_as_parabolas_do(n):
    """RK4 is exact on parabolas: what is left is the rounding of the instants, however many impacts a substep holds."""
    x, counts, status = run(ball, (1.0, 0.0, 0.0), 2.5, n, (9.81, 0.8))
    height, velocity, bounces = bounced(2.5, 9.81, 0.8, 1.0)
    assert status == DONE
    assert counts[2] == bounces == x[2]
    assert x[0] == pytest.approx(height, abs=1e-12)
    assert x[1] == pytest.approx(velocity, abs=1e-12)


@pytest.mark.parametrize("n", [1, 3, 50])
def test_a_guard_that_rests_at_zero_hides_no_other(n):
    x, counts, status = run(watched, (1.0, 0.0, 0.0), 2.5, n, (9.81, 0.8), guards=2)
    height, velocity, bounces = bounced(2.5, 9.81, 0.8, 1.0)
    assert status == DONE
    assert counts[2] == bounces == x[2]
    assert x[0] == pytest.approx(height, abs=1e-12)
    assert x[1] == pytest.approx(velocity, abs=1e-12)


def test_dry_friction_sticks_and_slips_with_the_period_of_the_closed_form():
    """First slip at F_s / (k v); then slip of (2 pi - 2 atan(w dF / (k v))) / w and stick of 2 dF / (k v), dF = F_s - F_c."""
    mass, spring, speed, static, kinetic = 1.0, 2.0, 0.1, 1.5, 1.0
    w = math.sqrt(spring / mass)
    slip = (2.0 * math.pi - 2.0 * math.atan(w * (static - kinetic) / (spring * speed))) / w
    stick = 2.0 * (static - kinetic) / (spring * speed)
    assert (slip, stick) == pytest.approx((2.61126, 5.0), abs=5e-6)  # the printed numbers
    p = (mass, spring, speed, static, kinetic)
    first = static / (spring * speed)
    before, counts, _ = run(puller, (0.0, 0.0, STICK), first - 1e-9, 100, p)
    assert before.tolist() == [0.0, 0.0, STICK]  # not a bit of creep
    assert counts[2] == 0
    for periods in (1, 4):
        end = first + periods * slip + (periods - 0.5) * stick
        x, counts, status = run(puller, (0.0, 0.0, STICK), end, math.ceil(end / 0.01), p)
        assert status == DONE
        assert counts[2] == 2 * periods
        assert x[1:].tolist() == [0.0, STICK]
        assert x[0] == pytest.approx(periods * speed * (slip + stick), abs=1e-8)  # RK4 at w d = 0.014


def test_events_do_not_lower_the_order():
    """Position between two events, in the second slip: slope of the error over the substep."""
    p, end = (1.0, 2.0, 0.1, 1.5, 1.0), 16.0
    w, k = math.sqrt(2.0), 2.0 * 0.1
    slip = (2.0 * math.pi - 2.0 * math.atan(w * 0.5 / k)) / w
    since = end - (7.5 + slip + 5.0)  # of the second slip
    start = 0.1 * (slip + 5.0)
    exact = start + 0.1 * since + 0.25 * (1.0 - math.cos(w * since)) - 0.1 / w * math.sin(w * since)
    assert 0.0 < since < slip
    steps = np.unique(np.geomspace(320, 2560, 12).astype(int))  # below, two terms of the error cancel
    errors = [abs(run(puller, (0.0, 0.0, STICK), end, n, p)[0][0] - exact) for n in steps]
    assert slope(1.0 / steps, errors) == pytest.approx(4.0, abs=0.1)


def test_modes_that_chase_each_other_are_an_error():
    assert run(restless, (1.0, 0.0, 0.0), 2.0, 10, (9.81, 0.8))[2] == NOT_CONVERGED
