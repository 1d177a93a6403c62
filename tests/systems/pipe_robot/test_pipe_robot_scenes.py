"""What the scenes of pipe robots must show: speeds, the slope that ends a climb, standstill, resonance, capture, a rope."""

import math

import numpy as np
import pytest
from cosimo.orchestrator.systems import load_scene
from cosimo.orchestrator.systems.pipe_robot.records import mean_speed, robots
from cosimo.tests.scene_runs import finished

pytestmark = pytest.mark.full


def late_speed(result, unit, begin, period):
    """Mean speed over whole periods from about `begin` on."""
    t, x = result.time, result[f"{unit}.position"]
    count = math.floor((t[-1] - begin) / period)
    return float(x[-1] - np.interp(t[-1] - count * period, t, x)) / (count * period)


def test_both_robots_travel_in_a_level_pipe():
    result = finished(load_scene("pipe-robot-level"))
    period = 2.0 * math.pi / 60.0
    # the same motion by a matrix exponential between switches; 2 ms between samples are 1e-4 of the way at their ends
    assert late_speed(result, "bristles", 2.0, period) == pytest.approx(0.36016773, rel=2e-4)
    assert late_speed(result, "rings", 2.0, period) > late_speed(result, "bristles", 2.0, period)
    assert result["rings.grip"].max() < 1.0


def test_the_climb_ends_at_the_slope_at_which_robots_turn_back_and_the_exact_one_stands_there():
    """The weight is (8 N - 2 N) / 2 at 0.2053 rad; towards it the mean speed dies away."""
    scene = load_scene("pipe-robot-climb")
    result = finished(scene)
    steepest = math.asin(3.0 / (1.5 * 9.81))
    for unit in ("exact", "lugre", "smoothed"):
        assert 0.85 * steepest < result[f"{unit}_pipe.slope"].max() < steepest
    rest = result.time >= 17.0
    assert not result["exact.velocity"][rest].any()
    assert np.ptp(result["exact.position"][rest]) == 0.0
    for unit in ("lugre", "smoothed"):
        way = result[f"{unit}.position"][rest]
        assert abs(way[-1] - way[0]) > 5e-3


def test_a_sweep_finds_the_resonance_and_a_stiffening_spring_jumps():
    """The straight spring peaks near 77.5 rad/s both ways; the stiffening one falls off later than it jumps back on."""
    result = finished(load_scene("pipe-robot-resonance"))
    rising = result.time <= 30.0
    w = result["program.frequency"]
    peaks = {}
    for record in robots(result):
        speed = np.nan_to_num(mean_speed(record))
        peaks[record.unit] = [float(w[part][np.argmax(speed[part])]) for part in (rising, ~rising)]
    assert peaks["straight"] == pytest.approx([77.46, 77.46], abs=3.0)  # the sweep passes 3.3 rad/s in a second
    up, down = peaks["stiffening"]
    assert up > down + 5.0 > 77.46 + 15.0


def test_the_weak_motor_is_caught_and_the_strong_one_passes():
    result = finished(load_scene("pipe-robot-motor-start"))
    late = result.time > 8.0
    caught, passing = (result[f"{n}.unbalance.rate"][late] for n in ("caught", "passing"))
    assert 63.25 < caught.mean() < 77.46
    assert passing.mean() > 2.0 * 77.46
    period = 2.0 * math.pi / caught.mean()
    assert late_speed(result, "caught", 8.0, period) > 5.0 * late_speed(result, "passing", 8.0, period) > 0.0
    for bond in result.info.energy.values():
        assert abs(bond.created) < 1e-3 * bond.exchanged


def test_a_rope_only_pulls_and_both_robots_come_along():
    result = finished(load_scene("pipe-robots-in-tow"))
    force = result["rope.rear_force"]
    assert force.min() == 0.0
    assert force.max() > 1.0
    np.testing.assert_array_equal(result["rope.front_force"], -force)
    late = result.time > 4.0
    speeds = [np.ptp(result[f"{n}.position"][late]) / np.ptp(result.time[late]) for n in ("front", "rear")]
    assert speeds[0] == pytest.approx(speeds[1], rel=0.02)  # the distance beats by some mm over 1.6 m
    for bond in result.info.energy.values():
        assert abs(bond.created) < 0.01 * bond.exchanged
