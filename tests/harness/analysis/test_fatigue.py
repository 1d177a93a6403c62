"""Rainflow counting and Miner's sum against a worked example and closed forms."""

import numpy as np
import pytest
from cosimo.orchestrator.harness.analysis.fatigue import Endurance, rainflow, turning_points


def test_worked_example_of_the_standard() -> None:
    cycles = rainflow([-2.0, 1.0, -3.0, 5.0, -1.0, 3.0, -4.0, 4.0, -2.0])
    counted = {float(r): float(cycles.counts[cycles.ranges == r].sum()) for r in np.unique(cycles.ranges)}
    assert counted == {3.0: 0.5, 4.0: 1.5, 6.0: 0.5, 8.0: 1.0, 9.0: 0.5}


def test_sine_with_a_ripple_has_one_large_cycle_a_period_and_its_ripples() -> None:
    t = np.arange(0.0, 10.0, 1e-3)
    slow, both = rainflow(np.sin(2.0 * np.pi * t)), rainflow(np.sin(2.0 * np.pi * t) + 0.2 * np.sin(40.0 * np.pi * t))
    assert slow.counts[slow.ranges > 1.9].sum() == pytest.approx(9.5)
    assert slow.counts.sum() == pytest.approx(10.25, abs=0.3)
    assert both.counts[both.ranges > 1.9].sum() == pytest.approx(9.5, abs=0.6)
    assert both.counts[both.ranges < 0.5].sum() > 100.0


def test_turning_points_leave_out_what_is_no_extreme() -> None:
    assert turning_points([0.0, 1.0, 1.0, 2.0, 2.0, 1.0, -1.0, 0.0]).tolist() == [0.0, 2.0, -1.0, 0.0]
    assert turning_points([]).size == 0
    assert turning_points([3.0, 3.0]).tolist() == [3.0]
    assert rainflow([1.0]).counts.size == 0


def test_damage_of_a_constant_amplitude() -> None:
    line = Endurance(100.0, 2e6, 5.0)
    cycles = rainflow([0.0] + 1000 * [50.0, -50.0])
    assert line.damage(cycles) == pytest.approx(1000.0 / 2e6 * 0.5**5, rel=2e-3)
    assert line.damage(rainflow(1000 * [400.0, 200.0])) == pytest.approx(line.damage(rainflow(1000 * [100.0, -100.0])), rel=1e-12)


def test_a_mean_stress_shortens_life() -> None:
    pulsating, alternating = (rainflow(100 * [m + 50.0, m - 50.0]) for m in (50.0, 0.0))
    line = Endurance(100.0, 2e6, 5.0, ultimate=400.0)
    assert line.damage(pulsating) / line.damage(alternating) == pytest.approx((1.0 - 50.0 / 400.0) ** -5, rel=1e-12)
    assert line.damage(rainflow([0.0, 900.0, 0.0, 900.0])) == float("inf")
