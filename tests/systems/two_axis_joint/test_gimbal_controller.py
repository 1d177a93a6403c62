"""Controller of the gimbal: its law at samples, the scan, limits without wind-up, and the closed loop with body and motors."""

import math

import numpy as np
import pytest
from cosimo.components.drives.torque_motor import TorqueMotor
from cosimo.components.two_axis_joint.controller import GimbalController
from cosimo.components.two_axis_joint.gimbal import GimbalBody
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import load_scene
from cosimo.tests.support import initialized

pytestmark = pytest.mark.interpreted


def controller(effects=(), inputs=None, **parameters) -> GimbalController:
    return initialized(GimbalController(effects, parameters), inputs)


def test_the_law_at_the_first_sample_and_its_integral():
    measured = {"outer_angle": 0.01, "inner_angle": -0.02, "outer_rate": 0.1, "inner_rate": 0.3}
    unit = controller((), measured, set_inner_angle=0.005)
    assert unit["outer_error"] == pytest.approx(-0.01, rel=1e-15)
    assert unit["inner_error"] == pytest.approx(0.025, rel=1e-15)
    outer, inner = 640.0 * -0.01 - 64.0 * 0.1, 400.0 * 0.025 - 40.0 * 0.3
    assert unit["outer_voltage"] == pytest.approx(outer, rel=1e-12)
    assert unit["inner_voltage"] == pytest.approx(inner, rel=1e-12)
    unit.step(0.0, 0.02)  # ten samples of 2 ms; the voltage at the k-th holds k earlier terms of the integral
    assert unit.work["samples"] == 10
    assert unit["outer_voltage"] == pytest.approx(outer + 640.0 * -0.01 * 10 * 2e-3, rel=1e-12)
    assert unit["inner_voltage"] == pytest.approx(inner + 400.0 * 0.025 * 10 * 2e-3, rel=1e-12)


def test_voltages_are_held_between_samples():
    unit = controller()
    unit.set("outer_angle", 0.01)
    unit.step(0.0, 1e-3)
    assert unit["outer_voltage"] == 0.0  # that sample is to come
    unit.step(1e-3, 1e-3)
    assert unit["outer_voltage"] == pytest.approx(-6.4, rel=1e-12)


@pytest.mark.parametrize("h", [2e-3, 7e-4, 0.05, 1.0])
def test_samples_lie_at_multiples_of_the_period_whatever_the_macro_step(h):
    """Inputs that are straight lines: each sample takes the line's own value, whichever step it falls into."""
    unit, reference = controller(), controller()
    n = math.floor(1.0 / h + 1e-9)
    for k in range(n):
        unit.u[0, 0], unit.u[1, 0] = 1e-3 * k * h, 1e-3
        unit.step(k * h, h)
    for k in range(round(n * h / 2e-3 - 0.499999)):
        reference.u[0, 0], reference.u[1, 0] = 1e-3 * k * 2e-3, 1e-3
        reference.step(k * 2e-3, 2e-3)
    assert unit.work["samples"] == reference.work["samples"]
    assert unit["outer_voltage"] == pytest.approx(reference["outer_voltage"], rel=1e-9)


@pytest.mark.known_answers(GimbalController="scan")
def test_the_scan_moves_set_points_and_their_rates():
    numbers = {"scan.outer_amplitude": 0.2, "scan.outer_frequency": 3.0, "scan.outer_phase": 0.4, "scan.inner_amplitude": 0.0}
    unit = controller(("scan",), None, **numbers, set_outer_angle=-0.1, outer_integral_gain=0.0, voltage_limit=1e6)
    unit.step(0.0, 0.1)
    w, phase = 2.0 * math.pi * 3.0, 2.0 * math.pi * 3.0 * 0.1 + 0.4
    assert unit["outer_error"] == pytest.approx(-0.1 + 0.2 * math.sin(phase), rel=1e-12)
    expected = 640.0 * (-0.1 + 0.2 * math.sin(phase)) + 64.0 * 0.2 * w * math.cos(phase)
    assert unit["outer_voltage"] == pytest.approx(expected, rel=1e-12)
    assert unit["inner_voltage"] == 0.0


