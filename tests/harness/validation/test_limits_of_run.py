"""A run against limits: the rules that hold for its speed and line, numbers with their errors, and an outcome as of a case."""

import json
from dataclasses import replace

import pytest
from cosimo import BadInput, load_scene, run, validate, write_report
from cosimo.orchestrator.harness.many.limits import with_rows
from cosimo.orchestrator.harness.many.plan import plan_settings
from cosimo.orchestrator.harness.validation.limits_of_run import judge
from cosimo.orchestrator.harness.validation.reference import load_table, named_function
from cosimo.orchestrator.judgement import verification
from cosimo.orchestrator.systems.railway.cases.en50367 import conditions, measures, rules, scene_conditions
from cosimo.orchestrator.systems.railway.records import whole_collectors
from cosimo.tests.commands import exit_code

ROW = '[[rows]]\nquantity = "{0}"\nmeasure = "{0}"\nunit = "N"\n{1}\nstanding = "verbatim"\nsource = "sheet"\n'
ONE_WIRE = ("pantograph.contact_force", "pantograph.contact_position", "catenary.wire_height")


@pytest.fixture(scope="module")
def result():
    """Of a quick scene with a pantograph."""
    return run(load_scene("lumped-catenary").with_changes({"limits": {"table": "en50367"}}), in_process=True, verify="whole")


def table(folder, *rows):
    """A user's table of rows (measure, ends)."""
    (folder / "mine.toml").write_text('[sources]\nsheet = "a sheet"\n' + "".join(ROW.format(*row) for row in rows))
    return str(folder / "mine.toml")


@pytest.mark.parametrize(
    ("supply", "speed", "named"),
    [
        ("AC", 160.0, ["AC up to 200 km/h"]),
        ("AC", 200.0, ["AC up to 200 km/h"]),
        ("AC", 200.0000001, ["AC up to 200 km/h"]),  # rounding of a measured speed
        ("AC", 220.0, ["AC above 200 km/h", "AC above 200, up to 250 km/h"]),
        ("AC", 300.0, ["AC above 200 km/h", "AC above 250 km/h"]),
        ("3 kV DC", 160.0, ["3 kV DC up to 200 km/h"]),
        ("1.5 kV DC", 220.0, ["1.5 kV DC above 200 km/h"]),
    ],
)
def test_conditions_follow_from_speed_and_supply(supply, speed, named):
    known = {row.condition for row in load_table("en50367").rows}
    assert [c for c in conditions(supply, speed) if c in known] == named


def test_no_row_of_the_standard_is_more_than_unconfirmed(result):
    """The standard was not at hand: nothing may pass by it."""
    assert {row.standing for row in load_table("en50367").rows} == {"unconfirmed"}
    case, _ = judge(result, result.summary)
    assert case.outcome == "unconfirmed"
    assert "Not assessed" in case.verdict


def test_numbers_of_rules_have_their_errors(result):
    case, answers = judge(result, result.summary)
    rows = {row.reference.measure: row for row in case.findings.rows}
    errors = {row.name: row.error for row in result.summary}
    assert rows["mean_less_target"].error == pytest.approx(errors["pantograph.mean"], rel=1e-6)
    assert rows["statistical_max"].error == errors["pantograph.statistical_max"]
    assert all(row.reference.condition.startswith("pantograph, ") for row in rows.values())
    assert answers["pantograph.mean"] == answers["pantograph.std"] == "unconfirmed"


def test_a_condition_without_a_rule_is_named(result):
    other = replace(result, scene=result.scene.with_changes({"analysis.supply": "3 kV DC"}))
    case, _ = judge(other, other.summary)
    assert any("no rule for contact loss with 3 kV DC" in note for note in case.findings.notes)
    assert {row.reference.condition for row in case.findings.rows} == {"pantograph, 3 kV DC above 200 km/h"}


def test_each_pantograph_is_judged_at_its_own_speed():
    scene = load_scene("two-pantographs").with_changes({"limits": "en50367", "analysis.spans": [5, 5], "stop_time": 4.0})
    result = run(scene.with_changes({"leading.start_position": 130.0}), in_process=True, verify="no")
    case, _ = judge(result, result.summary)
    assert {row.reference.condition.partition(",")[0] for row in case.findings.rows} == {"leading", "trailing"}
    plan = plan_settings({"vary": {"leading.static_force": [110.0, 120.0]}})
    for name in ("en50367", "en50318-2002"):  # many runs, and a table without rules, have rows of each
        chosen = () if name == "en50367" else ("250 km/h",)
        limits = with_rows(plan, table=name, conditions=chosen, scene=result.scene).limits
        numbers = named_function(load_table(name).measures)(result)
        assert {column.partition(".")[0] for column in limits} == {"leading", "trailing"}
        assert limits.keys() <= numbers.keys()
        assert numbers["leading.std"] == numbers["std"] != numbers["trailing.std"]
    by_name = {f"{of.label}.{n}": v for of in rules(result) for n, v in of.measures.items()}
    assert {n: v for n, v in measures(result).items() if "." in n} == pytest.approx(by_name, nan_ok=True)
    other = replace(result, scene=result.scene.with_changes({"limits": {"table": "en50318-2002", "conditions": ["250 km/h"]}}))
    case, answers = judge(other, other.summary)
    assert {name.partition(".")[0] for name in answers} == {"leading", "trailing"}
    simulated = {row.reference.condition: row.simulated for row in case.findings.rows if row.reference.measure == "std"}
    assert simulated == {f"{n}, 250 km/h": result.summary.value(f"{n}.std") for n in ("leading", "trailing")}


