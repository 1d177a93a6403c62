"""Component -> effect -> the test that compares it with a known answer."""

from __future__ import annotations

from cosimo.tests.contract.known_answers import in_file

KNOWN: dict[str, dict[str, str]] = {
    "TorqueMotor": in_file(
        "drives/test_torque_motor.py",
        inductance="current_rises_with_the_time_constant_of_the_winding",
        saturation="the_amplifier_limits_voltage_and_current",
    ),
    "ServoMotor": in_file(
        "drives/test_servo_motor.py",
        inductance="step_response_is_the_exact_one",
        saturation="the_current_limit_gives_a_constant_acceleration",
        shaft_friction="a_shaft_runs_out_under_dry_friction_in_the_exact_time_and_stays",
    ),
}
