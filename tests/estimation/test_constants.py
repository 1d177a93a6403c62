"""Constants of a record: several maxima, shapes that are no normal distribution, and what is said where bands may not hold."""

from __future__ import annotations

from copy import copy
from dataclasses import replace
from threading import get_ident
from time import sleep

import cosimo
import numpy as np
import pytest
from cosimo.components.core.kernels import COMPILED
from cosimo.orchestrator.estimation.answer import REACH
from cosimo.orchestrator.estimation.bounds import Bounds
from cosimo.orchestrator.estimation.model import Unknown
from cosimo.orchestrator.estimation.posterior import MAY_NOT, Runs, posterior
from cosimo.tests.estimation.oscillator import DAMPING, SIGNAL, Oscillator

UNKNOWN = [Unknown("unit.constant", "m", Bounds(), 0.0, 1.0, 0.0, np.inf)]


class Curve(Runs):
    """One measurement of a curve of one constant, in the place of runs of a scene."""

    def __init__(self, curve, slope, measured, noise):
        self.mean, self.deviation = np.zeros(1), np.ones(1)
        self.curve, self.slope, self.measured, self.noise = curve, slope, measured, noise

    def __call__(self, u):
        v = (self.measured - self.curve(u)) / self.noise
        return -0.5 * float(v @ v + u @ u), v, self.slope(u)[None] / self.noise

    def exact(self):
        """By quadrature: numbers and their weights."""
        u = np.linspace(-6.0, 6.0, 200_001)
        log = -0.5 * (((self.measured - self.curve(u)) / self.noise) ** 2 + u**2)
        weights = np.exp(log - log.max())
        return u, weights / weights.sum()


def ends(u, weights):
    return np.interp([0.025, 0.975], np.cumsum(weights), u)


@pytest.mark.parametrize("noise", [0.1, 0.6])
def test_two_maxima_have_the_weights_and_the_ends_of_quadrature(noise):
    """u² = 1 has two solutions, of which a small slope prefers one; with more noise they are one group, far from normal."""
    runs = Curve(lambda u: u**2 + 0.1 * u, lambda u: 2.0 * u + 0.1, 1.0, noise)
    found, (u, weights) = posterior(runs), runs.exact()
    assert [found.low[0], found.high[0]] == pytest.approx(ends(u, weights), abs=0.08)
    if noise == 0.1:
        (first, at), (second, other) = found.groups
        assert at[0] * other[0] < 0.0
        assert first + second == pytest.approx(1.0)
        assert first == pytest.approx(max(weights[u < 0.0].sum(), weights[u > 0.0].sum()), abs=0.06)
        text = found.remarks(UNKNOWN)[0]
        assert text.startswith("several values explain the measurement: unit.constant = ")
        assert MAY_NOT not in text
    else:
        assert len(found.groups) == 1
        assert found.mean[0] == pytest.approx(weights @ u, abs=0.12)
        assert found.deviation[0] == pytest.approx(np.sqrt(weights @ (u - weights @ u) ** 2), rel=0.1)


class Valley(Runs):
    """Two numbers of which a measurement shows the sum well and, by ripples, the difference: maxima are beads on a string."""

    def __init__(self):
        self.mean, self.deviation = np.zeros(2), np.ones(2)

    def __call__(self, u):
        s, d = 0.7 * (u[0] + u[1]), 0.7 * (u[0] - u[1])
        v = np.array([(1.5 - s - 0.1 * d**2) / 0.03, 4.0 * np.sin(3.0 * d) + 0.5 * (d - 1.0)])
        by = np.array([[1.0 / 0.03, 0.2 * d / 0.03], [0.0, -12.0 * np.cos(3.0 * d) - 0.5]])
        return -0.5 * float(v @ v + u @ u), v, by @ (0.7 * np.array([[1.0, 1.0], [1.0, -1.0]]))


def test_all_maxima_of_a_narrow_valley_are_found():
    """Their weights, and the ends of the bands, are those of quadrature."""
    found = posterior(Valley())
    s, d = np.meshgrid(np.linspace(-1.0, 2.5, 1401), np.linspace(-4.0, 4.0, 1601), indexing="ij")
    u = np.array([s + d, s - d]) / 1.4
    v = np.array([(1.5 - s - 0.1 * d**2) / 0.03, 4.0 * np.sin(3.0 * d) + 0.5 * (d - 1.0)])
    log = -0.5 * ((v**2).sum(axis=0) + (u**2).sum(axis=0))
    weights = np.exp(log - log.max())
    weights /= weights.sum()
    for k in range(2):
        order = np.argsort(u[k], axis=None)
        assert [found.low[k], found.high[k]] == pytest.approx(ends(u[k].ravel()[order], weights.ravel()[order]), abs=0.1)
    beads = np.round(d * 3.0 / np.pi)
    shares = sorted((weights[beads == n].sum() for n in np.unique(beads)), reverse=True)
    assert len(found.groups) >= 6  # starts of what was expected alone find five
    assert [w for w, _ in found.groups][:3] == pytest.approx(shares[:3], abs=0.08)


