"""The campaign of coverage: intervals of shares against known cases, and how far noise alone pulls estimates."""

from __future__ import annotations

from dataclasses import replace

import cosimo
import numpy as np
import pytest
from cosimo.components.core.kernels import COMPILED
from cosimo.tests.campaigns.coverage import (
    MACHINES,
    SOLVED,
    TESTED,
    Coverage,
    chances,
    coverage,
    drawn,
    draws,
    interval,
    judged,
    springs,
    truths,
)
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


@pytest.mark.full
@pytest.mark.skipif(not COMPILED, reason="compares the numbers of machine code")
@pytest.mark.parametrize(("name", "finer"), [("bearing", 1), ("catenary", 1), ("gimbal", 16)])
def test_runs_agree_with_equations_that_share_no_code(name, finer):
    """To a hundredth of the noise, of the gimbal with a sixteenth of its step."""
    machine = MACHINES[name]
    machine = replace(machine, changes={**machine.changes, "master.step": machine.model().master.step / finer})
    values = [drawn(machine, machine.model(), 3)]
    (run,), (solved,) = (list(truths(machine, values, kind)) for kind in ("same", SOLVED))
    for signal, noise in machine.noise.items():
        np.testing.assert_allclose(run[signal], np.interp(run.time, solved.time, solved[signal]), rtol=0.0, atol=0.01 * noise)


@pytest.mark.full
@pytest.mark.skipif(not COMPILED, reason="derivatives are those of machine code")
def test_a_wrong_model_is_rejected():
    assert list(judged(TESTED["catenary"], [1], True)) == [True]
