"""Wheels and sleeve on the verge of sliding: under vibration, breaking loose, half cycles of stick and slip."""

import math

import numpy as np
import pytest
from cosimo.components.friction_drive.wheels import FrictionWheels
from cosimo.tests.support import initialized
from cosimo.tests.systems.friction_drive.drive_runs import FULL, NEUTRAL

pytestmark = pytest.mark.interpreted


def wheels_under(effects=(), inputs=(0.0, 0.0, 0.0, 0.0), **parameters) -> FrictionWheels:
    """Initialized wheels; inputs: first and second rate, force, torque."""
    wheels = FrictionWheels(effects, parameters)
    wheels.u[0, :4] = inputs
    return initialized(wheels)


def shaken(wheels: FrictionWheels, duration: float, mean: float, swing: float, frequency: float, h: float = 1e-3) -> None:
    """A force that swings about its mean, N, at a frequency in Hz, as a polynomial of each step."""
    w = 2.0 * math.pi * frequency
    for k in range(round(duration / h)):
        t = k * h
        wheels.u[:, 2] = mean + swing * math.sin(w * t), swing * w * math.cos(w * t), -0.5 * swing * w**2 * math.sin(w * t)
        wheels.step(t, h)
    wheels.set("external_force", 0.0)


@pytest.mark.full
@pytest.mark.parametrize(("effects", "duration"), [(("exact_slip",), 60.0), (("lugre_slip",), 6.0), (("smoothed_slip",), 6.0)])
def test_a_load_held_under_vibration(effects, duration):
    """At 5 N, with 3 N at 40 Hz on top, two thirds of what holds: after 60 s the exact contact is back within 1e-12 m."""
    wheels = wheels_under(effects)
    shaken(wheels, duration, 5.0, 3.0, 40.0, h=2.5e-3)
    wheels.step(duration, 1.0)
    if effects == ("exact_slip",):
        assert abs(wheels["feed"]) < 1e-12
    else:
        assert wheels["feed"] > 1e-6
    if effects == ("smoothed_slip",):
        # slip = level / creep * artanh(F / 2 level), and the mass averages the force's 40 Hz out only in part
        assert duration * 5.0 / 1200.0 < wheels["feed"] < duration * 0.01 * math.atanh(8.0 / 12.0)


@pytest.mark.full
@pytest.mark.parametrize(("force", "slides"), [(13.0, False), (15.0, True)])
def test_bristles_of_both_contacts_let_go_at_the_static_level(force, slides):
    """1.2 times 12 N; the force comes within a second."""
    wheels = wheels_under(("lugre_slip",))
    wheels.u[1, 2] = force
    wheels.step(0.0, 1.0)
    wheels.step(1.0, 0.2)
    assert (wheels["feed_rate"] > 0.1) == slides
    assert slides or abs(wheels["feed_rate"]) < 1e-4


@pytest.mark.full
def test_wheels_that_pull_against_each_other_hold_the_sleeve_between_them():
    """Plain wheels, one turns, one stands: both slide or one sticks, and the run stays stable whichever."""
    for first, second in ((1e-3, 0.0), (5.0, 0.0), (5.0, -5.0), (1e-6, -1e-6)):
        wheels = wheels_under(("exact_slip",), (first, second, 0.0, 0.0))
        wheels.step(0.0, 2.0)
        v = np.array([wheels["feed_rate"], 0.005 * wheels["rotation_rate"]])
        cosine = math.cos(math.pi / 6.0)
        ends = 0.01 * np.array([[first * cosine, 0.5 * first], [second * cosine, -0.5 * second]])
        along = ends[1] - ends[0]
        share = (v - ends[0]) @ along / (along @ along)
        assert -1e-6 <= share <= 1.0 + 1e-6  # between the velocities of the two wheels' surfaces
        assert v == pytest.approx(ends[0] + share * along, abs=1e-6 * np.linalg.norm(along))


