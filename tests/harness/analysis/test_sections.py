"""Sections of motions whose points are known."""

import numpy as np
import pytest
from cosimo.orchestrator.harness.analysis.sections import crossings, distinct, section, swing_frequency

TIME = np.arange(0.0, 20.0, 2e-3)
TURN = 2 * np.pi
SPLINE = 1e-6  # fourth power of the step times the fourth derivative here: (2e-3 * 14)^4 * 5 / 384, and the ends


def test_points_of_a_period_are_one_and_of_a_subharmonic_two():
    angle = 7.0 * TIME
    x, y, half = section(angle % TURN, TURN, np.cos(angle), np.sin(2 * angle), np.cos(0.5 * angle))
    assert len(x) == 1 + int(140.0 / TURN)
    assert x == pytest.approx(1.0, abs=SPLINE)
    assert y == pytest.approx(0.0, abs=SPLINE)
    assert distinct(np.stack((x, y), axis=1), 1e-3) == 1
    assert distinct(np.stack((x, y, half), axis=1), 1e-3) == 2
    (thirds,) = section(angle, TURN / 3.0, np.cos(angle))
    assert distinct(thirds[:, None], 1e-3) == 2  # cos at 0, 120 and 240 degrees


def test_a_shaft_that_turns_the_other_way_gives_the_same_section():
    angle = 7.0 * TIME + 1.0
    (forward,), (backward,) = section(angle, TURN, np.cos(angle - 0.5)), section(-angle, TURN, np.cos(angle - 0.5))
    assert backward == pytest.approx(forward, abs=SPLINE)
    assert forward == pytest.approx(np.cos(0.5), abs=SPLINE)


def test_crossings_lie_on_the_surface_where_it_rises():
    x, y = crossings(TIME, np.sin(3 * TIME), np.cos(3 * TIME), np.sin(3 * TIME))
    assert len(x) in (9, 10)  # 60 rad; the first crossing is the first sample
    assert x == pytest.approx(1.0, abs=SPLINE)
    assert y == pytest.approx(0.0, abs=SPLINE)
    assert crossings(TIME, 2.0 + np.sin(TIME), TIME)[0].size == 0


def test_points_of_a_circle_are_one_group_when_gaps_are_bridged():
    phi = np.linspace(0, TURN, 200, endpoint=False)
    circle = np.stack((np.cos(phi), np.sin(phi)), axis=1)
    assert distinct(circle, 0.04) == 1  # neighbours are 0.0314 apart
    assert distinct(circle, 0.03) == 200


def test_the_frequency_of_a_swing_is_read_off_samples():
    t = np.linspace(0.0, 20.0, 4001)
    assert swing_frequency(t, np.cos(5.0 * t + 0.3)) == pytest.approx(5.0, rel=1e-7)
