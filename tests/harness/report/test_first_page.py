"""The first page of a report: the document, what was simulated, inputs with units, figures beside their limits."""

import random
import re
from dataclasses import replace
from datetime import date

import pytest
from cosimo import BadInput, delivered, load_scene, run
from cosimo.components.core.measure import conversion, number_in
from cosimo.orchestrator.harness.preferred_units import PREFERRED, preferred, written
from cosimo.orchestrator.harness.report import first_page, for_run
from cosimo.orchestrator.harness.report.used import in_use
from cosimo.orchestrator.harness.summary import SummaryRow, with_error
from cosimo.orchestrator.harness.validation.limits_of_run import judge
from cosimo.orchestrator.systems import SYSTEMS

DOCUMENT = {"title": "Line A at 250 km/h", "object": "Line A", "author": "A. Author", "number": "R-1", "date": "2026-01-02"}


@pytest.fixture(scope="module")
def result():
    """Of a short run under the limits of EN 50367."""
    scene = load_scene("lumped-catenary").with_changes({"limits": {"table": "en50367"}})
    return run(scene, in_process=True, verify="whole")


def document(result, **given):
    """The result with a table [document]."""
    return replace(result, scene=result.scene.with_changes({f"document.{key}": text for key, text in given.items()}))


def test_a_document_says_what_it_is(result, tmp_path):
    html = for_run(document(result, **DOCUMENT), tmp_path, SYSTEMS).read_text(encoding="utf-8")
    body = html[html.index("<body>") : html.index("Recorded signals")]
    assert f"<h1>{DOCUMENT['title']}</h1>" in body
    for text in ("Line A", "R-1", "2026-01-02", "Prepared by", "Checked by"):
        assert text in body
    assert [body.index(text) for text in ("Prepared by", "What was simulated", "Key inputs", "Verdict")] == sorted(
        body.index(text) for text in ("Prepared by", "What was simulated", "Key inputs", "Verdict")
    )


def test_a_report_without_a_document_has_its_day_and_no_lines_to_sign(result):
    facts = first_page.blocks(result, SYSTEMS)[0]
    assert dict(facts.rows)["Date"] == date.today().isoformat()
    assert first_page.signatures(result.scene.document) == []


def test_a_document_changes_no_result(result):
    assert (
        replace(result, scene=result.scene.with_changes({"document.author": "A"})).scene.connections == result.scene.connections
    )
    with pytest.raises(BadInput, match=r"document.*auther"):
        result.scene.with_changes({"document.auther": "A"})


def test_key_inputs_have_units_of_the_field(result):
    (inputs,) = (b for b in first_page.blocks(result, SYSTEMS) if b.title == "Key inputs")
    speed = next(value for name, value in inputs.rows if name.startswith("speed"))
    kmh = result.info.units["pantograph"].parameters["speed"] * 3.6
    assert speed.endswith(" km/h")
    assert float(speed.split()[0]) == pytest.approx(kmh, rel=1e-3)


def test_a_table_among_the_inputs_is_named_by_its_title():
    assert first_page._shortened('title = "Line A"\n[[sections]]\nstart = 0.0\n') == "Line A … (whole at the end)"
    assert first_page._shortened("explicit") == "explicit"
    assert len(first_page._shortened("x" * 500)) < 90


def test_the_mean_force_stands_beside_its_limit(result):
    """116 N and at most 133 N, not a difference of -17 N."""
    case, _ = judge(result, result.summary)
    row = next(r for r in case.findings.rows if r.reference.measure == "mean_less_target")
    mean = result.summary.value("pantograph.mean")
    speed = result.info.units["pantograph"].parameters["speed"] * 3.6
    assert row.simulated == mean
    assert row.reference.high == pytest.approx(0.00097 * speed**2 + 70.0 + 2.5, rel=1e-9)  # EN 50367, AC
    assert " less " not in row.reference.quantity


