"""Claims of papers: verdicts follow from rows, tables are complete, and what they point to exists."""

import json
import math
import runpy
from pathlib import Path

import pytest
from cosimo.components.catalogue import CATALOGUE, component_class
from cosimo.components.core.errors import BadInput, StepFailed
from cosimo.orchestrator.harness.charts.chart import Chart, Panel, Series
from cosimo.orchestrator.harness.validation.case import Case, CaseResult, ClaimResult, Findings, Row, claim_results
from cosimo.orchestrator.harness.validation.claims import Claim
from cosimo.orchestrator.harness.validation.questions import Evidence, Question
from cosimo.orchestrator.harness.validation.reference import TableRow, load_table, parse_table
from cosimo.orchestrator.systems import cases, papers, validate
from cosimo.tests.commands import exit_code

BUILT = "by construction"
ROOT = Path(__file__).resolve().parents[3]


def row(inside, role="supports", standing="computed", claim="X1"):
    confidence = "high" if standing == "unconfirmed" else ""
    reference = TableRow("force", "force", "at rest", "N", 0.0, 1.0, standing, "a closed form", confidence, claim, role)
    return Row(reference, 0.5 if inside else 2.0)


def claim(kind="finding", verdict="shown", number="X1"):
    return Claim(number, kind, "it moves", verdict, "more than nothing", "why", ("Catenary",))


@pytest.mark.parametrize(
    ("rows", "verdict"),
    [
        ([row(True)], "shown"),
        ([row(True), row(False)], "partly"),
        ([row(False)], "not shown"),
        ([row(True), row(True, "limits")], "partly"),
        ([row(True), row(False, "limits")], "shown"),
        ([row(False), row(True, "limits")], "not shown"),
        ([row(True), row(True, "contradicts")], "contradicted"),
        ([row(True), row(False, "contradicts")], "shown"),
        ([row(True), row(False, standing="unconfirmed")], "shown"),
        ([row(True, standing="unconfirmed")], "not shown"),
        ([], "not shown"),
        ([row(True, BUILT)], BUILT),
        ([row(True, BUILT), row(True)], "shown"),
        ([row(True, BUILT), row(False)], "not shown"),
        ([row(True, BUILT), row(True), row(False)], "partly"),
        ([row(True, BUILT), row(True, "contradicts")], "contradicted"),
        ([row(False, BUILT)], "not shown"),
        ([row(False, BUILT), row(True)], "partly"),
    ],
)
def test_the_verdict_follows_from_the_rows(rows, verdict):
    assert ClaimResult(claim(), tuple(rows)).verdict == verdict


def test_a_model_is_shown_by_what_it_points_to_unless_a_row_denies_it():
    assert ClaimResult(claim("model"), ()).verdict == "shown"
    assert ClaimResult(claim("model"), (row(False),)).verdict == "not shown"
    assert ClaimResult(claim("model"), (row(True, BUILT),)).verdict == "shown"
    assert ClaimResult(claim("model"), (row(False, BUILT),)).verdict == "not shown"


def test_a_claim_of_which_a_part_is_not_modelled_is_shown_partly():
    one = Claim("X1", "model", "it walks and swims", "partly", "", "it does not walk", ("Catenary",), "walking")
    assert ClaimResult(one, ()).verdict == "partly"
    assert ClaimResult(one, (row(False),)).verdict == "not shown"


def test_what_was_not_measured_shows_nothing():
    assert ClaimResult(claim(), (Row(row(True).reference, math.nan),)).verdict == "not shown"


def test_a_paper_fails_when_a_verdict_is_not_the_reviewed_one():
    case = Case("paper-x", "X", "text", ())

    def outcome(reviewed, *rows, complete=True):
        found = claim_results([claim(verdict=reviewed)], rows, {})
        return CaseResult(case, Findings(tuple(rows), complete=complete, claims=found)).outcome

    assert outcome("shown", row(True)) == "passed"
    assert outcome("partly", row(True), row(False)) == "passed"
    assert outcome("partly", row(True)) == "failed"
    assert outcome("shown", row(True), complete=False) == "failed"


TABLE = """
title = "A paper"
text = "Known by its abstract."
[sources]
closed = "closed form, derived for this test"
[[claims]]
number = "X1"
kind = "finding"
announced = "the force is small"
criterion = "below 1 N, as one spring of 1 N/m at 1 m gives no more"
verdict = "shown"
[[claims]]
number = "X2"
kind = "model"
announced = "a spring"
verdict = "shown"
shown_by = ["Catenary", "docs/validation.md"]
"""
ROWS = "claim,role,quantity,measure,condition,unit,high,standing,source\nX1,,force,force,at rest,N,1.0,computed,closed\n"


@pytest.mark.parametrize(
    ("old", "new", "named"),
    [
        ('verdict = "shown"', 'verdict = "proven"', "one of shown"),
        ('verdict = "shown"', 'verdict = "partly"', "discussion"),
        ('criterion = "below 1 N, as one spring of 1 N/m at 1 m gives no more"', "", "criterion"),
        ('shown_by = ["Catenary", "docs/validation.md"]', "", "shown_by"),
        ("X1,,", "X9,,", "X9"),
        ("X1,,", "X2,,", "no row for X1"),
        ('number = "X2"', 'number = "X1"', "twice"),
        ("X1,,", "X1,proves,", "role"),
        ('kind = "model"', 'kind = "model"\nanounced = "a"', "announced"),
    ],
)
def test_a_broken_table_is_refused(old, new, named):
    assert len(parse_table("x", TABLE, ROWS).claims) == 2
    with pytest.raises(BadInput, match=named):
        parse_table("x", TABLE.replace(old, new, 1), ROWS.replace(old, new, 1))


