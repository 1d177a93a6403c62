"""Rows of validation tables as limits of many runs: which of them hold, how often they are kept, and by which values."""

import csv
from typing import get_args

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.orchestrator.harness.many.design import design
from cosimo.orchestrator.harness.many.limits import check_limits, unconfirmed, with_rows
from cosimo.orchestrator.harness.many.measures import function_of
from cosimo.orchestrator.harness.many.plan import plan_settings
from cosimo.orchestrator.harness.many.uncertainty import probability, uncertainty
from cosimo.orchestrator.harness.report import answers
from cosimo.orchestrator.harness.sweep import sweep
from cosimo.orchestrator.harness.validation.reference import MISSING, STANDINGS, load_table, table_files
from cosimo.orchestrator.settings.plan import LimitSettings
from cosimo.orchestrator.systems import load_scene, many, read_scene
from cosimo.tests.harness.many.points import formula
from scipy.special import ndtr

ROW = """
[[rows]]
quantity = "{measure}"
measure = "{measure}"
condition = "{condition}"
unit = "{unit}"
{ends}
standing = "{standing}"
source = "here"
"""


def table(folder, *rows):
    """A file of rows (measure, condition, unit, ends, standing)."""
    keys = ("measure", "condition", "unit", "ends", "standing")
    text = "".join(ROW.format(**dict(zip(keys, row, strict=True))) for row in rows)
    text = text.replace('standing = "unconfirmed"', 'standing = "unconfirmed"\nconfidence = "low"')
    (folder / "rows.toml").write_text('[sources]\nhere = "a test"\n' + text)
    return str(folder / "rows.toml")


def test_probabilities_of_rows_are_those_of_the_distribution(tmp_path):
    """2 a + b of normal numbers is normal: 5 and sqrt(0.08); a + b: 4 and sqrt(0.05)."""
    limits = table(
        tmp_path, ("f.linear, end", "x", "1", "high = 5.2", "verbatim"), ("f.total, end", "x", "1", "low = 4.0", "unconfirmed")
    )
    plan = {
        "method": "random",
        "points": 400,
        "seed": 2,
        "vary": {
            "f.a": {"distribution": "normal", "mean": 1.0, "deviation": 0.1},
            "f.b": {"distribution": "normal", "mean": 3.0, "deviation": 0.2},
        },
    }
    scene = formula() | {"study": {"quantities": ["f.parabola, time history"]}}  # which is no number of a run
    answer = uncertainty(read_scene(scene), plan, limits=limits)
    first, second, together = answer.limits
    for found, exact in ((first, ndtr(0.2 / np.sqrt(0.08))), (second, 0.5)):
        assert found.count == 400
        assert found.low < exact < found.high
        assert abs(found.probability - exact) < 3.0 * np.sqrt(exact * (1.0 - exact) / 400)
    assert together.limit is None
    linear, total = (answer.sweep.measures[f"f.{name}, end"] for name in ("linear", "total"))
    assert together.inside == np.sum((linear <= 5.2) & (total >= 4.0))
    assert any("unconfirmed" in text and "f.total" in text and "f.linear" not in text for text in answer.messages)
    even = uncertainty(
        read_scene(scene), plan | {"method": "sobol", "points": 16}, limits=limits
    )  # no tolerance interval of so few
    exact = [any("confidence of the intervals of shares" in text for text in a.messages) for a in (answer, even)]
    assert exact == [False, True]
    _, file = answer.save(tmp_path)
    rows = list(csv.DictReader(file.open()))
    assert [(r["column"], r["standing"], r["source"]) for r in rows] == [
        ("f.linear, end", "verbatim", "a test"),
        ("f.total, end", "unconfirmed", "a test"),
        ("", "", ""),
    ]
    page = answers.for_uncertainty(answer, tmp_path).read_text()
    assert "Probability that the limits are met" in page


def test_intervals_of_probabilities_where_all_or_none_are_inside():
    """Closed form of Clopper and Pearson: of n out of n the lower end is 0.025^(1/n)."""
    everything, nothing = (probability("", None, np.full(93, value)) for value in (True, False))
    assert (everything.low, everything.high) == (pytest.approx(0.025 ** (1.0 / 93.0), rel=1e-9), 1.0)
    assert (nothing.low, nothing.high) == (0.0, pytest.approx(1.0 - 0.025 ** (1.0 / 93.0), rel=1e-9))


def test_a_design_keeps_the_rows_of_a_table(tmp_path):
    """(a - 1)² + (b - 2)² with a + b <= 2 of the table and a 2 a + b >= 2.6 of its own: at (0.6, 1.4) it is 0.52."""
    table(tmp_path, ("f.total, end", "x", "1", "high = 2.0", "unconfirmed"))
    (tmp_path / "design.toml").write_text("""
minimise = "f.parabola, end"
rows = { table = "rows.toml" }
[vary]
"f.a" = { low = -4.0, high = 4.0 }
"f.b" = { low = -4.0, high = 4.0 }
[constraints]
"f.linear, end" = { low = 2.6 }
""")
    answer = design(read_scene(formula()), tmp_path / "design.toml")
    assert answer.values == {"f.a": pytest.approx(0.6, abs=2e-3), "f.b": pytest.approx(1.4, abs=2e-3)}
    assert set(answer.active) == {"f.total, end", "f.linear, end"}
    assert unconfirmed(answer.constraints) == ["unconfirmed ranges, which no run passes or fails by: f.total, end (x)"]