@pytest.mark.parametrize(
    ("unit", "size", "name", "shown", "factor"),
    [
        ("m", 7.569e-7, "", "µm", 1e6),
        ("m", 0.0536, "", "mm", 1e3),
        ("m", 377.0, "", "m", 1.0),
        ("m", 0.0, "", "m", 1.0),
        ("m/s", 69.444444, "", "km/h", 3.6),
        ("rad/s", 589.0, "rotor.speed_at_max", "rpm", 60.0 / 6.283185307179586),
        ("rad/s", 0.2, "hull.yaw_rate", "°/s", 57.29577951308232),
        ("N", 20000.0, "", "kN", 1e-3),
        ("N.s/m", 90.0, "", "N·s/m", 1.0),
        ("kg.m", 8e-5, "", "g·mm", 1e6),
        ("mm", 3.0, "", "mm", 1.0),
        ("1", 3.0, "", "", 1.0),
    ],
)
def test_units_are_those_of_the_field(unit, size, name, shown, factor):
    assert preferred(unit, size, name) == (shown, pytest.approx(factor, rel=1e-12))
    with delivered(si=True):
        assert preferred(unit, size, name) == (written(unit), 1.0)


def test_every_preferred_unit_is_of_the_quantity_and_the_last_has_no_least_size():
    for unit, choices in PREFERRED.items():
        assert [least for _, least in choices] == sorted((least for _, least in choices), reverse=True)
        assert choices[-1][1] == 0.0
        for other, least in choices:
            assert least * conversion(unit, other)[0] >= 0.1 or least == 0.0  # no number below a tenth of its unit


def test_a_number_in_a_preferred_unit_keeps_its_error():
    row = SummaryRow("rotor.displacement_max", 7.569e-7, "m", "", error=3e-9)
    assert (row.for_reader().shown, row.for_reader().unit) == ("0.757 ± 0.003", "µm")


@pytest.mark.parametrize(
    ("value", "error", "text"),
    [
        (0.570544, 1e-9, "0.57054 ± 0.00001"),
        (116.009, 0.008, "116.009 ± 0.008"),
        (62.88, 20.2, "63 ± 21"),  # one digit would be 30: half as large again
        (62.98, 29.9, "63 ± 30"),
        (62.88, 30.2, "60 ± 40"),
        (6.2884, 0.14, "6.29 ± 0.14"),
        (2.535096, 1.3e-5, "2.53510 ± 0.00002"),
        (8.2e-9, 8e-9, "8.2e-09 ± 8e-09"),
        (1234567.0, 3.0, "1.2346e+06 ± 1e+02"),
        (1.23456789e-6, 1e-15, "1.2346e-06 ± 1e-10"),
    ],
)
def test_no_error_is_said_to_be_below_something(value, error, text):
    assert with_error(value, error) == text
    number, bound = map(float, text.split(" ± "))
    assert abs(number - value) + error <= bound * (1 + 1e-9) + 1e-15 or bound == error


def test_a_rounded_number_is_never_farther_off_than_its_error_says():
    chance = random.Random(1)
    for _ in range(3000):
        value = 10.0 ** chance.uniform(-14.0, 12.0)
        number, bound = map(float, with_error(value, value * 10.0 ** chance.uniform(-9.0, 2.0)).split(" ± "))
        assert abs(number - value) <= bound * (1.0 + 1e-9)


def test_units_that_were_misread():
    assert number_in("2 g", "m/s2", "x") == pytest.approx(2.0 * 9.80665, rel=1e-12)
    assert number_in("2 g", "kg", "x") == pytest.approx(2e-3, rel=1e-12)
    assert number_in("1.2 mPa.s", "Pa.s", "x") == pytest.approx(1.2e-3, rel=1e-12)


@pytest.mark.parametrize("paper", ["A4", "Letter"])
def test_the_sheet_is_the_one_that_is_asked_for(result, tmp_path, paper):
    with delivered(paper=paper):
        html = for_run(result, tmp_path, SYSTEMS).read_text(encoding="utf-8")
    assert re.search(r"@page \{ size: (\w+); \}", html)[1] == paper
    with pytest.raises(BadInput, match="--paper"), delivered(paper="foolscap"):
        pass


def test_numbers_in_whose_place_a_table_stands_are_in_no_report():
    """A line's table has the tensions and the spans: those of the component's parameters are of another line."""
    names = ("span_length", "contact_wire_tension", "messenger_tension", "contact_wire_mass", "line_table.table", "element")
    table = load_scene("unequal-spans")
    assert in_use(table, "catenary", names) == ["line_table.table", "element"]
    assert in_use(load_scene("en50318-2002"), "catenary", names[:4]) == list(names[:4])
    assert in_use(table, "nobody", names) == list(names)