def test_a_paper_goes_from_its_studies_to_report_and_json(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("cosimo.orchestrator.harness.validation.case.load_table", lambda name: parse_table(name, TABLE, ROWS))
    drawn = Chart("Force over the way", "way, m", (Panel("force, N", (Series("run", [0.0, 1.0], [0.0, 0.25]),)),))
    made = Case("paper-x", "A paper", "it shows", (Question(lambda runs: Evidence({"force": 0.25}, (drawn,), claim="X1")),))
    monkeypatch.setitem(cases(), "paper-x", made)
    assert "paper-x" in papers()
    assert exit_code("validate", "paper-x", "-o", tmp_path) == 0
    printed = capsys.readouterr().out
    assert "2 claims: 2 shown (X1, X2)." in printed
    (case,) = json.loads((tmp_path / "validation.json").read_text())["cases"]
    assert [(c["number"], c["verdict"]) for c in case["claims"]] == [("X1", "shown"), ("X2", "shown")]
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    main_part = page[page.index("<main") :]
    places = [main_part.index(text) for text in ("below 1 N, as one spring", "Force over the way", "X2: model")]
    assert places == sorted(places)

    made = Case("paper-x", "A paper", "it shows", (Question(lambda runs: Evidence({"force": 7.0})),))
    monkeypatch.setitem(cases(), "paper-x", made)
    (result,) = validate(["paper-x"], tmp_path)
    assert result.outcome == "failed"
    assert "X1 was shown" in result.verdict


def test_what_cannot_fail_is_by_construction_in_text_report_and_json(tmp_path, monkeypatch, capsys):
    built = (
        TABLE.replace('verdict = "shown"', f'verdict = "{BUILT}"\ndiscussion = "one spring"', 1),
        ROWS.replace("X1,,", f"X1,{BUILT},"),
    )
    monkeypatch.setattr("cosimo.orchestrator.harness.validation.case.load_table", lambda name: parse_table(name, *built))
    case = Case("paper-x", "A paper", "", (Question(lambda runs: Evidence({"force": 0.25})),))
    monkeypatch.setitem(cases(), "paper-x", case)
    assert exit_code("validate", "paper-x", "-o", tmp_path) == 0
    printed = capsys.readouterr().out
    assert f"2 claims: 1 shown (X2); 1 {BUILT} (X1)." in printed
    assert "1 of 1 rows by" in printed
    (made,) = json.loads((tmp_path / "validation.json").read_text())["cases"]
    assert [(c["number"], c["verdict"]) for c in made["claims"]] == [("X1", BUILT), ("X2", "shown")]
    assert [r["role"] for r in made["rows"]] == [BUILT]
    assert f"force ({BUILT})" in (tmp_path / "report.html").read_text(encoding="utf-8")


def test_two_questions_may_not_measure_the_same(tmp_path, monkeypatch):
    made = Case("paper-x", "A paper", "", (Question(lambda runs: Evidence({"force": 1.0})),) * 2)
    monkeypatch.setitem(cases(), "paper-x", made)
    with pytest.raises(ValueError, match="force measured by two questions"):
        validate(["paper-x"], tmp_path)


def test_a_run_that_fails_fails_the_case_and_keeps_what_was_measured(tmp_path, monkeypatch):
    monkeypatch.setattr("cosimo.orchestrator.harness.validation.case.load_table", lambda name: parse_table(name, TABLE, ROWS))

    def broken(runs):
        raise StepFailed("rotor", 0.5, "a ball left its groove")

    case = Case("paper-x", "A paper", "", (Question(lambda runs: Evidence({"force": 0.25})), Question(broken)))
    monkeypatch.setitem(cases(), "paper-x", case)
    (result,) = validate(["paper-x"], tmp_path)
    assert result.outcome == "failed"
    assert [r.simulated for r in result.findings.rows][:1] == [0.25]
    assert "a ball left its groove" in " ".join(result.findings.notes)


def test_figures_belong_to_a_claim_of_the_table(tmp_path, monkeypatch):
    monkeypatch.setattr("cosimo.orchestrator.harness.validation.case.load_table", lambda name: parse_table(name, TABLE, ROWS))
    made = Case("paper-x", "A paper", "", (Question(lambda runs: Evidence({"force": 0.5}, claim="X7")),))
    monkeypatch.setitem(cases(), "paper-x", made)
    with pytest.raises(ValueError, match="figures of X7"):
        validate(["paper-x"], tmp_path)


@pytest.mark.parametrize("name", papers())
def test_what_a_claim_points_to_exists(name):
    for one in load_table(name).claims:
        for place in one.shown_by:
            if "/" in place:
                assert (ROOT / place).is_file(), place
            else:
                component, _, effect = place.partition(".")
                assert component in CATALOGUE, place
                assert not effect or effect in component_class(component).effects, place
    assert (ROOT / "docs" / "papers" / f"{name.removeprefix('paper-')}.md").is_file()


def test_the_overview_of_all_claims_is_the_one_of_the_tables():
    module = runpy.run_path(str(ROOT / "docs" / "papers" / "overview.py"))
    written = (ROOT / "docs" / "papers" / "index.md").read_text(encoding="utf-8")
    assert written == module["text"](), "run python docs/papers/overview.py"
