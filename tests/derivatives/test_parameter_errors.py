"""What tolerances make of figures: against differences of runs and sums of correlated parts; how they are shown and refused."""

from __future__ import annotations

import json
from contextlib import ExitStack

import cosimo
import numpy as np
import pytest
import tomli_w
from cosimo.components.core.errors import BadInput
from cosimo.components.core.kernels import COMPILED
from cosimo.orchestrator.derivatives import gradient
from cosimo.orchestrator.derivatives.along import PointDerivatives
from cosimo.orchestrator.harness.summary import with_errors_of
from cosimo.orchestrator.harness.validation.reference import Row, TableRow
from cosimo.orchestrator.judgement import verification
from cosimo.orchestrator.judgement.parameter_errors import parameter_errors
from cosimo.orchestrator.run.thresholds import PARAMETER_SAMPLES
from cosimo.orchestrator.run.work import beginning
from cosimo.orchestrator.scene.scene import write_scene
from cosimo.orchestrator.scene.tolerances import tolerances_of, with_tolerances
from cosimo.orchestrator.systems import read_scene
from cosimo.tests.commands import exit_code
from cosimo.tests.units.exchange_fmu import exchange_fmu

NAMES = "pantograph.head_mass", "pantograph.static_force"
TOLERANCES = {"units.pantograph.tolerances": {"static_force": "5 N", "head_mass": "3 %"}}
compiled = pytest.mark.skipif(not COMPILED, reason="derivatives are those of machine code")


@pytest.fixture(scope="module")
def scene():
    return cosimo.load_scene("lumped-catenary")


@pytest.fixture(scope="module")
def parts(scene):
    """Of the deviation of the force: what a standard deviation of each parameter makes of it, by runs on either side."""
    slopes = cosimo.gradient(scene, "pantograph.std", NAMES, differences=1e-3)
    return {n: slopes["pantograph.std", n].derivative * s for n, s in zip(NAMES, (0.03 * 7.2, 5.0), strict=True)}


def of_deviation(scene, changes, **how):
    result = cosimo.run(scene.with_changes(changes), in_process=True, **how)
    return next(row for row in result.summary if row.name == "pantograph.std"), result


@compiled
@pytest.mark.parametrize(
    ("correlation", "of"), [(0.0, np.hypot), (1.0, lambda a, b: abs(a + b)), (-1.0, lambda a, b: abs(a - b))]
)
def test_the_parameter_error_is_that_of_the_parts(scene, parts, correlation, of):
    row, result = of_deviation(scene, TOLERANCES | {"correlations": {", ".join(NAMES): correlation}})
    assert row.parameters == pytest.approx(of(*parts.values()), rel=1e-3)
    shown = result.info.verification.parameters
    assert (shown.how, shown.samples) == ("exact", 6)
    assert shown.figures["pantograph.std"].largest == max(parts, key=lambda n: abs(parts[n]))
    assert 0.0 < shown.figures["pantograph.std"].rest < 0.02
    assert row.shown.endswith("(parameters)")
    assert not any("parameter error" in text for text in result.info.warnings)


@compiled
def test_large_tolerances_say_that_first_order_is_not_all(scene):
    _, result = of_deviation(scene, {"units.pantograph.tolerances": {"head_stiffness": "40 %"}})
    assert any("not of first order alone" in text for text in result.info.warnings)


def test_a_scene_without_derivatives_has_differences(scene, parts):
    """Here because a signal jumps from one step to the next: a fault that begins behind the end of what counts."""
    fault = {"kind": "offset", "signal": "pantograph.contact_force", "value": 1e-9, "begin": 4.9}
    row, result = of_deviation(scene, TOLERANCES | {"faults": [fault]})
    how = result.info.verification.parameters.how
    assert how.startswith("differences")
    assert "faults" in how
    assert row.parameters == pytest.approx(np.hypot(*parts.values()), rel=1e-2)


def test_a_tolerance_of_0_moves_nothing_by_differences_either():
    fault = {"kind": "offset", "signal": "body.inner_rate", "value": 1e-9, "begin": 0.45}
    zero = {"faults": [fault], "stop_time": 0.5, "analysis.transient": 0.1, "units.body.tolerances": {"inner_inertia": "0 %"}}
    result = cosimo.run(cosimo.load_scene("gimbal-scan").with_changes(zero), in_process=True)
    errors = result.info.verification.parameters
    assert errors.how.startswith("differences")
    assert {figure.error for figure in errors.figures.values()} == {0.0}


