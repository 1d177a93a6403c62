"""Hard cases of the inertial converter: many events, standstill of either shaft, reversal, a light lever, stiff clutches."""

from __future__ import annotations

import math

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput, StepFailed
from cosimo.components.wind_pump.converter import MODE, InertialConverter
from cosimo.components.wind_pump.driven_shaft import STANDING

pytestmark = pytest.mark.full


def started(effects=(), turbine=3.0, load=0.0, **parameters) -> InertialConverter:
    converter = InertialConverter(effects, parameters)
    converter.set("turbine_speed", turbine)
    converter.set("load_torque", load)
    converter.initialize(0.0)
    return converter


def per_work(converter: InertialConverter, duration: float) -> int:
    """Derivative calls a second of simulated time."""
    converter.step(0.0, duration)
    return round(converter.work["derivative_calls"] / duration)


@pytest.mark.parametrize("load", [0.5, 5.0, 15.0])
def test_four_events_a_revolution_over_ten_minutes(load):
    """None is missed and none doubled, and they cost less than half as much again as the steps without them."""
    converter = started(load=load)
    converter.step(0.0, 60.0)
    before, angle = converter.work, converter["crank_angle"]
    converter.step(60.0, 600.0)
    work = {n: after - before[n] for n, after in converter.work.items()}
    revolutions = (converter["crank_angle"] - angle) / (2.0 * math.pi)
    assert work["events"] == pytest.approx(4.0 * revolutions, abs=4.0)
    assert work["derivative_calls"] < 1.5 * 4 * work["steps"]


def test_what_stiff_clutches_cost():
    """Slipping clutches ask for substeps as short as their relaxation: 80 times as many as rigid ones, for the same speed."""
    rigid, slipping = started(load=5.0), started(["compliant_clutches"], load=5.0)
    assert per_work(slipping, 20.0) > 50 * per_work(rigid, 20.0)
    # the mean torque differs in the second order of the delay, 25 us at 18 rad/s; phases within a revolution shift a little
    assert slipping["speed"] == pytest.approx(rigid["speed"], rel=1e-3)
    stiffer = started(["compliant_clutches"], **{"compliant_clutches.damping": 1e3})
    assert stiffer.stable_step() < 2e-4
    with pytest.raises(BadInput, match="limit of RK4"):
        started(["compliant_clutches"], **{"compliant_clutches.damping": 1e5})


@pytest.mark.parametrize("effects", [(), ("compliant_clutches",)])
def test_a_resting_turbine_moves_nothing(effects):
    converter = started(effects, turbine=0.0, load=5.0)
    converter.step(0.0, 1.0)
    assert not converter.x[:6].any()
    assert converter.x[MODE] == STANDING
    assert [converter[n] for n in ("turbine_torque", "driving_torque", "ratio", "dissipation")] == [0.0] * 4


def test_slipping_clutches_start_from_a_rest_in_which_drive_and_load_are_equal():
    """Nothing moves and nothing brakes; then the turbine speeds up, and the shaft follows as it does with rigid clutches."""
    rigid, slipping = started(turbine=0.0), started(["compliant_clutches"], turbine=0.0)
    for converter in (rigid, slipping):
        converter.u[1, 0] = 1.0
        converter.step(0.0, 1.0)
    assert slipping["speed"] == pytest.approx(rigid["speed"], rel=1e-3)
    assert slipping.work["events"] < 10


def test_slipping_clutches_let_a_load_drive_the_resting_shaft():
    """A load that falls below 0 from 0: 1 N.m/s on 1 kg m²."""
    converter = started(["compliant_clutches"], turbine=0.0)
    converter.u[1, 1] = -1.0
    converter.step(0.0, 1.0)
    assert converter["speed"] == pytest.approx(0.5, rel=1e-9)


def test_a_resting_turbine_under_no_load_either():
    converter = started(turbine=0.0)
    converter.step(0.0, 1.0)
    assert not converter.x[:6].any()


@pytest.mark.parametrize("effects", [(), ("compliant_clutches",)])
def test_a_load_above_the_peak_is_not_moved_by_a_bit(effects):
    """The peak is rho m a b r w1² = 32 N.m; below it, the shaft turns for a while twice a revolution, and stands in between."""
    peak = 0.05 * 20.0 * 2.0 * 0.05 * 18.0**2
    converter = started(effects, load=1.2 * peak)
    for k in range(20):
        converter.step(0.05 * k, 0.05)
        assert converter["speed"] == 0.0
        assert converter["ratio"] == 0.0
    weaker = started(effects, load=0.9 * peak)
    speeds = []
    for k in range(200):
        weaker.step(0.01 * k, 0.01)
        speeds.append(weaker["speed"])
    assert min(speeds) == 0.0 < max(speeds)
    assert 0.1 < np.mean(np.array(speeds) == 0.0) < 0.9


def test_the_driven_shaft_runs_out_and_stands_when_the_turbine_stops():
    """Speed falls by load over inertia until it is zero, and stays there, whatever the lever still does."""
    converter = started(load=2.0, start_speed=5.0)
    converter.step(0.0, 5.0)
    converter.set("turbine_speed", 0.0)
    converter.step(5.0, 60.0)
    assert converter["speed"] == 0.0
    assert converter.x[MODE] == STANDING


