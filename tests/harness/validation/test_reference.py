"""Shipped tables are complete, and broken ones are refused."""

import pytest
from cosimo.components.core.errors import BadInput
from cosimo.orchestrator.harness.validation.reference import CONFIDENCES, STANDINGS, load_table, parse_table, table_files
from cosimo.orchestrator.settings.plan import LimitSettings

TABLES = sorted(table_files())


@pytest.mark.parametrize("name", TABLES)
def test_every_row_has_range_standing_and_source(name):
    table = load_table(name)
    assert table.rows
    # one number may be compared with two sources, but not twice against one
    assert len({(r.measure, r.condition, r.source) for r in table.rows}) == len(table.rows)
    for row in table.rows:
        assert row.standing in STANDINGS
        assert len(row.source) > 20  # a sentence, not a key
        assert row.low is not None or row.high is not None
        assert all((row.unit, row.quantity, row.measure))
        assert (row.standing == "unconfirmed") == (row.confidence in CONFIDENCES)


def test_the_2002_table_is_the_published_one():
    # Printed rows of the source: low and high at 250 km/h, then at 300 km/h.
    printed = {
        "mean": (110, 120, 110, 120),
        "std": (26, 31, 32, 40),
        "statistical_max": (190, 210, 210, 230),
        "statistical_min": (20, 40, -5, 20),
        "max": (175, 210, 190, 225),
        "min": (50, 75, 30, 55),
        "uplift_mm": (48, 55, 55, 65),
        "loss_raw": (0, 0, 0, 0),
    }
    table = load_table("en50318-2002")
    slow, fast = table.under("250 km/h"), table.under("300 km/h")
    assert {a.measure: (a.low, a.high, b.low, b.high) for a, b in zip(slow, fast, strict=True)} == printed
    assert {r.standing for r in table.rows} == {"verbatim"}


def test_nothing_of_the_2018_table_claims_to_be_read():
    assert {r.standing for r in load_table("en50318-2018-ac-simple").rows} == {"unconfirmed"}


def test_a_word_of_older_tables_is_read():
    table = parse_table("t", TEXT, ROWS.replace("standing", "standing,confidence").replace("verbatim", "recalled,high"))
    assert table.rows[0].standing == LimitSettings(low=0.0, standing="recalled").standing == "unconfirmed"


def test_a_value_with_tolerance_becomes_a_range():
    row = next(r for r in load_table("catenary-statics").rows if r.measure == "k_max" and r.condition == "EN 50318:2002, 120 N")
    assert (row.low, row.high) == pytest.approx((0.985 * 4730, 1.015 * 4730))


TEXT = """
title = "t"
text = "x"
[sources]
s = "somewhere public"
"""
ROWS = "quantity,measure,condition,unit,low,high,standing,source\nq,m,c,N,1,2,verbatim,s\n"


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("verbatim", "read", "standing 'read'"),
        ("verbatim", "unconfirmed", "confidence"),
        (",s\n", ",z\n", "a key of"),
        ("1,2", "1,0", "low 1 above high 0"),
        ("1,2", ",", "at least one end"),
        ("low", "value", "tolerance"),
        ("c,N", "c,", "unit = None"),
        ("high", "hihg", "Did you mean 'high'"),
        ("1,2", "1,two", "line 2, column 'high': got 'two'"),
        ("1,2", "1,2,3", "9 cells, expected 8"),
        ("q,m,c,N,1,2,verbatim,s\n", "", "no rows"),
        ('[sources]\ns = "somewhere public"', "", "no 'sources'"),
    ],
)
def test_broken_tables_are_refused(old, new, message):
    assert parse_table("good", TEXT, ROWS).rows[0].high == 2
    with pytest.raises(BadInput, match=message):
        parse_table("bad", TEXT.replace(old, new), ROWS.replace(old, new))


def test_title_and_text_are_those_of_the_case_unless_the_table_has_its_own():
    table = parse_table("plain", TEXT[TEXT.index("[sources]") :], ROWS)
    assert (table.title, table.text) == ("plain", "")
    assert parse_table("titled", TEXT, ROWS).title == "t"


def test_a_spreadsheet_may_put_semicolons_and_a_mark_of_its_own():
    assert parse_table("good", TEXT, "\ufeff" + ROWS.replace(",", ";")) == parse_table("good", TEXT, ROWS)


def test_unknown_table_names_the_near_one():
    with pytest.raises(BadInput, match="en50318-2002"):
        load_table("en50318-2003")