def test_maxima_that_starts_do_not_exhaust_are_said():
    runs = Curve(lambda u: np.sin(60.0 * u), lambda u: 60.0 * np.cos(60.0 * u), 0.3, 0.02)
    found = posterior(runs)
    assert found.unseen > 0.05
    assert any(MAY_NOT in text for text in found.remarks(UNKNOWN))


def test_few_draws_of_weight_are_said():
    found = posterior(Curve(lambda u: u, np.ones_like, 0.3, 0.1))
    assert found.effective > 150.0
    assert found.remarks(UNKNOWN) == []
    assert any(MAY_NOT in text for text in replace(found, effective=20.0).remarks(UNKNOWN))


machine_code = pytest.mark.skipif(not COMPILED, reason="derivatives are those of machine code")
STARTS = 0.1  # m


def swing(stiffness, times, damping=DAMPING):
    """Of a mass of 1 kg that is let go, in closed form."""
    omega = np.sqrt(stiffness - damping**2 / 4.0)
    wave = np.cos(omega * times) + damping / 2.0 / omega * np.sin(omega * times)
    return STARTS * np.exp(-damping / 2.0 * times) * wave


@machine_code
def test_a_stiffness_that_few_samples_leave_ambiguous():
    """Samples a second apart show a frequency and its mirror image alike: the bands are those of both, by quadrature in closed form."""
    case = Oscillator(h=0.005, every=200, count=9)
    y = swing(100.0, case.times) + 0.005 * np.random.default_rng(3).standard_normal(case.count)
    changes = {"estimated": {"spring.stiffness": {"deviation": "20 %"}}, "states": {}, "suspected": []}
    found = case.estimate(y, case.scene(**{"mass.start_x": STARTS}), **changes)
    q = np.linspace(-1.0, 1.0, 40_001)
    stiffness = 100.0 * np.exp(q)
    misfit = ((y - swing(stiffness[:, None], case.times)) ** 2).sum(axis=1) / 0.005**2
    log = -0.5 * (misfit + (q / 0.2) ** 2)
    weights = np.exp(log - log.max()) / np.exp(log - log.max()).sum()
    near = weights[np.abs(q) < 0.1].sum()
    assert 0.05 < near < 0.95  # there are two
    parameter = found["spring.stiffness"]
    assert [parameter.low, parameter.high] == pytest.approx(ends(stiffness, weights), abs=0.5)
    assert sorted(weight for weight, _ in found.posterior.groups)[-2:] == pytest.approx(sorted([near, 1.0 - near]), abs=0.06)
    assert "several values explain the measurement: spring.stiffness = " in " ".join(found.verdict.remarks)
    assert found.explains


@machine_code
def test_threads_change_no_number():
    """Two that take turns at random: each run begins anew, whichever memory it has."""
    case = Oscillator(h=0.005, every=200, count=9)
    y = swing(100.0, case.times) + 0.005 * np.random.default_rng(3).standard_normal(case.count)
    unknown = {"spring.stiffness": {"deviation": "20 %"}, "spring.damping": {"deviation": "10 %"}}
    plan = case.plan(estimated=unknown, states={}, suspected=[])
    scene, data = case.scene(**{"mass.start_x": STARTS}), {SIGNAL: (case.times, y)}
    one, two = (cosimo.estimate(scene, plan, data=data, halved=False, jobs=jobs) for jobs in (1, 2))
    assert one.parameters == two.parameters
    assert one.log_likelihood == two.log_likelihood
    assert one.posterior.effective == two.posterior.effective
    assert len(one.posterior.groups) == len(two.posterior.groups) > 1


@machine_code
@pytest.mark.parametrize(("h", "noise", "said"), [(0.025, 5e-4, True), (0.005, 0.02, False)])
def test_an_error_of_the_steps_beside_a_narrow_band_is_said(h, noise, said):
    """The truth is a closed form: bands of noise alone would miss it by far with long steps; the numerical error widens them."""
    case = Oscillator(h=h, every=round(0.05 / h), count=40, noise=noise)
    y = swing(104.0, case.times) + noise * np.random.default_rng(7).standard_normal(case.count)
    changes = {"estimated": {"spring.stiffness": {"deviation": "10 %"}}, "states": {}, "suspected": []}
    found = case.estimate(y, case.scene(**{"mass.start_x": STARTS}), halved=True, smooth=False, **changes)
    stiffness = found["spring.stiffness"]
    off = abs(stiffness.value - 104.0)
    assert (off > 3.0 * stiffness.deviation) == said
    assert stiffness.low < 104.0 < stiffness.high
    mean, low, high = found.band(SIGNAL)
    exact = swing(104.0, found.time)
    assert np.mean((low < exact) & (exact < high)) > 0.95
    assert (np.mean(np.abs(exact - mean) < REACH * found.series(SIGNAL)[1]) < 0.5) == said  # of noise alone
    assert stiffness.high - stiffness.low == pytest.approx(2.0 * (stiffness.error + REACH * stiffness.deviation), rel=0.05)
    text = "the numerical error of spring.stiffness is more than half of a standard deviation: reduce master.step"
    assert (text in found.verdict.remarks) == said


