"""A user's own case: ranges and measured curves of a file of theirs, and one message for what cannot be used."""

import json

import numpy as np
import pytest
from cosimo import BadInput, load_scene, read_scene, validate, write_scene
from cosimo.orchestrator.harness.report.first_page import simulated
from cosimo.orchestrator.harness.validation.curves import compare_curve
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.scene.measured import read_curve
from cosimo.orchestrator.settings.case import CurveSettings
from cosimo.orchestrator.systems import SYSTEMS
from cosimo.tests.commands import exit_code
from cosimo.tests.support import two_masses

CASE = """
title = "Two masses"
scene = "masses.toml"
[sources]
rig = "a test rig of this test"
[[runs]]
condition = "soft"
[[rows]]
quantity = "largest position"
measure = "a.x_out, maximum"
condition = "soft"
unit = "m"
high = 100.0
standing = "verbatim"
source = "rig"
[[curves]]
signal = "a.x_out"
condition = "soft"
file = "measured.csv"
time = "t"
column = "x_mm"
separator = ";"
scale = 1e-3
tolerances = { mean = 0.01, "standard deviation" = 0.01, difference = 0.01 }
source = "rig"
"""


@pytest.fixture(scope="module")
def result():
    return run(read_scene(two_masses("jacobi", 1e-3, 2)), in_process=True)


@pytest.fixture
def folder(tmp_path, result):
    write_scene(read_scene(two_masses("jacobi", 1e-3, 2)), tmp_path / "masses.toml")
    write(tmp_path, result.time, 1e3 * result["a.x_out"])
    (tmp_path / "case.toml").write_text(CASE, encoding="utf-8")
    return tmp_path


def write(folder, time, values):
    lines = [f"{t:.9g};{x:.12g}" for t, x in zip(time, values, strict=True)]
    (folder / "measured.csv").write_text("\n".join(["t;x_mm", *lines]) + "\n", encoding="utf-8")


def test_a_case_that_measures_what_is_simulated_passes(folder):
    (folder / "case.toml").write_text(f'{CASE}[document]\ntitle = "Sheet 12"\nauthor = "A. Author"\n', encoding="utf-8")
    (case,) = validate([str(folder / "case.toml")], folder / "out", in_process=True)
    assert case.outcome == "passed"
    assert [r.inside for r in case.findings.rows] == [True] * 4
    assert {r.reference.standing for r in case.findings.rows} == {"verbatim", "measured"}
    (document,) = json.loads((folder / "out" / "validation.json").read_text())["cases"]
    assert document["outcome"] == "passed"
    html = (folder / "out" / "report.html").read_text(encoding="utf-8")
    assert "a.x_out against the measurement, soft" in html
    first = html[html.index("<h1>Sheet 12</h1>") : html.index("Settings</h3>")]
    assert all(text in first for text in ("A. Author", "Prepared by", "What was simulated", "largest position"))


def test_inputs_of_runs_stand_apart_where_they_differ():
    """Of two speeds the speed, with its unit; what both have once."""
    scene = load_scene("lumped-catenary").with_changes({"stop_time": 0.02})
    runs = {c: run(scene.with_changes({"pantograph.speed": v}), in_process=True) for c, v in (("a", 50.0), ("b", 60.0))}
    objects, varied, inputs = simulated(runs, SYSTEMS)
    ((name, first, second),) = varied.rows
    assert name.startswith("speed")
    assert (varied.header, first, second) == (("input", "a", "b"), "180 km/h", "216 km/h")
    assert name not in dict(inputs.rows)
    assert objects.title == "What was simulated"


def test_a_measurement_ten_percent_higher_fails_with_exit_code_1(folder, result, capsys):
    write(folder, result.time, 1.1e3 * result["a.x_out"])
    assert exit_code("validate", folder / "case.toml", "--in-process", "-o", folder / "out") == 1
    (case,) = validate([str(folder / "case.toml")], folder / "out", in_process=True)
    by_kind = {r.reference.measure.split(" ", 1)[1]: r for r in case.findings.rows if r.reference.standing == "measured"}
    assert not any(r.inside for r in by_kind.values())
    spread = by_kind["standard deviation"]
    assert 0.5 * (spread.reference.low + spread.reference.high) == pytest.approx(1.1 * spread.simulated, rel=1e-3)


def test_without_runs_and_conditions_the_scene_is_run_as_it_is(folder):
    text = CASE.replace('[[runs]]\ncondition = "soft"\n', "").replace('condition = "soft"\n', "")
    (folder / "case.toml").write_text(text, encoding="utf-8")
    (case,) = validate([str(folder / "case.toml")], folder / "out", in_process=True)
    assert case.outcome == "passed"
    assert {r.reference.condition for r in case.findings.rows} == {*case.findings.runs}


def test_rows_and_curves_without_a_condition_are_of_the_only_run(folder):
    text = CASE.replace('condition = "soft"\n', "").replace("[[runs]]\n", '[[runs]]\ncondition = "soft"\n')
    (folder / "case.toml").write_text(text, encoding="utf-8")
    (case,) = validate([str(folder / "case.toml")], folder / "out", in_process=True)
    assert case.outcome == "passed"
    assert {r.reference.condition for r in case.findings.rows} == {"soft"}


def test_a_condition_twice_is_refused(folder):
    text = CASE.replace('[[runs]]\ncondition = "soft"\n', '[[runs]]\ncondition = "soft"\n' * 2)
    (folder / "case.toml").write_text(text, encoding="utf-8")
    with pytest.raises(BadInput, match="'soft' twice"):
        validate([str(folder / "case.toml")], folder / "out", in_process=True)


