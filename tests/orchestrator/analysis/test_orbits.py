"""Sections of motions whose points are known."""

import numpy as np
import pytest

from components.core.errors import BadInput
from orchestrator.analysis.orbits import bifurcation, crossings, distinct, stroboscopic

TIME = np.arange(0.0, 20.0, 2e-3)
SPLINE = 1e-6  # fourth power of the step times the fourth derivative here: (2e-3 * 14)^4 * 5 / 384, and the ends


def test_stroboscopic_points_of_a_period_are_one_and_of_a_subharmonic_two():
    angle = 7.0 * TIME
    x = np.stack((np.cos(angle), np.sin(2 * angle), np.cos(0.5 * angle)), axis=1)
    points = stroboscopic(angle % (2 * np.pi), x)
    assert len(points) == 1 + int(140.0 / (2 * np.pi))
    assert points[:, 0] == pytest.approx(1.0, abs=SPLINE)
    assert points[:, 1] == pytest.approx(0.0, abs=SPLINE)
    assert distinct(points[:, :2], 1e-3) == 1
    assert distinct(points, 1e-3) == 2
    assert distinct(stroboscopic(angle, x[:, :1], per_turn=3.0), 1e-3) == 2  # cos at 0, 120 and 240 degrees


def test_section_with_an_offset_and_in_reverse():
    angle = 7.0 * TIME
    for direction in (1.0, -1.0):
        points = stroboscopic(direction * angle, np.sin(angle)[:, None], offset=direction * np.pi / 2)
        assert points == pytest.approx(1.0, abs=SPLINE)


def test_turning_back_is_refused():
    with pytest.raises(BadInput, match="turns back"):
        stroboscopic(np.sin(TIME), TIME[:, None])


def test_crossings_lie_on_the_surface_where_it_rises():
    states = np.stack((np.cos(3 * TIME), np.sin(3 * TIME)), axis=1)
    points = crossings(TIME, np.sin(3 * TIME), states)
    assert len(points) in (9, 10)  # 60 rad; the first crossing is the first sample
    assert points == pytest.approx(np.tile([1.0, 0.0], (len(points), 1)), abs=SPLINE)
    assert crossings(TIME, 2.0 + np.sin(TIME), states).shape == (0, 2)


def test_points_of_a_circle_are_one_group_when_gaps_are_bridged():
    phi = np.linspace(0, 2 * np.pi, 200, endpoint=False)
    circle = np.stack((np.cos(phi), np.sin(phi)), axis=1)
    assert distinct(circle, 0.04) == 1  # neighbours are 0.0314 apart
    assert distinct(circle, 0.03) == 200


def test_bifurcation_points_keep_their_parameter():
    p, v = bifurcation([1.0, 2.0], [np.array([[5.0], [6.0]]), np.array([7.0])])
    assert p.tolist() == [1.0, 1.0, 2.0]
    assert v.tolist() == [5.0, 6.0, 7.0]
    assert bifurcation([], [])[0].size == 0
    with pytest.raises(BadInput, match="each value"):
        bifurcation([1.0], [])
