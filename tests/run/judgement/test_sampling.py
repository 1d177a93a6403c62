"""What rows leave of a figure against closed forms, and the error of a chaotic motion's figures against an ensemble of starts."""

from dataclasses import replace

import numpy as np
import pytest
from cosimo.orchestrator.judgement.sampling import between, curve, of_parts
from cosimo.orchestrator.run.key_results import KeyResults
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import read_scene
from cosimo.tests.support import two_masses
from scipy.integrate import solve_ivp
from scipy.interpolate import Akima1DInterpolator

pytestmark = pytest.mark.interpreted
NAME = "a.x_out"


@pytest.fixture(scope="module")
def result():
    return run(read_scene(two_masses("jacobi", 5e-2, 0)), in_process=True)


def with_rows(result, time, values):
    return replace(result, time=time, columns={NAME: values}, texts={})


def figures(result):
    """Share of time, number of stretches and length of the longest above 0.8, largest value: of rows as they stand."""
    above, step = result[NAME] > 0.8, result.time[1] - result.time[0]
    edges = np.flatnonzero(np.diff(np.concatenate(([0], above.astype(int), [0]))))
    return KeyResults(
        {
            "share": float(above.mean()),
            "longest": float((edges[1::2] - edges[::2]).max(initial=0) * step),
            "largest": float(result[NAME].max()),
            "count": float(edges.size // 2),
        }
    )


def test_the_error_of_rows_covers_shares_lengths_and_extremes(result):
    """A sine of known crossings and height, at 40 distances of rows: stated is never 0 where rows are off, and is right to a half."""
    covered, n = dict.fromkeys(("share", "longest", "largest"), 0), 40
    for step in np.linspace(0.11, 0.17, n):
        time = np.arange(0.0, 40.0 * np.pi, step)
        seen = with_rows(result, time, np.sin(time + 0.3))
        exact = {"share": 0.5 - np.arcsin(0.8) / np.pi, "longest": np.pi - 2.0 * np.arcsin(0.8), "largest": 1.0}
        here = figures(seen)
        stated = between(seen, here, figures)
        for name, right in exact.items():
            true = abs(here[name] - right)
            finest = 0.2 * step if name == "longest" else 0.002 * right  # a length is one of whole filled rows
            covered[name] += bool(true <= 2.0 * stated[name] + finest)
            assert stated[name] > 0.0 or true < finest, (name, step)
    assert covered == dict.fromkeys(covered, n)


def test_a_count_changes_by_what_is_near_its_threshold(result):
    """Peaks that reach over the threshold between two rows only."""
    time = np.arange(0.0, 60.0, 0.4)
    seen = with_rows(result, time, 0.81 * np.sin(time))
    here = figures(seen)
    assert here["count"] < 10.0  # of peaks
    assert between(seen, here, figures)["count"] > 0.0


def test_jumps_and_whole_numbers_are_no_curves(result):
    time = np.arange(0.0, 10.0, 0.1)
    counted = with_rows(result, time, np.floor(time))
    assert between(counted, KeyResults({"largest": 9.0}), lambda r: KeyResults({"largest": float(r[NAME].max())})) == {
        "largest": 0.0
    }


def test_the_mean_of_a_chaotic_motion_has_the_error_that_an_ensemble_shows(result):
    """Lorenz' system from 20 starts over 60 s: nominally 95 % of the stated errors hold the ensemble's mean."""
    time = np.linspace(0.0, 60.0, 3001)
    flow = lambda t, v: [10.0 * (v[1] - v[0]), v[0] * (28.0 - v[2]) - v[1], v[0] * v[1] - 8.0 / 3.0 * v[2]]  # noqa: E731
    names = {"mean": np.mean, "rms": np.std}
    values = lambda r: KeyResults({name: float(of(r[NAME])) for name, of in names.items()})  # noqa: E731
    found = []
    for k in range(20):
        states = solve_ivp(flow, (-10.0, 60.0), [1.0 + 0.01 * k, 1.0, 20.0], t_eval=time, rtol=1e-6, atol=1e-6).y
        seen = with_rows(result, time, states[0] ** 2)
        found.append((values(seen), of_parts(seen, values)))
    for name in names:
        numbers, errors = (np.array([one[i][name] for one in found]) for i in (0, 1))
        held = int((np.abs(numbers - numbers.mean()) <= errors).sum())
        assert held >= 17, (name, held)
        assert errors.mean() < 6.0 * numbers.std()  # no error that says nothing


@pytest.mark.parametrize("n", [3, 4, 200])
def test_the_curve_is_that_of_scipy(n):
    rng = np.random.default_rng(n)
    t, share = np.cumsum(rng.uniform(0.1, 1.0, n)), np.arange(4) / 4
    for y in (rng.normal(size=n), np.repeat(rng.normal(size=n), 3)[:n], np.zeros(n), 1e6 + t):
        at = (t[:-1, None] + np.diff(t)[:, None] * share).ravel()
        expected = Akima1DInterpolator(t, y, method="makima")(at)
        np.testing.assert_allclose(
            curve(t, y, share).ravel(), expected, rtol=0.0, atol=1e-12 * max(np.ptp(y), abs(y).max(), 1e-300)
        )
