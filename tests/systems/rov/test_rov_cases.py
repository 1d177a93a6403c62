"""The cases of the underwater vehicle pass, and would not if the vehicle were another."""

from dataclasses import replace

import pytest
from cosimo.orchestrator.harness.validation.questions import Options
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import cases, load_scene
from cosimo.orchestrator.systems.rov.cases import added_mass as rov_added_mass
from cosimo.orchestrator.systems.rov.cases import allocation as rov_allocation
from cosimo.orchestrator.systems.rov.cases import closed_forms as rov_closed_forms


def test_columns_as_printed_would_fail(monkeypatch):
    monkeypatch.setattr(rov_allocation, "wrench_matrix", lambda *_: rov_allocation.printed())
    found = cases()["rov-allocation"].findings(Options())
    inside = {r.reference.measure: r.inside for r in found.rows}
    assert not inside["determinant"]
    assert not inside["N.plus"]
    assert inside["rank"]  # a poor matrix, but not a singular one


@pytest.mark.full
@pytest.mark.parametrize(
    ("name", "parameter", "value", "rows"),
    [
        ("10 N ahead", "quadratic_drag.surge", 18.2, {"speed.10", "start.10"}),
        ("ahead, slightly disturbed", "added_mass.heave", 14.6, {"munk"}),
        ("roll", "added_mass.roll", 0.19, {"roll"}),
    ],
)
def test_another_vehicle_fails(name, parameter, value, rows):
    """Its own rows, and no others."""
    scenes = rov_closed_forms.scenes()
    scenes[name] = scenes[name].with_changes({f"hull.{parameter}": value})
    case = cases()["rov-closed-forms"]
    case = replace(case, questions=(replace(case.questions[0], scenes=lambda: scenes),))
    found = case.findings(Options(in_process=True))
    assert {r.reference.measure for r in found.rows if not r.inside} == rows


@pytest.mark.full
def test_a_force_told_once_a_step_ends_the_run_and_keeps_what_was_computed():
    scene = load_scene("rov-added-mass").with_changes(rov_added_mass.LAGGED)
    result = run(scene, in_process=True)
    assert result.outcome == "unstable"
    assert "water failed at" in result.message
    assert result.time.size > 100
    assert abs(result["hull.external.acceleration_z"][-1]) > 1e9
    assert result["whole.external.acceleration_z"][-1] == pytest.approx(10.0 / 26.07, rel=0.2)  # beside it, all is well
