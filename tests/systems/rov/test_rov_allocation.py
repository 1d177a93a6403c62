"""Thrusts for a wrench: the inverse where it exists, the priorities where it does not, one scale for all within the limits."""

import numpy as np
import pytest
from cosimo.components.rov.allocation import allocate, allocation_of, chosen, share_out
from cosimo.components.rov.arrangement import eight_arrangement, wrench_matrix, y_arrangement
from scipy.optimize import linprog, minimize

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


EIGHT = wrench_matrix(*eight_arrangement())


def shared(matrix, wrench, choice, priority=None):
    """As `given`, of any number of thrusters, with the smallest thrusts within the limits."""
    n = matrix.shape[1]
    wrench, priority = np.asarray(wrench, dtype=float), np.ones(6) if priority is None else priority
    thrust, out, room = np.full(n, np.nan), np.full(6, np.nan), np.full((4, n, n + 6), np.nan)
    left = np.full((n, 6), np.nan), room, np.full((6, n), np.nan)
    return share_out(wrench, priority, matrix, choice, FORWARD, REVERSE, thrust, out, *left), thrust, out


def attainable(matrix, wrench):
    """Largest part of a wrench, at most 1, by a linear programme."""
    n = matrix.shape[1]
    bounds = [(-REVERSE, FORWARD)] * n + [(0.0, 1.0)]
    answer = linprog(np.r_[np.zeros(n), -1.0], A_eq=np.c_[matrix, -wrench], b_eq=np.zeros(6), bounds=bounds)
    return answer.x[-1]


@pytest.mark.parametrize("priority", [None, PRIORITY])
def test_more_than_six_thrusters_give_all_that_their_unequal_limits_allow(priority):
    """In random directions, and in the plane, where the regular arrangement has several thrusters at their limits at once."""
    rng = np.random.default_rng(3)
    angles = np.linspace(0.0, 2.0 * np.pi, 9)[:-1]
    flat = [(EIGHT, 200.0 * np.array([np.cos(a), np.sin(a), 0.0, 0.0, 0.0, 0.0])) for a in angles]
    wide = [(rng.normal(size=(6, n)), 100.0 * rng.normal(size=6)) for n in (7, 8, 9, 10)]
    more = 0
    for matrix, wrench in [*flat, *wide, *((EIGHT, w) for w in rng.normal(size=(20, 6)) * [60.0, 60.0, 60.0, 9.0, 9.0, 9.0])]:
        n = matrix.shape[1]
        scale, thrust, out = shared(matrix, wrench, 2**n - 1, priority)
        assert scale == pytest.approx(attainable(matrix, wrench), abs=1e-9)
        np.testing.assert_allclose(out, scale * wrench, atol=1e-7)
        assert thrust.max() < FORWARD + 1e-9
        assert thrust.min() > -REVERSE - 1e-9
        more += scale > 1.02 * allocate(
            wrench, allocation_of(matrix, np.ones(6), 2**n - 1), matrix, FORWARD, REVERSE, np.zeros(n), np.zeros(6)
        )
    assert more > 10


def test_within_the_limits_the_shared_thrusts_are_the_smallest():
    """By another programme (SLSQP), where the pseudo-inverse alone would pass a limit."""
    rng = np.random.default_rng(5)
    tried = 0
    for wrench in rng.normal(size=(60, 6)) * [60.0, 60.0, 60.0, 9.0, 9.0, 9.0]:
        scale, thrust, _ = shared(EIGHT, wrench, 255)
        if scale < 1.0 or np.abs(np.linalg.pinv(EIGHT) @ wrench).max() < REVERSE:
            continue
        tied = {"type": "eq", "fun": lambda p, w=wrench: EIGHT @ p - w, "jac": lambda p: EIGHT}
        least = minimize(lambda p: 1e-3 * p @ p, thrust + rng.normal(size=8), bounds=[(-REVERSE, FORWARD)] * 8, constraints=tied,
                         method="SLSQP", options={"ftol": 1e-13})  # fmt: skip
        np.testing.assert_allclose(thrust, least.x, atol=1e-4)
        tried += 1
    assert tried > 3


def test_shared_thrusts_change_continuously_and_one_that_is_lost_is_not_asked():
    wrench, before = np.array([0.0, 1.0, 0.3, 0.05, 0.0, 0.02]), None
    for size in np.linspace(1.0, 150.0, 300):
        _, thrust, _ = shared(EIGHT, size * wrench, 255 - 4)
        assert thrust[2] == 0.0
        assert before is None or np.abs(thrust - before).max() < 1.5
        before = thrust
    lost = np.delete(EIGHT, 2, axis=1)
    assert shared(EIGHT, 150.0 * wrench, 255 - 4)[0] == pytest.approx(attainable(lost, 150.0 * wrench), abs=1e-9)


def test_without_any_wrench_or_thruster_nothing_is_shared():
    for wrench, choice in ((np.zeros(6), 255), (np.ones(6), 0)):
        _, thrust, out = shared(EIGHT, wrench, choice)
        assert not thrust.any()
        assert not out.any()
