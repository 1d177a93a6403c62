"""The closed forms of the case `recurrence` are right by themselves: by sampling, by counting, by limits."""

import numpy as np
import pytest
from cosimo.orchestrator.systems.bearings.cases import recurrence


def test_measures_of_noise_by_drawing_columns_and_diagonals_at_random():
    """Not from a matrix: pairs drawn on their own, columns that share one state."""
    eps, rng = 0.5, np.random.default_rng(6)
    exact = recurrence.of_noise(eps)
    pair = np.abs(rng.normal(size=(400_000, 5)) - rng.normal(size=(400_000, 5))) <= eps  # five points along diagonals
    assert pair.mean() == pytest.approx(exact["RR"], abs=4e-3)  # 4 sigma of 2 million draws are 1.3e-3
    middle = pair[pair[:, 2]]
    assert (middle[:, 1] | middle[:, 3]).mean() == pytest.approx(exact["DET"], abs=8e-3)  # 4 sigma of 100 000 are 6e-3
    column = np.abs(rng.normal(size=(400_000, 1)) - rng.normal(size=(400_000, 3))) <= eps
    hit = column[column[:, 1]]
    assert (hit[:, 0] | hit[:, 2]).mean() == pytest.approx(exact["LAM"], abs=8e-3)


def test_entropy_and_mean_of_geometric_lengths_are_their_sums():
    p = recurrence.of_noise(0.3)["RR"]
    lengths = np.arange(2, 400)
    shares = (1 - p) * p ** (lengths - 2.0)
    assert recurrence.of_noise(0.3)["L"] == pytest.approx(shares @ lengths, rel=1e-12)
    assert recurrence.of_noise(0.3)["ENTR"] == pytest.approx(-(shares * np.log(shares))[shares > 0].sum(), rel=1e-12)
    half = 0.5 ** (lengths - 1.0)
    assert recurrence.of_doubling(0.01)["L"] == pytest.approx(half @ lengths, rel=1e-12)
    assert recurrence.of_doubling(0.01)["ENTR"] == pytest.approx(-half @ np.log(half), rel=1e-12)


def test_coordinate_makes_the_logistic_map_a_tent():
    x = recurrence.logistic(4.0, 0.2)
    y = recurrence.uniform(x)[:, 0]
    assert y[1:] == pytest.approx(1.0 - np.abs(1.0 - 2.0 * y[:-1]), abs=1e-7)  # asin near 1: the root of a rounding
    assert np.histogram(y, 10, (0, 1))[0] == pytest.approx(200, abs=60)  # 4 sigma of independent points


@pytest.mark.parametrize(("r", "period"), recurrence.WINDOWS.items())
def test_windows_have_their_period(r, period):
    x = recurrence.logistic(r, 0.3, settle=100_000, states=4 * period)[:, 0]
    assert x[period:] == pytest.approx(x[:-period], abs=1e-12)
    assert np.unique(x.round(9)).size == period
