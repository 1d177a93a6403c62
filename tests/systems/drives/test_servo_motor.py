"""Servo motor: exact step response, no load, load and stall, friction that stands, balance of power, limits of the amplifier."""

import math

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.components.drives.servo_motor import ServoMotor, servo_derivatives, shaft_inertia
from cosimo.tests.slopes import orders
from cosimo.tests.support import initialized
from cosimo.tests.systems.drives.closed_forms import poles, steady, step_response, wheel_constants
from scipy.linalg import expm

pytestmark = pytest.mark.interpreted

R, L, K, N = 2.3, 0.238e-3, 23.4e-3, 19.0  # Ohm, H, N.m/A, 1


def motor(effects=(), inputs=None, **parameters) -> ServoMotor:
    return initialized(ServoMotor(effects, parameters), inputs)


def response(made, t, voltage, load=0.0) -> np.ndarray:
    """Angle, rate and current at the times t, stepped from one to the next."""
    made.set("voltage", voltage)
    made.set("load_torque", load)
    rows = []
    for before, after in zip((0.0, *t[:-1]), t, strict=True):
        made.step(before, after - before)
        rows.append([made["angle"], made["rate"], made["current"]])
    return np.array(rows)


# -- closed forms ------------------------------------------------------------------------------------------------------------
def test_poles_of_the_bare_motor():
    """J = 1e-6 kg.m², b = 1e-7 N.m.s/rad: s² + (R/L + b/J) s + (k² + R b) / (L J)."""
    bare = ServoMotor(preset="motor alone")
    found = poles(bare)
    assert [p.real for p in found] == pytest.approx([-244.3, -9419.6], abs=0.1)
    assert [p.imag for p in found] == [0.0, 0.0]
    matrix = np.array([[-1e-7 / 1e-6, K / 1e-6], [-K / L, -R / L]])
    np.testing.assert_allclose(sorted(p.real for p in found), sorted(np.linalg.eigvals(matrix)), rtol=1e-8)


@pytest.mark.parametrize("change", [{}, {"inductance.inductance": 0.05}])  # real poles, complex ones
def test_the_closed_form_is_the_matrix_exponential(change):
    made = ServoMotor(("inductance",), change)
    J, B, torque = wheel_constants(made)
    inductance = made["inductance.inductance"]
    system = np.zeros((4, 4))  # angle, rate, current, and 1
    system[0, 1] = 1.0
    system[1] = 0.0, -B / J, torque / J, -0.2 / J
    system[2] = 0.0, -torque / inductance, -R / inductance, 8.0 / inductance
    t = np.array([1e-5, 1e-3, 0.02, 0.3])
    exact = [(expm(system * s) @ [0.0, 0.0, 0.0, 1.0])[:3] for s in t]
    np.testing.assert_allclose(step_response(made, t, 8.0, 0.2), exact, rtol=1e-9, atol=1e-12)


@pytest.mark.known_answers(ServoMotor="inductance")
@pytest.mark.parametrize("load", [0.0, 0.4])
def test_step_response_is_the_exact_one(load):
    made = motor(("inductance",), substep=1e-5)
    t = np.array([1e-4, 1e-3, 4e-3, 2e-2, 0.1])
    exact = step_response(made, t, 12.0, load)
    # RK4 with 0.1 of the fast time constant a substep: 0.1^4 / 120 of the fast part
    np.testing.assert_allclose(response(made, t, 12.0, load), exact, rtol=1e-6, atol=1e-7)


def test_the_response_converges_with_the_fourth_order():
    errors = []
    for n in (1, 2, 4):
        made = motor(("inductance",), substep=5e-5 / n)
        error = response(made, np.array([1e-3]), 12.0) - step_response(made, np.array([1e-3]), 12.0)
        errors.append(abs(error[0, 1]))
    slopes = orders(errors)
    assert slopes == pytest.approx([4.0, 4.0], abs=0.3)


def test_without_a_winding_the_rate_rises_with_one_time_constant():
    made = motor()
    J, B, torque = wheel_constants(made)
    rate = (torque**2 / R + B) / J
    t = np.array([1e-3, 5e-3, 2e-2])
    exact = -steady(made, 12.0).rate * np.expm1(-rate * t)
    assert response(made, t, 12.0)[:, 1] == pytest.approx(exact, rel=1e-7)  # 0.024 of the time constant a substep


