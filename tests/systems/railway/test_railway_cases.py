"""The railway cases: their closed forms are solutions, their variants differ, their verdicts follow the standing."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from cosimo import run
from cosimo.orchestrator import systems
from cosimo.orchestrator.harness.validation.case import Options, compare, outcome
from cosimo.orchestrator.harness.validation.limits_of_run import judge
from cosimo.orchestrator.harness.validation.reference import load_table
from cosimo.orchestrator.systems import cases, load_scene
from cosimo.orchestrator.systems.railway.cases import bane_nor, catenary_statics, en50318_2002
from cosimo.orchestrator.systems.railway.records import statistics, wave_speed
from cosimo.orchestrator.systems.railway.runs import at_speed, numbers, reference_run, target_mean, with_stable_substep

UNEQUAL = (Path(systems.__file__).parent / "railway" / "lines" / "unequal.toml").read_text(encoding="utf-8")
IN_PROCESS = Options(in_process=True)


def test_every_case_says_what_it_shows():
    for name, case in cases().items():
        assert name == case.name
        assert len(case.text) > 80
        assert case.system


def test_string_on_droppers_is_in_equilibrium():
    """Tensions of the droppers, put back: each piece of wire hangs as a parabola, and vertical forces at every clamp cancel."""
    x, y = np.array([0.0, 4.0, 10.0, 15.0, 21.0]), np.array([0.0, 0.02, -0.01, 0.0, 0.01])
    weight, pull, clamp = 13.0, 2e4, 3.0
    tensions = catenary_statics.string_tensions(x, y, weight, pull, clamp)
    for i, tension in enumerate(tensions, 1):
        left, right = x[i] - x[i - 1], x[i + 1] - x[i]
        slope_left = (y[i] - y[i - 1]) / left + weight * left / (2 * pull)  # of the parabola at its right end
        slope_right = (y[i + 1] - y[i]) / right - weight * right / (2 * pull)
        assert tension + pull * (slope_right - slope_left) - clamp == pytest.approx(0.0, abs=1e-9)  # rounding


def test_string_sag_solves_its_equation():
    """Sag at midspan from a fine discrete string T y'' = w + point loads, solved independently."""
    span, pull, weight, n = 12.0, 1.6e4, 10.0, 1200
    positions, loads = np.array([3.0, 7.0]), np.array([80.0, 50.0])
    h = span / n
    force = np.full(n - 1, weight * h)
    force[np.round(positions / h).astype(int) - 1] += loads
    matrix = (2 * np.eye(n - 1) - np.eye(n - 1, k=1) - np.eye(n - 1, k=-1)) * pull / h
    middle = np.linalg.solve(matrix, force)[n // 2 - 1]
    assert catenary_statics.string_sag(span, pull, weight, positions, loads) == pytest.approx(middle, rel=1e-9)  # exact at nodes


@pytest.mark.parametrize("speed", [250.0, 300.0])
def test_the_reference_model_lies_in_the_published_ranges(speed):
    rows = compare(load_table("en50318-2002").under(f"{speed:g} km/h"), numbers(reference_run(speed, IN_PROCESS)))
    assert [r.reference.quantity for r in rows if not r.inside] == []
    assert outcome(rows) == "passed"


@pytest.mark.full
def test_bilateral_droppers_fail_the_table():
    """The table tells models apart: droppers that push, which no published result allows, are far outside."""
    scene = load_scene("en50318-2002")
    effects = [e for e in scene.units["catenary"].effects if e != "dropper_slackening"]
    measured = en50318_2002._variant({"units.catenary.effects": effects}, 250.0)
    rows = compare(load_table("en50318-2002").under("250 km/h"), measured)
    assert outcome(rows) == "failed"
    assert measured["std"] > 35.0  # N, 4 N above the range; an independent solver found 48 N with less damping


def test_statistics_of_a_run_take_the_supports_of_the_window():
    s = statistics(reference_run(250.0, IN_PROCESS))
    assert len(s.uplift) == 3  # supports at 240, 300 and 360 m
    assert s.window == (240.0, 360.0)


def test_speed_changes_keep_the_distance():
    slow, fast = (at_speed(load_scene("en50318-2002"), v) for v in (125.0, 250.0))
    assert slow.stop_time == pytest.approx(2.0 * fast.stop_time, abs=2 * fast.master.step)  # rounded to whole steps


def test_a_shorter_internal_step_is_taken_only_where_it_must():
    scene = load_scene("en50318-2002")
    assert with_stable_substep(scene) is scene
    stiff = scene.with_changes({"catenary.damping.beta": 1e-2})
    substep = with_stable_substep(stiff).units["catenary"].parameters["substep"]
    assert substep < scene.master.step
    assert scene.master.step / substep == pytest.approx(round(scene.master.step / substep))


def test_target_mean_force_of_the_source():
    assert target_mean(300.0) == pytest.approx(157.3)  # the source's own example
    assert target_mean(200.0) == pytest.approx(108.8)


def test_unconfirmed_rules_do_not_pass_even_if_all_are_kept():
    table = load_table("en50367")
    rows = compare(tuple(replace(r, low=None, high=1e9) for r in table.rows), {r.measure: 0.0 for r in table.rows})
    assert all(r.inside for r in rows)
    assert outcome(rows) == "unconfirmed"


def judged_by_rules(name, **changes):
    """Rows of a shipped scene, shortened, under the rules: (object, measure) -> row; and the case."""
    result = run(load_scene(name).with_changes({"limits": "bane-nor", **changes}), in_process=True, verify="no")
    case, _ = judge(result, result.summary)
    return {(row.reference.condition.partition(",")[0], row.reference.measure): row for row in case.findings.rows}, case, result


def test_rules_that_can_be_read_give_a_verdict():
    """Each row is firm; a spacing that is just kept, a static force that is not; another supply has no rules."""
    rows, case, result = judged_by_rules("two-pantographs", stop_time=4.0, **{"analysis.spans": [5, 5]})
    assert rows["leading", "speed_ratio"].simulated == pytest.approx(250.0 / 3.6 / (20e3 / 1.35) ** 0.5, rel=1e-6)
    assert rows["trailing", "spacing"].simulated == pytest.approx(200.0, abs=1e-6)
    assert {measure for (_, measure), row in rows.items() if not row.inside} == {"static_force"}
    assert {row.reference.standing for row in rows.values()} == {"verbatim"}
    assert case.outcome == "failed"
    other = replace(result, scene=result.scene.with_changes({"analysis.supply": "3 kV DC"}))
    case, _ = judge(other, other.summary)
    assert "leading: bane-nor has no rule for 3 kV DC" in case.findings.notes
    assert case.outcome != "passed"


def test_the_wave_speed_is_that_of_the_table_and_heights_are_those_of_the_window():
    rows, _, result = judged_by_rules("unequal-spans", stop_time=4.5, **{"analysis.spans": [3, 5]})
    speed = result.scene.units["pantograph"].parameters["speed"]
    assert rows["pantograph", "speed_ratio"].simulated == pytest.approx(speed / (22e3 / 1.35) ** 0.5, rel=1e-4)
    assert rows["pantograph", "height_low"].simulated == 5.25
    assert rows["pantograph", "height_high"].simulated == 5.3
    worn = result.scene.with_changes({"catenary.line_table.table": UNEQUAL.replace("0.001 }", "0.001, wear = 0.1 }")})
    assert wave_speed(replace(result, scene=worn), "catenary") == pytest.approx((22e3 / 1.215) ** 0.5, rel=1e-9)


@pytest.mark.parametrize(
    ("speed", "least"), [(79.0, 8.0), (80.0, 8.0), (81.0, 15.0), (120.0, 15.0), (121.0, 85.0), (249.0, 85.0), (250.0, 200.0)]
)
def test_the_spacing_of_a_speed_is_that_of_its_row(speed, least):
    (row,) = load_table("bane-nor").under(f"AC, pantographs, {bane_nor.spaced(speed)}")
    assert row.low == least
