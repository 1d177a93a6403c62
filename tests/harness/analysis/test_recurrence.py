"""Recurrence quantification of matrices counted by hand, and of signals whose measures are known in closed form."""

import numpy as np
import pytest
from cosimo.orchestrator.harness.analysis.recurrence import (
    embed,
    line_survival,
    quantify,
    recurrence_matrix,
    run_lengths,
    standardised,
)
from scipy.special import erf

SAME = 1e-12  # sums of a few shares, in different order


def symmetric(n, *pairs):
    matrix = np.eye(n, dtype=bool)
    for i, j in pairs:
        matrix[i, j] = matrix[j, i] = True
    return matrix


def counted(matrix, shortest, theiler):
    """All measures by looking at one point after the other."""
    n = len(matrix)
    at = lambda i, j: 0 <= i < n and 0 <= j < n and abs(i - j) >= theiler and matrix[i, j]  # noqa: E731

    def lines(di, dj):
        found = []
        for i in range(n):
            for j in range(n):
                if at(i, j) and not at(i - di, j - dj):
                    length = 1
                    while at(i + length * di, j + length * dj):
                        length += 1
                    found.append(length)
        return found

    diagonal, vertical = lines(1, 1), lines(0, 1)
    pairs = sum(abs(i - j) >= theiler for i in range(n) for j in range(n))
    long, tall = ([x for x in found if x >= shortest] for found in (diagonal, vertical))
    p = [long.count(x) / len(long) for x in sorted(set(long))]
    return {
        "rate": sum(diagonal) / pairs,
        "determinism": sum(long) / sum(diagonal) if diagonal else 0.0,
        "mean_diagonal": sum(long) / len(long) if long else np.nan,
        "longest_diagonal": max(long, default=0),
        "entropy": -sum(x * np.log(x) for x in p),
        "laminarity": sum(tall) / sum(vertical) if vertical else 0.0,
        "trapping_time": sum(tall) / len(tall) if tall else np.nan,
        "longest_vertical": max(tall, default=0),
    }


@pytest.mark.parametrize("theiler", [1, 2, 5])
@pytest.mark.parametrize("shortest", [2, 3])
@pytest.mark.parametrize("density", [0.0, 0.15, 0.5, 0.9, 1.0])
def test_counting_agrees_with_looking_at_every_point(density, shortest, theiler):
    rng = np.random.default_rng(11)
    for n in (6, 17, 30):
        upper = np.triu(rng.random((n, n)) < density)
        matrix = upper | upper.T | np.eye(n, dtype=bool)
        mine, brute = quantify(matrix, shortest, theiler), counted(matrix, shortest, theiler)
        for name, value in brute.items():
            assert getattr(mine, name) == pytest.approx(value, abs=SAME, nan_ok=True), (name, n)


def test_measures_of_a_matrix_counted_by_hand():
    # Above the main diagonal: a line of three (0,2)(1,3)(2,4), a line of two (0,5)(1,6), single points (3,7) and (4,7).
    q = quantify(symmetric(8, (0, 2), (1, 3), (2, 4), (0, 5), (1, 6), (3, 7), (4, 7)))
    assert q.rate == pytest.approx(14 / 56, abs=SAME)
    assert q.determinism == pytest.approx(5 / 7, abs=SAME)
    assert q.mean_diagonal == 2.5
    assert q.longest_diagonal == 3
    assert q.divergence == pytest.approx(1 / 3, abs=SAME)
    assert q.entropy == pytest.approx(np.log(2.0), abs=SAME)  # two lengths, one line each
    # Columns by row index: 7 holds 3, 4 (a line of two), row 7 is the same read along; no other neighbours.
    assert q.laminarity == pytest.approx(2 / 14, abs=SAME)
    assert q.trapping_time == 2.0


def test_entropy_weighs_lengths_by_their_number():
    # Three lines of two, one of three, all on different diagonals.
    q = quantify(symmetric(12, (0, 3), (1, 4), (0, 5), (1, 6), (0, 7), (1, 8), (0, 9), (1, 10), (2, 11)))
    assert q.entropy == pytest.approx(-(0.75 * np.log(0.75) + 0.25 * np.log(0.25)), abs=SAME)
    assert q.mean_diagonal == pytest.approx(9 / 4, abs=SAME)


def test_theiler_window_takes_out_pairs_and_ends_vertical_lines():
    matrix = np.abs(np.subtract.outer(np.arange(20), np.arange(20))) <= 3  # a slow drift: only neighbours in time recur
    assert quantify(matrix, theiler=1).determinism == 1.0
    narrow = quantify(matrix, theiler=3)
    assert narrow.rate == pytest.approx(17 / (17 * 18 / 2), abs=SAME)  # the diagonal j - i = 3 of the pairs from 3 on
    assert narrow.longest_diagonal == 17
    assert narrow.longest_vertical == 0
    empty = quantify(matrix, theiler=4)
    assert (empty.rate, empty.determinism, empty.laminarity, empty.entropy) == (0.0, 0.0, 0.0, 0.0)
    assert np.isnan(empty.mean_diagonal)
    assert np.isnan(empty.trapping_time)
    assert empty.divergence == np.inf


