"""The drive as one unit: exactly where it is linear, against a servo motor's step response, its parts coupled, and its energy."""

import math

import numpy as np
import pytest
from cosimo.components.drives.servo_motor import ServoMotor
from cosimo.components.friction_drive.monolith import FrictionDrive, drive_derivatives, motor_place
from cosimo.components.friction_drive.wheels import FrictionWheels
from cosimo.tests.slopes import orders
from cosimo.tests.support import initialized
from cosimo.tests.systems.energy import energy_rate
from scipy.linalg import expm

pytestmark = pytest.mark.full

FULL = ("inductance", "shaft_friction", "exact_slip", "trocar_friction", "gravity", "preload_loss")
NEUTRAL = {
    "shaft_friction.level": 0.0,
    "shaft_friction.gear_loss": 0.0,
    "trocar_friction.level": 0.0,
    "gravity.acceleration": 0.0,
    "preload_loss.first": 0.0,
}
SHAFT, TORQUE = 19.0**2 * 1e-6 + 1e-6, 19.0 * 23.4e-3  # kg.m2 and N.m/A at the wheel


def drive_at(effects=(), first=0.0, second=0.0, force=0.0, torque=0.0, **parameters) -> FrictionDrive:
    """An initialized drive with given voltages and loads."""
    drive = FrictionDrive(effects, parameters)
    drive.u[0, :4] = first, second, force, torque
    return initialized(drive)


@pytest.mark.parametrize("layout", ["skewed", "skewed_free_rollers", "orthogonal"])
def test_a_drive_that_creeps_is_linear(layout):
    """Without an effect: rates of sleeve and wheels by the matrix exponential."""
    drive = drive_at((), 9.0, 4.0, -1.0, 0.003, layout=layout, substep=2e-5)
    c, R, half = 600.0, 0.01, math.pi / 6.0
    t = np.array(
        [[1.0, 0.0], [0.0, 1.0]]
        if layout == "orthogonal"
        else [[math.cos(half), math.sin(half)], [math.cos(half), -math.sin(half)]]
    )
    # coordinates: the sleeve's surface along and around, both rims; every slip is linear in them
    D = np.zeros((4, 4))
    for k in range(2):
        slips = np.zeros((2, 4))
        slips[:, :2] = np.eye(2) if layout == "skewed" else np.outer(t[k], t[k])
        slips[:, 2 + k] = -t[k]
        D += c * slips.T @ slips
    D += np.diag([0.0, 0.0, *[(TORQUE**2 / 2.3 + 19.0**2 * 1e-7) / R**2] * 2])
    masses = np.array([0.15, 1.875e-6 / 0.005**2, SHAFT / R**2, SHAFT / R**2])
    A, b = D / masses[:, None], np.array([-1.0, 0.6, 9.0 * TORQUE / 2.3 / R, 4.0 * TORQUE / 2.3 / R]) / masses
    steady = np.linalg.solve(A, b)
    for k in range(5):
        drive.step(k * 2e-3, 2e-3)
        exact = steady - expm(-A * (k + 1) * 2e-3) @ steady
        found = [drive["feed_rate"], 0.005 * drive["rotation_rate"], R * drive["first_rate"], R * drive["second_rate"]]
        assert found == pytest.approx(exact, rel=1e-6)


