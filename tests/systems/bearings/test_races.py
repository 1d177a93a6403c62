"""Waviness and defects of races and balls against their formulas, evaluated the slow way, and against their own derivatives."""

import math

import numpy as np
import pytest
from cosimo.components.bearings.geometry import BallGeometry
from cosimo.components.bearings.races import Waviness, add_ball_pit, add_pit, add_waves, develop, pit_profile, smooth_pit, wrapped

ORDER = np.array([2, 7, 9, 16])
AMPLITUDE = np.array([1e-6, 0.3e-6, 0.0, 0.2e-6])
PHASE = np.array([0.1, -0.7, 0.3, 2.0])
GAP_ACCURACY = 1e-20  # m; some 30 roundings of 1e-6 m


def race_waves(order, amplitude, phase, balls):
    """What `add_waves` asks for."""
    waves, table = Waviness.Values(np.array(order), np.array(amplitude), np.array(phase)), np.zeros((2, len(order), balls))
    develop(waves, table)
    return waves, table


def gaps(add, angle, speed, what, balls=8, with_rate=True):
    gap, rate = np.zeros(balls), np.zeros(balls)
    add(gap, rate if with_rate else None, angle, speed, *what)
    return gap, rate


@pytest.mark.parametrize("balls", [1, 7, 8])
def test_waves_are_the_sum_of_cosines(balls):
    angle = 0.83
    found, _ = gaps(add_waves, angle, 0.0, race_waves(ORDER, AMPLITUDE, PHASE, balls), balls)
    at = angle + 2.0 * np.pi * np.arange(balls) / balls
    expected = [(AMPLITUDE * np.cos(ORDER * a + PHASE)).sum() for a in at]
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=GAP_ACCURACY)


def test_an_order_that_is_a_multiple_of_the_balls_lifts_all_alike():
    """Order Z: every ball stands on the same phase, the ring is only larger; order Z + 1: the sum over the balls vanishes."""
    alike, _ = gaps(add_waves, 0.4, 0.0, race_waves([8], [1e-6], [0.0], 8))
    np.testing.assert_allclose(alike, alike[0], rtol=0.0, atol=GAP_ACCURACY)
    odd, _ = gaps(add_waves, 0.4, 0.0, race_waves([9], [1e-6], [0.0], 8))
    assert abs(odd.sum()) < GAP_ACCURACY
    assert np.abs(odd).max() > 0.5e-6


@pytest.mark.parametrize(
    ("add", "what"),
    [
        (add_waves, race_waves(ORDER, AMPLITUDE, PHASE, 8)),
        (add_pit, (smooth_pit(5e-6, 0.6, 0.9),)),
        (add_ball_pit, (smooth_pit(5e-6, 0.6, 0.9, ball=3),)),
    ],
    ids=["waves", "pit", "ball pit"],
)
def test_the_rate_is_the_derivative_of_the_gap(add, what):
    speed, h = 30.0, 1e-6
    moved = []
    for angle in np.linspace(-7.0, 7.0, 61):
        _, rate = gaps(add, angle, speed, what)
        (ahead, _), (behind, _) = (gaps(add, angle + speed * s, speed, what) for s in (h, -h))
        # central difference: rounding 1e-22/h, and (w h)² / 6 of a third derivative of A (10.5/rad w)³
        np.testing.assert_allclose(rate, (ahead - behind) / (2.0 * h), rtol=0.0, atol=1e-9)
        moved.append(np.abs(rate).max())
    assert max(moved) > 1e-5


def test_the_gap_is_the_same_where_no_rate_is_asked_for():
    for add, what in (
        (add_waves, race_waves(ORDER, AMPLITUDE, PHASE, 8)),
        (add_pit, (smooth_pit(5e-6, 0.6, 0.9),)),
        (add_ball_pit, (smooth_pit(5e-6, 0.6, 0.9, 3),)),
    ):
        with_rate, without = (gaps(add, 0.7, 30.0, what, with_rate=w)[0] for w in (True, False))
        assert with_rate.tobytes() == without.tobytes()


def test_pit_is_deep_in_the_middle_and_starts_without_a_kink():
    made = smooth_pit(5e-6, 0.1, 6.2)  # across the seam at 2 pi
    assert pit_profile(6.2, made) == (5e-6, 0.0)
    assert pit_profile(6.2 - 2.0 * np.pi, made)[0] == pytest.approx(5e-6, rel=1e-12)  # the angle's own rounding
    assert pit_profile(6.2 + 0.05, made)[0] == pytest.approx(0.0, abs=1e-18)
    assert pit_profile(6.2 - 0.025, made)[0] == pytest.approx(2.5e-6, rel=1e-10)  # half depth at a quarter of the width
    assert pit_profile(0.0, made)[0] == 0.0
    # depth and slope go to zero together at the edge: quadratically and linearly
    near, nearer = (pit_profile(6.2 + 0.05 - e, made) for e in (1e-4, 1e-5))
    assert near[0] / nearer[0] == pytest.approx(100.0, rel=1e-3)
    assert near[1] / nearer[1] == pytest.approx(10.0, rel=1e-3)


def test_a_narrow_pit_touches_one_ball_only():
    gap, _ = gaps(add_pit, -3.0 * 2.0 * np.pi / 8.0, 0.0, (smooth_pit(5e-6, 0.1, 0.0),))
    assert np.flatnonzero(gap).tolist() == [3]


def test_a_pit_on_a_ball_meets_both_races_in_a_turn():
    made = smooth_pit(5e-6, 0.1, 0.0, ball=2)
    spins = np.linspace(0.0, 2.0 * np.pi, 3601)[:-1]
    depth = np.array([gaps(add_ball_pit, s, 0.0, (made,))[0] for s in spins])
    assert np.flatnonzero(depth.any(axis=0)).tolist() == [1]
    assert depth[0, 1] == depth[1800, 1] == 5e-6  # at 0 on the inner, at pi on the outer race


def test_cage_and_spin_roll_without_slip():
    """The ball's surface moves with the inner race where it touches it, and rests where it touches the outer one."""
    bearing = BallGeometry(9, 7.94e-3, 39.04e-3)
    cage, spin = bearing.cage_ratio, -bearing.spin_ratio  # the ball turns against the shaft
    centre, r = 0.5 * bearing.pitch_diameter, 0.5 * bearing.ball_diameter
    # velocity of the ball's surface = that of its centre, and its turn, cage + spin in the frame at rest
    inner, outer = cage * centre - (cage + spin) * r, cage * centre + (cage + spin) * r
    assert inner == pytest.approx(centre - r, rel=1e-14)
    assert outer == pytest.approx(0.0, abs=1e-17)


def test_angles_are_wrapped_into_a_turn():
    for angle in (0.0, 1.0, -1.0, 100.0, -100.0, 2.0 * math.pi, -1e-18, math.nextafter(2.0 * math.pi, 0.0)):
        found = wrapped(angle)
        assert 0.0 <= found < 2.0 * math.pi
        assert math.cos(found) == pytest.approx(math.cos(angle), abs=1e-14)
        assert math.sin(found) == pytest.approx(math.sin(angle), abs=1e-14)
