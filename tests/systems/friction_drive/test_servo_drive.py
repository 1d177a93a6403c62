"""Servo motor and controller together: hunting, standing, reversal with stiction, counted rates, saturation, stall."""

import numpy as np
import pytest
from cosimo.components.drives.servo_motor import ServoMotor
from cosimo.components.friction_drive.controller import ServoController
from cosimo.orchestrator.judgement.verification import verified_result
from cosimo.orchestrator.systems import read_scene
from cosimo.tests.scene_runs import finished

STEP = 1e-3


TORQUE = 23.4e-3 * 19.0 / 2.3  # N.m/V at the wheel


HELD = 0.015 / TORQUE  # V that the static friction holds, 1.5 times 0.01 N.m


FRICTION = {"shaft_friction.gear_loss": 0.0}


SEEKING = {"feed_integral_gain": 400.0, "rate_integral_gain": 0.0}  # poles of the way with an imaginary part: it overshoots


NOT_SEEKING = {"feed_integral_gain": 0.0, "rate_integral_gain": 0.0}


def loop(seconds, control, motor=(), on=("shaft_friction",), counted=False, course=None):
    """A motor on the first of two orthogonal wheels under its controller: (n, 5) time, angle, rate, voltage, stuck at samples."""
    servo = ServoMotor(on, {**(FRICTION if "shaft_friction" in on else {}), **dict(motor)})
    effects = (["quantisation"] if counted else []) + (["reference"] if course else [])
    made = ServoController(effects, {"layout": "orthogonal", "feedback": "wheels", **control, **(course or {})})
    servo.initialize(0.0)
    made.initialize(0.0)
    rows = []
    for k in range(round(seconds / STEP)):
        servo.set("voltage", made["first_voltage"])
        servo.step(k * STEP, STEP)
        made.set("first_angle", servo["angle"])
        made.set("first_rate", servo["rate"])
        made.step(k * STEP, STEP)
        stuck = servo["shaft_friction.stuck"] if "shaft_friction" in on else 0.0
        rows.append(((k + 1) * STEP, servo["angle"], servo["rate"], made["first_voltage"], stuck))
    return np.array(rows), servo


@pytest.mark.full
def test_a_drive_that_seeks_under_stiction_hunts():
    """It stands on either side of its set point in turn, until the integral breaks it loose."""
    found, _ = loop(4.0, {**SEEKING, "set_feed": 2e-4})
    _, angle, _, _, stuck = found[found[:, 0] > 2.0].T
    error = 0.02 - angle
    assert 0.6 < stuck.mean() < 0.95
    left = np.flatnonzero(np.diff(stuck) < 0.0)
    assert left.size >= 3
    assert np.array_equal(np.sign(error[left]), np.sign(error[left[0]]) * (-1.0) ** np.arange(left.size))
    assert np.abs(error[left]) == pytest.approx(np.abs(error[left]).mean(), rel=0.05)  # a cycle, not a decay


@pytest.mark.full
def test_without_a_drop_of_friction_there_is_no_hunting():
    found, _ = loop(4.0, {**SEEKING, "set_feed": 2e-4}, {"shaft_friction.static_ratio": 1.0})
    left = np.flatnonzero(np.diff(found[:, 4]) < 0.0)[1:]  # the first is the start
    errors = np.abs(0.02 - found[[*left, -1], 1])
    assert errors.size >= 3
    assert (errors[1:] < 0.5 * errors[:-1]).all()


@pytest.mark.full
@pytest.mark.parametrize("target", [2e-5, 1e-3, 0.02])
def test_a_drive_that_does_not_seek_stands_within_what_friction_holds(target):
    """Any error up to the static friction over the gain is a place of rest, and there it stands to the last bit."""
    found, _ = loop(2.0, {**NOT_SEEKING, "set_feed": target})
    late = found[found[:, 0] > 1.6]
    assert np.ptp(late[:, 1]) < 1e-12  # approached without end, or reached
    assert abs(target / 0.01 - late[-1, 1]) * 0.8446 * 20.0 <= HELD * (1.0 + 1e-9)
    assert np.abs(late[:, 2]).max() < 1e-10


@pytest.mark.full
def test_the_smallest_set_point_that_moves_is_that_of_the_static_friction():
    limit = 0.01 * HELD / (0.8446 * 20.0)
    still, _ = loop(0.2, {**NOT_SEEKING, "set_feed": 0.999 * limit})
    assert not still[:, 1].any()
    moved, _ = loop(0.2, {**NOT_SEEKING, "set_feed": 1.001 * limit})
    assert moved[-1, 1] > 0.0


@pytest.mark.full
def test_counts_make_the_rates_chatter_and_nothing_else():
    """At rest after a step; a count is 0.165 rad/s, whose voltage friction holds: one sample of chatter, and it stands."""
    found, _ = loop(2.0, {"set_feed": 5e-3, "rate_integral_gain": 0.0}, counted=True)
    late = found[found[:, 0] > 1.6]
    assert late[:, 4].all()
    assert np.ptp(late[:, 1]) == 0.0
    assert np.ptp(late[:, 3]) == 0.0
    free, _ = loop(2.0, {"set_feed": 5e-3}, {"damping": 0.0}, on=(), counted=True)
    late = free[free[:, 0] > 1.0]
    assert np.abs(0.5 - late[:, 1]).max() < 3 * 1.65e-4  # without friction it wanders between counts
    assert np.abs(late[:, 3]).max() <= 0.8446 * 0.165 * 2.0  # and the voltage by what two counts are worth


