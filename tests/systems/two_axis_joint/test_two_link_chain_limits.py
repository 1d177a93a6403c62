"""The two-link chain in chaos, on the verge of standing, and with hardly any mass."""

import math

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.components.two_axis_joint.chain import TwoLinkChain
from cosimo.tests.support import initialized
from scipy.integrate import solve_ivp

G = 9.81


HIGH = {"start_first_angle": 2.5, "start_second_angle": 2.9}


def started(effects=("gravity",), **parameters) -> TwoLinkChain:
    return initialized(TwoLinkChain(effects, parameters))


@pytest.mark.full
def test_a_chaotic_chain_is_right_for_a_short_while():
    """2 s against DOP853 on the textbook's equations; the exponent of separation, some 3 1/s, allows a factor of 400."""

    def right(t, x):
        d = x[0] - x[1]
        b = [-math.sin(d) * x[3] ** 2 - 2.0 * G * math.sin(x[0]), math.sin(d) * x[2] ** 2 - G * math.sin(x[1])]
        return [x[2], x[3], *np.linalg.solve([[2.0, math.cos(d)], [math.cos(d), 1.0]], b)]

    exact = solve_ivp(right, (0.0, 2.0), [2.5, 2.9, 0.0, 0.0], method="DOP853", rtol=1e-12, atol=1e-12).y[:, -1]
    chain = started(**HIGH, substep=1e-4)
    chain.step(0.0, 2.0)
    np.testing.assert_allclose(chain.y[:4], exact, atol=1e-8)


@pytest.mark.full
@pytest.mark.parametrize("levels", [(0.5, 0.5), (0.3, 0.8), (0.0, 0.5), (0.5, 0.0), (0.0, 0.0)])
@pytest.mark.parametrize("ratio", [1.0, 1.5])
def test_every_swing_with_friction_ends_and_energy_never_grows(levels, ratio):
    """Both joints stop and start again many times; where both rub, the chain is at rest in the end, to the last bit."""
    friction = {
        "stick_friction.first_level": levels[0],
        "stick_friction.second_level": levels[1],
        "stick_friction.static_ratio": ratio,
    }
    chain = started(("gravity", "stick_friction"), **friction, **HIGH, substep=2e-4)  # RK4 gains 1e-12 of the energy a second
    energy = chain.energy()
    for k in range(160):
        chain.step(0.5 * k, 0.5)
        assert chain.energy() <= energy * (1.0 + 1e-9) + 1e-12
        energy = chain.energy()
    if min(levels) > 0.0:
        assert (chain["first_rate"], chain["relative_rate"]) == (0.0, 0.0)
        place = chain.y[:2].copy()
        chain.step(80.0, 50.0)
        assert (chain.y[:2] == place).all()


@pytest.mark.full
def test_two_joints_on_the_verge_of_standing():
    """Torques of 0.3 N.m in both joints: the second one slides, and just then the first one bears exactly its level of 0.1."""
    chain = TwoLinkChain(("stick_friction",))
    chain.set("first_torque", 0.3)
    chain.set("second_torque", 0.3)
    chain.initialize(0.0)
    chain.step(0.0, 0.01)
    assert chain["first_rate"] == 0.0
    # J = 1: (0.3 - 0.1) * 0.01; then the first joint's load grows as the second one's rate does, and pulls it backwards
    assert chain["second_rate"] == pytest.approx(0.002, rel=1e-3)
    chain.u[1] = 0.5
    chain.step(0.01, 0.2)
    assert chain["first_rate"] < 0.0
    assert chain.work["events"] <= 4


@pytest.mark.full
def test_torque_that_turns_many_times_while_friction_holds_some_of_it():
    """A torque across the static level again and again: stick-slip with the motion of the closed form, one turn after another."""
    chain = started(
        ("stick_friction",),
        second_mass=0.0,
        second_inertia=1.0,
        **{"stick_friction.first_level": 1.0, "stick_friction.second_level": 0.0},
    )
    for k in range(50):  # 0.9, held, and 1.1, which moves it for 0.1 s: rate 0.01, and standing after another 0.01 / 1.9 s or so
        chain.set("first_torque", 1.1)
        chain.step(0.3 * k, 0.1)
        assert chain["first_rate"] == pytest.approx(0.01, rel=1e-6)
        chain.set("first_torque", 0.9)
        chain.step(0.3 * k + 0.1, 0.2)
        assert chain["first_rate"] == 0.0
    once = 0.5 * 0.1 * 0.1**2 + 0.01**2 / (2.0 * 0.1)
    assert chain["first_angle"] == pytest.approx(50 * once, rel=1e-6)


@pytest.mark.full
def test_a_nearly_massless_elbow_needs_and_gets_a_small_step():
    """1e-6 kg between the ground and 1 kg: a string, whose transverse frequency is some sqrt(m2 g / m1) = 3 to 9 krad/s."""
    with pytest.raises(BadInput, match=r"substep = 0.001 s"):
        started(first_mass=1e-6, start_first_angle=0.3, start_second_angle=0.3)
    chain = started(first_mass=1e-6, start_first_angle=0.3, start_second_angle=0.3, substep=1e-5)
    energy = chain.energy()
    chain.step(0.0, 2.0)
    assert chain.energy() == pytest.approx(energy, rel=1e-6)
    # a pendulum of 2 m in the mean
    w = math.sqrt(G / 2.0)
    swing = 0.3 * math.cos(w * (1.0 - 0.3**2 / 16.0) * 2.0)
    assert 0.5 * (chain["first_angle"] + chain["second_angle"]) == pytest.approx(swing, abs=2e-3)


@pytest.mark.full
def test_stops_hold_the_weight_of_the_second_link():
    """Folded upwards onto its stop and pressed into it by a motor: at rest, the spring bears the torque."""
    chain = started(
        ("gravity", "viscous", "smoothed_friction", "stops", "reactions"),
        **{
            "gravity.acceleration": 0.0,
            "smoothed_friction.first_level": 0.0,
            "smoothed_friction.second_level": 0.0,
            "stops.upper": 1.0,
            "viscous.first": 5.0,
            "viscous.second": 1.0,
        },
    )
    chain.set("second_torque", 3.0)
    chain.step(0.0, 120.0)
    assert chain["relative_angle"] - 1.0 == pytest.approx(3.0 / 1000.0, rel=1e-6)
    assert chain["relative_rate"] == pytest.approx(0.0, abs=1e-9)
    assert chain.work["events"] < 100
