"""Bands of figures against the joint normal distribution of all steps, and those of a system."""

from __future__ import annotations

import cosimo
import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.components.core.kernels import COMPILED
from cosimo.tests.estimation.machines import CATENARY
from cosimo.tests.estimation.oscillator import NOISE, Oscillator

pytestmark = pytest.mark.skipif(not COMPILED, reason="derivatives are those of machine code")
TRUTH = Oscillator(h=0.005, every=4, count=12)
MEAN, MEAN_VELOCITY, LARGEST = "mass.base_x, mean", "mass.base_velocity_x, mean", "mass.base_x, maximum"


def posterior(y):
    """Mean (2 N,) and covariance of all positions and velocities behind the steps, given the measurements."""
    covariance, seen = TRUTH.stacked()
    S = covariance[np.ix_(seen, seen)] + NOISE**2 * np.eye(y.size)
    gain = np.linalg.solve(S, covariance[seen]).T
    return gain @ y, covariance - gain @ covariance[seen]


def test_bands_of_figures_are_those_of_the_joint_distribution_of_the_path():
    """Of a mean in closed form; of a maximum, which is no linear figure, by draws from that distribution."""
    y, _ = TRUTH.drawn(4)
    found = TRUTH.estimate(y, figures=[MEAN, MEAN_VELOCITY, LARGEST], suspected=[])
    figures = {f.name: f for f in found.figures}
    mean, covariance = posterior(y)
    first = mean.size // 2 - found.time.size  # the filter begins behind the first steps
    for name, part in ((MEAN, 0), (MEAN_VELOCITY, 1)):
        weights = np.zeros(mean.size)
        weights[2 * first + part :: 2] = 1.0 / found.time.size
        deviation = np.sqrt(weights @ covariance @ weights)
        assert figures[name].value == pytest.approx(weights @ mean, abs=0.25 * deviation)  # 200 paths know it to 0.07
        assert figures[name].at_mean == pytest.approx(weights @ mean, abs=0.03 * deviation)
        assert figures[name].deviation == pytest.approx(deviation, rel=0.2)
        assert figures[name].high - figures[name].low == pytest.approx(3.92 * deviation, rel=0.25)
    draws = np.random.default_rng(0).multivariate_normal(mean, covariance, 4000, method="eigh")[:, 2 * first :: 2].max(axis=1)
    assert figures[LARGEST].value == pytest.approx(draws.mean(), abs=0.25 * draws.std())
    assert figures[LARGEST].deviation == pytest.approx(draws.std(), rel=0.2)


def test_figures_have_a_numerical_error_beside_the_statistical_one():
    truth = Oscillator(h=0.02, every=5, count=30, kick=0.0)
    found, alone = (
        truth.estimate(truth.drawn(3)[0], figures=[LARGEST], suspected=[], states={}, halved=h) for h in (True, False)
    )
    (figure,) = found.figures
    assert figure.error > 0.0
    assert [figure.low, figure.high] == [alone.figures[0].low - figure.error, alone.figures[0].high + figure.error]
    assert found.to_json()["figures"][LARGEST]["error"] == figure.error
    assert any("numerical error of" in text for text in found.verdict.remarks) == any(
        one.error > 0.5 * one.deviation for one in (*found.parameters, *found.figures)
    )


@pytest.mark.full
def test_headline_figures_of_a_system_hold_those_of_the_truth():
    model = CATENARY.model(stop_time=5.0)
    run = cosimo.run(model.with_changes({"pantograph.static_force": 126.0, "master.step": 5e-4}), in_process=True, verify="no")
    found = CATENARY.estimate(CATENARY.measured(run), model, suspected=[])
    bands = {f.name: f for f in found.figures}
    true = {row.name: row.value for row in run.summary if row.name in bands}
    assert len(true) >= 3
    off = {n: abs(bands[n].value - v) / bands[n].deviation for n, v in true.items() if bands[n].deviation > 0.0}
    assert np.mean([o < 3.0 for o in off.values()]) > 0.8, off


def test_a_figure_that_there_is_not_is_refused():
    y, _ = TRUTH.drawn(1)
    for wrong in ("mass.base_x, median", "mass.base, mean"):
        with pytest.raises(BadInput, match="figures"):
            TRUTH.estimate(y, figures=[wrong], suspected=[])