def test_runs_do_not_cross_rows():
    assert run_lengths(np.array([[1, 1, 0], [0, 0, 1], [1, 0, 1]], dtype=bool)).tolist() == [2, 1, 1, 1]


def test_survival_counts_the_lines_of_at_least_each_length():
    assert line_survival(symmetric(8, (0, 2), (1, 3), (2, 4), (0, 5), (1, 6), (3, 7), (4, 7))).tolist() == [4, 2, 1]


@pytest.mark.parametrize("metric", ["euclidean", "maximum"])
def test_white_noise_recurs_as_often_as_its_distribution_says(metric):
    # One coordinate: both metrics are |x - y| < eps with x - y normal of variance 2, so RR = erf(eps / 2).
    eps = 0.3
    x = np.random.default_rng(3).normal(size=(2000, 1))
    q = quantify(recurrence_matrix(x, eps, metric))
    # The rate is a U-statistic: standard deviation 2 std(p) / sqrt(n), p(x) = P(|y - x| < eps); std(p) < 0.3 of its mean here.
    assert q.rate == pytest.approx(erf(eps / 2.0), rel=4 * 2 * 0.4 / np.sqrt(2000))
    # Along a diagonal the points are independent: a recurrent one stands alone with probability (1 - p)^2.
    p = q.rate
    assert q.determinism == pytest.approx(1.0 - (1.0 - p) ** 2, abs=0.01)  # 330 000 points: 4 sigma are 0.004
    assert q.mean_diagonal == pytest.approx((2.0 - p) / (1.0 - p), rel=0.01)  # geometric lengths from 2 on


def test_noise_in_two_coordinates_is_less_recurrent_by_the_product_in_the_maximum_norm():
    eps = 0.1
    one = 2 * eps - eps**2  # P(|x - y| <= eps) on the unit interval
    noise = np.random.default_rng(8).uniform(size=(10, 1000, 2))
    rates = [quantify(recurrence_matrix(x, eps, "maximum")).rate for x in noise]
    # One rate scatters by 2 std(p) / sqrt(n) = 1.1 % and by the pairs' own share, together 1.4 %.
    assert np.mean(rates) == pytest.approx(one**2, rel=4 * 0.014 / np.sqrt(10))


def test_a_sine_is_determined_whatever_the_sampling():
    for per_period in (40.0, 16.0 * np.sqrt(5.0)):
        t = np.arange(800) / per_period
        states = np.stack((np.sin(2 * np.pi * t), np.cos(2 * np.pi * t)), axis=1)
        q = quantify(recurrence_matrix(states, 0.5))
        # The corners of the triangle cut the last lines short: of 800 diagonals at most a handful there have one point.
        assert q.determinism > 0.9999
        # Chord 2 sin(phi / 2) <= eps: an arc of 2 * 2 asin(eps / 2), of which whole samples count.
        arc = 2 * np.arcsin(0.25) / (2 * np.pi) * per_period  # samples to either side
        assert q.trapping_time == pytest.approx(2 * arc, abs=1.0)
    assert q.longest_diagonal > 800 - 3 * per_period


def test_a_sampled_period_gives_whole_diagonals():
    x = np.tile([0.1, 0.7, 0.4], 40)
    q = quantify(recurrence_matrix(x[:, None], 1e-6))
    n = x.size
    assert q.rate == pytest.approx((n * n / 3 - n) / (n * n - n), abs=SAME)
    assert q.determinism == 1.0
    assert q.longest_diagonal == n - 3
    assert q.mean_diagonal == n / 2  # lengths 3, 6 ... n - 3
    assert q.entropy == pytest.approx(np.log(n / 3 - 1), abs=SAME)  # each length once
    assert q.laminarity == 0.0


def test_embedding_is_delayed_copies():
    states = embed(np.arange(10.0), 3, 2)
    assert states.shape == (6, 3)
    assert states[0].tolist() == [0.0, 2.0, 4.0]
    assert states[-1].tolist() == [5.0, 7.0, 9.0]


def test_standardised_states_are_centred_and_of_one_size_and_a_still_one_is_zero():
    rng = np.random.default_rng(1)
    states = np.stack((rng.normal(3.0, 2e-6, 500), rng.normal(0.0, 1e3, 500), np.full(500, 0.1) * (1 + 1e-16)), axis=1)
    z = standardised(states)
    assert z.mean(axis=0) == pytest.approx(0.0, abs=1e-8)  # one rounding of 3.0 over 2e-6, and its mean
    assert z[:, :2].std(axis=0) == pytest.approx(1.0, abs=SAME)
    assert (z[:, 2] == 0.0).all()