@pytest.mark.known_answers(FrictionDrive="inductance")
def test_even_wheels_with_free_rollers_are_one_motor_with_the_sleeve_on_its_shaft():
    """No slip: each motor accelerates half of the sleeve, m R² / 2 cos² a; the motor's own step response, poles and all."""
    drive = drive_at(
        FULL, 3.0, 3.0, **NEUTRAL | {"layout": "skewed_free_rollers", "exact_slip.deflection": 2e-5, "substep": 5e-5}
    )
    added = 0.5 * 0.15 * 0.01**2 / math.cos(math.pi / 6.0) ** 2
    motor = ServoMotor(("inductance",), {"wheel_inertia": 1e-6 + added, "substep": 5e-5})
    motor.set("voltage", 3.0)
    motor.initialize(0.0)
    drive.step(0.0, 2e-3)
    motor.step(0.0, 2e-3)
    for k in range(20):
        drive.step(2e-3 + k * 1e-3, 1e-3)
        motor.step(2e-3 + k * 1e-3, 1e-3)
        # the elastic contact lets the sleeve lag by a few um at first: measured 9e-4
        assert drive["first_rate"] == pytest.approx(motor["rate"], rel=2e-3)
        assert drive["second_rate"] == pytest.approx(drive["first_rate"], rel=1e-12)
    drive.step(0.022, 0.3)
    motor.step(0.022, 0.3)
    assert drive["first_rate"] == pytest.approx(motor["rate"], rel=1e-6)
    assert drive["first_current"] == pytest.approx(motor["current"], rel=1e-4)
    assert drive["feed_rate"] == pytest.approx(0.01 * motor["rate"] / math.cos(math.pi / 6.0), rel=1e-6)


def test_a_motor_that_slips_carries_the_friction_of_its_contact():
    """Plain even wheels without load: each bears R mu N sin a, and settles where its motor does under that load."""
    drive = drive_at(FULL, 9.0, 9.0, **NEUTRAL)
    motor = ServoMotor(("inductance",))
    motor.set("voltage", 9.0)
    motor.set("load_torque", 0.01 * 6.0 * 0.5)
    for unit in (drive, motor):
        unit.initialize(0.0)
        unit.step(0.0, 0.5)
    assert drive["first_rate"] == pytest.approx(motor["rate"], rel=1e-9)
    assert drive["first_current"] == pytest.approx(motor["current"], rel=1e-6)
    assert drive["feed_rate"] == pytest.approx(0.01 * motor["rate"] * math.cos(math.pi / 6.0), rel=1e-6)
    assert drive["contact_power"] == pytest.approx(12.0 * 0.01 * motor["rate"] * 0.5, rel=1e-6)
    assert drive["electrical_power"] == pytest.approx(18.0 * motor["current"], rel=1e-6)


def coupled(h: float, duration: float) -> np.ndarray:
    """Two motors and the wheels, each step with the others' last outputs: feed, rotation, both rates at the end."""
    wheels = FrictionWheels(("exact_slip", "trocar_friction", "gravity", "preload_loss"), {"preload_loss.start": 0.02})
    motors = [ServoMotor(("inductance", "shaft_friction")) for _ in range(2)]
    for motor, voltage in zip(motors, (6.0, 4.0), strict=True):
        motor.set("voltage", voltage)
    wheels.set("external_force", -1.0)
    for unit in (*motors, wheels):
        unit.initialize(0.0)
    for k in range(round(duration / h)):
        loads = wheels["first_torque"], wheels["second_torque"]
        rates = motors[0]["rate"], motors[1]["rate"]
        for motor, load in zip(motors, loads, strict=True):
            motor.set("load_torque", load)
            motor.step(k * h, h)
        wheels.set("first_rate", rates[0])
        wheels.set("second_rate", rates[1])
        wheels.step(k * h, h)
    return np.array([wheels["feed"], wheels["rotation"], motors[0]["rate"], motors[1]["rate"]])


@pytest.mark.known_answers(FrictionDrive=("trocar_friction", "gravity", "preload_loss"))
def test_the_parts_tend_to_the_whole_with_the_step():
    """Held inputs in parallel: first order in the macro step, of slip and stick, seal, gears and a lost preload."""
    drive = drive_at(FULL, 6.0, 4.0, -1.0, **{"preload_loss.start": 0.02, "substep": 2.5e-5})
    drive.step(0.0, 0.1)
    whole = np.array([drive["feed"], drive["rotation"], drive["first_rate"], drive["second_rate"]])
    steps = [4e-4, 2e-4, 1e-4]
    errors = np.array([np.abs(coupled(h, 0.1) - whole) for h in steps])
    slopes = orders(errors)
    assert (np.abs(slopes - 1.0) < 0.1).all(), slopes


