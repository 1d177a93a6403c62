"""Trials: counts that can be worked out, failures that keep their reason."""

import math

import pytest
from cosimo.orchestrator.harness.studies.trial import WORK, trial
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import load_scene, read_scene

SCENE = load_scene("mass-on-spring").with_changes({"stop_time": 1.0})


def test_counts_are_those_of_the_settings():
    found = trial(SCENE, {"master.step": 1e-2, "mass.substep": 2.5e-3}, repeats=2)
    assert found.done
    assert set(found.work) == set(WORK)
    assert found.work["macro_steps"] == 100
    assert found.work["hand_overs"] == 200  # two units
    assert found.work["derivative_calls"] == 100 * 4 * 4  # four internal steps of four stages
    assert found.work["calls"] == 1600 + 100 + 200  # the spring counts its steps
    assert found.work["iterations"] == found.work["rollbacks"] == found.work["events"] == 0
    assert found.seconds == found.timing.seconds <= found.timing.median
    assert found.history.time.size == 101


def test_iterations_and_rollbacks_are_counted():
    found = trial(SCENE, {"master.algorithm": "iterative", "master.step": 1e-2}, repeats=1)
    assert found.work["iterations"] >= found.work["macro_steps"] == 100
    assert found.work["hand_overs"] == 2 * found.work["iterations"]
    assert found.work["rollbacks"] > 0


def test_rejected_steps_are_macro_steps_too():
    control = {"method": "doubling", "relative": 1e-6, "absolute": 1e-6}
    found = trial(SCENE, {"master.control": control, "master.step": 5e-2}, repeats=1)
    changed = SCENE.with_changes({"master.control": control, "master.step": 5e-2})
    counts = run(changed, in_process=True).info.counters.stepping
    assert found.work["macro_steps"] == counts.accepted + counts.rejected > counts.accepted


@pytest.mark.parametrize(
    ("changes", "word"),
    [({"master.step": 2.0}, "master.step"), ({"master.algorithm": "jacoby"}, "jacobi"), ({"mass.substep": -1.0}, "substep")],
)
def test_what_cannot_start_is_kept_as_refused(changes, word):
    found = trial(SCENE, changes)
    assert found.outcome == "refused"
    assert word in found.reason
    assert found.time is None
    assert math.isnan(found.seconds)


def test_what_fails_on_the_way_is_kept_with_what_it_computed():
    scene = read_scene(
        {
            "stop_time": 50.0,
            "master": {"step": 0.5, "algorithm": "jacobi", "extrapolation": 0},
            "units": {"a": {"component": "cosimo.tests.support:Mass"}, "b": {"component": "cosimo.tests.support:SpringDamper"}},
            "connections": ["a.x_out -> b.position", "a.v_out -> b.velocity", "b.force -> a.force"],
        }
    )
    found = trial(scene)
    assert found.outcome == "failed"
    assert found.reason
    assert 1 < found.history.time.size < 101