def test_collectors_are_judged_as_wholes():
    assert whole_collectors(load_scene("overlap")) == ("pantograph.both_wires",)
    assert whole_collectors(load_scene("two-strips")) == ("pantograph.both_strips",)
    assert whole_collectors(load_scene("two-pantographs")) == ("leading", "trailing")


def test_a_table_of_ones_own_decides(result, tmp_path):
    """One row that passes by far, one that fails, one whose end lies within the error; a quantity that is no figure."""
    mean = result.summary.value("pantograph.mean")
    limits = table(
        tmp_path,
        ("pantograph.mean", f"high = {mean + 1e-9}"),
        ("pantograph.contact_force, maximum below 20 Hz", "low = 1.0"),
        ("pantograph.std", "high = 0.001"),
    )
    scene = result.scene.with_changes({"limits": {"table": limits}})
    judged = run(scene, in_process=True, verify="whole")
    case, answers = judge(judged, judged.summary)
    assert [row.answer for row in case.findings.rows] == ["undecided", "yes", "NO"]
    assert case.outcome == "failed"
    assert answers == {
        "pantograph.mean": "undecided",
        "pantograph.contact_force, maximum below 20 Hz": "in",
        "pantograph.std": "out",
    }
    html = write_report(judged, tmp_path).read_text(encoding="utf-8")
    assert html.index("Failed: 2 of 3 rows") < html.index("<main")
    assert '<div class="out"><dt>standard deviation' in html


def test_the_command_line_judges_and_leaves_files(tmp_path, capsys):
    limits = table(tmp_path, ("pantograph.std", "high = 0.001"))
    assert exit_code("run", "lumped-catenary", "--in-process", "--no-verify", "--limits", limits, "-o", tmp_path / "out") == 1
    assert "Limits of mine: Failed" in capsys.readouterr().out
    (case,) = json.loads((tmp_path / "out" / "validation.json").read_text())["cases"]
    assert [row["inside"] for row in case["rows"]] == [False]
    assert len((tmp_path / "out" / "validation.csv").read_text().splitlines()) == 2


def test_what_cannot_judge_is_refused_before_the_run(tmp_path):
    for limits, named in (
        ({"table": "en5036"}, "'en50367'"),
        ({"table": "en50367", "conditions": ["DC"]}, "condition 'DC'"),
        ({"table": str(tmp_path / "no.toml")}, "There is no"),
    ):
        with pytest.raises(BadInput, match=named):
            run(load_scene("lumped-catenary").with_changes({"limits": limits}), in_process=True)


def test_a_case_is_judged_by_one_line(tmp_path):
    (tmp_path / "case.toml").write_text('title = "Mine"\nscene = "lumped-catenary"\nlimits = "en50367"\n')
    (case,) = validate([str(tmp_path / "case.toml")], tmp_path / "out", in_process=True)
    assert case.outcome == "unconfirmed"
    assert len(case.findings.rows) == 7 - 1  # a lumped catenary does not say what its wire is


@pytest.mark.parametrize(
    ("scene", "options", "word"),
    [
        ("mass-on-spring", ["--limits", "en50367"], "no pantograph on a catenary"),
        ("mass-on-spring", ["--limits", "en50318-2002", "--condition", "250 km/h"], "no pantograph on a catenary"),
        ("lumped-catenary", ["--limits", "en50367", "--record", "pantograph.contact_force"], "no pantograph on a catenary"),
        ("two-contact-wires", ["--limits", "en50367", *(f"--record={n}" for n in ONE_WIRE)], "all of a collector's force"),
        ("lumped-catenary", ["--limits", "paper-wrist"], "rows are of any run"),
    ],
)
def test_a_scene_with_nothing_to_compare_is_refused_before_it_runs(scene, options, word, capsys, monkeypatch):
    monkeypatch.setattr(verification, "run", lambda *_, **__: pytest.fail("it ran"))
    assert exit_code("run", scene, "--in-process", *options) == 2
    error = capsys.readouterr().err
    assert word in error
    assert error.count("cosimo:") == 1


def test_a_scene_says_which_conditions_hold_for_all_its_runs():
    scene = load_scene("en50318-2002")
    assert scene_conditions(scene, ()) == ("AC above 200 km/h", "AC above 200, up to 250 km/h")
    assert scene_conditions(scene.with_changes({"pantograph.speed": 50.0}), ()) == ("AC up to 200 km/h",)
    accelerated = scene.with_changes({"pantograph.effects.acceleration": True})
    several = scene_conditions(accelerated, ()), scene_conditions(scene, ["pantograph.speed"])
    assert several == ((), ())
