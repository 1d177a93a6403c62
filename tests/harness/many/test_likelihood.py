"""The likelihood of measurements: closed forms of a linear Gaussian system, differences, profiles by a search of SciPy's own, outliers."""

from __future__ import annotations

import cosimo
import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.components.core.kernels import COMPILED
from cosimo.tests.estimation.oscillator import Oscillator
from scipy.linalg import expm
from scipy.optimize import brentq, minimize_scalar
from scipy.stats import multivariate_normal

pytestmark = pytest.mark.skipif(not COMPILED, reason="derivatives are those of machine code")
TIMES, NOISE = 0.05 * np.arange(1, 41), 5e-3
STARTS = ("mass.start_x", "mass.start_velocity_x")
SCENE = Oscillator(h=0.0005).scene(stop_time=2.05)


def rows_of_starts():
    """Position over start position and velocity, (n, 2), in closed form."""
    A = np.array([[0.0, 1.0], [-100.0, -0.4]])
    return np.array([expm(A * t)[0] for t in TIMES])


def measured(tmp_path, seed=0, outliers=0):
    """A plan, and the positions that it is about."""
    rng = np.random.default_rng(seed)
    y = rows_of_starts() @ np.array([0.05, 0.8]) + NOISE * rng.standard_normal(TIMES.size)
    y[rng.choice(TIMES.size, outliers, replace=False)] += 0.1
    text = "\n".join(f"{float(t)!r},{float(v)!r}" for t, v in zip(TIMES, y, strict=True))
    (tmp_path / "measured.csv").write_text(f"t,x\n{text}\n")
    curve = {"signal": "mass.base_x", "file": "measured.csv", "time": "t", "column": "x", "noise": NOISE}
    return curve, y


def plan(curve, *names, **more):
    ranges = {STARTS[0]: (-0.5, 0.5, 0.0), STARTS[1]: (-4.0, 4.0, 0.0), "spring.stiffness": (50.0, 200.0, 100.0)}
    vary = {n: dict(zip(("low", "high", "start"), ranges[n], strict=True)) for n in names}
    return {"vary": vary, "curves": [curve], **more}


def test_a_linear_gaussian_likelihood_and_its_gradient_are_the_closed_form(tmp_path):
    curve, y = measured(tmp_path)
    H = rows_of_starts()
    with cosimo.likelihood(SCENE, plan(curve, *STARTS), folder=tmp_path) as likelihood:
        assert likelihood.names == STARTS
        for x in (np.array([0.05, 0.8]), np.array([-0.1, 0.3])):
            exact = multivariate_normal(H @ x, NOISE**2 * np.eye(y.size)).logpdf(y)
            assert likelihood(x) == pytest.approx(exact, rel=2e-3)
            assert likelihood.gradient(x) == pytest.approx(H.T @ (y - H @ x) / NOISE**2, rel=5e-3, abs=2.0)
        assert set(likelihood.exact.values()) == {"exact"}
        assert likelihood(np.array([0.6, 0.0])) == -np.inf


def test_its_gradient_is_that_of_differences(tmp_path):
    curve, _ = measured(tmp_path)
    names = (*STARTS, "spring.stiffness")
    with cosimo.likelihood(SCENE, plan(curve, *names), folder=tmp_path) as likelihood:
        x = np.array([0.04, 0.7, 96.0])
        gradient = likelihood.gradient(x)
        for k, h in enumerate((1e-5, 1e-4, 1e-2)):
            ahead, back = (likelihood(x + way * h * np.eye(3)[k]) for way in (1.0, -1.0))
            assert gradient[k] == pytest.approx((ahead - back) / (2.0 * h), rel=1e-5)


def test_a_fit_with_profiles_has_the_covariance_and_intervals_of_the_closed_form(tmp_path):
    curve, y = measured(tmp_path)
    H = rows_of_starts()
    covariance = NOISE**2 * np.linalg.inv(H.T @ H)
    values, deviations = np.linalg.solve(H.T @ H, H.T @ y), np.sqrt(np.diag(covariance))
    found = cosimo.fit(SCENE, plan(curve, *STARTS, profile=True), folder=tmp_path, verify=False).fit
    assert (found.values - values) / deviations == pytest.approx(np.zeros(2), abs=0.02)
    assert found.covariance == pytest.approx(covariance, rel=0.01)
    assert (found.intervals - found.values[:, None]) / deviations[:, None] == pytest.approx(
        1.96 * np.array([[-1, 1]] * 2), abs=0.03
    )