def test_an_effect_that_is_switched_off_takes_its_tolerances_with_it():
    given = cosimo.load_scene("gimbal-scan").with_changes(
        {
            "units.body.tolerances": {"gravity.mass": "1 %", "inner_inertia": "1 %", "frame_inertia": "1 %"},
            "correlations": {"body.gravity.mass, body.inner_inertia": 0.5, "body.frame_inertia, body.inner_inertia": 0.25},
        }
    )
    off = given.with_changes({"body.effects.gravity": False})
    assert set(tolerances_of(off).names) == {"body.inner_inertia", "body.frame_inertia"}
    assert off.correlations == {"body.frame_inertia, body.inner_inertia": 0.25}


def of_gimbal(monkeypatch, tolerance, again=None):
    """Parameter errors by differences, and how many runs were made for them."""
    runs, kept = [], gradient._run
    monkeypatch.setattr(gradient, "_run", lambda scene: runs.append(scene) or kept(scene))
    changes = {"stop_time": 0.5, "analysis.transient": 0.1, "units.body.tolerances": {"inner_inertia": tolerance}}
    fault = {"kind": "offset", "signal": "body.inner_rate", "value": 1e-9, "begin": 0.45}
    scene = cosimo.load_scene("gimbal-scan").with_changes(changes | {"faults": [fault]})
    result = cosimo.run(scene, in_process=True, verify="no")
    asked = []
    errors = parameter_errors(result, tolerances_of(scene), lambda times: asked.append(times) or True, again)
    return errors, runs, asked


def test_differences_are_those_of_a_standard_deviation_and_count_two_runs_a_parameter(monkeypatch):
    _, runs, asked = of_gimbal(monkeypatch, 0.005, lambda scene, changes: (None, ""))
    assert sorted(r.units["body"].parameters["inner_inertia"] for r in runs) == pytest.approx([0.045, 0.055])
    assert asked[1:] == [2.0, 2.0 + PARAMETER_SAMPLES]


def test_samples_that_all_fail_are_told(monkeypatch):
    errors, _, _ = of_gimbal(monkeypatch, 0.005, lambda scene, changes: (None, "unstable"))
    assert any(f"{PARAMETER_SAMPLES} of {PARAMETER_SAMPLES} samples" in text for text in errors.warnings)


def test_the_first_part_of_a_dry_run_has_no_tolerances(scene):
    correlated = scene.with_changes(TOLERANCES | {"correlations": {", ".join(NAMES): 0.5}})
    part = beginning(correlated, 0.1)
    assert tolerances_of(part) is None
    assert not part.correlations


@compiled
def test_a_period_of_waves_is_no_period_of_samples():
    scene = cosimo.load_scene("rov-waves").with_changes({"stop_time": 0.1, "analysis.transient": 0.0})
    names = ["water.waves.period", "controller.period", "hull.substep"]
    found = cosimo.gradient(scene, "hull.depth, last", names, halved=False)
    assert set(found.refused) == set(names[1:])
    assert {s.parameter for s in found.slopes} == set(names[:1])
    with ExitStack() as stack:
        assert set(PointDerivatives(scene, names, stack).reasons) == set(names[1:])
    changed = scene.with_changes({"units.water.tolerances": {"waves.period": "1 %"}})
    assert tolerances_of(changed).names == ("water.waves.period",)


def test_without_tolerances_nothing_is_called_or_written(scene, monkeypatch, tmp_path):
    monkeypatch.setattr(verification, "parameter_errors", None)
    row, result = of_deviation(scene, {}, output=tmp_path)
    assert "parameters" not in result.info.to_json()["verification"]
    assert "parameters" not in row.to_json()
    assert "(" not in row.shown
    with pytest.raises(TypeError, match="NoneType"):
        of_deviation(scene, TOLERANCES)


@compiled
def test_the_command_prints_both_errors(scene, tmp_path, capsys):
    path = write_scene(scene.with_changes(TOLERANCES), tmp_path / "scene.toml")
    assert exit_code("run", path, "--in-process", "-o", tmp_path / "out") == 0
    assert "(parameters)" in capsys.readouterr().out
    figures = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert figures["pantograph.std"]["parameters"] > 10.0 * figures["pantograph.std"]["error"] > 0.0
    assert "parameter error" in (tmp_path / "out" / "summary.csv").read_text().splitlines()[0]
    assert "(parameters)" in (tmp_path / "out" / "report.html").read_text()


