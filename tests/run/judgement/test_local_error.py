"""The error of single macro steps, measured at the end of a run by steps of half the length."""

from __future__ import annotations

from math import log2

import cosimo.orchestrator.run as run_module
import numpy as np
import pytest
from cosimo.orchestrator.advice.instability import InstabilityMonitor
from cosimo.orchestrator.advice.local_error import SAMPLES, RepeatedSteps, repeatable
from cosimo.orchestrator.engine.algorithms.compiled_loop import CompiledLoop
from cosimo.orchestrator.run import run
from cosimo.orchestrator.systems import load_scene


@pytest.fixture
def measured(monkeypatch) -> list[dict]:
    """Local errors by signal of every run."""
    kept: list[dict] = []
    errors = RepeatedSteps.errors

    def keep(self):
        kept.append(errors(self))
        assert SAMPLES <= len(self._saved) <= SAMPLES + 1
        return kept[-1]

    monkeypatch.setattr(RepeatedSteps, "errors", keep)
    return kept


@pytest.mark.parametrize("degree", [0, 1])
def test_the_error_of_a_step_falls_with_its_order(degree, measured):
    """Velocity of a mass under a force that is extrapolated with degree p: H^(p + 2) a step."""
    scene = load_scene("mass-on-spring").with_changes({"master.extrapolation": degree, "stop_time": 2.0})
    for h in (4e-3, 2e-3):
        run(scene.with_changes({"master.step": h}), in_process=True)
    coarse, fine = measured
    end = ("mass", "base_velocity_x")
    assert log2(coarse[end] / fine[end]) == pytest.approx(degree + 2, abs=0.3)


@pytest.mark.parametrize("bonds", [[], ["spring.second_force_x * mass.base_velocity_x"]])
@pytest.mark.parametrize("algorithm", ["jacobi", "gauss-seidel"])
def test_states_that_are_kept_inside_of_batches_are_those_of_steps(algorithm, bonds, measured, monkeypatch):
    """A batch goes on behind such an instant; a monitor that takes steps back leaves none of what it kept of them."""
    changes = {"master.algorithm": algorithm, "master.bonds": bonds, "master.extrapolation": 2, "stop_time": 3.1}
    scene = load_scene("mass-on-spring").with_changes(changes)
    stretches: list[int] = []
    monkeypatch.setattr(CompiledLoop, "run", counted(CompiledLoop.run, stretches))
    run(scene, in_process=True)
    assert 0 < len(stretches) < SAMPLES
    alarm, alarms = InstabilityMonitor.alarm, []

    def early(self, at, inputs):
        found = alarm(self, at, inputs)
        alarms.append(int(at[len(at) // 2]) if not alarms else found)
        return alarms[-1]

    monkeypatch.setattr(InstabilityMonitor, "alarm", early)
    run(scene, in_process=True)
    assert alarms[0] > 0
    monkeypatch.setattr("cosimo.orchestrator.engine.stepping.adaptive.batch_loop_for", lambda *_: None)
    run(scene, in_process=True)
    together, taken_back, apart = measured
    assert together == taken_back == apart
    assert max(apart.values()) > 0.0


def counted(function, calls: list[int]):
    def call(self, *arguments):
        calls.append(1)
        return function(self, *arguments)

    return call


def test_steps_that_are_repeated_change_no_result(monkeypatch):
    scene = load_scene("mass-on-spring").with_changes({"stop_time": 0.5})
    with_them = run(scene, in_process=True)
    monkeypatch.setattr(run_module, "repeatable", lambda scene: False)
    without = run(scene, in_process=True)
    assert all(np.array_equal(with_them.columns[name], without.columns[name]) for name in without.columns)
    for key in ("counters", "warnings", "outcome", "message", "input_misses"):
        assert with_them.info[key] == without.info[key]
    assert with_them.info.get("energy") == without.info.get("energy")


def test_a_step_near_the_limit_is_wrong_by_itself():
    """Near the limit of 0.121 s."""
    scene = load_scene("mass-on-spring")
    coarse = scene.with_changes({"master.step": 0.1, "stop_time": 5.0})
    warned = run(coarse, in_process=True).info["warnings"]
    assert any("a single macro step is wrong by" in text and "two steps of half its length" in text for text in warned)
    assert not run(scene, in_process=True).info["warnings"]


@pytest.mark.full
def test_held_forces_of_a_tether_are_a_warning():
    """With held forces its tension is wrong by half of its range at every step that the scene could afford."""
    scene = load_scene("rov-manoeuvre").with_changes({"stop_time": 12.0})
    held = run(scene.with_changes({"master.extrapolation": 0}), in_process=True)
    assert any("a single macro step is wrong by" in text and "tether" in text for text in held.info["warnings"])
    assert not run(scene, in_process=True).info["warnings"]


@pytest.mark.parametrize("change", [{"units.mass.every": 2}, {"master.control": {"method": "milne"}}])
def test_only_equal_steps_of_one_rate_are_repeated(change):
    scene = load_scene("mass-on-spring")
    assert repeatable(scene)
    assert not repeatable(scene.with_changes(change))
