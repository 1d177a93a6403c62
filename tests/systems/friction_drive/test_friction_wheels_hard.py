"""Hard cases of friction wheels: both stuck, parallel wheels, no preload, stiff contact and winding, reversals, long steps."""

from __future__ import annotations

import math

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.components.friction_drive.monolith import FrictionDrive
from cosimo.components.friction_drive.wheels import FrictionWheels

pytestmark = pytest.mark.full

FULL = ("exact_slip", "trocar_friction", "gravity", "preload_loss")
NEUTRAL = {"trocar_friction.level": 0.0, "gravity.acceleration": 0.0, "preload_loss.first": 0.0}
STIFFNESS = 2.0 * 0.4 * 15.0 / 1e-4  # N/m, both contacts


def wheels_at(effects=(), inputs=(0.0, 0.0, 0.0, 0.0), **parameters) -> FrictionWheels:
    """Initialized wheels; inputs: first and second rate, force, torque."""
    wheels = FrictionWheels(effects, parameters)
    wheels.u[0, :4] = inputs
    wheels.initialize(0.0)
    return wheels


def shaken(wheels: FrictionWheels, duration: float, mean: float, swing: float, frequency: float, h: float = 1e-3) -> None:
    """A force that swings about its mean, N, at a frequency in Hz, as a polynomial of each step."""
    w = 2.0 * math.pi * frequency
    for k in range(round(duration / h)):
        t = k * h
        wheels.u[:, 2] = mean + swing * math.sin(w * t), swing * w * math.cos(w * t), -0.5 * swing * w**2 * math.sin(w * t)
        wheels.step(t, h)
    wheels.set("external_force", 0.0)


# -- |s| -> 0: both wheels stuck ----------------------------------------------------------------------------------------------
def test_two_wheels_that_stick_share_the_load_and_come_back():
    """Rigid contacts would leave the tractions open; these share a slow load evenly, and lose nothing."""
    wheels = wheels_at(("exact_slip",))
    wheels.u[1, 2:4] = -6.0, 0.01
    wheels.step(0.0, 1.0)
    wheels.step(1.0, 0.5)
    for wheel in ("first", "second"):
        assert wheels[f"{wheel}_traction_axial"] == pytest.approx(3.0, rel=1e-12)
        assert wheels[f"{wheel}_traction_around"] == pytest.approx(-1.0, rel=1e-12)
    assert wheels["feed"] == pytest.approx(-6.0 / STIFFNESS, rel=1e-12)
    wheels.u[1, 2:4] = 6.0, -0.01
    wheels.step(1.5, 1.0)
    wheels.step(2.5, 0.5)
    assert [wheels["feed"], wheels["rotation"]] == pytest.approx([0.0, 0.0], abs=1e-13)


@pytest.mark.parametrize(("effects", "duration"), [(("exact_slip",), 60.0), (("lugre_slip",), 6.0), (("smoothed_slip",), 6.0)])
def test_a_load_held_under_vibration(effects, duration):
    """At 5 N, with 3 N at 40 Hz on top, two thirds of what holds: after 60 s the exact contact is back within 1e-12 m."""
    wheels = wheels_at(effects)
    shaken(wheels, duration, 5.0, 3.0, 40.0, h=2.5e-3)
    wheels.step(duration, 1.0)
    if effects == ("exact_slip",):
        assert abs(wheels["feed"]) < 1e-12
    else:
        assert wheels["feed"] > 1e-6
    if effects == ("smoothed_slip",):
        # slip = level / creep * artanh(F / 2 level), and the mass averages the force's 40 Hz out only in part
        assert duration * 5.0 / 1200.0 < wheels["feed"] < duration * 0.01 * math.atanh(8.0 / 12.0)


@pytest.mark.parametrize(("force", "slides"), [(13.0, False), (15.0, True)])
def test_bristles_of_both_contacts_let_go_at_the_static_level(force, slides):
    """1.2 times 12 N; the force comes within a second."""
    wheels = wheels_at(("lugre_slip",))
    wheels.u[1, 2] = force
    wheels.step(0.0, 1.0)
    wheels.step(1.0, 0.2)
    assert (wheels["feed_rate"] > 0.1) == slides
    assert slides or abs(wheels["feed_rate"]) < 1e-4


