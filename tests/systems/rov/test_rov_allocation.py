"""Thrusts for a wrench: the inverse where it exists, the priorities where it does not, one scale for all within the limits."""

import numpy as np
import pytest
from cosimo.components.rov.allocation import allocate, allocation_of, chosen
from cosimo.components.rov.arrangement import wrench_matrix, y_arrangement

FORWARD, REVERSE = 51.44, 39.90
MATRIX = wrench_matrix(*y_arrangement())
PRIORITY = np.array([1.0, 1.0, 100.0, 1.0, 1.0, 500.0])
TABLES = np.array([allocation_of(MATRIX, PRIORITY, choice) for choice in range(64)])
ALL = 63
# Largest wrench along one axis with the limits above, both ways, N and N.m, computed independently from the thrusters' places
LARGEST = [(69.11, -69.11), (77.15, -59.86), (154.3, -119.7), (15.55, -15.55), (13.47, -17.36), (23.34, -18.11)]


def given(wrench, choice: int = ALL):
    """Scale, thrusts and the wrench that comes of them."""
    thrust, out = np.zeros(6), np.zeros(6)
    scale = allocate(np.asarray(wrench, dtype=float), TABLES[choice], MATRIX, FORWARD, REVERSE, thrust, out)
    return scale, thrust, out


def test_all_thrusters_give_every_small_wrench():
    rng = np.random.default_rng(1)
    for wrench in rng.normal(size=(50, 6)):
        scale, thrust, out = given(wrench)
        assert scale == 1.0
        np.testing.assert_allclose(thrust, np.linalg.solve(MATRIX, wrench), atol=1e-12)
        np.testing.assert_allclose(out, wrench, atol=1e-12)


@pytest.mark.parametrize("axis", range(6))
@pytest.mark.parametrize("way", [0, 1])
def test_the_largest_wrench_along_each_axis(axis, way):
    wrench = np.zeros(6)
    wrench[axis] = (1e4, -1e4)[way]
    _, _, out = given(wrench)
    assert out[axis] == pytest.approx(LARGEST[axis][way], abs=0.06)  # the printed digits
    np.testing.assert_allclose(np.delete(out, axis), 0.0, atol=1e-10)


def test_beyond_the_limits_the_direction_stays():
    """And one thruster is at its limit, ahead or astern, so that no more could be had along this direction."""
    rng = np.random.default_rng(2)
    for wrench in rng.normal(size=(200, 6)) * 300.0:
        scale, thrust, out = given(wrench)
        assert 0.0 < scale < 1.0
        np.testing.assert_allclose(out, scale * wrench, rtol=1e-10, atol=1e-9)
        assert max((thrust / FORWARD).max(), (-thrust / REVERSE).max()) == pytest.approx(1.0, rel=1e-14)


@pytest.mark.parametrize("lost", range(6))
def test_without_a_thruster_the_rank_is_five_and_depth_and_heading_are_kept(lost):
    there = np.delete(np.arange(6), lost)
    assert np.linalg.matrix_rank(MATRIX[:, there]) == 5
    choice = ALL - (1 << lost)
    rng = np.random.default_rng(lost)
    for wrench in rng.normal(size=(20, 6)):
        _, thrust, out = given(wrench, choice)
        assert thrust[lost] == 0.0
        best, *_ = np.linalg.lstsq(PRIORITY[:, None] * MATRIX[:, there], PRIORITY * wrench, rcond=None)
        np.testing.assert_allclose(thrust[there], best, atol=1e-10)
        # what is given up is one direction of the wrench; its share in an axis goes with the inverse square of the priority
        miss = wrench - out
        assert abs(miss[2]) <= 1e-3 * np.abs(miss).max() + 1e-12
        assert abs(miss[5]) <= 1e-3 * np.abs(miss).max() + 1e-12


@pytest.mark.parametrize("choice", range(64))
def test_what_is_not_available_is_never_asked_for(choice):
    away = [i for i in range(6) if not choice >> i & 1]
    assert not TABLES[choice, away].any()
    assert np.isfinite(TABLES[choice]).all()


def test_an_arrangement_without_pitch_gets_the_best_it_can():
    """Six thrusters of which two push along the same line: rank 5 from the start, and no division by zero."""
    matrix = MATRIX.copy()
    matrix[:, 5] = matrix[:, 4]
    table = allocation_of(matrix, np.ones(6), ALL)
    assert np.linalg.matrix_rank(matrix) == 5
    np.testing.assert_allclose(matrix @ table @ matrix, matrix, atol=1e-12)  # every wrench it can give, it gives
    assert table[4] == pytest.approx(table[5])  # and shares between the two


def test_a_thruster_is_there_above_one_half():
    inputs = np.array([9.0, 9.0, 1.0, 0.4, 1.0, 0.0, 0.6, 0.5])
    assert chosen(inputs, 2, 6) == 0b010101
