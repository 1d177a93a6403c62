"""A case is repeated with half of its steps: each row has its error, and one whose range ends within it is undecided."""

import math
from dataclasses import replace

import numpy as np
import pytest
from cosimo import StepFailed, read_scene
from cosimo.orchestrator.harness.report.generic import range_row
from cosimo.orchestrator.harness.validation.case import Case, CaseResult, Row, compare, to_table
from cosimo.orchestrator.harness.validation.questions import Evidence, Options, Question
from cosimo.orchestrator.harness.validation.reference import TableRow
from cosimo.orchestrator.harness.validation.repeated import find
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.scene.shorter_steps import kept_runs, made_runs, runs_with
from cosimo.tests.commands import exit_code
from cosimo.tests.support import exact_two_masses, two_masses

STEP = 5e-3


def table_row(low, high, standing="computed"):
    return TableRow("position", "x", "", "m", low, high, standing, "the closed form", "high" if standing == "unconfirmed" else "")


def position(step=STEP):
    return float(run(read_scene(two_masses("jacobi", step, 0)), in_process=True)["a.x_out"][-1])


def case(low, high, standing="computed", measure=position, counted=None):
    def measured(runs):
        if counted is not None:
            counted.append(runs)
        return Evidence(rows=compare((table_row(low, high, standing),), {"x": measure()}))

    return Case("c", "A case", "It shows.", (Question(measured),))


def test_the_error_of_a_row_is_at_least_half_of_the_true_one():
    (row,) = find(case(-10.0, 10.0), Options()).rows
    end = run(read_scene(two_masses("jacobi", STEP, 0)), in_process=True).end
    true = abs(row.simulated - exact_two_masses(end)[0])
    assert true > 1e-4
    assert 0.5 * true < row.error < 4.0 * true
    assert not row.undecided


@pytest.mark.parametrize(
    ("share", "answer", "outcome"), [(3.0, "yes", "passed"), (0.3, "undecided", "undecided"), (-0.3, "NO", "failed")]
)
def test_a_range_that_ends_within_the_error_is_undecided(share, answer, outcome):
    (row,) = find(case(-10.0, 10.0), Options()).rows
    result = CaseResult(case(0, 0), find(case(-10.0, row.simulated + share * row.error), Options()))
    assert (result.findings.rows[0].answer, result.outcome) == (answer, outcome)
    assert bool(result.warnings) == (answer == "undecided")
    assert result.to_json()["rows"][0]["undecided"] == (answer == "undecided")
    assert ("undecided" in result.verdict.lower()) == (answer == "undecided")


def test_an_unconfirmed_range_decides_nothing_even_where_it_ends_within_the_error():
    (row,) = find(case(-10.0, 10.0), Options()).rows
    result = CaseResult(case(0, 0), find(case(-10.0, row.simulated + 0.3 * row.error, "unconfirmed"), Options()))
    assert result.outcome == "unconfirmed"
    assert "undecided" in result.warnings[0]


def test_a_number_without_macro_steps_has_no_error():
    found = find(case(0.0, 2.0, measure=lambda: 1.0), Options())
    assert math.isnan(found.rows[0].error)
    assert found.unverified == ""


def test_what_takes_long_is_repeated_only_when_asked_for(monkeypatch):
    monkeypatch.setattr("cosimo.orchestrator.run.work.BUDGET", 0.0)
    counted = []
    found = find(case(-10.0, 10.0, counted=counted), Options())
    assert "--verify whole" in found.unverified
    assert math.isnan(found.rows[0].error)
    assert len(counted) == 1
    assert find(case(-10.0, 10.0), Options(), "whole").rows[0].error > 0.0
    assert find(case(-10.0, 10.0), Options(), "no").unverified == "not asked for"


def test_studies_are_made_once():
    made = []
    with_studies = replace(case(-10.0, 10.0), studies=(Question(lambda runs: made.append(runs) or Evidence()),))
    assert find(with_studies, Options()).rows[0].error > 0.0
    assert len(made) == 1