@pytest.mark.parametrize("effects", [FULL, ("smoothed_slip",)], ids="+".join)
def test_energy_of_the_drive_changes_by_power_and_losses(effects):
    """dE/dt = V i + F z' + M phi' - R i² - friction of shafts, contacts and seal, at random states."""
    random = np.random.default_rng(5)
    drive = drive_at(effects, **({"preload_loss.first": 0.0} if effects is FULL else {}))
    _, p, e = drive.arguments
    shaft, lugre, exact, trocar = e.shaft_friction, e.lugre_slip, e.exact_slip, e.trocar_friction
    at = motor_place(lugre, exact, e.rolling_slip, trocar)
    for trial in range(30):
        drive.x[:4] = random.normal(0.0, [0.1, 1.0, 0.2, 20.0])
        drive.x[at : at + 4] = random.normal(0.0, 10.0, 4)
        drive.u[0, :4] = random.normal(0.0, [6.0, 6.0, 3.0, 0.01])
        if exact is not None:
            drive.x[4:8] = random.normal(0.0, 3e-5, 4)
            drive.x[10:12] = random.normal(0.0, 1e-4, 2)
            drive.x[at + 4 : at + 6] = random.normal(0.0, 1.0, 2)
            modes = np.sign(drive.x[at + 2 : at + 4]) * (trial % 3 > 0)
            drive.x[at + 6 : at + 8] = modes
            drive.x[at + 2 : at + 4] *= modes != 0.0
        drive.refresh()
        change, rate = energy_rate(drive, drive_derivatives, 1e-7)
        rates = drive.x[at + 2 : at + 4]
        currents = np.array([drive["first_current"], drive["second_current"]])
        power = (
            drive["electrical_power"]
            + drive["external_force"] * drive["feed_rate"]
            + drive["external_torque"] * drive["rotation_rate"]
        )
        power -= p.resistance * currents @ currents + p.gear_ratio**2 * p.damping * rates @ rates + drive["contact_power"]
        if shaft is not None:
            power -= float((shaft.level + shaft.gear_loss * np.abs(TORQUE * currents)) @ np.abs(rates))
            power += 6.0 / exact.deflection * float(drive.x[4:8] @ rate[4:8])
            v = np.array([drive["feed_rate"], 0.005 * drive["rotation_rate"]])
            power -= trocar.level / trocar.deflection * trocar.damping_time * float(v @ v)
        assert change == pytest.approx(power, rel=1e-6, abs=1e-5)


SOFT = {"exact_slip.deflection": 0.1, "trocar_friction.level": 0.01, "resistance": 0.1}


@pytest.mark.parametrize(
    "given", [SOFT, SOFT | {"inductance.inductance": 5e-2}, {"gear_ratio": 1.0, "inductance.inductance": 0.1}]
)
def test_the_stable_step_is_that_of_the_drive_at_rest(given):
    """2.61, RK4's limit, over the largest eigenvalue of the derivatives, by differences: contacts hold, shafts are free."""
    drive = drive_at(FULL, substep=1e-5, **given)
    drive.x[19:] = 1.0
    moving, d, columns = [i for i in range(19) if i not in (8, 9, 12)], 1e-7, []
    for i in moving:
        ends = np.zeros((2, drive.x.size))
        for end, sign in zip(ends, (1.0, -1.0), strict=True):
            drive_derivatives(0.0, drive.x + sign * d * np.eye(drive.x.size)[i], drive.u[0], end, *drive.arguments)
        columns.append((ends[0] - ends[1])[moving] / (2.0 * d))
    assert drive.stable_step() == pytest.approx(2.61 / np.abs(np.linalg.eigvals(np.array(columns))).max(), rel=5e-3)