def test_wheels_that_pull_against_each_other_hold_the_sleeve_between_them():
    """Plain wheels, one turns, one stands: both slide or one sticks, and the run stays stable whichever."""
    for first, second in ((1e-3, 0.0), (5.0, 0.0), (5.0, -5.0), (1e-6, -1e-6)):
        wheels = wheels_at(("exact_slip",), (first, second, 0.0, 0.0))
        wheels.step(0.0, 2.0)
        v = np.array([wheels["feed_rate"], 0.005 * wheels["rotation_rate"]])
        cosine = math.cos(math.pi / 6.0)
        ends = 0.01 * np.array([[first * cosine, 0.5 * first], [second * cosine, -0.5 * second]])
        along = ends[1] - ends[0]
        share = (v - ends[0]) @ along / (along @ along)
        assert -1e-6 <= share <= 1.0 + 1e-6  # between the velocities of the two wheels' surfaces
        assert v == pytest.approx(ends[0] + share * along, abs=1e-6 * np.linalg.norm(along))


def test_breaking_loose_of_one_contact_first():
    """Wheel one has half its preload: it slides first, and the sleeve holds until both do."""
    wheels = wheels_at(
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


# -- the angle -> 0 -----------------------------------------------------------------------------------------------------------
def test_parallel_wheels_lose_the_rotation_and_nothing_else():
    """Free rollers leave the rotation to the load, M t / J; plain wheels hold it."""
    free = wheels_at(("exact_slip",), (20.0, 20.0, -1.0, 1e-4), layout="skewed_free_rollers", angle=0.0)
    free.step(0.0, 0.5)
    assert free["feed_rate"] == pytest.approx(0.2, rel=1e-9)
    assert free["rotation_rate"] == pytest.approx(1e-4 * 0.5 / 1.875e-6, rel=1e-9)
    plain = wheels_at(("exact_slip",), (20.0, 20.0, -1.0, 1e-4), angle=0.0)
    plain.step(0.0, 0.5)
    assert plain["feed_rate"] == pytest.approx(0.2, rel=1e-9)
    assert plain["rotation_rate"] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("angle", [1e-3, 1e-6, 1e-9])
def test_nearly_parallel_free_rollers_turn_the_sleeve_fast(angle):
    """Rates that differ ask for R dw / (2 r sin a) of rotation: the sleeve runs after it as far as friction lets it."""
    wheels = wheels_at(("exact_slip",), (20.0, 19.0, 0.0, 0.0), layout="skewed_free_rollers", angle=angle)
    wheels.step(0.0, 1.0)
    most = 12.0 * math.sin(angle) * 0.005 / 1.875e-6  # rad/s², of both contacts
    assert np.isfinite(wheels.y).all()
    assert abs(wheels["rotation_rate"]) <= min(most, 0.01 / (2.0 * 0.005 * math.sin(angle))) * 1.01
    assert wheels["feed_rate"] == pytest.approx(0.195, abs=0.006)


# -- the preload -> 0 ---------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("duration", [1e-6, 0.01, 0.1])
def test_without_preload_the_sleeve_falls_freely(duration):
    upright = {"gravity.acceleration": 9.81, "gravity.inclination": 0.5 * math.pi}
    wheels = wheels_at(
        FULL,
        **NEUTRAL
        | upright
        | {"preload_loss.first": 1.0, "preload_loss.second": 1.0, "preload_loss.start": 0.1, "preload_loss.duration": duration},
    )
    wheels.step(0.0, 0.25)
    early = wheels["feed_rate"]
    wheels.step(0.25, 0.5)
    assert wheels["feed_rate"] - early == pytest.approx(-9.81 * 0.5, rel=1e-12)
    assert [wheels["margin"], wheels["first_torque"], wheels["contact_power"]] == pytest.approx([0.0, 0.0, 0.0], abs=1e-15)


@pytest.mark.parametrize("left", [1e-3, 1e-9, 1e-15])
def test_nearly_no_preload_is_no_stiffer_than_full_preload(left):
    """The deflection at which a contact slides stays; what shrinks is its stiffness."""
    lost = {
        "preload_loss.first": 1.0 - left,
        "preload_loss.second": 1.0 - left,
        "preload_loss.start": 0.0,
        "preload_loss.duration": 1e-6,
    }
    wheels = wheels_at(FULL, (20.0, 20.0, 0.0, 0.0), **NEUTRAL | lost)
    wheels.step(0.0, 0.5)
    assert wheels.work["events"] < 20
    assert 0.0 <= wheels["feed_rate"] <= 0.1733
    assert np.isfinite(wheels.y).all()


def test_hardly_any_friction_is_followed():
    wheels = wheels_at(("exact_slip",), (20.0, 20.0, 0.0, 0.0), friction=1e-9)
    wheels.step(0.0, 1.0)
    assert wheels["feed_rate"] == pytest.approx(2.0 * 1e-9 * 15.0 * math.cos(math.pi / 6.0) / 0.15, rel=1e-3)


# -- stiff contact, winding ---------------------------------------------------------------------------------------------------
def test_contacts_and_windings_too_stiff_for_the_substep_are_refused():
    stiff = [
        ("exact_slip", {"exact_slip.deflection": 1e-8}),
        ("lugre_slip", {"lugre_slip.stiffness": 1e10}),
        ("lugre_slip", {"lugre_slip.damping": 1e4}),
        ("smoothed_slip", {"creep": 1e5}),
        ("", {"creep": 1e5}),
    ]
    for effect, given in stiff:
        effects = (effect,) if effect else ()
        with pytest.raises(BadInput, match="the limit of RK4"):
            wheels_at(effects, **given)
    with pytest.raises(BadInput, match="the limit of RK4"):
        FrictionDrive(("inductance",), {"inductance.inductance": 1e-5}).initialize(0.0)


@pytest.mark.parametrize("effects", [("exact_slip",), ("lugre_slip",), ()])
def test_the_stated_limit_of_the_substep_is_stable(effects):
    """At 0.99 of the limit a blow dies away."""
    limit = FrictionWheels(effects).stable_step()
    wheels = wheels_at(effects, substep=0.99 * limit, start_feed_rate=1e-4, start_rotation_rate=0.01)
    wheels.step(0.0, 2000.0 * limit)
    assert abs(wheels["feed_rate"]) < 1e-9
    assert abs(wheels["rotation_rate"]) < 1e-7


# -- reversals, grazing, long steps -------------------------------------------------------------------------------------------
@pytest.mark.parametrize("frequency", [0.5, 5.0, 50.0])
def test_stick_slip_at_every_half_cycle_repeats(frequency):
    """Wheels stand; a force beyond the contacts swings: from the second cycle on each is like the one before."""
    wheels = wheels_at(("exact_slip",))
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


def test_a_contact_that_is_just_not_left_is_not_left():
    """The load comes to rest at the very level that holds, to 1e-9 of it."""
    for beyond, stuck in ((-1e-6, 2.0), (1e-6, 0.0)):
        wheels = wheels_at(("exact_slip",), **{"exact_slip.damping_time": 3e-3})
        wheels.u[:, 2] = 0.0, 0.2 * 14.4 * (1.0 + beyond), -0.01 * 14.4 * (1.0 + beyond)  # ends level after 10 s, 1.2 * 12 N
        wheels.step(0.0, 10.0)
        wheels.step(10.0, 1.0)
        assert wheels["exact_slip.first_stuck"] + wheels["exact_slip.second_stuck"] == stuck


@pytest.mark.parametrize("effects", [("exact_slip",), ("lugre_slip",), ("smoothed_slip",)])
def test_one_long_step_is_many_short_ones(effects):
    ends = []
    for n in (1, 2000):
        wheels = wheels_at(effects, (20.0, 5.0, -3.0, 0.01))
        for k in range(n):
            wheels.step(k * 2.0 / n, 2.0 / n)
        ends.append(wheels.y.copy())
    assert ends[0] == pytest.approx(ends[1], rel=1e-8, abs=1e-9)


def test_slip_of_exactly_zero_has_no_direction_and_no_force():
    for effects in (("smoothed_slip",), ("lugre_slip",), ("exact_slip",)):
        wheels = wheels_at(effects)
        wheels.step(0.0, 0.01)
        assert not wheels.x[:6].any()
        assert wheels["margin"] == 1.0


@pytest.mark.parametrize("effects", [("exact_slip",), ("lugre_slip",), ("smoothed_slip",)])
def test_very_fast_wheels_stay_within_the_friction(effects):
    """Rims at 1 km/s; contacts give, on their way to their deflection, damping * deflection of momentum on top."""
    wheels = wheels_at(effects, (1e5, -1e5, 0.0, 0.0), **({"lugre_slip.viscous": 0.0} if effects == ("lugre_slip",) else {}))
    wheels.step(0.0, 0.01)
    friction = 2.0 * math.sin(math.pi / 6.0) * 6.0 * 0.01  # N.s around the sleeve
    bristles = 2.0 * math.sin(math.pi / 6.0) * 60.0 * 1.2e-4 if effects != ("smoothed_slip",) else 0.0
    assert 0.98 * friction < 1.875e-6 / 0.005 * wheels["rotation_rate"] <= friction + bristles
