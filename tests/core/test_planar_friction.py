"""Friction in the plane of contact: laws at constant slip, against the scalar ones, and a block that is pulled at an angle."""

import math
from itertools import pairwise

import numpy as np
import pytest
from cosimo.components.core.events import EventComponent, event_kernels
from cosimo.components.core.friction import (
    SLIDES,
    lugre_level,
    lugre_rate,
    planar_lugre_rate,
    planar_stick_deflection,
    planar_stick_guard,
    planar_stick_rate,
    planar_stick_switch,
    smoothed_planar,
)
from cosimo.components.core.kernels import DONE, kernel
from cosimo.components.core.variables import output, parameter
from scipy.integrate import solve_ivp

STIFFNESS, DAMPING, VISCOUS, KINETIC, STATIC, STRIBECK = 1e5, math.sqrt(1e5), 0.4, 1.0, 1.5, 1e-3  # of the LuGre paper of 1995
MASS, SPRING, PULL = 1.0, 2.0, 0.1  # of its block, kg, N/m, m/s
COSINE, SINE = 0.6, -0.8  # the direction in which the block is pulled here


def turned(vector, angle: float) -> np.ndarray:
    """A vector of the plane turned by an angle."""
    c, s = math.cos(angle), math.sin(angle)
    return np.array([c * vector[0] - s * vector[1], s * vector[0] + c * vector[1]])


def bristles_rate(s, z, fastest: float) -> tuple[float, float]:
    """Rate of the bristles' deflection, of the paper's law."""
    level = lugre_level(math.hypot(*s), KINETIC, STATIC, STRIBECK)
    return planar_lugre_rate(*s, *z, STIFFNESS, level, fastest)


# -- the laws -----------------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("slip", [0.0, 1e-300, 1e-6, 0.01, 1.0, 1e9])
def test_smoothed_friction_is_viscous_at_small_slip_and_ends_at_its_level(slip):
    fx, fy = smoothed_planar(COSINE * slip, SINE * slip, 6.0, 600.0)
    assert math.hypot(fx, fy) == pytest.approx(6.0 * math.tanh(100.0 * slip), rel=1e-14)
    assert fx * SINE == pytest.approx(fy * COSINE, rel=1e-14)
    assert fx * slip >= 0.0


def test_without_a_level_nothing_rubs():
    assert smoothed_planar(1.0, 2.0, 0.0, 600.0) == (0.0, 0.0)


@pytest.mark.parametrize("v", [-0.3, -1e-4, 0.0, 2e-3, 0.1])
@pytest.mark.parametrize("fastest", [1e3, math.inf])
def test_along_a_line_the_bristles_are_the_scalar_ones(v, fastest):
    rate = lugre_rate(v, 3e-6, STIFFNESS, KINETIC, STATIC, STRIBECK, fastest)
    assert bristles_rate((v, 0.0), (3e-6, 0.0), fastest) == pytest.approx((rate, 0.0), rel=1e-14)
    rx, ry = bristles_rate((v * COSINE, v * SINE), (3e-6 * COSINE, 3e-6 * SINE), fastest)
    assert (rx, ry) == pytest.approx((rate * COSINE, rate * SINE), rel=1e-12)


@pytest.mark.parametrize("speed", [1e-4, 1e-3, 0.1])
def test_bristles_settle_in_the_direction_of_the_slip(speed):
    """At constant slip: z = level(|s|) / stiffness in its direction, whatever it was before."""
    done = solve_ivp(
        lambda t, z: bristles_rate((speed * COSINE, speed * SINE), z, 1e9),
        (0.0, 100.0 * STATIC / STIFFNESS / speed),
        [-8e-6, 1e-6],
        method="Radau",
        rtol=1e-10,
        atol=1e-14,
    )
    settled = lugre_level(speed, KINETIC, STATIC, STRIBECK) / STIFFNESS
    assert done.y[:, -1] == pytest.approx([settled * COSINE, settled * SINE], rel=1e-8)


@pytest.mark.parametrize("angle", [0.3, 2.0, -1.1])
def test_no_direction_is_another(angle):
    s, z = np.array([0.03, -0.01]), np.array([2e-5, 4e-5])
    laws = [
        lambda s, z: smoothed_planar(*s, 6.0, 600.0),
        lambda s, z: bristles_rate(s, z, 1e4),
        lambda s, z: planar_stick_rate(0.0, *s, *z, 1e4),
        lambda s, z: planar_stick_rate(SLIDES, *s, *z, 1e4),
        lambda s, z: planar_stick_deflection(SLIDES, *z, 1e-4),
    ]
    for law in laws:
        assert np.array(law(turned(s, angle), turned(z, angle))) == pytest.approx(turned(law(s, z), angle), rel=1e-12)