@pytest.mark.parametrize(
    ("tolerances", "words"),
    [
        ({"static_forc": "5 N"}, "static_force"),
        ({"static_force": "5 kg"}, "dimension of N"),
        ({"static_force": "-5 N"}, "at least 0"),
        ({"static_force": -1.0}, "at least 0"),
        ({"static_force": "-3 %"}, "at least 0"),
        ({"static_force": "little"}, "standard deviation"),
        ({"static_force": True}, "standard deviation"),
        ({"substep": "3 %"}, "numerical error alone"),
        ({"contact_force": "3 %"}, "derivative"),
    ],
)
def test_what_is_no_tolerance_is_refused(scene, tolerances, words):
    with pytest.raises(BadInput, match=words):
        scene.with_changes({"units.pantograph.tolerances": tolerances})


@pytest.mark.parametrize("name", ["u", "x", "whole"])
def test_inputs_and_outputs_of_an_fmu_have_no_tolerance(name):
    unit = {"fmu": exchange_fmu(), "tolerances": {name: 0.1}}
    data = {"stop_time": 1.0, "units": {"f": unit}, "master": {"step": 0.1}}
    with pytest.raises(BadInput, match="a parameter"):
        read_scene(data)
    read_scene(data | {"units": {"f": unit | {"tolerances": {"period": 0.1}}}})  # nothing says that it samples


def test_structural_parameters_have_no_tolerance():
    with pytest.raises(BadInput, match="not structural"):
        cosimo.load_scene("en50318-2002").with_changes({"units.catenary.tolerances": {"spans": 1.0}})


@pytest.mark.parametrize(
    ("correlations", "words"),
    [
        ({"pantograph.head_mass, pantograph.frame_mass": 0.5}, "two with tolerances"),
        ({"pantograph.head_mass": 0.5}, "two with tolerances"),
        ({", ".join(NAMES): 0.5, ", ".join(reversed(NAMES)): -0.5}, "twice"),
        ({"pantograph.head_mass, pantograph.static_force": 1.5}, "less than or equal to 1|at most 1"),
    ],
)
def test_correlations_are_of_two_tolerances(scene, correlations, words):
    with pytest.raises(BadInput, match=words):
        scene.with_changes(TOLERANCES | {"correlations": correlations})


def test_correlations_have_to_fit_one_another_and_a_share_is_of_a_number(scene):
    three = {"units.pantograph.tolerances": {"static_force": 1.0, "head_mass": 1.0, "frame_mass": 1.0}}
    pairs = {", ".join(NAMES): 0.9, "pantograph.frame_mass, pantograph.head_mass": 0.9}
    pairs["pantograph.frame_mass, pantograph.static_force"] = -0.9
    with pytest.raises(BadInput, match="positive semidefinite"):
        cosimo.run(scene.with_changes(three | {"correlations": pairs}), in_process=True)
    zero = {"pantograph.head_damping": 0.0, "units.pantograph.tolerances": {"head_damping": "3 %"}}
    with pytest.raises(BadInput, match="3 % of 0"):
        tolerances_of(scene.with_changes(zero))


def test_tolerances_of_a_subsystem_come_along_with_their_correlations(scene, tmp_path):
    inner = {"pantograph.head_mass, pantograph.static_force": 0.5}
    write_scene(scene.with_changes(TOLERANCES | {"correlations": inner}), tmp_path / "inner.toml")
    around = {"stop_time": 1.0, "units": {"train": {"scene": "inner.toml"}}, "master": {"step": 1e-3}}
    (tmp_path / "outer.toml").write_text(tomli_w.dumps(around))
    whole = tolerances_of(cosimo.load_scene(tmp_path / "outer.toml"))
    assert set(whole.names) == {f"train.{n}" for n in NAMES}
    assert whole.correlation[0, 1] == 0.5
    around["correlations"] = {"train.pantograph.static_force, train.pantograph.head_mass": -0.9}
    (tmp_path / "outer.toml").write_text(tomli_w.dumps(around))
    assert tolerances_of(cosimo.load_scene(tmp_path / "outer.toml")).correlation[0, 1] == -0.9


