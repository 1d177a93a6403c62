"""Charts and sentences of a case as data: signals of runs, numbers by name, ranges of rows; one message for what is not there."""

import re

import numpy as np
import pytest
from cosimo import BadInput, load_scene, read_scene, validate, write_scene
from cosimo.orchestrator.harness.charts.chart import Grid
from cosimo.orchestrator.harness.charts.described import Described, with_numbers
from cosimo.orchestrator.harness.validation import Evidence
from cosimo.orchestrator.harness.validation.questions import Options, Question
from cosimo.orchestrator.harness.validation.reference import TableRow
from cosimo.orchestrator.harness.validation.shipped import read_shipped
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.settings.chart import ChartSettings
from cosimo.tests.support import two_masses

ROW = TableRow("largest position", "x.max", "soft", "m", 0.0, 2.0, "computed", "a closed form")
NUMBERS = {"t": np.arange(5.0), "x.1": 3.0, "x.2": 4.0, "way": {"one": np.arange(5.0), "other": ([0.0, 1.0], [2.0, 3.0])}}


@pytest.fixture(scope="module")
def result():
    return run(read_scene(two_masses("jacobi", 1e-3, 2)), in_process=True)


def chart(result, **panel):
    settings = {"title": "Motion", "panels": [{"label": "x, mm", **panel}]}
    runs = {"soft": result, "hard": result}
    return Described("case", NUMBERS, runs, lambda: {"x.max": ROW}).chart(ChartSettings.model_validate(settings))


def test_a_signal_is_drawn_in_the_unit_that_is_asked_for(result):
    """Over time, and over another signal; every second row from an instant to another."""
    (line,) = chart(result, run="soft", scale="mm", series=[{"signal": "a.x_out", "name": "mass"}]).panels[0].series
    assert line.name == "mass"
    np.testing.assert_array_equal(line.x, result.time)
    np.testing.assert_allclose(line.y, 1e3 * result["a.x_out"], rtol=1e-15)
    drawn = result.series("a.x_out", over="a.v_out", since=result.time[4], until=result.time[9], every=2)
    np.testing.assert_array_equal(drawn.x, result["a.v_out"][4:10:2])
    assert drawn.name == "a.x_out"


def test_a_pattern_of_runs_is_a_line_for_each(result):
    lines = chart(result, series=[{"run": "*", "signal": "a.x_out", "kind": "points"}]).panels[0].series
    assert [(s.name, s.kind) for s in lines] == [("soft", "points"), ("hard", "points")]


def test_numbers_are_named_matched_by_patterns_and_taken_from_tables(result):
    panel = chart(result, series=[{"x": [1.0, 2.0], "y": "x.*", "name": "ends"}, {"each": "way", "x": "t", "scale": 2.0}]).panels[
        0
    ]
    ends, one, other = panel.series
    assert (list(ends.x), list(ends.y)) == ([1.0, 2.0], [3.0, 4.0])
    np.testing.assert_array_equal(one.y, 2.0 * np.arange(5.0))
    assert (one.name, other.name, list(other.x), list(other.y)) == ("one", "other", [0.0, 1.0], [4.0, 6.0])


def test_a_range_is_that_of_the_row_and_a_table_has_its_numbers(result):
    (band,) = chart(result, limits=["x.max"]).panels[0].bands
    assert (band.low, band.high, band.standing) == (0.0, 2.0, "computed")
    settings = {"title": "Ends", "header": ["what", "m"], "rows": [["first", "x.1"], ["second", "x.2:.2f"]]}
    table = Described("case", NUMBERS, {}, dict).chart(ChartSettings.model_validate(settings))
    assert isinstance(table, Grid)
    assert table.rows == (("first", 3.0), ("second", "4.00"))


@pytest.mark.parametrize(
    ("panel", "words"),
    [
        ({"series": [{"run": "sofd", "signal": "a.x_out"}]}, "run 'sofd', expected the label of a run. Did you mean 'soft'"),
        ({"run": "soft", "series": [{"signal": "a.x_ou"}]}, "'a.x_ou', expected a recorded signal"),
        ({"run": "soft", "series": [{"signal": "a.x_out", "scale": "kg"}]}, "'m' for 'kg'"),
        ({"series": [{"x": "t", "y": "wai"}]}, "'wai', expected the name of something that the case measures"),
        ({"limits": ["x.most"]}, "'x.most', expected the measure of a row"),
    ],
)
def test_what_there_is_not_is_one_message(result, panel, words):
    with pytest.raises(BadInput, match=re.escape(words)):
        chart(result, **panel)


