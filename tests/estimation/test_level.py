"""How often the verdict rejects a right model, and bands hold the truth: as often as they say, whatever the number of samples."""

from __future__ import annotations

import re
from contextlib import ExitStack

import numpy as np
import pytest
from cosimo.components.core.kernels import COMPILED
from cosimo.orchestrator.estimation.filtered_scene import FilteredScene, plan_of
from cosimo.orchestrator.estimation.filtering import Innovations
from cosimo.orchestrator.estimation.measurements import Measurements, measurements_of
from cosimo.orchestrator.estimation.suspects import judged as doubted
from cosimo.orchestrator.estimation.verdict import LEVEL, verdict
from cosimo.tests.estimation.oscillator import SIGNAL, Oscillator
from scipy.signal import lfilter
from scipy.stats import binom, chi2

NAMES = tuple("abcde")


def judged(e):
    """The verdict on normalised innovations, (n, k), of k signals at n instants."""
    n, k = e.shape
    time, none = np.repeat(0.1 * np.arange(1, n + 1), k), np.zeros(0)
    which = np.tile(np.arange(k), n)
    measured = Measurements(NAMES[:k], ("m",) * k, time, which, e.ravel(), np.ones(k))
    innovations = Innovations(which=which.tolist(), time=time.tolist(), normalised=e.ravel().tolist(), between=[0.0] * e.size)
    return verdict(measured, innovations, (), none, none, ())


@pytest.mark.parametrize(("n", "k"), [(100, 5), (20, 1), (9, 2)])
def test_white_innovations_are_rejected_as_often_as_stated(n, k):
    rng, draws = np.random.default_rng(1), 500
    found = [judged(rng.standard_normal((n, k))) for _ in range(draws)]
    assert sum(not v.explains for v in found) <= binom.ppf(0.999, draws, LEVEL)
    for name in [c.name for c in found[0].checks]:
        p = np.array([next(c.p for c in v.checks if c.name == name) for v in found])
        for level in (0.003, 0.01, 0.05):
            assert (p < level).sum() <= binom.ppf(0.999, draws, level), (name, level)


def test_innovations_that_follow_from_earlier_ones_are_noticed():
    """The least correlation of neighbours that 100 samples show at a level of 0.14 %, and a line with a share of the power."""
    rng, noticed = np.random.default_rng(2), {"slope": 0, "line": 0, "white": 0}
    for _ in range(100):
        white, time = rng.standard_normal(160), np.arange(100)
        slow = lfilter([np.sqrt(1.0 - 0.5**2)], [1.0, -0.5], white)[60:]
        line = np.sqrt(0.7) * white[60:] + np.sqrt(2 * 0.3) * np.sin(1.3 * time + rng.uniform(0.0, 6.0))
        for name, e in (("slope", slow), ("line", line), ("white", white[60:])):
            check = next(c for c in judged(e[:, None]).checks if c.name == "whiteness")
            noticed[name] += not check.holds
            if name == "line" and not check.holds:
                assert re.search(r"has a period of (4\.76|5) measurements", check.words)  # 4.83, between two ordinates of 100
    assert noticed["slope"] > 80
    assert noticed["line"] > 60  # at the worst place: halfway between two ordinates
    assert noticed["white"] <= 2


@pytest.mark.full
@pytest.mark.skipif(not COMPILED, reason="derivatives are those of machine code")
def test_a_filter_of_a_right_model_is_rejected_and_off_as_often_as_stated():
    """100 draws of a mass on a spring by one opening of the scene, each within 99.9 % of what is stated. 300 seeds: see the campaign."""
    case, p, off = Oscillator(h=0.02, every=2, count=60), [], []
    plan, where, folder = plan_of(case.plan())
    scene = case.scene(stop_time=case.times[-1] + 3.0 * case.h)
    with ExitStack() as stack:
        drawn = lambda y: measurements_of(plan, scene, folder, {SIGNAL: (case.times, y)}, where)  # noqa: E731
        filtered = FilteredScene(scene, plan, drawn(case.times), stack, where, case.every * case.count)
        begins, model = filtered.model.block.time, filtered.model
        columns = {name: k for k, name in filtered.columns.items()}
        state = [columns[name] for name in ("mass.base_x", "mass.base_velocity_x")]
        for seed in range(100):
            y, states = case.drawn(seed)
            measured = drawn(y).within(begins, np.inf)
            run = filtered.filter(doubts=True, smooth=False)
            run.run(measured)
            suspects = doubted(model, filtered.suspected, measured.signals, measured.units, run.innovations)
            deviations = np.sqrt((run.belief.Tq**2).sum(axis=1))
            checks = verdict(measured, run.innovations, model.unknowns, run.belief.q, deviations, suspects).checks
            p.append(min(c.p for c in checks) * len(checks))
            off.append((run.track.values[-1][state] - states[-1]) / run.track.columns[-1][state, 0])
    for level in (LEVEL, 0.05, 0.2):
        assert np.sum(np.array(p) < level) <= binom.ppf(0.999, len(p), level), level
    size = np.sum(np.square(off), axis=0)
    assert (chi2.ppf(0.001, len(off)) < size).all()
    assert (size < chi2.ppf(0.999, len(off))).all()