def test_the_ends_of_a_curved_profile_are_where_a_search_of_its_own_finds_them(tmp_path):
    """With few and poor samples the interval of a stiffness is not symmetric."""
    curve, _ = measured(tmp_path)
    rough = curve | {"noise": 0.06}
    names = (STARTS[1], "spring.stiffness")
    found = cosimo.fit(SCENE, plan(rough, *names, profile=True), folder=tmp_path, verify=False).fit
    with cosimo.likelihood(SCENE, plan(rough, *names), folder=tmp_path) as likelihood:

        def fallen(k):
            best = minimize_scalar(lambda v: -likelihood(np.array([v, k])), bounds=(-4.0, 4.0), method="bounded").fun
            return 2.0 * (best + likelihood(found.values)) - 3.841459

        low, high = (brentq(fallen, found.values[1], end, xtol=1e-2) for end in (51.0, 199.0))
    assert found.intervals[1] == pytest.approx([low, high], abs=0.02 * (high - low))
    ends = np.abs(found.intervals[1] - found.values[1])
    assert abs(ends[1] / ends[0] - 1.0) > 0.03


def test_a_parameter_that_the_data_leave_open_is_said_to_be(tmp_path):
    curve, _ = measured(tmp_path)
    found = cosimo.fit(SCENE, plan(curve | {"noise": 5.0}, STARTS[0], profile=True), folder=tmp_path, verify=False).fit
    assert found.intervals[0].tolist() == [-0.5, 0.5]
    assert any("open up to its lower bound" in text for text in found.messages)


def test_robust_losses_bear_outliers_that_least_squares_does_not(tmp_path):
    curve, _ = measured(tmp_path, outliers=6)
    H = rows_of_starts()
    deviations = NOISE * np.sqrt(np.diag(np.linalg.inv(H.T @ H)))
    off = {}
    for loss in ("linear", "huber", "soft_l1", "cauchy"):
        found = cosimo.fit(SCENE, plan(curve, *STARTS, loss=loss), folder=tmp_path, verify=False).fit
        off[loss] = np.abs((found.values - [0.05, 0.8]) / deviations).max()
        if loss != "linear":
            assert (np.abs(found.values - [0.05, 0.8]) < 3.0 * found.deviations).all()
            assert any("count less" in text for text in found.messages)
    assert off["linear"] > 4.0
    assert max(off["huber"], off["soft_l1"], off["cauchy"]) < 0.7 * off["linear"]


def test_deviations_of_a_robust_fit_are_those_of_many_fits(tmp_path):
    """Over noise of 40 seeds; without outliers they are those of least squares and a little more."""
    H = rows_of_starts()
    deviations = NOISE * np.sqrt(np.diag(np.linalg.inv(H.T @ H)))
    values, own = [], []
    for seed in range(40):
        curve, _ = measured(tmp_path, seed)
        found = cosimo.fit(SCENE, plan(curve, *STARTS, loss="huber"), folder=tmp_path, verify=False).fit
        values.append(found.values)
        own.append(found.deviations)
    assert np.mean(own, axis=0) == pytest.approx(np.std(values, axis=0), rel=0.3)
    assert np.mean(own, axis=0) == pytest.approx(deviations / np.sqrt(0.95), rel=0.08)


def test_what_is_no_likelihood_is_refused(tmp_path):
    curve, _ = measured(tmp_path)
    unknown = {k: v for k, v in curve.items() if k != "noise"}
    with pytest.raises(BadInput, match="noise"):
        cosimo.likelihood(SCENE, plan(unknown, *STARTS), folder=tmp_path)
    with pytest.raises(BadInput, match="loss"):
        cosimo.fit(SCENE, plan(unknown, *STARTS, loss="huber"), folder=tmp_path)
    with pytest.raises(BadInput, match="profile"):
        cosimo.fit(SCENE, plan(curve, *STARTS, loss="huber", profile=True), folder=tmp_path)
    with cosimo.likelihood(SCENE, plan(curve, *STARTS), folder=tmp_path) as likelihood:
        with pytest.raises(BadInput, match="shape"):
            likelihood(np.zeros(3))
        with pytest.raises(BadInput, match="bounds"):
            likelihood.gradient(np.array([9.0, 0.0]))
