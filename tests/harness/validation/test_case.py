"""Outcomes follow from rows and their standing."""

import json
import math
from dataclasses import replace

import pytest
from cosimo.components.core.errors import BadInput
from cosimo.orchestrator.cli import main
from cosimo.orchestrator.harness.validation.case import Case, CaseResult, Findings, Row, compare, outcome, to_json
from cosimo.orchestrator.harness.validation.questions import Evidence, Question
from cosimo.orchestrator.harness.validation.reference import TableRow, check_numbers
from cosimo.orchestrator.systems import cases, validate


def row(measured, standing="verbatim", low=0.0, high=10.0):
    confidence = "high" if standing == "unconfirmed" else ""
    low, high = (None, None) if standing == "missing" else (low, high)
    return Row(TableRow("force", "mean", "250 km/h", "N", low, high, standing, "a public table", confidence), measured)


@pytest.mark.parametrize(
    ("rows", "expected"),
    [
        ([row(5), row(10)], "passed"),
        ([row(5, "computed")], "passed"),
        ([row(5), row(11)], "failed"),
        ([row(5), row(5, "unconfirmed")], "unconfirmed"),
        ([row(5), row(50, "unconfirmed")], "unconfirmed"),
        ([row(50), row(5, "unconfirmed")], "failed"),
        ([row(5, "unconfirmed")], "unconfirmed"),
        ([row(50, "unconfirmed")], "unconfirmed"),
        ([row(5, "inferred")], "unconfirmed"),
        ([row(5, "missing")], "undecided"),
        ([row(5), row(5, "missing")], "undecided"),
        ([row(50), row(5, "missing")], "failed"),
        ([row(50, "inferred"), row(5)], "failed"),
        ([row(math.nan)], "failed"),
        ([], "failed"),
    ],
)
def test_outcome(rows, expected):
    assert outcome(tuple(rows)) == expected


def test_unconfirmed_ranges_never_pass_whatever_is_measured():
    for measured in (-1.0, 0.0, 5.0, 10.0, 11.0, math.nan):
        for others in ((), (row(5),), (row(5, "computed"), row(1))):
            assert outcome((row(measured, "unconfirmed"), *others)) == "unconfirmed"


@pytest.mark.parametrize(
    ("measured", "low", "high", "margin"),
    [
        (4.0, 0.0, 10.0, 4.0),
        (9.0, 0.0, 10.0, 1.0),
        (12.0, 0.0, 10.0, -2.0),
        (0.0, 0.0, 0.0, 0.0),
        (0.1, 0.0, 0.0, -0.1),
        (7.0, None, 10.0, 3.0),
        (7.0, 8.0, None, -1.0),
    ],
)
def test_margin_is_the_distance_to_the_nearer_end(measured, low, high, margin):
    r = row(measured, low=low, high=high)
    assert r.margin == pytest.approx(margin)
    assert r.inside == (margin >= 0.0)


def test_what_was_not_measured_is_not_inside():
    assert not compare((row(0).reference,), {"std": 3.0})[0].inside


def case_result(rows, complete=True):
    case = Case("a-case", "A case", "text", ())
    return CaseResult(case, Findings(tuple(rows), complete=complete))


def test_a_row_that_no_question_measures_is_named():
    given = replace(row(0).reference, measure="std", condition="20 Hz")
    check_numbers("t", (given,), {"std": 3.0})
    check_numbers("t", (given,), {"20 Hz": {"std": 3.0}})
    for measured in ({"stdd": 3.0}, {"20 Hz": {"stdd": 3.0}, "std": 3.0}):
        with pytest.raises(BadInput, match=r"table t, row 1: got measure 'std' of condition '20 Hz'.* Did you mean 'stdd'"):
            check_numbers("t", (given,), measured)


def test_a_broken_run_fails_the_case():
    assert case_result([row(5)]).outcome == "passed"
    assert case_result([row(5)], complete=False).outcome == "failed"


def test_the_verdict_counts_by_standing():
    text = case_result([row(5), row(5, "unconfirmed"), row(50, "unconfirmed")]).verdict
    assert "1 of 1 rows inside the range" in text
    assert "1 of 2 rows inside the unconfirmed range" in text
    assert "Passed" not in text


def test_rows_outside_of_unconfirmed_ranges_are_a_warning_that_names_them():
    result = case_result(
        [row(5), row(5, "unconfirmed"), row(50, "unconfirmed"), row(-1, "unconfirmed"), row(math.nan, "unconfirmed")]
    )
    above, below, nothing = result.warnings
    assert above == "force (250 km/h): 50 N is above 10, an unconfirmed range"
    assert "-1 N is below 0" in below
    assert "not a number" in nothing
    assert result.to_json()["warnings"] == result.warnings
    assert case_result([row(5), row(5, "unconfirmed")]).warnings == []


@pytest.mark.parametrize(("measured", "strict", "code"), [(5, False, 0), (5, True, 0), (50, False, 0), (50, True, 1)])
def test_strict_counts_rows_outside_of_unconfirmed_ranges(measured, strict, code, tmp_path, monkeypatch, capsys):
    rows = (row(5), row(measured, "unconfirmed"))
    case = Case("a-case", "A case", "text", (Question(lambda runs: Evidence(rows=rows)),))
    monkeypatch.setitem(cases(), "a-case", case)
    try:
        main(["validate", "a-case", "-o", str(tmp_path), *(["--strict"] if strict else [])])
        found = 0
    except SystemExit as exit_:
        found = exit_.code or 0
    assert found == code
    warned = "warning: a-case: force (250 km/h): 50 N is above 10, an unconfirmed range"
    assert (warned in capsys.readouterr().err) == (measured > 10)
    assert ("50 N is above 10" in (tmp_path / "report.html").read_text(encoding="utf-8")) == (measured > 10)


def test_json_has_the_agreed_fields_and_is_strict():
    document = json.loads(to_json([case_result([row(5), row(math.nan)])]), parse_constant=lambda c: pytest.fail(c))
    (case,) = document["cases"]
    assert (case["case"], case["outcome"]) == ("a-case", "failed")
    assert {"quantity", "condition", "unit", "measured", "low", "high", "standing", "source", "inside"} <= set(case["rows"][0])
    assert case["rows"][0]["inside"] is True
    assert case["rows"][1]["measured"] is None


def test_unknown_case_is_refused_before_anything_runs(tmp_path):
    with pytest.raises(BadInput, match="a validation case"):
        validate(["no-such-case"], tmp_path)
    assert not list(tmp_path.iterdir())