@pytest.mark.parametrize("effects", [(), ("inductance",)])
def test_no_load_loaded_and_stalled(effects):
    free = motor(effects, damping=0.0)
    assert response(free, [0.5], 12.0)[0, 1] == pytest.approx(12.0 / (K * N), rel=1e-9)
    loaded = motor(effects, damping=0.0)
    shaft_load = 0.02  # N.m at the motor's shaft
    rate = response(loaded, [0.5], 12.0, N * shaft_load)[0, 1]
    assert N * rate == pytest.approx((12.0 - R * shaft_load / K) / K, rel=1e-9)
    stalled = motor(effects, damping=0.0)
    _, rate, current = response(stalled, [0.5], 12.0, N * K * 12.0 / R)[0]
    assert current == pytest.approx(12.0 / R, rel=1e-9)
    assert abs(rate) < 1e-9


def test_gear_and_wheel_belong_to_the_inertia_at_the_wheel():
    made = motor(gear_ratio=-3.0, rotor_inertia=2e-6, wheel_inertia=5e-6)
    assert shaft_inertia(made.arguments[1]) == wheel_constants(made)[0] == pytest.approx(23e-6, rel=1e-15)
    backwards = motor(gear_ratio=-19.0)
    assert response(backwards, [0.2], 12.0)[0, 1] == -response(motor(), [0.2], 12.0)[0, 1]


# -- power -------------------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("effects", [(), ("inductance",), ("inductance", "saturation", "shaft_friction")])
def test_power_in_is_power_out_heat_and_change_of_energy(effects):
    """Identity of the equations at random states; the friction that is left over must be a loss."""
    random = np.random.default_rng(1)
    for _ in range(50):
        made = motor(effects)
        made.u[0] = random.normal(size=2) * [20.0, 0.5]
        rate, current = random.normal(size=2) * [20.0, 5.0]
        made.x[1] = rate
        if "inductance" in effects:
            made.x[2] = current
        if "shaft_friction" in effects:
            made.x[-1] = math.copysign(1.0, rate)
        made.refresh()
        dx = np.zeros(made.x.size)
        servo_derivatives(0.0, made.x, made.u[0], dx, *made.arguments)
        J, B, _ = wheel_constants(made)
        gain = J * rate * dx[1] + (L * made["current"] * dx[2] if "inductance" in effects else 0.0)
        friction = 0.0
        if "shaft_friction" in effects:
            friction = (0.01 + 0.2 * N * K * abs(made["current"])) * abs(rate)
        out = made["load_torque"] * rate + R * made["current"] ** 2 + B * rate**2 + friction
        assert made["electrical_power"] == pytest.approx(gain + out, rel=1e-12, abs=1e-10)


def test_the_current_at_the_start_is_the_steady_one_without_inductance_and_the_given_one_with_it():
    made = motor((), {"voltage": 5.0}, start_rate=3.0)
    assert made["current"] == pytest.approx((5.0 - K * N * 3.0) / R, rel=1e-14)
    assert motor(("inductance",), {"voltage": 5.0}, start_rate=3.0)["current"] == 0.0
    assert motor(("inductance",), {"voltage": 5.0}, **{"inductance.start_current": 1.5})["current"] == 1.5


def test_energy_is_that_of_inertia_and_winding():
    made = motor(("inductance",), {"voltage": 5.0}, start_rate=3.0, **{"inductance.start_current": 1.5})
    assert made.energy() == pytest.approx(0.5 * (361e-6 + 1e-6) * 9.0 + 0.5 * L * made["current"] ** 2, rel=1e-14)


# -- friction ----------------------------------------------------------------------------------------------------------------
def test_a_shaft_stands_up_to_its_static_level_and_not_beyond():
    """0.01 N.m and ratio 1.5, 20 % of the motor's torque in the gear: 0.8 N k i = 0.015 N.m breaks loose."""
    current = 0.015 / (0.8 * N * K)
    below, above = (motor(("shaft_friction",), {"voltage": share * R * current}) for share in (0.999, 1.001))
    assert (below["shaft_friction.stuck"], above["shaft_friction.stuck"]) == (1.0, 0.0)
    below.step(0.0, 1.0)
    above.step(0.0, 1.0)
    assert below["angle"] == 0.0
    assert above["rate"] == pytest.approx(
        (0.8 * K * N * 1.001 * R * current - 0.01 * R) / (0.8 * (K * N) ** 2 + R * N**2 * 1e-7), rel=1e-9
    )


def test_a_load_must_overcome_the_friction_to_drive_the_motor_back():
    held = motor(("shaft_friction",), {"load_torque": 0.0149})
    held.step(0.0, 0.2)
    assert (held["rate"], held["shaft_friction.stuck"]) == (0.0, 1.0)
    driven = motor(("shaft_friction",), {"load_torque": 0.1})
    driven.step(0.0, 0.5)
    # the shorted motor brakes with N k i, the gear with a fifth of it more
    rate = -(0.1 - 0.01) / (1.2 * (K * N) ** 2 / R + N**2 * 1e-7)
    assert driven["rate"] == pytest.approx(rate, rel=1e-9)


