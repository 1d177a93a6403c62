"""Errors of many runs: what half of every step changes, against closed forms; which points are repeated, when none is."""

import json
import threading
from collections import Counter
from time import sleep

import numpy as np
import pytest
import tomli_w
from cosimo.orchestrator.harness.many import repetition
from cosimo.orchestrator.harness.many.design import design
from cosimo.orchestrator.harness.many.fitting import fit
from cosimo.orchestrator.harness.many.measures import PointResult
from cosimo.orchestrator.harness.many.plan import plan_of, plan_settings
from cosimo.orchestrator.harness.many.point_runs import PointRuns
from cosimo.orchestrator.harness.many.repetition import compared, ends_and_some
from cosimo.orchestrator.harness.many.sensitivity import sensitivity
from cosimo.orchestrator.harness.many.uncertainty import uncertainty
from cosimo.orchestrator.run import work
from cosimo.orchestrator.run.key_results import KeyResults
from cosimo.orchestrator.scene.shorter_steps import runs_with
from cosimo.orchestrator.systems import load_scene, read_scene
from cosimo.orchestrator.systems.many import sweep
from cosimo.tests.commands import exit_code
from cosimo.tests.harness.many.points import formula

END = "mass.base_x, end"
STIFFNESS = np.linspace(50.0, 200.0, 7)  # N/m


def held(step=0.01):
    """Mass on a spring and damper with held forces, an error of first order; 1 s."""
    return load_scene("mass-on-spring").with_changes(
        {"stop_time": 1.0, "master": {"algorithm": "jacobi", "step": step, "extrapolation": 0}}
    )


def exact_end(stiffness):
    """x(1 s) of m = 1 kg, c = 4 N.s/m, v0 = 1 m/s."""
    omega = np.sqrt(stiffness - 4.0)
    return np.exp(-2.0) * np.sin(omega) / omega


def test_stated_errors_hold_the_true_ones(tmp_path):
    result = sweep(held(), {"vary": {"spring.stiffness": STIFFNESS.tolist()}, "keep": {"quantities": [END]}}, tmp_path)
    repeated = result.repeated
    assert {0, 6} < set(repeated.points)
    assert repeated.points == repeated.chosen
    true = np.abs(result.measures[END] - exact_end(STIFFNESS))[list(repeated.points)].max()
    assert 0.7 * true < repeated.errors[END] < 2.0 * true
    written = json.loads((tmp_path / "sweep.json").read_text())["verification"]
    assert written["points"] == list(repeated.points)
    assert written["errors"][END]["error"] == repeated.errors[END]
    assert "shorten master.step and the substeps" in " ".join(result.remarks)


def test_repeated_points_are_kept_and_change_no_number(tmp_path, monkeypatch):
    plan = {"vary": {"spring.stiffness": [50.0, 100.0]}}
    first = sweep(held(), plan, tmp_path)
    monkeypatch.setattr(repetition, "Computing", lambda *_, **__: pytest.fail("a point was repeated again"))
    again, without = sweep(held(), plan, tmp_path), sweep(held(), plan, verify=False)
    assert again.repeated == first.repeated
    assert without.repeated is None
    for name, values in without.measures.items():
        assert values.tobytes() == first.measures[name].tobytes()


def test_who_computes_repeated_points_changes_no_number(monkeypatch):
    """In this thread, by threads, and where no kernel alone steps the scene by other processes; threads share them."""
    threads, row = set(), PointRuns.row

    def seen(self, values):
        threads.add((self._task.alterations.parts, threading.get_ident()))
        sleep(0.01)
        return row(self, values)

    plan = {"vary": {"spring.stiffness": STIFFNESS.tolist()}}
    one = sweep(held(), plan, jobs=1)
    monkeypatch.setattr(PointRuns, "row", seen)
    two = sweep(held(), plan, jobs=2)
    assert Counter(parts for parts, _ in threads) == {1: 2, 2: 2}
    iterated = load_scene("mass-on-spring").with_changes({"stop_time": 0.2, "master": {"algorithm": "iterative", "step": 0.01}})
    few = {"vary": {"spring.stiffness": [50.0, 100.0, 200.0]}}
    results = [(one, two), tuple(sweep(iterated, few, jobs=jobs) for jobs in (1, 2))]
    for first, second in results:
        assert len(first.repeated.points) > 2
        assert first.repeated == second.repeated
        assert max(first.repeated.shares.values()) > 0.0


