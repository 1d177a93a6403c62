"""Torque motor: its characteristic, balance of power, winding, limits of the amplifier, and a run-up with a load."""

import math

import numpy as np
import pytest
from cosimo.components.drives.torque_motor import TorqueMotor
from cosimo.tests.support import initialized

pytestmark = pytest.mark.interpreted

R, K, N, L = 2.0, 0.1, 1.0, 1e-3  # Ohm, N.m/A, 1, H


def motor(effects=(), inputs=None, **parameters) -> TorqueMotor:
    return initialized(TorqueMotor(effects, parameters), inputs)


def steady(effects, inputs, **parameters) -> TorqueMotor:
    """A motor that starts with the current that it has without a winding."""
    if "inductance" not in effects:
        return motor(effects, inputs, **parameters)
    current = motor([e for e in effects if e != "inductance"], inputs, **parameters)["current"]
    return motor(effects, inputs, **parameters, **{"inductance.start_current": current})


@pytest.mark.parametrize("gear", [1.0, -3.0, 50.0])
@pytest.mark.parametrize("effects", [(), ("inductance",)])
def test_stall_torque_no_load_rate_and_the_line_between(effects, gear):
    stall = steady(effects, {"voltage": 12.0}, gear_ratio=gear)
    assert stall["torque"] == pytest.approx(gear * K * 12.0 / R, rel=1e-12)
    free = steady(effects, {"voltage": 12.0, "rate": 12.0 / (K * gear)}, gear_ratio=gear)
    assert abs(free["current"]) < 1e-12
    half = steady(effects, {"voltage": 12.0, "rate": 6.0 / (K * gear)}, gear_ratio=gear)
    assert half["torque"] == pytest.approx(0.5 * stall["torque"], rel=1e-12)
    assert half["torque"] * half["rate"] == pytest.approx(0.25 * 12.0**2 / R, rel=1e-12)  # the largest mechanical power


@pytest.mark.parametrize(("voltage", "rate"), [(10.0, 20.0), (-10.0, 20.0), (0.0, 30.0), (3.0, 200.0), (300.0, -20.0)])
@pytest.mark.parametrize("effects", [(), ("saturation",), ("inductance", "saturation")])
def test_electrical_power_is_shaft_power_and_heat(effects, voltage, rate):
    made = steady(effects, {"voltage": voltage, "rate": rate})
    heat = R * made["current"] ** 2
    assert made["electrical_power"] == pytest.approx(made["torque"] * rate + heat, rel=1e-12, abs=1e-12)


def test_a_motor_driven_with_open_amplifier_voltage_zero_brakes():
    made = motor((), {"voltage": 0.0, "rate": 7.0})
    assert made["torque"] == pytest.approx(-(K**2) / R * 7.0, rel=1e-12)  # the damping k² / R of a shorted motor
    assert made["electrical_power"] == 0.0


@pytest.mark.known_answers(TorqueMotor="inductance")
def test_current_rises_with_the_time_constant_of_the_winding():
    """From none: the motor is switched on at the start."""
    made = motor(("inductance",), {"voltage": 12.0})
    assert (made["current"], made["torque"], made["electrical_power"]) == (0.0, 0.0, 0.0)
    for k in range(20):
        made.step(k * 1e-4, 1e-4)
        expected = 12.0 / R * (1.0 - math.exp(-(k + 1) * 1e-4 * R / L))
        assert made["current"] == pytest.approx(expected, abs=5e-5)  # RK4, 0.1 or 0.2 of R / L: 6 A * 0.2^5 / 120 a step
    assert made.energy() == pytest.approx(0.5 * L * made["current"] ** 2, rel=1e-15)


def test_amplitude_and_phase_of_the_winding_at_a_sinusoidal_voltage():
    w, h = 2000.0, 2e-5  # rad/s, four times R / L
    made = motor(("inductance",), **{"inductance.substep": 2e-5})
    for k in range(1000):
        a, b, c = (math.cos(w * (k + share) * h) for share in (0.0, 0.5, 1.0))
        made.u[:, 0] = a, (-3.0 * a + 4.0 * b - c) / h, 2.0 * (a - 2.0 * b + c) / h**2
        made.step(k * h, h)
    expected = np.exp(1j * w * 1000 * h) / (R + 1j * w * L)  # after 40 time constants
    assert made["current"] == pytest.approx(expected.real, abs=1e-6)


@pytest.mark.known_answers(TorqueMotor="saturation")
def test_the_amplifier_limits_voltage_and_current():
    limits = {"saturation.voltage": 10.0, "saturation.current": 3.0}
    # at rest 10 V would drive 5 A: the current is the limit; at 60 rad/s there are 4 V left: the voltage is
    assert motor(("saturation",), {"voltage": 50.0}, **limits)["current"] == pytest.approx(3.0, rel=1e-12)
    fast = motor(("saturation",), {"voltage": 50.0, "rate": 60.0}, **limits)
    assert fast["current"] == pytest.approx((10.0 - 6.0) / R, rel=1e-12)
    # driven far beyond the voltage: the amplifier cannot hold the current any more
    driven = motor(("saturation",), {"voltage": 0.0, "rate": 300.0}, **limits)
    assert driven["current"] == pytest.approx((10.0 - 30.0) / R, rel=1e-12)
    inside = motor(("saturation",), {"voltage": 4.0}, **limits)
    assert inside["current"] == motor((), {"voltage": 4.0})["current"]


def test_the_limited_current_does_not_overshoot_in_the_winding():
    made = motor(("inductance", "saturation"))
    made.set("voltage", 100.0)
    currents = []
    for k in range(100):
        made.step(k * 1e-4, 1e-4)
        currents.append(made["current"])
    assert max(currents) <= 5.0
    assert currents[-1] == pytest.approx(5.0, rel=1e-6)


def test_run_up_with_an_inertia():
    """A load beside the motor, by Euler's method: w = V / k (1 - (1 - h / T)^n), T = R J / k², exactly."""
    made, inertia, h, rate = motor((), {"voltage": 12.0}), 1e-3, 1e-4, 0.0
    constant = R * inertia / K**2
    for _ in range(2000):
        made.set("rate", rate)
        made.refresh()
        rate += h * made["torque"] / inertia
    assert rate == pytest.approx(12.0 / K * -math.expm1(2000 * math.log1p(-h / constant)), rel=1e-9)


def test_nothing_is_integrated_without_a_winding():
    made = motor()
    assert made.x.size == 0
    assert made.stable_step() == math.inf
    made.step(0.0, 10.0)
    assert made.work["steps"] == 1
