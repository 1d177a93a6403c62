"""Piston and centrifugal pump: means, peaks, power, affinity laws, standstill."""

import math

import numpy as np
import pytest
from cosimo.components.wind_pump.centrifugal_pump import CentrifugalPump
from cosimo.components.wind_pump.piston_pump import PistonPump
from cosimo.tests.support import initialized

pytestmark = pytest.mark.interpreted

WEIGHT = 1000.0 * 9.81
VOLUME = 0.25 * math.pi * 0.06**2 * 0.15


def piston(parameters=None, effects=(), speed=4.0, head=20.0, angle=0.0):
    """A piston pump that turns at a speed against a head."""
    return initialized(PistonPump(effects, (parameters or {}) | {"start_angle": angle}), {"speed": speed, "head": head})


def over_a_turn(name, parameters=None, effects=()):
    """An output at 720 equal angles of a revolution, whose sums integrate sines, but not their kinks, exactly."""
    values = []
    for angle in 2.0 * math.pi * (np.arange(720) + 0.5) / 720:
        values.append(piston(parameters, effects, angle=angle)[name])
    return np.array(values)


def test_a_single_acting_pump_peaks_at_pi_times_its_mean():
    """60 mm, 150 mm, 20 m: 0.42412 l per stroke, 13.2435 N.m in the mean, 41.606 N.m at most."""
    torque = over_a_turn("torque")
    assert pytest.approx(0.42412e-3, abs=5e-9) == VOLUME
    assert torque.mean() == pytest.approx(WEIGHT * 20.0 * VOLUME / (2.0 * math.pi), rel=1e-5)  # midpoint rule: 1/n²
    assert torque.mean() == pytest.approx(13.2435, rel=2e-5)
    assert piston(angle=0.5 * math.pi)["torque"] == pytest.approx(41.606, abs=5e-4)
    assert piston(angle=0.5 * math.pi)["torque"] == pytest.approx(math.pi * WEIGHT * 20.0 * VOLUME / (2.0 * math.pi), rel=1e-14)
    assert over_a_turn("flow").mean() == pytest.approx(VOLUME * 4.0 / (2.0 * math.pi), rel=1e-5)


def test_a_double_acting_pump_delivers_with_both_strokes():
    both = over_a_turn("torque", {"action": "double"})
    rod = over_a_turn("torque", {"action": "double", "rod_diameter": 0.03})
    assert both.mean() == pytest.approx(2.0 * over_a_turn("torque").mean(), rel=1e-12)
    assert rod.mean() == pytest.approx((2.0 - 0.25) * over_a_turn("torque").mean(), rel=1e-12)
    assert np.all(both > 0.0)


@pytest.mark.parametrize("parameters", [{}, {"action": "double", "rod_diameter": 0.02}])
def test_torque_times_speed_is_weight_times_head_times_flow(parameters):
    rng = np.random.default_rng(4)
    for _ in range(50):
        pump = piston(parameters, (), rng.uniform(0.0, 10.0), rng.uniform(0.0, 60.0), rng.uniform(0.0, 7.0))
        power = WEIGHT * pump["head"] * pump["flow"]
        assert pump["torque"] * pump["speed"] == pytest.approx(power, rel=1e-13)
        assert pump["hydraulic_power"] == pytest.approx(power, rel=1e-13)


@pytest.mark.known_answers(PistonPump=("leakage", "seal_friction"))
def test_leakage_costs_flow_and_seals_cost_torque():
    plain, lossy = (piston({}, effects, angle=1.0) for effects in ((), ("leakage", "seal_friction")))
    assert lossy["flow"] == pytest.approx(0.95 * plain["flow"], rel=1e-14)
    assert lossy["torque"] - plain["torque"] == pytest.approx(100.0 * 0.075 * math.sin(1.0), rel=1e-12)
    idle = piston({}, ("seal_friction",), angle=4.0)
    assert idle["torque"] == pytest.approx(100.0 * 0.075 * abs(math.sin(4.0)), rel=1e-14)  # the way back, too


def test_the_angle_follows_a_speed_that_changes():
    """The integral of a quadratic, exactly; turns are taken off."""
    pump = piston(speed=2.0)
    pump.u[1, 0], pump.u[2, 0] = 3.0, 1.0
    pump.step(0.0, 2.0)
    assert pump["angle"] == pytest.approx((4.0 + 6.0 + 8.0 / 3.0) % (2.0 * math.pi), abs=1e-13)
    assert 0.0 <= piston(angle=-1e-18)["angle"] < 2.0 * math.pi


def test_volume_of_a_stroke_passes_in_a_revolution():
    pump, volume = piston(speed=2.0), 0.0
    h = math.pi / 1000.0
    for k in range(1000):  # one revolution; Simpson's rule with the flow at both ends and in the middle
        first = pump["flow"]
        pump.step(k * h, 0.5 * h)
        middle = pump["flow"]
        pump.step((k + 0.5) * h, 0.5 * h)
        volume += h / 6.0 * (first + 4.0 * middle + pump["flow"])
    assert volume == pytest.approx(VOLUME, rel=1e-9)


# -- centrifugal -----------------------------------------------------------------------------------------------------------
def centrifugal(speed, head, parameters=None, effects=()):
    """A centrifugal pump at a speed against a head."""
    return initialized(CentrifugalPump(effects, parameters), {"speed": speed, "head": head})


@pytest.mark.parametrize("factor", [0.01, 0.5, 1.7])
def test_affinity_laws(factor):
    """At n times the speed and n² times the head: n times the flow, n² times the torque, n³ times the power."""
    one, other = centrifugal(150.0, 18.0), centrifugal(factor * 150.0, factor**2 * 18.0)
    assert other["flow"] == pytest.approx(factor * one["flow"], rel=1e-12)
    assert other["torque"] == pytest.approx(factor**2 * one["torque"], rel=1e-12)
    assert other["hydraulic_power"] == pytest.approx(factor**3 * one["hydraulic_power"], rel=1e-12)


@pytest.mark.parametrize("share", [0.2, 1.0, 1.5])
def test_efficiency_is_the_parabola(share):
    head = 30.0 - 2e3 * share * 1.2e-3 - 5.3e6 * (share * 1.2e-3) ** 2
    pump = centrifugal(150.0, head)
    assert pump["flow"] == pytest.approx(share * 1.2e-3, rel=1e-12)
    efficiency = pump["hydraulic_power"] / (pump["torque"] * 150.0)
    assert efficiency == pytest.approx(0.55 * (2.0 * share - share**2), rel=1e-12)


def test_behind_a_closed_valve_and_at_standstill_the_torque_is_an_ordinary_number():
    closed, barely = centrifugal(150.0, 30.0), centrifugal(150.0, 30.0 - 1e-9)
    assert closed["flow"] == 0.0
    assert closed["torque"] == pytest.approx(WEIGHT * 30.0 * 1.2e-3 / (0.55 * 2.0 * 150.0), rel=1e-14)
    assert barely["torque"] == pytest.approx(closed["torque"], rel=1e-4)
    for speed in (0.0, -3.0):
        at_rest = centrifugal(speed, 10.0)
        assert [at_rest[n] for n in at_rest.outputs] == [0.0, 0.0, 0.0]
    assert centrifugal(1e-200, 0.0)["torque"] == 0.0
    assert centrifugal(150.0, -5.0)["flow"] == centrifugal(150.0, 0.0)["flow"]


@pytest.mark.known_answers(CentrifugalPump="seal_friction")
def test_seals_are_felt_at_standstill():
    assert centrifugal(0.0, 10.0, None, ["seal_friction"])["torque"] == 0.2
