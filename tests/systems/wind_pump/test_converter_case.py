"""The case of the inertial converter passes, and would not with another lever, another mean, or a load of its own."""

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.orchestrator.harness.validation.case import Options, compare
from cosimo.orchestrator.harness.validation.reference import load_table
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import cases
from cosimo.orchestrator.systems.wind_pump.cases import inertial_converter as case

pytestmark = pytest.mark.full


def assert_held_speeds_are_closer(findings):
    """What distinguishes a wrong mean from the pulsation of light shafts: 1e-6 at held speeds, percents in the wind."""
    by_name = {row.reference.measure: row for row in findings.rows}
    held = [by_name[f"torque.{w:g}.{s:g}"].simulated / (1.0 - s) for w in case.CRANKS for s in case.SHARES]
    np.testing.assert_allclose(held, 1.0, atol=2e-6)
    assert 0.005 < by_name["turbine.3"].simulated / 2.5179 - 1.0 < 0.02


@pytest.mark.parametrize(("parameter", "value"), [("lever_mass", 4.04), ("clutch_arm", 0.0505), ("slider_mass", 0.1)])
def test_another_lever_fails(parameter, value):
    """One percent of a mass or an arm, or the slider's own mass, is outside of every range but the power's."""
    scene = case.held(20.0, {"half": 0.5 * case.LARGEST * 20.0}, {**case.EXAMPLE, parameter: value})
    driving, braking = case.mean_torques(run(scene, in_process=True), "half")
    measured = {"torque.20.0.5": driving / (case.STALL * 400.0), "power.20.0.5": braking / (driving * 0.5 * case.LARGEST)}
    rows = {
        row.reference.measure: row.inside
        for row in compare(load_table("inertial-converter").rows, measured)
        if row.reference.measure in measured
    }
    assert rows == {"torque.20.0.5": False, "power.20.0.5": True}


def test_a_run_that_fails_fails_the_case(monkeypatch):
    """A macro step at which the input shaft is unstable, or too coarse an internal one: no verdict from what is left."""
    monkeypatch.setattr(case, "EXAMPLE", {**case.EXAMPLE, "substep": 0.02})
    failed = cases()["inertial-converter"].findings(Options(in_process=True))
    assert not failed.complete
    assert "range" in failed.notes[0]
    monkeypatch.setattr(case, "EXAMPLE", {**case.EXAMPLE, "lever_mass": -1.0})
    with pytest.raises(BadInput):
        cases()["inertial-converter"].findings(Options(in_process=True))


def test_the_return_is_read_off_a_known_motion():
    """Two speeds of one damped swing, with a pulsation of the revolutions on top."""
    scene = case.in_wind(3.0, 2.6, 2.6)
    t = np.arange(round(scene.stop_time / case.STEP) + 1) * case.STEP
    swing = np.exp(-0.4 * t)

    class Known:
        time = t

        def __getitem__(self, name):
            phase, size = (0.0, 0.3) if name == "turbine.speed" else (1.2, 2.0)
            return 2.5 + size * swing * np.cos(1.1 * t + phase) + 0.05 * np.sin(30.0 * t + phase)

    back = case.returning(Known())
    assert back.real == pytest.approx(-0.4, rel=1e-3)
    assert back.imag == pytest.approx(1.1, rel=1e-3)