@pytest.mark.parametrize(("share", "stands"), [(0.999, 1.0), (1.001, 0.0)])
def test_each_shaft_stands_up_to_its_static_level(share, stands):
    """As a motor alone: 0.8 N k i = 0.015 N.m breaks loose, forwards and backwards; wheels without friction."""
    voltage = share * 2.3 * 0.015 / (0.8 * TORQUE)
    drive = drive_at(FULL, voltage, -voltage, **NEUTRAL | {"shaft_friction.level": 0.01, "shaft_friction.gear_loss": 0.2,
                                                          "friction": 1e-9})  # fmt: skip
    drive.step(0.0, 0.05)
    assert drive["shaft_friction.first_stuck"] == drive["shaft_friction.second_stuck"] == stands
    assert (drive["first_angle"] > 0.0, drive["second_angle"] < 0.0) == (stands == 0.0, stands == 0.0)


def standing(layout: str) -> FrictionDrive:
    """Drive without voltage, shafts that bear 0.03 N.m each, a force that has come slowly to -3 N."""
    drive = drive_at(FULL, **NEUTRAL | {"shaft_friction.level": 0.02, "layout": layout})
    drive.u[1, 2] = -3.0
    drive.step(0.0, 1.0)
    drive.step(1.0, 1.0)
    return drive


@pytest.mark.known_answers(FrictionDrive="shaft_friction")
@pytest.mark.parametrize(("layout", "part"), [("skewed", 1.0), ("skewed_free_rollers", 0.75)])
def test_motors_that_stand_hold_the_sleeve_through_contacts_that_stick(layout, part):
    """Double stick on shafts that stick: the sleeve gives as far as the contacts do, along their directions, and no further."""
    drive = standing(layout)
    assert drive["shaft_friction.first_stuck"] == drive["shaft_friction.second_stuck"] == 1.0
    assert drive["first_angle"] == drive["second_angle"] == 0.0
    assert drive["feed"] == pytest.approx(-3.0 / (part * 12.0 / 1e-4), rel=1e-9)
    drive.step(2.0, 10.0)
    assert drive["feed"] == pytest.approx(-3.0 / (part * 12.0 / 1e-4), rel=1e-12)


def test_shafts_give_way_under_free_rollers_while_plain_wheels_hold_each_other():
    """7 N: 0.0404 N.m at each wheel with free rollers, and it turns as a generator under what is above 0.02 N.m.

    Plain wheels that turn pull against each other around the sleeve, until the contacts bear what the shafts do not: by the
    balance at a shaft F / 2 cos a - Q sin a = 0.02 N.m / R, here of 10 N.
    """
    drive = standing("skewed_free_rollers")
    drive.set("external_force", -7.0)
    drive.step(2.0, 0.5)
    assert drive["shaft_friction.first_stuck"] == 0.0
    assert drive["exact_slip.first_stuck"] == 1.0
    load = 0.01 * 7.0 / (2.0 * math.cos(math.pi / 6.0))
    assert drive["first_torque"] == pytest.approx(load, rel=1e-6)
    rate = -(load - 0.02) / (TORQUE**2 / 2.3 + 19.0**2 * 1e-7)
    assert drive["first_rate"] == pytest.approx(rate, rel=1e-3)
    assert drive["feed_rate"] == pytest.approx(0.01 * rate / math.cos(math.pi / 6.0), rel=1e-3)
    plain = standing("skewed")
    plain.u[1, 2] = -7.0  # N/s: to -10 N
    plain.step(2.0, 1.0)
    plain.step(3.0, 1.0)
    around = (5.0 * math.cos(math.pi / 6.0) - 2.0) / 0.5
    assert plain["first_traction_around"] == pytest.approx(-around, rel=1e-5)
    assert plain["second_traction_around"] == pytest.approx(around, rel=1e-5)
    assert plain["exact_slip.first_stuck"] == plain["exact_slip.second_stuck"] == 1.0
    assert plain["feed_rate"] == pytest.approx(0.0, abs=1e-7)