def test_a_filtered_curve_over_a_position_is_compared_there(tmp_path):
    """A sine of 5 Hz in the simulated force, and the same with 60 Hz on top as measured: below 20 Hz they are the same."""
    scene = load_scene("lumped-catenary").with_changes({"stop_time": 4.0, "analysis.transient": 0.0})
    simulated = run(scene, in_process=True)
    t, x, force = simulated.time, simulated["pantograph.contact_position"], simulated["pantograph.contact_force"]
    measured = force + 30.0 * np.sin(2.0 * np.pi * 60.0 * t)
    table = np.column_stack([x, measured])[500:3500]
    np.savetxt(tmp_path / "force.csv", table, delimiter=",", header="x,F", comments="", fmt="%.9f")
    curve = CurveSettings(
        signal="pantograph.contact_force",
        over="pantograph.contact_position",
        file="force.csv",
        over_column="x",
        column="F",
        cutoff=20.0,
        source="s",
    )
    comparison = compare_curve(curve, read_curve(curve, tmp_path, simulated.measures), simulated)
    assert comparison.time[0] == pytest.approx(0.5 + 2.0 / 20.0, abs=0.01)
    difference, spread = comparison.numbers["difference"][1], comparison.numbers["standard deviation"][1]
    assert difference < 0.05 * spread
    raw = compare_curve(curve.model_copy(update={"cutoff": None}), read_curve(curve, tmp_path, simulated.measures), simulated)
    assert raw.numbers["difference"][1] == pytest.approx(30.0 / np.sqrt(2.0), rel=0.02)


@pytest.mark.parametrize(
    ("old", "new", "named"),
    [
        ('scene = "masses.toml"', 'scene = "masse.toml"', "masse.toml"),
        ('condition = "soft"\n[[rows]]', 'condition = "hard"\n[[rows]]', "condition"),
        ('"a.x_out, maximum"', '"a.x_aut, maximum"', "a.x_aut"),
        ('unit = "m"', 'unit = "mm"', "'mm'"),
        ('standing = "verbatim"', 'standing = "certain"', "one of verbatim"),
        ("high = 100.0", "", "no low and no high"),
        ('source = "rig"\n[[curves]]', 'source = "rug"\n[[curves]]', "rug"),
        ('file = "measured.csv"', 'file = "measure.csv"', "measure.csv"),
        ('column = "x_mm"', 'column = "x_m"', "x_mm"),
        ('separator = ";"', 'separator = ","', "no column"),
        ("scale = 1e-3", "scale = 1.0", "scale = 1 beside the unit 'mm', expected scale = 0.001"),
        ("mean = 0.01", "median = 0.01", "median"),
        ("mean = 0.01", "mean = -0.01", "greater than 0"),
        ("mean = 0.01", "mean = 5.0", "tolerance of mean = 5, expected a share below 1. 5 % is written 0.05"),
        ("high = 100.0", "value = 1.0\ntolerance = 10", "tolerance = 10, expected a share of the value"),
        ("scale = 1e-3", "shift = 1e6", "a stretch that both have"),
        ("[sources]", "[source]", "source"),
        ("[[rows]]", "[[row]]", "row"),
    ],
)
def test_what_cannot_be_used_is_one_message(old, new, named, folder):
    assert CASE.count(old) >= 1
    (folder / "case.toml").write_text(CASE.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(BadInput, match=named):
        validate([str(folder / "case.toml")], folder / "out", in_process=True)


@pytest.mark.parametrize(
    ("lines", "named"),
    [
        (["t;x_mm", "0;1", "1;2"], "2 lines"),
        (["t;x_mm", *(f"{k};1" for k in range(9)), "4;1"], "measured.csv, line 11.*does not rise"),
        (
            ["t;x_mm", *(f"{k};1" for k in range(9)), "9;1,5", "10;2.5"],
            "'x_mm': got decimals with ',' in line 11 and '.' in line 12",
        ),
        (["t;x_mm", *(f"{k};1" for k in range(9)), "9;inf"], "not finite"),
        ([], "a header and rows"),
    ],
)
def test_a_broken_file_is_named_with_its_line(lines, named, folder):
    (folder / "measured.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    with pytest.raises(BadInput, match=named):
        validate([str(folder / "case.toml")], folder / "out", in_process=True)


def test_an_unknown_file_and_an_unknown_name_are_told_apart(tmp_path):
    with pytest.raises(BadInput, match="the file of a case"):
        validate([str(tmp_path / "nothing.toml")], tmp_path)
    with pytest.raises(BadInput, match=r"or the \.toml file of one"):
        validate(["nothing"], tmp_path)


def test_rows_may_stand_in_a_file_of_a_spreadsheet(folder, tmp_path, capsys):
    """The same case, its rows a CSV file beside it; a file that is not there is told."""
    first, behind = CASE.index("[[rows]]"), CASE.index("[[curves]]")
    text = CASE[:first] + CASE[behind:]
    (folder / "case.toml").write_text(text.replace("[sources]", 'rows = "limits.csv"\n[sources]', 1), encoding="utf-8")
    assert exit_code("validate", folder / "case.toml", "-o", tmp_path / "none") == 2
    assert "limits.csv" in capsys.readouterr().err
    (folder / "limits.csv").write_text(
        "quantity;measure;condition;unit;high;standing;source\nlargest position;a.x_out, maximum;soft;m;100.0;verbatim;rig\n",
        encoding="utf-8",
    )
    assert exit_code("validate", folder / "case.toml", "--json", "--no-verify", "-o", tmp_path / "out") == 0
    (case,) = json.loads(capsys.readouterr().out)["cases"]
    assert [row["high"] for row in case["rows"] if row["quantity"] == "largest position"] == [100.0]