def test_at_rest_the_deflection_takes_the_slip_and_while_sliding_only_turns():
    assert planar_stick_rate(0.0, 0.02, -0.01, 1e-5, 0.0, 1e4) == (0.02, -0.01)
    rx, ry = planar_stick_rate(SLIDES, 0.02, -0.01, 1e-4, 1e-4, 1e4)
    assert rx + ry == pytest.approx(0.0, abs=1e-17)  # across the deflection, whose length it keeps
    assert rx - ry == pytest.approx(0.03, rel=1e-14)
    assert planar_stick_rate(SLIDES, 0.02, -0.01, 0.0, 0.0, 1e4) == (0.0, 0.0)


@pytest.mark.parametrize("start", [0.1, 1.5, 3.0])
def test_a_sliding_contact_turns_into_the_slip_as_in_closed_form(start):
    """Angle b of a deflection of length d to the slip s: b' = -(s / d) sin b, so tan(b / 2) = tan(b_0 / 2) exp(-s t / d)."""
    d, speed = 1e-4, 0.05
    done = solve_ivp(
        lambda t, z: planar_stick_rate(SLIDES, speed, 0.0, *z, math.inf),
        (0.0, 3.0 * d / speed),
        [d * math.cos(start), d * math.sin(start)],
        rtol=1e-10,
        atol=1e-16,
    )
    zx, zy = done.y[:, -1]
    assert math.hypot(zx, zy) == pytest.approx(d, rel=1e-8)
    assert math.atan2(zy, zx) == pytest.approx(2.0 * math.atan(math.tan(0.5 * start) * math.exp(-3.0)), rel=1e-6)


def test_turning_is_no_faster_than_asked():
    """Deflections of a nanometre would turn within nanoseconds; what is slowed down is the path it takes, not where it ends."""
    rx, ry = planar_stick_rate(SLIDES, 0.0, 1.0, 1e-9, 0.0, 1e4)
    assert math.hypot(rx, ry) == pytest.approx(1e4 * 1e-9, rel=1e-12)
    assert planar_stick_rate(SLIDES, 1.0, 0.0, 1e-9, 0.0, 1e4) == (0.0, 0.0)


def test_modes_last_and_end_where_they_should():
    breakaway, sliding = 1.2e-4, 1e-4
    assert planar_stick_guard(0.0, 9.0, 9.0, 0.72e-4, -0.96e-4, breakaway) > 0.0  # right at the level, it holds
    assert planar_stick_guard(0.0, 9.0, 9.0, 0.73e-4, -0.96e-4, breakaway) < 0.0
    mode, zx, zy = planar_stick_switch(0.0, 0.73e-4, -0.96e-4, sliding)
    assert mode == SLIDES
    assert math.hypot(zx, zy) == pytest.approx(sliding, rel=1e-14)
    assert planar_stick_guard(SLIDES, 0.01, 0.0, zx, zy, breakaway) == pytest.approx(0.01 * zx / sliding, rel=1e-14)
    assert planar_stick_guard(SLIDES, -0.01, 0.0, zx, zy, breakaway) < 0.0
    mode, *z = planar_stick_switch(SLIDES, zx, zy, sliding)
    assert mode == 0.0
    assert z == pytest.approx([zx, zy], rel=1e-14)


@pytest.mark.parametrize("mode", [0.0, SLIDES])
def test_a_contact_that_holds_or_slides_takes_power_up(mode):
    """Traction times slip less what the deflection stores is nowhere negative, with its damper, where the mode holds."""
    random = np.random.default_rng(7)
    k, damping = 6e4, 60.0
    for _ in range(500):
        z = turned([1e-4, 0.0], random.uniform(0.0, 7.0))
        s = random.normal(0.0, 0.1, 2)
        if mode == SLIDES and s @ z < 0.0:
            s = -s
        r = np.array(planar_stick_rate(mode, *s, *z, 1e4))
        assert (k * z + damping * r) @ s - k * z @ r >= -1e-15