def test_a_sentence_shows_what_was_measured():
    assert with_numbers("From {a.1:.2f} to {b} m.", {"a.1": 1.234, "b": 2}) == "From 1.23 to 2 m."
    with pytest.raises(BadInput, match=r"'c', expected a number that the case measures"):
        with_numbers("{c}", {"a": 1.0})


def test_a_question_tells_and_shows_what_its_file_says():
    scene = read_scene(two_masses("jacobi", 1e-3, 2))
    asked = Question(
        lambda runs: Evidence({"end": runs["soft"]["a.x_out"][-1]}, data={"first": 2.0}),
        lambda: {"soft": scene, ("hard", 2): scene},
        notes=("It begins with {first:g} and ends at {end:.3f} m.",),
        show=("hard*",),
        claim="X1",
    ).ask(Options(in_process=True))
    assert asked.notes == (f"It begins with 2 and ends at {asked.numbers['end']:.3f} m.",)
    assert list(asked.shown) == ["hard, 2"]
    assert asked.claim == "X1"


def test_a_chart_of_no_question_is_refused(tmp_path):
    text = 'title = "T"\ntext = "x"\n[[questions]]\nmeasure = "one"\n[[questions]]\nmeasure = "other"\n[[charts]]\ntitle = "C"\n'
    (tmp_path / "case.toml").write_text(text, encoding="utf-8")
    with pytest.raises(BadInput, match=r"question '', expected one of one, other"):
        read_shipped(tmp_path / "case.toml", "cosimo", "none", load_scene)


OWN = """
title = "Two masses, soft and hard"
scene = "masses.toml"
measure = "ends:measure"
[sources]
form = "a closed form"
[[runs]]
condition = "soft"
[[runs]]
condition = "damped"
changes = { stop_time = 1.0 }
[[rows]]
quantity = "last position"
measure = "last"
condition = "soft"
unit = "m"
low = -100.0
high = 100.0
standing = "computed"
source = "form"
[[charts]]
title = "Both runs, the first one ends at {soft.last:.3f} m"
[[charts.panels]]
label = "position, mm"
limits = ["soft: last"]
series = [{ run = "*", signal = "a.x_out", scale = "mm" }]
"""
ENDS = """
def measure(runs):
    ends = {condition: {"last": float(result["a.x_out"][-1])} for condition, result in runs.items()}
    return {**ends, "soft.last": ends["soft"]["last"]}
"""


def test_a_case_of_one_s_own_measures_by_a_function_and_draws_several_runs(tmp_path):
    write_scene(read_scene(two_masses("jacobi", 1e-3, 2)), tmp_path / "masses.toml")
    (tmp_path / "case.toml").write_text(OWN, encoding="utf-8")
    (tmp_path / "ends.py").write_text(ENDS, encoding="utf-8")
    (case,) = validate([str(tmp_path / "case.toml")], tmp_path / "out", in_process=True, verify="no")
    (row,) = case.findings.rows
    end = case.findings.runs["soft"]["a.x_out"][-1]
    assert (row.simulated, case.outcome) == (end, "passed")
    (drawn,) = case.findings.charts
    assert drawn.title == f"Both runs, the first one ends at {end:.3f} m"
    assert [s.name for s in drawn.panels[0].series] == ["soft", "damped"]
    assert "position, mm" in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")


def test_a_function_that_there_is_not_is_one_message(tmp_path):
    write_scene(read_scene(two_masses("jacobi", 1e-3, 2)), tmp_path / "masses.toml")
    (tmp_path / "case.toml").write_text(OWN, encoding="utf-8")
    with pytest.raises(BadInput, match=r"measure: got 'ends:measure', expected module:function"):
        validate([str(tmp_path / "case.toml")], tmp_path / "out")
    (tmp_path / "ends.py").write_text("def measures(runs): pass\n", encoding="utf-8")
    with pytest.raises(BadInput, match=r"'measure', expected a function of ends\. Did you mean 'measures'"):
        validate([str(tmp_path / "case.toml")], tmp_path / "out")