def test_a_load_that_drives_never_turns_the_shaft_back():
    converter = started(turbine=0.0, load=-2.0)
    converter.step(0.0, 3.0)
    assert converter["speed"] == pytest.approx(6.0, rel=1e-12)  # 2 N.m on 1 kg m², and the lever at rest
    assert converter["slider_velocity"] == 0.0
    converter.set("load_torque", 3.0)
    converter.step(3.0, 5.0)
    assert converter["speed"] == 0.0


def test_a_crank_turned_backwards_is_the_mirror_image():
    """phi and y change sign, the driven shaft turns the same way: to the last bit."""
    forward, backward = started(turbine=3.0, load=5.0), started(turbine=-3.0, load=5.0)
    for k in range(100):
        forward.step(0.1 * k, 0.1)
        backward.step(0.1 * k, 0.1)
        for name, sign in (("speed", 1.0), ("driving_torque", 1.0), ("ratio", -1.0), ("turbine_torque", -1.0),
                           ("slider_velocity", -1.0), ("crank_angle", -1.0), ("engaged", -1.0)):  # fmt: skip
            assert backward[name] == sign * forward[name]
    assert forward["speed"] > 0.1


def test_the_turbine_may_turn_over():
    """Through standstill in both directions, under load: the pump's shaft comes to rest with it and starts again."""
    converter = started(load=5.0)
    reached = []
    for k in range(6):
        converter.set("turbine_speed", 3.0 if k % 2 else -3.0)
        converter.step(5.0 * k, 5.0)
        reached.append(converter["speed"])
    assert min(reached) > 0.1


@pytest.mark.parametrize("slider", [0.0, 1e-6])
def test_a_very_light_lever(slider):
    """It pushes nothing: a crank alone under load, and without load the shaft follows up to the largest speed."""
    light = {"lever_mass": 1e-6, "slider_mass": slider}
    converter = started(load=1.0, **light)
    converter.step(0.0, 10.0)
    assert converter["speed"] == 0.0
    assert converter["crank_speed"] == pytest.approx(18.0, rel=1e-5)
    free = started(load=0.0, driven_inertia=1e-6, **light)
    free.step(0.0, 200.0)
    largest = 2e-6 * 0.05 * 18.0 / ((1e-6 + slider) * 0.05)
    assert free["speed"] == pytest.approx(largest, rel=1e-2)


def test_a_slider_without_mass_is_regular():
    """The mass matrix of the coordinates stays regular as the lever's mass moves with the slider."""
    converter = started(load=5.0, slider_mass=0.0)
    converter.step(0.0, 30.0)
    assert 0.0 < converter["speed"] < 100.0


def test_a_macro_step_of_ten_seconds_is_a_thousand_of_ten_milliseconds():
    long, short = started(load=5.0), started(load=5.0)
    long.step(0.0, 10.0)
    for k in range(1000):
        short.step(0.01 * k, 0.01)
    assert long.work["steps"] == short.work["steps"]
    # rounding of 10 s against 1000 times 10 ms, through 110 events
    np.testing.assert_allclose(long.x, short.x, rtol=1e-8, atol=1e-8)
    assert long.work["events"] == short.work["events"] > 100


def test_a_gust_and_a_load_that_jumps():
    """Turbine from 2 to 8 rad/s in 0.1 s, loads that come and go at every macro step: finite, never backwards, parts engaged."""
    rng = np.random.default_rng(11)
    converter = started(turbine=2.0, load=10.0)
    for k in range(400):
        if k == 100:
            converter.u[1, 0] = 60.0
        converter.step(0.1 * k, 0.1)
        converter.set("load_torque", rng.choice([0.0, 1e-6, 10.0, 100.0]))
        assert converter["speed"] >= 0.0
        assert abs(converter["slider_velocity"]) <= 0.05 * converter["speed"] + 1e-14
    assert converter["turbine_speed"] == pytest.approx(8.0)


def test_random_converters_under_random_jumps():
    """Masses, arms and inertias over decades: no state that is not finite, no modes that chase each other."""
    rng = np.random.default_rng(3)
    for _ in range(40):
        ranges = {
            "lever_mass": (-3, 2),
            "crank_radius": (-2, -1),
            "lever_ratio": (-0.7, 0.7),
            "clutch_arm": (-2, -0.5),
            "driven_inertia": (-2, 1),
            "crank_inertia": (-0.5, 1),
        }
        parameters = {n: 10.0 ** rng.uniform(*r) for n, r in ranges.items()}
        converter = started(turbine=rng.uniform(-5.0, 5.0), slider_mass=rng.choice([0.0, 0.1]),
                            start_speed=rng.choice([0.0, 4.0]), **parameters)  # fmt: skip
        for k in range(50):
            converter.set("load_torque", rng.choice([0.0, -0.1, 10.0 ** rng.uniform(-3.0, 2.0)]))
            converter.u[1] = rng.normal(size=2)
            converter.step(0.05 * k, 0.05)
            assert converter["speed"] >= 0.0


def test_a_crank_too_fast_for_the_substep_is_refused():
    converter = started()
    converter.set("turbine_speed", 40.0)
    with pytest.raises(StepFailed, match="range"):
        converter.step(0.0, 5.0)
    finer = started(substep=2e-4)
    finer.set("turbine_speed", 40.0)
    finer.step(0.0, 5.0)
    assert finer["crank_speed"] == pytest.approx(240.0, rel=0.05)
