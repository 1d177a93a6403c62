"""The campaign of coverage: intervals of shares against known cases, and how far noise alone pulls estimates."""

from __future__ import annotations

import cosimo
import numpy as np
import pytest
from cosimo.components.core.kernels import COMPILED
from cosimo.tests.campaigns.coverage import MACHINES, Coverage, chances, coverage, draws, interval, springs
from scipy.stats import binomtest, chi2


@pytest.mark.parametrize("held", [0, 91, 95, 100])
def test_the_interval_of_independent_bands_is_that_of_clopper_and_pearson(held):
    inside = np.arange(100)[:, None] < held
    exact = binomtest(held, 100).proportion_ci(0.95, method="exact")
    assert interval(inside) == pytest.approx((exact.low, exact.high), abs=0.002)


def test_bands_that_hold_together_count_once():
    once = np.arange(100)[:, None] < 91
    assert interval(np.hstack([once, once])) == pytest.approx(interval(once), abs=0.002)


def test_the_interval_holds_the_share_of_bands_that_scatter_together():
    rng, held = np.random.default_rng(1), 0
    for _ in range(400):
        together, alone = rng.random((100, 1)) < 0.94, rng.random((100, 2)) < 0.94
        low, high = interval(np.where(rng.random((100, 1)) < 0.5, together, alone))
        held += low <= 0.94 <= high
    assert held >= 0.93 * 400


@pytest.mark.full
@pytest.mark.skipif(not COMPILED, reason="derivatives are those of machine code")
def test_the_pull_of_noise_is_chi_square_and_one_opening_is_as_good_as_many():
    machine = MACHINES["gimbal"]
    pulls = chances(draws(machine, range(8)))
    assert chi2.ppf(0.001, 16) < pulls.sum() < chi2.ppf(0.999, 16)
    found = coverage(draws(machine, range(2)))
    model, plan, values, data = list(draws(machine, range(2)))[1]
    alone = Coverage()
    alone.add(values, cosimo.estimate(model, plan, data=data, halved=False))
    assert found.names == tuple(machine.unknown)
    assert found.off[1:] == alone.off
    assert np.shape(coverage(springs([1])).off) == (1, 1)


@pytest.mark.full
def test_the_truth_as_fmus_has_the_same_numbers():
    machine = MACHINES["gimbal"]
    ours, fmus = (cosimo.run(machine.model(stop_time=0.3), verify="no", in_process=here) for here in (True, False))
    for name in machine.noise:
        assert np.array_equal(ours[name], fmus[name])