def test_points_of_a_case_are_altered_as_its_runs_are(tmp_path):
    """A sweep within a function of a validation case, in threads, too; each point is altered once, and kept apart from the others."""
    plan, asked = {"vary": {"master.step": [0.02, 0.01]}, "keep": {"quantities": [END]}}, {"jobs": 2, "verify": False}
    whole = sweep(held(), plan, tmp_path, **asked)
    with runs_with(parts=2):
        half = sweep(held(), plan, tmp_path, **asked)
    exact = sweep(held(), {**plan, "vary": {"master.step": [0.01, 0.005]}, "keep": {"quantities": [END]}}, **asked)
    np.testing.assert_allclose(half.measures[END], exact.measures[END], rtol=1e-9)
    assert np.abs(half.measures[END] / whole.measures[END] - 1.0).min() > 1e-3
    with runs_with(parts=2):
        spring = sweep(held(), {"vary": {"spring.stiffness": [50.0, 100.0]}, "keep": {"quantities": [END]}}, **asked)
    finer = sweep(held(0.005), {"vary": {"spring.stiffness": [50.0, 100.0]}, "keep": {"quantities": [END]}}, **asked)
    np.testing.assert_allclose(spring.measures[END], finer.measures[END], rtol=1e-9)


def test_some_points_are_left_where_they_take_too_long(monkeypatch):
    """One is repeated in any case."""
    monkeypatch.setattr(work, "BUDGET", 0.0)
    result = sweep(held(), {"vary": {"spring.stiffness": STIFFNESS.tolist()}})
    assert len(result.repeated.points) == 1 < len(result.repeated.chosen)
    assert "too much work" in result.repeated.summary(7)


def test_ends_of_every_parameter_are_among_the_points():
    scene = held()
    grid = plan_of(scene, plan_settings({"vary": {"spring.stiffness": [1.0, 2.0, 3.0], "mass.mass": [1.0, 2.0, 3.0, 4.0]}}))
    everywhere = np.ones(12, dtype=bool)
    assert ends_and_some(grid, everywhere)[:2] == [0, 11]
    drawn = plan_of(
        scene,
        plan_settings(
            {
                "method": "random",
                "points": 50,
                "seed": 1,
                "vary": {"spring.stiffness": {"distribution": "uniform", "low": 1.0, "high": 9.0}, "master.step": [1e-3, 2e-3]},
            }
        ),
    )
    values = drawn.columns["spring.stiffness"].labels
    chosen = ends_and_some(drawn, np.ones(50, dtype=bool))
    assert {values.argmin(), values.argmax()} <= set(chosen)
    assert len(chosen) <= 4 + repetition.AT_RANDOM
    failed = np.ones(50, dtype=bool)
    failed[values.argmin()] = False
    assert values.argmin() not in ends_and_some(drawn, failed)
    assert ends_and_some(drawn, ~everywhere[:1].repeat(50)) == []


def test_a_macro_step_that_varies_is_halved_as_well():
    plan = {"vary": {"master.step": [0.02, 0.01, 0.005]}, "keep": {"quantities": [END]}}
    result = sweep(held(), plan)
    assert result.repeated.at[END] == 0
    true = abs(result.measures[END][0] - exact_end(100.0))
    assert 0.7 * true < result.repeated.errors[END] < 2.0 * true


def test_an_internal_step_that_varies_is_halved_as_well():
    """Each point with half of its own: the macro step alone changes nothing of a single unit."""
    scene, end, steps = (
        load_scene("double-pendulum").with_changes({"stop_time": 2.0, "master.step": 0.1}),
        "chain.tip_x, end",
        [0.05, 0.025],
    )
    result = sweep(scene, {"vary": {"chain.substep": steps}, "keep": {"quantities": [end]}})
    finer = sweep(scene, {"vary": {"chain.substep": [0.5 * h for h in steps]}, "keep": {"quantities": [end]}}, verify=False)
    differences = np.abs(result.measures[end] - finer.measures[end])
    assert result.repeated.errors[end] >= 0.9 * differences.max() > 0.0


