"""A filter of a linear scene against independent answers: a Kalman filter by hand, a Riccati equation, joint normal distributions."""

from __future__ import annotations

import numpy as np
import pytest
from cosimo.components.core.kernels import COMPILED
from cosimo.tests.estimation.oscillator import NOISE, Oscillator
from scipy.linalg import solve_discrete_are
from scipy.stats import chi2, multivariate_normal

pytestmark = pytest.mark.skipif(not COMPILED, reason="derivatives are those of machine code")
BOTH = ("mass.base_x", "mass.base_velocity_x")


def at(found, times):
    """(means, deviations), (n, 2) each, of position and velocity at times."""
    place = np.searchsorted(found.time, times - 1e-9)
    series = [found.series(name) for name in BOTH]
    return tuple(np.stack([s[k][place] for s in series], axis=1) for k in (0, 1))


@pytest.mark.parametrize(("filter_", "tolerance"), [("extended", 0.02), ("unscented", 0.02), ("ensemble", 0.35)])
def test_means_deviations_and_likelihood_are_those_of_the_filter_by_hand(filter_, tolerance):
    truth = Oscillator(count=40)
    y, _ = truth.drawn(1)
    means, covariances, density = truth.filtered(y)
    more = {"members": 200, "inflation": 1.0, "estimated": {}} if filter_ == "ensemble" else {}
    if more:
        more["states"] = {"mass.base_x": {"deviation": "20 mm"}, "mass.base_velocity_x": {"deviation": 1.0, "walk": truth.kick}}
    found = truth.estimate(y, filter=filter_, smooth=False, **more)
    deviations = np.sqrt(np.diagonal(covariances, axis1=1, axis2=2))
    own, own_deviations = at(found, truth.times)
    assert np.sqrt(np.mean(((own - means) / deviations) ** 2)) < tolerance
    assert own_deviations == pytest.approx(deviations, rel=tolerance)
    assert found.log_likelihood == pytest.approx(density, abs=10.0 * tolerance)


def test_what_is_left_of_the_difference_is_the_error_of_the_coupling():
    """It is of second order in the macro step: of half of it a quarter."""
    off = []
    for h, every in ((0.02, 5), (0.01, 10)):
        truth = Oscillator(h=h, every=every, count=30, kick=0.0)
        y, _ = truth.drawn(2)
        means, covariances, _ = truth.filtered(y)
        own, _ = at(truth.estimate(y, smooth=False), truth.times)
        off.append(np.sqrt(np.mean((own - means)[10:] ** 2 / np.diagonal(covariances, axis1=1, axis2=2)[10:])))
    assert 3.0 < off[0] / off[1] < 5.5


def test_the_steady_covariance_solves_the_riccati_equation():
    truth = Oscillator(every=1, count=400)
    found = truth.estimate(truth.drawn(3)[0], smooth=False)
    F, Q, H = truth.F, truth.F @ truth.Q @ truth.F.T, np.array([[1.0, 0.0]])
    P = solve_discrete_are(F.T, H.T, Q, np.array([[NOISE**2]]))  # before an update
    P = P - P @ H.T @ H @ P / (P[0, 0] + NOISE**2)
    _, deviations = at(found, truth.times)
    assert deviations[-1] == pytest.approx(np.sqrt(np.diag(P)), rel=0.01)


def test_smoothed_states_and_likelihood_are_those_of_the_joint_normal_distribution():
    truth = Oscillator(h=0.005, every=4, count=12)
    y, _ = truth.drawn(4)
    covariance, seen = truth.stacked()
    S = covariance[np.ix_(seen, seen)] + NOISE**2 * np.eye(y.size)
    found = truth.estimate(y)
    assert found.log_likelihood == pytest.approx(multivariate_normal(np.zeros(y.size), S).logpdf(y), abs=0.02)
    gain = np.linalg.solve(S, covariance[seen]).T
    means = (gain @ y).reshape(-1, 2)
    deviations = np.sqrt(np.diag(covariance - gain @ covariance[seen])).reshape(-1, 2)
    own, own_deviations = at(found, truth.h * np.arange(2, 1 + means.shape[0]))
    assert np.abs((own - means[1:]) / deviations[1:]).max() < 0.02
    assert own_deviations == pytest.approx(deviations[1:], rel=0.02)


@pytest.mark.full
def test_a_constant_beside_disturbances_is_as_far_off_as_its_band_says():
    """Within 99.8 % of chi square: bands that are 1.6 times too narrow or 2 times too wide fail half of the time; 100 seeds: see
    the campaign of coverage."""
    off = []
    for seed in range(16):
        stiffness = 100.0 * np.exp(0.12 * np.random.default_rng(1000 + seed).standard_normal())
        truth = Oscillator(count=60, stiffness=stiffness)
        plan = truth.plan()["estimated"] | {"spring.stiffness": {"deviation": "12 %"}}
        scene = truth.scene(**{"spring.stiffness": 100.0})
        found = truth.estimate(truth.drawn(seed)[0], scene, estimated=plan, suspected=[], smooth=False)["spring.stiffness"]
        off.append(np.log(found.value / stiffness) * found.value / found.deviation)
    assert chi2.ppf(0.001, len(off)) < np.sum(np.square(off)) < chi2.ppf(0.999, len(off))


def test_bands_of_95_percent_hold_most_of_the_truth():
    inside = []
    for seed in range(6):
        truth = Oscillator(count=60)
        y, states = truth.drawn(seed)
        mean, deviation = at(truth.estimate(y, suspected=[]), truth.times)
        inside.append(np.abs(mean - states) < 1.96 * deviation)
    assert 0.90 <= np.mean(inside) <= 0.99