@pytest.mark.known_answers(ServoMotor="shaft_friction")
def test_a_shaft_runs_out_under_dry_friction_in_the_exact_time_and_stays():
    """No constant: nothing but friction brakes, w = w0 - T t / J, and the shaft stands after w0 J / T, at w0² J / 2 T."""
    made = motor(("shaft_friction",), constant=0.0, damping=0.0, start_rate=10.0)
    J = wheel_constants(made)[0]
    end = 10.0 * J / 0.01
    made.step(0.0, 0.5 * end)
    assert made["rate"] == pytest.approx(5.0, rel=1e-12)
    made.step(0.5 * end, end)
    assert made["angle"] == pytest.approx(10.0**2 * J / 0.02, rel=1e-12)
    assert (made["rate"], made["shaft_friction.stuck"], made.work["events"]) == (0.0, 1.0, 1)


# -- limits ------------------------------------------------------------------------------------------------------------------
@pytest.mark.known_answers(ServoMotor="saturation")
def test_the_current_limit_gives_a_constant_acceleration():
    made = motor(("saturation",), {"voltage": 20.0}, damping=0.0)
    assert made["current"] == pytest.approx(4.0, rel=1e-12)  # 12 V, what the amplifier has, would drive 5.2 A
    made.step(0.0, 1e-3)
    assert made["rate"] == pytest.approx(4.0 * K * N * 1e-3 / wheel_constants(made)[0], rel=1e-12)
    made.step(1e-3, 0.5)
    assert made["rate"] == pytest.approx(12.0 / (K * N), rel=1e-9)  # the voltage is the limit in the end


def test_a_substep_that_the_motor_does_not_allow_is_refused():
    with pytest.raises(BadInput, match="limit of RK4"):
        motor(("inductance",), **{"inductance.inductance": 1e-6})
    with pytest.raises(BadInput, match="limit of RK4"):
        motor(rotor_inertia=1e-9)
    assert motor(constant=0.0, damping=0.0).stable_step() == math.inf


# -- temperature -----------------------------------------------------------------------------------------------------------------
HEAT = {
    "coefficient": 0.0,
    "winding_capacity": 1.1e-3,  # a thousandth of usual ones: 1 s stands for 17 minutes
    "housing_capacity": 40e-3,
    "winding_to_housing": 5.0,
    "housing_to_ambient": 14.0,
}
STALLED = {"gear_ratio": 1.0, "wheel_inertia": 1e9}  # it does not turn


def heated(seconds: float, voltage: float, **parameters) -> ServoMotor:
    made = motor(("heating",), {"voltage": voltage}, **STALLED, **{f"heating.{n}": v for n, v in (HEAT | parameters).items()})
    for k in range(round(seconds / 0.01)):
        made.step(0.01 * k, 0.01)
    return made


@pytest.mark.known_answers(ServoMotor="heating")
@pytest.mark.parametrize("seconds", [0.01, 0.3])
def test_temperatures_rise_as_the_matrix_exponential(seconds):
    """A constant resistance: two capacities, two resistances, and 4 V at stall."""
    made = heated(seconds, 4.0)
    power = 4.0**2 / R
    system = np.array(
        [[-1 / 5.0 / 1.1e-3, 1 / 5.0 / 1.1e-3, power / 1.1e-3], [1 / 5.0 / 40e-3, -(1 / 5.0 + 1 / 14.0) / 40e-3, 0.0], [0.0] * 3]
    )
    rise = (expm(system * seconds) @ [0.0, 0.0, 1.0])[:2]
    assert [made["heating.winding_temperature"] - 298.15, made["heating.housing_temperature"] - 298.15] == pytest.approx(
        rise, rel=1e-8
    )


def test_a_warm_winding_takes_less_current_and_settles_where_heat_balances():
    """x = P0 Rth / (1 + a x) at a constant voltage: the root of a quadratic."""
    made = heated(10.0, 4.0, coefficient=0.00393)
    rth, cold = 19.0, 4.0**2 / R
    rise = (-1.0 + math.sqrt(1.0 + 4.0 * 0.00393 * cold * rth)) / (2.0 * 0.00393)
    assert made["heating.winding_temperature"] - 298.15 == pytest.approx(rise, rel=1e-6)
    assert made["current"] == pytest.approx(4.0 / (R * (1.0 + 0.00393 * rise)), rel=1e-6)


def test_a_motor_in_the_cold_has_the_resistance_of_the_cold():
    made = motor(("heating",), {"voltage": 1.0}, **STALLED, **{"heating.ambient": 248.15})
    assert made["current"] == pytest.approx(1.0 / (R * (1.0 - 50.0 * 0.00393)), rel=1e-12)
