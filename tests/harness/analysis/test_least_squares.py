"""Fits against linear regression's closed form, and against what data cannot determine."""

import numpy as np
import pytest
from cosimo.orchestrator.harness.analysis.least_squares import fit, profile_end

WIDE = {"offset": (-1e3, 1e3), "slope": (-1e3, 1e3)}


def line(seed, n=40, noise=0.3):
    x = np.linspace(0.0, 4.0, n)
    return x, 2.0 + 0.5 * x + noise * np.random.default_rng(seed).standard_normal(n)


@pytest.mark.parametrize("known", [False, True])
def test_a_straight_line_has_the_closed_form(known):
    """Estimates and covariance of linear regression: (XᵀX)⁻¹Xᵀy and s²(XᵀX)⁻¹."""
    x, y = line(1)
    sigma = 0.3 if known else 1.0
    design = np.stack([np.ones_like(x), x], axis=1)
    best = np.linalg.solve(design.T @ design, design.T @ y)
    rest = y - design @ best
    variance = sigma**2 if known else rest @ rest / (x.size - 2)
    found = fit(lambda p: (p[0] + p[1] * x - y) / sigma, {"offset": 0.0, "slope": 0.0}, WIDE, noise_known=known)
    np.testing.assert_allclose(found.values, best, rtol=1e-6)
    np.testing.assert_allclose(found.covariance, variance * np.linalg.inv(design.T @ design), rtol=1e-5)
    assert found.messages == ()


def test_the_intervals_cover_the_truth_as_often_as_they_say():
    """Of 400 fits 95 % hold the slope: between 92 and 98 % but for 1 of 200 seeds (binomial)."""
    inside = 0
    for seed in range(400):
        x, y = line(seed, n=8)
        low, high = fit(lambda p, x=x, y=y: p[0] + p[1] * x - y, {"offset": 0.0, "slope": 0.0}, WIDE).intervals[1]
        inside += low <= 0.5 <= high
    assert 0.92 * 400 <= inside <= 0.98 * 400


def test_what_the_data_do_not_determine_is_named():
    """Only the product of two parameters shows in the data."""
    x, y = line(2)
    bounds = {"a": (0.1, 10.0), "b": (0.1, 10.0), "offset": (-10.0, 10.0)}
    found = fit(lambda p: p[2] + p[0] * p[1] * x - y, {"a": 1.0, "b": 1.0, "offset": 0.0}, bounds)
    assert any("do not identify" in text and "a" in text and "b" in text for text in found.messages)
    assert found.deviations[2] < 0.2
    assert not found.deviations[0] < 1.0


def test_a_fit_at_its_bound_says_so():
    x, y = line(3)
    found = fit(lambda p: p[0] + p[1] * x - y, {"offset": 0.0, "slope": 0.1}, {"offset": (-1e3, 1e3), "slope": (0.0, 0.2)})
    assert any("slope has stopped at its upper bound" in text for text in found.messages)


def test_a_profile_of_one_parameter_goes_on_where_runs_fail():
    x, y = line(3)

    def residuals(p):
        return np.full(x.size, np.nan) if p[0] > 0.55 else (x * p[0] - y + 2.0) / 0.3

    best = fit(lambda p: residuals(p), {"slope": 0.5}, {"slope": (0.0, 1.0)}, noise_known=True)
    end, _ = profile_end(best, residuals, lambda p: x[:, None] / 0.3, 0, 1.0)
    assert best.values[0] < end <= 0.56