def test_runs_have_shorter_steps_inside_only_and_the_same_rows():
    whole = run(read_scene(two_masses("jacobi", STEP, 0)), in_process=True)
    with runs_with(parts=2):
        half = run(read_scene(two_masses("jacobi", STEP, 0)), in_process=True)
    assert half.scene.master.step == 0.5 * STEP
    assert np.array_equal(whole.time, half.time)
    assert run(read_scene(two_masses("jacobi", STEP, 0)), in_process=True).scene.master.step == STEP


def test_kept_runs_are_kept_apart_for_shorter_steps():
    kept = kept_runs(position)
    first = kept()
    with runs_with(parts=2):
        assert kept() != first
    assert kept() == first


def test_a_repetition_that_fails_says_why():
    def fails_with_short_steps(runs):
        step = runs.run(read_scene(two_masses("jacobi", STEP, 0))).scene.master.step
        if step != STEP:
            raise StepFailed("a", 0.1, "a short step")
        return Evidence(rows=(Row(table_row(0.0, 2.0), 1.0),))

    found = find(Case("c", "A case", "It shows.", (Question(fails_with_short_steps, in_process=True),)), Options())
    assert found.complete
    assert "did not reach its end" in found.unverified


@pytest.mark.parametrize(("options", "shown"), [([], "±"), (["--no-verify"], "not verified, as requested")])
def test_the_terminal_shows_errors_or_says_why_there_are_none(options, shown, tmp_path, capsys):
    assert exit_code("validate", "jeffcott", "--in-process", "-o", tmp_path, *options) == 0
    printed = capsys.readouterr()
    assert shown in printed.out + printed.err


def test_a_row_has_the_error_of_the_mesh_too_which_is_measured_once(tmp_path, monkeypatch):
    """sin 2 t (1 + h): elements of twice the length change it by as much as it is wrong; the second time nothing is run."""
    monkeypatch.setenv("COSIMO_CACHE", str(tmp_path))
    unit = {"component": "cosimo.tests.run.judgement.test_mesh:ByLength"}
    runs = []

    def end():
        runs.append(1)
        scene = read_scene({"stop_time": 1.0, "units": {"a": unit}, "master": {"step": 0.05}})
        return float(run(scene, in_process=True)["a.value"][-1])

    first, second = (find(case(-10.0, 10.0, measure=end), Options()).rows[0] for _ in range(2))
    assert first.error == second.error == pytest.approx(0.1 * abs(math.sin(2.0)))
    assert len(runs) == 3 + 2
    kept = kept_runs(end)
    with made_runs() as scenes:
        kept()
        kept()
    assert len(scenes) == 2


def test_rows_without_an_error_say_why_in_every_output():
    """Not asked for, unchanged by half of the steps, steps that are what is asked about, a repetition that fails: JSON, CSV, page."""

    def fails(runs):
        if runs.run(read_scene(two_masses("jacobi", STEP, 0))).scene.master.step != STEP:
            raise StepFailed("a", 0.1, "a short step")
        return Evidence(rows=(Row(table_row(0.0, 2.0), 1.0),))

    def asked_at_its_steps(runs):
        step = runs.run(read_scene(two_masses("jacobi", STEP, 0)), at_its_steps=True).scene.master.step
        return Evidence(rows=(Row(table_row(0.0, 2.0), step),))

    of = lambda measure: Case("c", "A case", "It shows.", (Question(measure, in_process=True),))  # noqa: E731
    kinds = (
        (case(-10.0, 10.0), "no", "not asked for", "not repeated"),
        (case(0.0, 2.0, measure=lambda: 1.0), "auto", "unchanged", "unchanged"),
        (of(asked_at_its_steps), "whole", "unchanged", "unchanged"),
        (of(fails), "whole", "a short step", "not repeated"),
    )
    for one, wish, why, shown in kinds:
        result = CaseResult(one, find(one, Options(), wish))
        (row,) = result.to_json()["rows"]
        (cells,) = to_table([result])[1]
        assert row["error"] is None
        assert why in row["why"]
        assert why in cells[-1]
        assert range_row(result.findings.rows[0]).simulated.endswith(shown)