def test_points_come_in_their_order_whoever_is_first():
    class Slow(Curve):
        def __call__(self, u):
            sleep(0.02 if u[0] < 3.0 else 0.0)
            threads.add(get_ident())
            return super().__call__(u)

    runs, threads = Slow(lambda u: u, np.ones_like, 0.0, 1.0), set()
    runs.beside = (copy(runs),)
    found = runs.each(lambda one, u: one(u)[0], np.arange(6.0)[:, None])
    assert found == [-(u**2) for u in np.arange(6.0)]
    assert len(threads) == 2


@machine_code
def test_a_doubt_knows_that_estimated_constants_give_way():
    """Change and deviation of a suspected damping, and the likelihood, against generalised least squares on the closed form."""
    case = Oscillator(h=0.005, every=10, count=80)
    y = swing(104.0, case.times, 0.42) + 0.005 * np.random.default_rng(5).standard_normal(case.count)
    changes = {"estimated": {"spring.stiffness": {"deviation": "10 %"}}, "states": {}, "suspected": ["spring.damping"]}
    found = case.estimate(y, case.scene(**{"mass.start_x": STARTS}), **changes)
    q, d = np.log(found["spring.stiffness"].value), 1e-5
    at = lambda q, damping: swing(np.exp(q), case.times, damping)  # noqa: E731 - a prediction
    by_q = (at(q + d, DAMPING) - at(q - d, DAMPING)) / (2.0 * d)
    by_damping = (at(q, DAMPING + d) - at(q, DAMPING - d)) / (2.0 * d)
    S = 0.005**2 * np.eye(case.count) + 0.1**2 * np.outer(by_q, by_q)
    v = y - at(q, DAMPING) - by_q * (np.log(100.0) - q)
    size = by_damping @ np.linalg.solve(S, by_damping)
    suspect = next(s for s in found.verdict.suspects if s.name == "spring.damping")
    assert suspect.deviation == pytest.approx(1.0 / np.sqrt(size), rel=0.02)
    assert suspect.change == pytest.approx(by_damping @ np.linalg.solve(S, v) / size, abs=0.05 * suspect.deviation)
    likelihood = -0.5 * (v @ np.linalg.solve(S, v) + np.linalg.slogdet(2.0 * np.pi * S)[1])
    assert found.log_likelihood == pytest.approx(likelihood, abs=0.1)


@machine_code
def test_constants_beside_disturbances_against_quadrature():
    """A stiffness far off what was expected, and kicks: the likelihood of each stiffness by the Kalman filter by hand."""
    y, _ = Oscillator(count=120, stiffness=128.0).drawn(4)
    case = Oscillator(count=120)
    unknown = case.plan()["estimated"] | {"spring.stiffness": {"deviation": "15 %"}}
    found = case.estimate(y, estimated=unknown, suspected=[])
    q = np.linspace(-0.2, 0.7, 91)
    log = np.array([replace(case, stiffness=100.0 * np.exp(v)).filtered(y)[2] for v in q]) - 0.5 * (q / 0.15) ** 2
    weights = np.exp(log - log.max()) / np.exp(log - log.max()).sum()
    mean = weights @ q
    parameter, deviation = found["spring.stiffness"], np.sqrt(weights @ (q - mean) ** 2)
    assert not any(MAY_NOT in text for text in found.verdict.remarks)
    assert np.log(parameter.value / 100.0) == pytest.approx(mean, abs=0.15 * deviation)
    assert parameter.deviation / parameter.value == pytest.approx(deviation, rel=0.1)


@machine_code
def test_a_scene_that_no_start_takes_on_is_refused(monkeypatch):
    def fails(self, u):
        return -np.inf, np.zeros(0), np.zeros((0, u.size))

    case = Oscillator(count=20)
    monkeypatch.setattr(Runs, "__call__", fails)
    changes = {"estimated": {"spring.stiffness": {"deviation": "10 %"}}, "states": {}, "suspected": []}
    with pytest.raises(cosimo.StepFailed, match="no run goes on with what is expected"):
        case.estimate(swing(100.0, case.times), **changes)
