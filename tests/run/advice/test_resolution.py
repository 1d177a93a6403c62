"""Steps that are too long for a scene are said at the end of the run, however few they were and whatever limits the growth."""

from __future__ import annotations

import numpy as np
import pytest
from cosimo.orchestrator.advice.resolution import SUMS, StepResolution, _differences
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


@pytest.mark.parametrize("phase", [0.2, 1.0, 2.0, 3.1])
@pytest.mark.parametrize("degree", [0, 1, 2])
def test_the_two_numbers_of_an_oscillation_are_those_of_its_phase(phase, degree):
    """q = sin²(φ/2); the error of an extrapolation of degree p is the (p+1)-th difference, (2 sin(φ/2))^(p+1) of the signal."""
    signals = np.cos(phase * np.arange(4000))[None]
    ticks = np.arange(4000) * 7
    for order, expected in ((2, 4.0 * np.sin(phase / 2.0) ** 2), (degree + 1, (2.0 * np.sin(phase / 2.0)) ** (degree + 1))):
        differences, ends = _differences(signals, ticks, order, 0)
        assert np.sqrt(np.mean(differences**2)) / signals.std() == pytest.approx(expected, rel=2e-2)
        assert differences.shape[1] == len(ends) == 4000 - order


def test_differences_are_taken_among_equal_steps_only():
    ticks = np.array([0, 1, 2, 3, 5, 7, 9, 10, 11, 12])
    signals = np.random.default_rng(1).normal(size=(2, 10))
    for order in (1, 2, 3):
        differences, ends = _differences(signals, ticks, order, 2)
        assert ends.tolist() == [k for k in range(order, 10) if k >= 2 and np.ptp(np.diff(ticks)[k - order : k]) == 0]
        np.testing.assert_array_equal(differences, np.diff(signals, n=order)[:, ends - order])


def test_a_resumed_run_judges_all_steps(tmp_path, monkeypatch):
    """The sums of a run that was resumed are those of the whole run."""
    scene, sums = read_scene(two_masses("jacobi", 5e-3, 1)), []
    judge = StepResolution.judge

    def seen(self):
        found = judge(self)
        sums.append([np.array(getattr(self, name)) for name in SUMS])
        return found

    monkeypatch.setattr(StepResolution, "judge", seen)
    run(scene)
    run(scene, checkpoint_every=0.34, checkpoint_to=tmp_path / "a")
    run(scene, resume=tmp_path / "a")
    for one, other in zip(sums[0], sums[2], strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-12)