# -- the block of the LuGre paper, pulled at an angle -------------------------------------------------------------------------
def test_the_published_block_slides_as_on_a_line():
    """Reference run of the scalar law, Radau at 1e-8: first slip at 7.458 s, then a period of 6.363 s, both +- 1 ms."""

    def course(t, x):
        rx, ry = bristles_rate(x[2:4], x[4:6], math.inf)
        pull = SPRING * PULL * t
        return [
            x[2],
            x[3],
            (pull * COSINE - SPRING * x[0] - STIFFNESS * x[4] - DAMPING * rx - VISCOUS * x[2]) / MASS,
            (pull * SINE - SPRING * x[1] - STIFFNESS * x[5] - DAMPING * ry - VISCOUS * x[3]) / MASS,
            rx,
            ry,
        ]

    def fast(t, x):
        return x[2] * COSINE + x[3] * SINE - 0.05

    fast.direction = 1.0
    done = solve_ivp(course, (0.0, 22.0), np.zeros(6), method="Radau", rtol=1e-7, atol=1e-10, events=fast)
    slips = done.t_events[0]
    assert len(slips) == 3
    assert np.diff(slips) == pytest.approx(6.363, abs=2e-3)
    assert slips[0] == pytest.approx(7.458, abs=0.15)  # 0.05 m/s is reached a little after the slip has begun
    across = done.y[0] * SINE - done.y[1] * COSINE
    assert np.abs(across).max() < 1e-9


class PlanarBlock(EventComponent):
    """The block on a contact that holds elastically; x: place, velocity, deflection, two numbers each, and the mode."""

    deflection = parameter(1e-6, "m", "deflection at the kinetic level")
    substep = parameter(1e-4, "s", "longest internal step")
    along = output("m", "way in the direction of the pull")
    across = output("m", "way across")
    speed = output("m/s", "velocity in the direction of the pull")

    def states(self) -> int:
        return 7


@kernel
def block_start(t, s, p, e):
    """At rest."""
    return DONE


@kernel
def block_stable(t, s, p, e):
    """Of the elastic contact."""
    return 2.6 / math.sqrt(KINETIC / p.deflection / MASS)


@kernel
def block_derivatives(t, x, u, dx, s, p, e):
    """dx/dt of the block."""
    rx, ry = planar_stick_rate(x[6], x[2], x[3], x[4], x[5], 1.0 / p.substep)
    zx, zy = planar_stick_deflection(x[6], x[4], x[5], p.deflection)
    stiffness = KINETIC / p.deflection
    damping = 0.2 * math.sqrt(stiffness * MASS)
    dx[0], dx[1], dx[4], dx[5], dx[6] = x[2], x[3], rx, ry, 0.0
    dx[2] = (SPRING * (PULL * t * COSINE - x[0]) - stiffness * zx - damping * rx) / MASS
    dx[3] = (SPRING * (PULL * t * SINE - x[1]) - stiffness * zy - damping * ry) / MASS


@kernel
def block_guards(t, x, u, g, s, p, e):
    """What keeps the mode."""
    g[0] = planar_stick_guard(x[6], x[2], x[3], x[4], x[5], STATIC / KINETIC * p.deflection)


@kernel
def block_switch(which, t, x, u, s, p, e):
    """Breaks loose or comes to rest."""
    x[6], x[4], x[5] = planar_stick_switch(x[6], x[4], x[5], p.deflection)


@kernel
def block_outputs(t, s, p, e):
    """Way along and across, speed."""
    x, y = s.x, s.y
    y[0], y[1] = x[0] * COSINE + x[1] * SINE, x[0] * SINE - x[1] * COSINE
    y[2] = x[2] * COSINE + x[3] * SINE
    return DONE


PlanarBlock.kernels = event_kernels(
    __name__,
    start=block_start,
    derivatives=block_derivatives,
    guards=block_guards,
    switch=block_switch,
    outputs=block_outputs,
    stable=block_stable,
)


def slips_of(deflection: float) -> tuple[list[float], float, float]:
    """(instants at which the block breaks loose, to half a ms, highest speed, way across) within 32 s."""
    block = PlanarBlock(parameters={"deflection": deflection})
    block.initialize(0.0)
    modes, top = [], 0.0
    for k in range(32000):
        block.step(k * 1e-3, 1e-3)
        modes.append(block.x[6])
        top = max(top, block["speed"])
    starts = [1e-3 * (k + 1.5) for k, (a, b) in enumerate(pairwise(modes)) if (a, b) == (0.0, SLIDES)]
    return starts, top, abs(block["across"])


@pytest.mark.full
def test_a_stiff_contact_sticks_and_slips_as_the_rigid_one():
    """Rigid: slips at 7.5 s, then every 7.61126 s, at 0.467423 m/s at most.

    The elastic contact moves by 1.5 um before it breaks loose, which takes 1.5e-5 s; instants are read at steps of 1 ms.
    """
    starts, top, across = slips_of(1e-6)
    ideal = 7.5 + 7.61126 * np.arange(4)
    assert starts == pytest.approx(ideal, abs=2e-3)
    assert top == pytest.approx(0.467423, rel=1e-4)
    assert across < 1e-12
