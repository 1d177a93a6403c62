"""Kinematics of wheels and sleeve: inverse, singular arrangements, and what the simulated wheels do without load."""

import math

import numpy as np
import pytest
from cosimo.components.friction_drive.kinematics import (
    FREE_ROLLERS,
    LAYOUTS,
    ORTHOGONAL,
    SKEWED,
    condition,
    directions,
    sleeve_rates,
    wheel_rates,
)
from cosimo.components.friction_drive.wheels import FrictionWheels

pytestmark = pytest.mark.interpreted

WHEEL, SLEEVE = 0.01, 0.005


@pytest.mark.parametrize("layout", range(3))
@pytest.mark.parametrize("angle", [0.05, math.pi / 6.0, 1.2])
def test_wheel_rates_are_the_inverse(layout, angle):
    for rates in ((0.1, 0.0), (0.0, 7.0), (-0.03, 11.0)):
        wheels = wheel_rates(*rates, layout, angle, WHEEL, SLEEVE)
        assert sleeve_rates(*wheels, layout, angle, WHEEL, SLEEVE) == pytest.approx(rates, rel=1e-13, abs=1e-14)


@pytest.mark.parametrize("layout", range(3))
def test_feed_and_rotation_are_decoupled(layout):
    feed, turn = (np.array(wheel_rates(*r, layout, 0.4, WHEEL, SLEEVE)) for r in ((0.1, 0.0), (0.0, 7.0)))
    assert feed @ turn == pytest.approx(0.0, abs=1e-14 * np.linalg.norm(feed) * np.linalg.norm(turn))


@pytest.mark.parametrize("layout", [FREE_ROLLERS, ORTHOGONAL])
@pytest.mark.parametrize(("first", "second"), [(20.0, 20.0), (20.0, -20.0), (3.0, 17.0)])
def test_with_free_rollers_no_wheel_slips_along_its_direction(layout, first, second):
    angle = math.pi / 6.0
    feed, turn = sleeve_rates(first, second, layout, angle, WHEEL, SLEEVE)
    c1, s1, c2, s2 = directions(layout, angle)
    assert c1 * feed + s1 * SLEEVE * turn == pytest.approx(WHEEL * first, rel=1e-13)
    assert c2 * feed + s2 * SLEEVE * turn == pytest.approx(WHEEL * second, rel=1e-13)


def test_mean_of_plain_wheels_lies_between_their_surfaces():
    """Equal and opposite slips: the tractions of two wheels of equal preload cancel, whatever the law."""
    feed, turn = sleeve_rates(20.0, 5.0, SKEWED, 0.5, WHEEL, SLEEVE)
    c1, s1, c2, s2 = directions(SKEWED, 0.5)
    first = np.array([feed - WHEEL * 20.0 * c1, SLEEVE * turn - WHEEL * 20.0 * s1])
    second = np.array([feed - WHEEL * 5.0 * c2, SLEEVE * turn - WHEEL * 5.0 * s2])
    assert first == pytest.approx(-second, rel=1e-13)


@pytest.mark.parametrize("angle", [1e-2, 1e-4, 1e-8])
def test_the_condition_grows_as_one_over_the_angle(angle):
    assert condition(SKEWED, angle) * angle == pytest.approx(1.0, rel=angle)
    assert condition(SKEWED, 0.0) == math.inf
    assert condition(SKEWED, 0.25 * math.pi) == pytest.approx(1.0, rel=1e-15)


# -- the simulated wheels -----------------------------------------------------------------------------------------------------
def settled(layout: int, effects, first: float, second: float, duration: float = 0.4) -> FrictionWheels:
    wheels = FrictionWheels(effects, {"layout": LAYOUTS[layout]})
    wheels.set("first_rate", first)
    wheels.set("second_rate", second)
    wheels.initialize(0.0)
    wheels.step(0.0, duration)
    return wheels


@pytest.mark.first(4)
@pytest.mark.parametrize("effects", [(), ("smoothed_slip",), ("lugre_slip",), ("exact_slip",)])
@pytest.mark.parametrize("layout", [FREE_ROLLERS, ORTHOGONAL])
def test_free_rollers_end_without_slip_whatever_the_friction(layout, effects):
    wheels = settled(layout, effects, 20.0, 7.0)
    feed, turn = sleeve_rates(20.0, 7.0, layout, math.pi / 6.0, WHEEL, SLEEVE)
    assert wheels["feed_rate"] == pytest.approx(feed, rel=1e-9)
    assert wheels["rotation_rate"] == pytest.approx(turn, rel=1e-9)
    assert wheels["contact_power"] == pytest.approx(0.0, abs=1e-9)
    assert (wheels["first_torque"], wheels["second_torque"]) == pytest.approx((0.0, 0.0), abs=1e-9)


def test_creeping_plain_wheels_end_at_the_mean():
    wheels = settled(SKEWED, (), 20.0, 7.0)
    feed, turn = sleeve_rates(20.0, 7.0, SKEWED, math.pi / 6.0, WHEEL, SLEEVE)
    assert wheels["feed_rate"] == pytest.approx(feed, rel=1e-10)
    assert wheels["rotation_rate"] == pytest.approx(turn, rel=1e-10)


@pytest.mark.first(2)
@pytest.mark.parametrize("effects", [("smoothed_slip",), ("lugre_slip",), ("exact_slip",)])
@pytest.mark.parametrize("second", [20.0, -20.0])
def test_even_plain_wheels_give_a_pure_motion(effects, second):
    """Started from rest; by symmetry the other motion stays away: R w cos a of feed, or R w sin a at the surface."""
    wheels = settled(SKEWED, effects, 20.0, second)
    feed, turn = sleeve_rates(20.0, second, SKEWED, math.pi / 6.0, WHEEL, SLEEVE)
    assert (feed, turn) == pytest.approx((0.2 * math.cos(math.pi / 6.0), 0.0) if second > 0.0 else (0.0, 20.0), rel=1e-14)
    assert wheels["feed_rate"] == pytest.approx(feed, rel=1e-7, abs=1e-12)
    assert wheels["rotation_rate"] == pytest.approx(turn, rel=1e-7, abs=1e-9)


@pytest.mark.first
@pytest.mark.parametrize("turn", [-12.0, 0.0, 15.0])
def test_unloaded_plain_wheels_leave_the_rotation_between_their_own_open(turn):
    """Slips against each other, whatever their size: no torque. The controller of such wheels has to close the loop."""
    wheels = FrictionWheels(("exact_slip",), {"start_rotation_rate": turn, "start_feed_rate": 0.2 * math.cos(math.pi / 6.0)})
    wheels.set("first_rate", 20.0)
    wheels.set("second_rate", 20.0)
    wheels.initialize(0.0)
    wheels.step(0.0, 0.1)
    early = wheels["rotation_rate"]  # less than at the start: until both slid, they have held the sleeve
    wheels.step(0.1, 0.5)
    assert 0.5 * abs(turn) <= abs(early) <= abs(turn)
    assert wheels["rotation_rate"] == pytest.approx(early, abs=1e-9)