def test_limits_count_all_columns_and_are_those_of_the_conditions(tmp_path):
    limits = table(
        tmp_path, ("f.total, end", "slow", "1", "high = 2.0", "verbatim"), ("f.total, end", "fast", "1", "high = 3.0", "verbatim")
    )
    (tmp_path / "plan.toml").write_text(
        'rows = { table = "rows.toml", conditions = ["fast"] }\n[vary]\n"f.a" = [1.0, 2.0, 3.0, 4.0]\n'
    )
    plan = plan_settings(tmp_path / "plan.toml")
    result = sweep(read_scene(formula()), plan)
    assert result.plan.limits["f.total, end"].high == 3.0
    assert sum(result.plan.limits["f.total, end"].keeps(x) for x in result.measures["f.total, end"]) == 3
    for conditions, named in (((), "2 ranges of f.total, end"), (("slow", "fast"), "2 ranges"), (("sloow",), "'slow'")):
        with pytest.raises(BadInput, match=named):
            with_rows(plan_settings({"vary": {"f.a": [1.0]}}), table=limits, conditions=conditions)
    with pytest.raises(BadInput, match="one range a column"):
        with_rows(
            plan_settings({"vary": {"f.a": [1.0]}, "limits": {"f.total, end": {"low": 0.0}}}), table=limits, conditions=["fast"]
        )
    for name, named in (("nowhere.toml", "There is no"), ("en5067", "'en50367'"), ("catenary-statics", "own runs")):
        with pytest.raises(BadInput, match=named):
            with_rows(plan_settings({"vary": {"f.a": [1.0]}}), table=name)


def test_limits_of_unknown_columns_and_other_units_are_refused():
    with pytest.raises(BadInput, match=r"'f\.total, mean'"):
        sweep(read_scene(formula()), {"vary": {"f.a": [1.0]}, "limits": {"f.totl, mean": {"low": 0.0}}})
    with pytest.raises(BadInput, match="'mm'"):
        check_limits({"x": LimitSettings(low=1.0, unit="mm")}, {"x": "m"})


def test_shipped_tables_name_functions_of_any_run():
    named = [t.measures for t in map(load_table, table_files()) if t.measures]
    assert len(named) == 4
    assert all(callable(function_of(text)) for text in named)
    standings = get_args(LimitSettings.model_fields["standing"].annotation)
    assert set(standings) == {"", *STANDINGS} - {MISSING}  # whose rows judge nothing


@pytest.mark.parametrize(
    ("plan", "named"),
    [
        ({"limits": {"f.linear, maximal": {"high": 1.0}}}, "limits: got 'f.linear, maximal'"),
        ({"limits": {"linear": {"high": 1.0}}}, "limits: got 'linear'"),  # a figure, of a scene whose system has none
        ({"keep": {"quantities": ["f.linear, maximum below 1 Hz"]}}, "a run of more than"),
    ],
)
def test_columns_and_windows_that_no_run_has_start_nothing(plan, named, tmp_path):
    with pytest.raises(BadInput, match=named):
        sweep(read_scene(formula()), {"vary": {"f.a": [1.0, 2.0]}, **plan}, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_figures_of_a_system_are_known_from_the_first_run_on(tmp_path):
    """The first run alone is made, and kept for the plan as it is mended."""
    scene = load_scene("lumped-catenary").with_changes(
        {"stop_time": 0.3, "analysis": {"system": "railway", "window": [32.0, 40.0]}}
    )
    plan = {"vary": {"pantograph.static_force": [60.0, 70.0]}, "limits": {"pantograph.st": {"high": 1.0}}}
    with pytest.raises(BadInput, match="Did you mean 'pantograph\\.std'"):
        many.sweep(scene, plan, tmp_path, verify=False)
    plan["limits"] = {"pantograph.std": {"high": 1e6}}
    assert many.sweep(scene, plan, tmp_path, verify=False).computed == 1


def test_a_window_that_no_pantograph_reaches_starts_nothing():
    scene = load_scene("lumped-catenary")
    with pytest.raises(BadInput, match=r"pantograph runs from .*Lengthen the run"):
        many.sweep(scene, {"vary": {"stop_time": [scene.stop_time, 1.5]}})
    with pytest.raises(BadInput, match="Lengthen the run"):
        many.design(
            scene.with_changes({"stop_time": 1.5}),
            {"minimise": "pantograph.std", "vary": {"pantograph.static_force": {"low": 60.0, "high": 70.0}}},
        )