@pytest.mark.full
def test_a_reversal_under_stiction_sticks_once_and_goes_on():
    """Up and down at 20 mm/s: at the turning point the shaft stands until the integral has turned friction about."""
    course = {"reference.time[2]": 0.5, "reference.feed[2]": 0.01, "reference.time[3]": 1.0}
    found, servo = loop(1.0, {}, course=course)
    turning = found[(found[:, 0] > 0.4) & (found[:, 0] < 0.7)]
    assert np.sum(np.diff(turning[:, 4]) > 0.0) <= 2
    assert found[-2, 2] == pytest.approx(-2.0, rel=0.05)
    assert servo.work["events"] < 10
    wanted = np.where(found[:, 0] < 0.5, 2.0 * found[:, 0], 2.0 * (1.0 - found[:, 0]))
    assert np.abs(wanted - found[:, 1])[found[:, 0] > 0.1].max() < 0.02  # rad, of a turning point at 1 rad


@pytest.mark.full
def test_anti_windup_keeps_a_long_way_from_overshooting():
    """A way of 20 rad, with the voltage at its limit; an integral that may wind up overshoots three times as far."""
    control = {"set_feed": 0.2, "rate_limit": 100.0, "feed_integral_gain": 50.0}
    kept, _ = loop(2.0, control, on=("saturation",))
    wound, _ = loop(2.0, {**control, "unwinding_time": 1e6}, on=("saturation",))
    overshoot, without = kept[:, 1].max() - 20.0, wound[:, 1].max() - 20.0
    assert overshoot < 0.05 * 20.0
    assert without > 3.0 * max(overshoot, 0.1)


@pytest.mark.full
def test_a_stalled_motor_stands_at_its_limit_and_starts_again():
    motor = ServoMotor(("saturation", "shaft_friction", "inductance"))
    motor.initialize(0.0)
    motor.set("voltage", 12.0)
    motor.set("load_torque", 2.0)  # more than 4 A give, 1.78 N.m less the gear's fifth; less than what drives it back
    motor.step(0.0, 0.2)
    assert motor["rate"] == 0.0
    assert motor["current"] == pytest.approx(4.0, rel=1e-9)
    motor.set("load_torque", 0.0)
    motor.step(0.2, 0.2)
    assert motor["rate"] > 20.0


def coupled(step: float, voltages, force=0.0, **motor):
    """0.2 s of two motors with windings of 0.1 ms and wheels on bristles of 60 kN/m, coupled with linear inputs."""
    names = ("first", "second")
    units = {f"{k}_motor": {"component": "ServoMotor", "effects": ["inductance"], "parameters": {"voltage": v, **motor}}
             for k, v in zip(names, voltages, strict=True)}  # fmt: skip
    units["wheels"] = {"component": "FrictionWheels", "effects": ["lugre_slip"],
                       "parameters": {"layout": "skewed_free_rollers", "external_force": force}}  # fmt: skip
    links = [f"{k}_motor.rate -> wheels.{k}_rate" for k in names]
    links += [f"wheels.{k}_torque -> {k}_motor.load_torque" for k in names]
    bonds = [f"{k}_motor.rate * wheels.{k}_torque" for k in names]
    return finished(read_scene({"stop_time": 0.2, "units": units, "connections": links,
                                "master": {"step": step, "bonds": bonds}}, "stiff"))  # fmt: skip


@pytest.mark.full
def test_geared_motors_bear_stiff_contacts_at_a_millisecond():
    """The gear makes the rotors heavy, 3.6 kg at the rim, beside the sleeve's 0.15 kg: what is stiff stays within a unit."""
    coarse, fine = coupled(1e-3, (6.0, -3.0), -4.0), coupled(2.5e-4, (6.0, -3.0), -4.0)
    for result in (coarse, fine):
        assert not result.info.warnings
        for bond in result.info.energy.values():
            assert abs(bond.created) < 2e-3 * bond.exchanged
    assert coarse["wheels.feed_rate"][-1] == pytest.approx(fine["wheels.feed_rate"][-1], rel=1e-6)


@pytest.mark.full
def test_motors_without_a_gear_need_shorter_macro_steps_and_the_run_says_so():
    """0.01 kg at the rim on 60 kN/m: 2.4 krad/s between the units, too fast for inputs that are led over 1 ms."""
    coarse, fine = coupled(1e-3, (0.3, -0.2), gear_ratio=1.0), coupled(1e-4, (0.3, -0.2), gear_ratio=1.0)
    judged = verified_result(coarse, in_process=True)
    assert judged.message.startswith("the coupling is unstable")
    assert "master.step = " in judged.message
    assert not fine.info.warnings
    for bond in fine.info.energy.values():
        assert abs(bond.created) < 1e-3 * bond.exchanged