def test_a_limited_voltage_does_not_wind_the_integral_up():
    """An error that lasts: without the way back the integral would grow by K_i e t = 3200 V in 10 s; it stays at a balance.

    At the limit V_l the integral settles where K_i e = (K_p e + I - V_l) / T.
    """
    unit = controller((), {"outer_angle": -0.5})
    unit.step(0.0, 10.0)
    assert unit["outer_voltage"] == 24.0
    balance = 640.0 * 0.5 * 0.1 - 640.0 * 0.5 + 24.0
    assert unit.x[3] == pytest.approx(balance, rel=1e-9)


def closed_loop(body: GimbalBody, unit: GimbalController, duration: float, gear: float = 1.0) -> list[list[float]]:
    """Body, two motors and controller stepped by hand, 0.5 ms, motors between; rows of time, angles and errors."""
    motors = {axis: TorqueMotor(("saturation",), {"gear_ratio": gear}) for axis in ("outer", "inner")}
    for motor in motors.values():
        motor.initialize(0.0)
    rows, h = [], 5e-4
    for k in range(round(duration / h)):
        for axis, motor in motors.items():
            motor.set("voltage", unit[f"{axis}_voltage"])
            motor.set("rate", body[f"{axis}_rate"])
            motor.refresh()
            body.set(f"{axis}_torque", motor["torque"])
        body.step(k * h, h)
        for name in unit.inputs:
            unit.set(name, body[name])
        unit.step(k * h, h)
        rows.append([(k + 1) * h, *body.y[:2], unit["outer_error"], unit["inner_error"]])
    return rows


def test_the_loop_points_and_holds_against_weight_and_dry_friction():
    body = GimbalBody(("gravity", "stick_friction"), {"gravity.mass": 0.5, "start_inner_angle": 0.0})
    unit = controller((), None, set_outer_angle=0.5, set_inner_angle=0.4)
    body.initialize(0.0)
    rows = np.array(closed_loop(body, unit, 6.0))
    late = rows[:, 0] > 5.0
    # the integral takes the weight; under dry friction it hunts, within what K_i and the level allow
    assert np.abs(rows[late, 1] - 0.5).max() < 2e-3
    assert np.abs(rows[late, 2] - 0.4).max() < 2e-3
    assert rows[:, 1].max() < 0.5 * 1.4


@pytest.mark.full
def test_the_loop_follows_a_scan():
    body = GimbalBody(("viscous",), {"start_inner_angle": 0.0})
    unit = controller(("scan",), None, **{"scan.outer_frequency": 0.2, "scan.inner_frequency": 0.4})
    body.initialize(0.0)
    rows = np.array(closed_loop(body, unit, 8.0))
    late = rows[:, 0] > 3.0
    assert np.abs(rows[late, 3]).max() < 0.02 * 0.5
    assert np.abs(rows[late, 4]).max() < 0.02 * 0.3


def test_a_command_acts_from_its_sample_on_whatever_the_algorithm():
    """An arm's motors, whose torques jump with the voltage: errors are those of a second order, and the account sees no energy lost."""

    def ran(algorithm, step):
        changes = {"master.algorithm": algorithm, "master.step": step, "stop_time": 0.5, "analysis.transient": 0.0}
        return run(load_scene("two-link-manipulator", changes), in_process=True)

    fine = ran("iterative", 5e-4)["elbow.electrical_power"]
    for algorithm in ("gauss-seidel", "iterative"):
        errors = []
        for parts in (1, 2):
            result = ran(algorithm, 2e-3 / parts)
            errors.append(np.sqrt(np.mean((result["elbow.electrical_power"] - fine[:: 4 // parts]) ** 2)) / fine.std())
            for bond in result.info.energy.values():
                assert abs(bond.created) < 1e-4 * bond.exchanged
        assert errors[1] < 0.3 * errors[0] < 0.3 * 1e-3