def test_a_covariance_becomes_tolerances_of_the_scene(scene, tmp_path):
    """Settings that no tolerance can be of are left out, and what was known of the others stays."""
    covariance = np.array([[4.0, 0.6, 0.0], [0.6, 0.25, 0.0], [0.0, 0.0, 1.0]])
    given = scene.with_changes({"units.pantograph.tolerances": {"frame_mass": "1 %"}})
    path = write_scene(
        with_tolerances(given, ["pantograph.static_force", "pantograph.head_mass", "master.step"], covariance),
        tmp_path / "fitted.toml",
    )
    tolerances = tolerances_of(cosimo.load_scene(path))
    order = [tolerances.names.index(n) for n in ("pantograph.static_force", "pantograph.head_mass")]
    np.testing.assert_allclose(tolerances.covariance[np.ix_(order, order)], covariance[:2, :2], rtol=1e-12)
    assert len(tolerances.names) == 3
    exact = tolerances_of(with_tolerances(given, NAMES, np.zeros((2, 2))))  # a fit without residuals
    assert not exact.deviations[[exact.names.index(n) for n in NAMES]].any()


@pytest.mark.parametrize(
    ("error", "parameters", "answer"), [(0.1, 0.1, "yes"), (2.5, 0.1, "undecided"), (0.1, 1.1, "undecided"), (0.1, 0.9, "yes")]
)
def test_a_row_is_undecided_by_either_error(error, parameters, answer):
    """The range ends 2 away: two standard deviations by parameters, one numerical error."""
    reference = TableRow("force", "f", "a", "N", 0.0, 10.0, "measured", "a source")
    assert Row(reference, 8.0, error, parameters=parameters).answer == answer


def test_a_case_has_the_parameter_errors_of_its_rows(scene, parts, tmp_path):
    """By runs on either side: that of the deviation as above, and an end of the range within two of it leaves the row open."""
    write_scene(scene.with_changes(TOLERANCES), tmp_path / "line.toml")
    value = of_deviation(scene, {}, verify="no")[0].value
    error = float(np.hypot(*parts.values()))
    row = {"quantity": "deviation", "measure": "pantograph.std", "unit": "N", "standing": "measured", "source": "a"}
    rows = [row | {"low": 0.0, "high": value + k * error} for k in (1.5, 3.0)]
    case = {"title": "t", "scene": "line.toml", "sources": {"a": "nowhere"}, "rows": rows}
    (tmp_path / "case.toml").write_text(tomli_w.dumps(case))
    (answer,) = cosimo.validate([str(tmp_path / "case.toml")], tmp_path / "out", in_process=True)
    assert [r.answer for r in answer.findings.rows] == ["undecided", "yes"]
    assert answer.findings.rows[0].parameters == pytest.approx(error, rel=1e-2)
    assert answer.outcome == "undecided"
    assert '"parameters"' in (tmp_path / "out" / "validation.csv").read_text().splitlines()[0].split(",")


def test_a_case_whose_tolerances_cannot_be_says_so(scene, tmp_path):
    given = {"pantograph.head_damping": 0.0, "units.pantograph.tolerances": {"head_damping": "3 %"}}
    write_scene(scene.with_changes(given), tmp_path / "line.toml")
    row = {"quantity": "mean", "measure": "pantograph.mean", "unit": "N", "standing": "measured", "source": "a", "low": 0.0}
    case = {"title": "t", "scene": "line.toml", "sources": {"a": "nowhere"}, "rows": [row]}
    (tmp_path / "case.toml").write_text(tomli_w.dumps(case))
    (answer,) = cosimo.validate([str(tmp_path / "case.toml")], tmp_path / "out", in_process=True)
    assert any("3 % of 0" in note for note in answer.findings.notes)


@pytest.mark.parametrize(
    ("numbers", "text"),
    [
        ((116.0, 0.007, 4.2), "116.000 ± 0.007 (steps) ± 4.2 (parameters)"),
        ((116.0, float("nan"), 123.4), "116 ± 120 (parameters)"),
        ((0.0, 0.0, 0.0), "0 ± 0 (steps) ± 0 (parameters)"),
        ((116.0, 0.5, float("nan")), "116.0 ± 0.5"),
    ],
)
def test_a_number_is_shown_with_both_errors(numbers, text):
    assert with_errors_of(*numbers) == text
