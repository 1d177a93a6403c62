"""Steps that are too long for a scene are said at the end of the run, however few they were and whatever limits the growth."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from cosimo.orchestrator.advice.resolution import StepResolution, _wrapped
from cosimo.orchestrator.advice.step_sums import Sums, add_steps
from cosimo.orchestrator.run import run
from cosimo.orchestrator.systems import load_scene, read_scene
from cosimo.tests.short_run import full_but
from cosimo.tests.support import two_masses

LINES = {  # what ended as done, without a warning: changes, outcome, part of the message or warning
    "few steps": ("mass-on-spring", {"master.step": 0.5, "stop_time": 5.0}, "unstable",
                  "mass against spring is stable up to 0.121 s"),
    "fewer steps": ("mass-on-spring", {"master.step": 2.0, "stop_time": 10.0}, "unstable", "is stable up to 0.121 s"),
    "slow growth": ("mass-on-spring", {"units.spring.parameters.stiffness": 10500.0}, "done", "is stable up to 0.00485 s"),
    "damping taken away": ("mass-on-spring", {"units.spring.parameters.stiffness": 1e4}, "done", "is stable up to 0.00502 s"),
    "a contact that opens": ("en50318-2002", {"master.step": 0.05}, "done",
                             "catenary against pantograph, which is stable up to 0.0128 s"),
    "a stiff contact": ("en50318-2002", {
        "units.pantograph.parameters.contact_stiffness": 1e9, "units.pantograph.parameters.substep": 1e-5, "stop_time": 0.5,
    }, "done", "the values extrapolated for input catenary.contact_force"),
    "step drive, 10": ("friction-drive-step", {"master.step": 0.01}, "done", "the values extrapolated"),
    "step drive, 50": ("friction-drive-step", {"master.step": 0.05}, "done", "the values extrapolated of wheels.second_torque"),
    "preload, 10": ("friction-drive-preload", {"master.step": 0.01}, "done", "the values extrapolated"),
    "preload, 50": ("friction-drive-preload", {"master.step": 0.05}, "done", "the values extrapolated"),
    "climb, 10": ("pipe-robot-climb", {"master.step": 0.05}, "done", "too long to show them"),
    "climb, 50": ("pipe-robot-climb", {"master.step": 0.25}, "done", "too long to show them"),
}


@pytest.mark.parametrize("name", full_but(("few steps", "slow growth", "a contact that opens"), LINES))
def test_a_step_that_is_too_long_is_never_silent(name):
    scene, changes, outcome, text = LINES[name]
    result = run(load_scene(scene).with_changes(changes), in_process=True)
    assert result.outcome == outcome
    text_said = "; ".join(result.info["warnings"] if outcome == "done" else [result.message])
    assert text in text_said
    assert "Reduce" in text_said
    assert result.info["outcome"] == outcome


@pytest.mark.parametrize("scene", full_but(
    ("mass-on-spring",), ("mass-on-spring", "friction-drive-step", "friction-drive-preload", "pipe-robot-climb")))
def test_the_shipped_settings_raise_no_alarm(scene):
    result = run(load_scene(scene), in_process=True)
    assert (result.outcome, result.info["warnings"]) == ("done", [])


def sums_of(signals: np.ndarray, ticks: np.ndarray, degree: int, blocks=(None,)) -> Sums:
    """Of signals (n, k), added in blocks of steps that end at these indices."""
    sums = Sums.zeros(len(signals))
    for first, last in pairwise((0, *blocks)):
        add_steps(np.ascontiguousarray(signals.T[first:last]), ticks[first:last], degree, 1000, sums)
    return sums


@pytest.mark.parametrize("phase", [0.2, 1.0, 2.0, 3.1])
@pytest.mark.parametrize("degree", [0, 1, 2])
def test_the_two_numbers_of_an_oscillation_are_those_of_its_phase(phase, degree):
    """q = sin²(φ/2); the error of an extrapolation of degree p is the (p+1)-th difference, (2 sin(φ/2))^(p+1) of the signal."""
    signals = np.cos(phase * np.arange(4000))[None]
    sums = sums_of(signals, np.arange(4000) * 7, degree)
    assert sums.counts.tolist() == [4000, 4000 - degree - 1, 998, 1000, 1000, 1000]
    for squares, number, expected in ((sums.seconds.sum(), 3998, 4.0 * np.sin(phase / 2.0) ** 2),
                                      (sums.missed[0], 3999 - degree, (2.0 * np.sin(phase / 2.0)) ** (degree + 1))):
        assert np.sqrt(squares / number) / signals.std() == pytest.approx(expected, rel=2e-2)


@pytest.mark.parametrize("degree", [0, 1, 2])
def test_differences_are_taken_among_equal_steps_only(degree):
    ticks = np.array([0, 1, 2, 3, 5, 7, 9, 10, 11, 12])
    signals = np.random.default_rng(1).normal(size=(2, 10))
    sums = sums_of(signals, ticks, degree, (4, 5, 10))

    def equal(order):
        ends = [k for k in range(order, 10) if np.ptp(np.diff(ticks)[k - order : k]) == 0]
        return np.diff(signals, n=order)[:, np.array(ends) - order]

    seconds, missed = equal(2), equal(degree + 1)
    np.testing.assert_allclose(sums.seconds[0], (seconds**2).sum(axis=1), rtol=1e-13)
    np.testing.assert_allclose(sums.missed, (missed**2).sum(axis=1), rtol=1e-13)
    assert sums.counts.tolist() == [10, missed.shape[1], seconds.shape[1], 0, 0, 0]
    np.testing.assert_allclose(sums.largest, np.abs(missed).max(axis=1), rtol=1e-13)
    errors = np.abs(missed)
    before = [row[k - 1] if k else 0.0 for row, k in zip(errors, errors.argmax(axis=1), strict=True)]
    np.testing.assert_allclose(sums.before, before, rtol=1e-13)
    np.testing.assert_allclose(sums.total / 10, signals.mean(axis=1) - signals[:, 0], rtol=1e-12)
    np.testing.assert_array_equal(sums.peak, np.abs(signals).max(axis=1))


def test_ticks_of_a_clock_finer_than_64_bits_count_as_others_do():
    """Macro steps whose smallest common part with the recording is tiny have such clocks."""
    signals, even = np.random.default_rng(2).normal(size=(2, 12)), [0, 1, 2, 3, 5, 7, 9, 10, 11, 12, 13, 14]
    fine = np.concatenate([_wrapped([k * (2**62 + 1) for k in some]) for some in (even[:2], even[2:])])
    for one, other in zip(sums_of(signals, fine, 1), sums_of(signals, np.array(even), 1), strict=True):
        if one.dtype != np.int64 or one.shape != (3,):  # the ticks themselves
            np.testing.assert_array_equal(one, other)


def test_a_resumed_run_judges_all_steps(tmp_path, monkeypatch):
    """The sums of a run that was resumed are those of the whole run."""
    scene, sums = read_scene(two_masses("jacobi", 5e-3, 1)), []
    judge = StepResolution.judge

    def seen(self):
        found = judge(self)
        sums.append([values.copy() for values in self._sums])
        return found

    monkeypatch.setattr(StepResolution, "judge", seen)
    run(scene)
    run(scene, checkpoint_every=0.34, checkpoint_to=tmp_path / "a")
    run(scene, resume=tmp_path / "a")
    for one, other in zip(sums[0], sums[2], strict=True):
        np.testing.assert_array_equal(one, other)