def test_a_mean_near_zero_is_judged_by_the_size_of_its_signal_and_failed_points_are_named():
    numbers = {"a.x, mean": np.array([1e-9, np.nan]), "a.x, maximum": np.array([2.0, np.nan]), "own": np.array([4.0, np.nan])}
    half = {
        0: PointResult("done", numbers=KeyResults({"a.x, mean": 1e-3, "a.x, maximum": 2.0, "own": 3.0})),
        1: PointResult("failed", "it breaks"),
    }
    judged = compared([0, 1], half, numbers)
    assert judged.shares == pytest.approx({"a.x, mean": 1e-3, "a.x, maximum": 0.0, "own": 0.5}, rel=1e-5)
    text = " ".join(judged.messages())
    assert "own by up to ±2, 50 %" in text
    assert "point 1 does not come to its end" in text
    assert "it breaks" in text


def test_distributions_that_are_blurred_by_the_macro_step_say_so():
    plan = {
        "method": "random",
        "points": 20,
        "seed": 1,
        "vary": {"spring.stiffness": {"distribution": "uniform", "low": 99.0, "high": 101.0}},
    }
    blurred, sharp = (uncertainty(held(step), plan, quantities=[END]) for step in (0.01, 1e-4))
    assert any("standard deviation over the points" in text for text in blurred.messages)
    assert not any("standard deviation over the points" in text for text in sharp.messages)
    assert uncertainty(held(), plan, quantities=[END], verify=False).sweep.repeated is None


def test_indices_that_are_blurred_by_the_macro_step_say_so():
    pytest.importorskip("SALib")
    narrow = {
        name: {"distribution": "uniform", "low": 0.99 * value, "high": 1.01 * value}
        for name, value in (("spring.stiffness", 100.0), ("mass.mass", 1.0))
    }
    answer = sensitivity(held(0.02), {"method": "random", "points": 1, "vary": narrow}, quantities=[END], samples=8)
    assert any("standard deviation over the points" in text for text in answer.messages)


def test_a_design_has_the_error_of_its_aim_and_says_which_limits_it_blurs():
    settings = {
        "minimise": "mass.base_x, maximum",
        "vary": {"spring.stiffness": {"low": 50.0, "high": 200.0}},
        "constraints": {"spring.second_force_x, maximum": {"high": 6.0}},
        "evaluations": 30,
    }
    answer = design(held(), settings)
    assert answer.repeated.errors["mass.base_x, maximum"] > 0.0
    assert any("kept by less than its numerical error" in text for text in answer.messages)
    assert design(held(), settings, verify=False).repeated is None


def test_a_fit_says_where_its_run_is_less_exact_than_the_measurement():
    settings = {
        "vary": {"spring.stiffness": {"low": 80.0, "high": 120.0}},
        "targets": [{"quantity": END, "value": float(exact_end(100.0)), "deviation": 1e-4}],
    }
    assert any("numerical error of the fitted run" in text for text in fit(held(), settings).fit.messages)
    assert not any("numerical error" in text for text in fit(held(), settings, verify=False).fit.messages)
    coarse = {**settings, "targets": [{**settings["targets"][0], "deviation": 1.0}]}
    assert not any("numerical error" in text for text in fit(held(), coarse).fit.messages)


def test_a_scene_without_a_macro_step_that_matters_has_no_error():
    result = sweep(read_scene(formula()), {"vary": {"f.a": [0.0, 1.0]}})
    assert set(result.repeated.errors.values()) == {0.0}
    assert result.remarks == ()


def test_the_command_prints_which_points_were_repeated(tmp_path, capsys):
    (tmp_path / "plan.toml").write_text(tomli_w.dumps({"vary": {"spring.stiffness": [50.0, 100.0, 200.0]}}))
    command = ["sweep", "mass-on-spring", "--plan", str(tmp_path / "plan.toml"), "-o", str(tmp_path / "out")]
    _ends_well(command)
    assert "3 of 3 points, at the ends and at random, repeated with half of every step" in capsys.readouterr().out
    page = (tmp_path / "out" / "report.html").read_text()
    assert "Numerical errors" in page
    _ends_well([*command, "--no-verify"])
    assert "no point was repeated" in capsys.readouterr().out


def _ends_well(command):
    assert exit_code(*command) == 0