@pytest.mark.full
def test_breaking_loose_of_one_contact_first():
    """Wheel one has half its preload: it slides first, and the sleeve holds until both do."""
    wheels = wheels_under(
        FULL,
        **NEUTRAL
        | {
            "preload_loss.first": 0.5,
            "preload_loss.start": 0.0,
            "preload_loss.duration": 1e-3,
            "exact_slip.static_ratio": 1.0,
            "layout": "orthogonal",
        },
    )
    wheels.step(0.0, 0.1)
    wheels.u[1, 2] = 2.9  # N/s: the first wheel bears 3 N along the axis, the second none
    wheels.step(0.1, 1.0)
    assert wheels["exact_slip.first_stuck"] == 1.0
    wheels.u[1, 2] = 0.2
    wheels.step(1.1, 1.0)
    assert wheels["exact_slip.first_stuck"] == 0.0
    assert wheels["exact_slip.second_stuck"] == 1.0
    assert wheels["feed_rate"] > 0.0


@pytest.mark.full
@pytest.mark.parametrize("angle", [1e-3, 1e-6, 1e-9])
def test_nearly_parallel_free_rollers_turn_the_sleeve_fast(angle):
    """Rates that differ ask for R dw / (2 r sin a) of rotation: the sleeve runs after it as far as friction lets it."""
    wheels = wheels_under(("exact_slip",), (20.0, 19.0, 0.0, 0.0), layout="skewed_free_rollers", angle=angle)
    wheels.step(0.0, 1.0)
    most = 12.0 * math.sin(angle) * 0.005 / 1.875e-6  # rad/s², of both contacts
    assert np.isfinite(wheels.y).all()
    assert abs(wheels["rotation_rate"]) <= min(most, 0.01 / (2.0 * 0.005 * math.sin(angle))) * 1.01
    assert wheels["feed_rate"] == pytest.approx(0.195, abs=0.006)


@pytest.mark.full
@pytest.mark.parametrize("effects", [("exact_slip",), ("lugre_slip",), ()])
def test_the_stated_limit_of_the_substep_is_stable(effects):
    """At 0.99 of the limit a blow dies away."""
    limit = FrictionWheels(effects).stable_step()
    wheels = wheels_under(effects, substep=0.99 * limit, start_feed_rate=1e-4, start_rotation_rate=0.01)
    wheels.step(0.0, 2000.0 * limit)
    assert abs(wheels["feed_rate"]) < 1e-9
    assert abs(wheels["rotation_rate"]) < 1e-7


@pytest.mark.full
@pytest.mark.parametrize("frequency", [0.5, 5.0, 50.0])
def test_stick_slip_at_every_half_cycle_repeats(frequency):
    """Wheels stand; a force beyond the contacts swings: from the second cycle on each is like the one before."""
    wheels = wheels_under(("exact_slip",))
    w, h = 2.0 * math.pi * frequency, 1.0 / frequency / 200.0
    feeds, events = [], []
    for k in range(1000):
        t = k * h
        wheels.u[:, 2] = 16.0 * math.sin(w * t), 16.0 * w * math.cos(w * t), -8.0 * w**2 * math.sin(w * t)
        wheels.step(t, h)
        if k % 200 == 199:
            feeds.append(wheels["feed"])
            events.append(wheels.work["events"])
    travel = np.diff(feeds)
    assert np.diff(events)[-2:].tolist() == [np.diff(events)[-1]] * 2
    assert abs(travel[-1] - travel[-2]) < 1e-3 * abs(feeds[0]) + 1e-9
    assert np.diff(events)[-1] >= 4  # two contacts, loose and at rest again, each half cycle


@pytest.mark.full
def test_a_contact_that_is_just_not_left_is_not_left():
    """The load comes to rest at the very level that holds, to 1e-9 of it."""
    for beyond, stuck in ((-1e-6, 2.0), (1e-6, 0.0)):
        wheels = wheels_under(("exact_slip",), **{"exact_slip.damping_time": 3e-3})
        wheels.u[:, 2] = 0.0, 0.2 * 14.4 * (1.0 + beyond), -0.01 * 14.4 * (1.0 + beyond)  # ends level after 10 s, 1.2 * 12 N
        wheels.step(0.0, 10.0)
        wheels.step(10.0, 1.0)
        assert wheels["exact_slip.first_stuck"] + wheels["exact_slip.second_stuck"] == stuck
