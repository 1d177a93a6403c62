"""What the scenes of the friction drive must show: set points reached, stick-slip, hunting, standing, what holds and slides."""

import numpy as np
import pytest
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import load_scene, read_scene
from cosimo.orchestrator.systems.friction_drive.records import drives, energies, moves, starts
from cosimo.tests.scene_runs import finished

ORDER = ["drive", "controller"]


@pytest.fixture(scope="module")
def step():
    return finished(load_scene("friction-drive-step"))


@pytest.fixture(scope="module")
def slow():
    return finished(load_scene("friction-drive-slow-feed"))


@pytest.fixture(scope="module")
def preload():
    return finished(load_scene("friction-drive-preload"))


def test_steps_in_both_axes_settle_without_overshoot_and_stand(step):
    (drive,) = drives(step)
    found = moves(drive)
    assert [(m.axis, m.begin, round(m.way, 9)) for m in found] == [
        ("feed", 0.1, 0.03), ("rotation", 0.1, 1.0), ("feed", 1.0, -0.01), ("rotation", 1.0, -1.5)]  # fmt: skip
    assert all(m.settling_time is not None and m.settling_time < 0.5 for m in found)
    assert all(m.overshoot < (1e-5 if m.axis == "feed" else 2e-3) for m in found)
    late = step.time > 1.8
    for name in ("first", "second"):
        assert not step[f"{name}_motor.rate"][late].any()
        assert step[f"{name}_motor.shaft_friction.stuck"][late].all()
        assert step[f"wheels.exact_slip.{name}_stuck"][late].all()


def test_the_drive_stays_within_the_amplifiers_limits(step):
    for name in ("first", "second"):
        assert np.abs(step[f"{name}_motor.current"]).max() <= 4.0 + 1e-9
        assert np.abs(step[f"controller.{name}_voltage"]).max() == 12.0  # of the controller, reached at both steps


def test_energy_is_passed_on_and_lost_and_not_made(step):
    found = energies(drives(step)[0])
    assert found["motors"] > found["wheels"] > found["contacts"] + found["sleeve"] > 0.0
    finer = run(step.scene.with_changes({"master.step": 0.5 * step.scene.master.step}), in_process=True)
    for name, bond in step.info.energy.items():  # extrapolated linearly: what the coupling makes falls at least with the step
        assert abs(bond.created) < 3e-3 * bond.exchanged
        assert abs(finer.info.energy[name].created) < 0.5 * abs(bond.created)
    weight = 0.15 * 9.81 * np.sin(0.5) * 0.02
    assert found["sleeve"] == pytest.approx(weight, abs=2e-3)  # and what contacts and seal hold by their deflection


@pytest.mark.full
def test_split_and_whole_agree():
    """The same course by the drive in one unit: what differs is the macro step, over which loads are extrapolated."""
    motors, sleeve = ["inductance", "shaft_friction"], ["exact_slip", "trocar_friction", "gravity", "preload_loss"]
    given = {"layout": "skewed_free_rollers", "preload_loss": {"start": 0.4, "duration": 0.1, "first": 0.5}}
    course = {"time": [0.1, 0.3], "feed": [0.0, 5e-3], "rotation": [0.0, 0.3]}
    control = {"layout": "skewed_free_rollers", "reference": course}
    changes = {f"units.{k}_motor.effects": (motors[0], "saturation", motors[1]) for k in ("first", "second")}
    changes |= {"units.wheels.effects": tuple(sleeve), "units.wheels.parameters": given, "stop_time": 0.6,
                "units.controller.effects": ("reference",), "units.controller.parameters": control}  # fmt: skip
    split = finished(load_scene("friction-drive-step").with_changes(changes))
    step = split.scene.master.step
    links = [f"drive.{k}_{what} -> controller.{k}_{what}" for k in ("first", "second") for what in ("angle", "rate")]
    links += [f"controller.{k}_voltage -> drive.{k}_voltage" for k in ("first", "second")]
    links += [f"drive.{n} -> controller.{n}" for n in ("feed", "rotation")]
    units = {"drive": {"component": "FrictionDrive", "effects": [*motors, *sleeve], "parameters": given},
             "controller": {"component": "ServoController", "effects": ["reference"], "parameters": control}}  # fmt: skip
    whole = finished(read_scene({"stop_time": 0.6, "units": units, "connections": links,
                                 "master": {"step": step, "extrapolation": 0, "order": ORDER}}, "whole"))  # fmt: skip
    # on the way rates of 0.03 m/s and 1.7 rad/s, held for a step; at rest both within the bands, where friction holds them
    moving = split.time < 0.3
    for axis, rate, band in (("feed", 0.03, 1e-4), ("rotation", 1.7, 0.01)):
        one, other = split[f"wheels.{axis}"], whole[f"drive.{axis}"]
        assert np.abs(one - other)[moving].max() < 1.5 * rate * step
        assert max(abs(course[axis][-1] - way[-1]) for way in (one, other)) < band
    one, other = drives(split)[0], drives(whole)[0]
    assert one.rests.keys() == other.rests.keys()
    assert one.level == other.level


@pytest.mark.full
def test_slow_feed_goes_by_stick_and_slip(slow):
    """The seal lets go when wheels and contacts have pulled it to its static friction, and holds again at the kinetic one."""
    for unit in ("seeking", "plain"):
        assert starts(slow[f"{unit}.trocar_friction.stuck"]) >= 4
        rate = slow[f"{unit}.feed_rate"][(slow.time > 1.5) & (slow.time < 3.2)]
        assert rate.max() > 4.0 * 5e-4  # of the wanted 0.5 mm/s
        assert rate.min() < 5e-4


@pytest.mark.full
def test_the_seeking_drive_hunts_and_the_plain_one_stands(slow):
    late = slow.time > 3.3
    assert starts(slow["seeking_first.shaft_friction.stuck"][late]) >= 3
    assert starts(slow["plain_first.shaft_friction.stuck"][late]) == 0
    assert np.ptp(slow["plain.feed"][slow.time > 4.0]) < 1e-9
    error = slow["seeking_controller.feed_error"][late]
    assert error.min() < -1e-5
    assert error.max() > 1e-5  # on both sides
    left = slow["plain_controller.feed_error"][-1]
    # loads and kinetic friction of the shafts, by the gain: no more than static friction of shafts and seal ask for
    most = (2.0 * 0.01 / 0.8 + 0.01 * 1.3 * 2.0 / (2.0 * np.cos(np.pi / 6.0)) / 0.8) * 2.3 / (23.4e-3 * 19.0)
    assert 0.0 < left < most / (0.8446 * 20.0) * 0.01 / np.cos(np.pi / 6.0)


@pytest.mark.full
def test_plain_wheels_hold_what_rollers_let_slide(preload):
    """Without the first wheel's preload rollers of the second let the sleeve go across; a plain wheel bears any direction."""
    before = (preload.time > 0.9) & (preload.time < 1.0)
    for unit in ("plain", "rollers"):
        assert np.abs(preload[f"{unit}.feed"][before] - 0.01).max() < 1e-4
    lost = 0.01 - preload["rollers.feed"][-1]
    assert lost > 5e-4
    assert abs(preload["plain.feed"][-1] - 0.01) < 2e-4
    # the way of the sleeve is across the second wheel: t . (z, r phi) stays, but for what its motor and contact give
    a = np.pi / 6.0
    along = np.cos(a) * -lost - np.sin(a) * 0.005 * preload["rollers.rotation"][-1]
    assert abs(along) < 0.15 * lost
    for unit in ("plain", "rollers"):
        assert preload[f"{unit}.first_torque"][-1] == 0.0
        assert preload[f"{unit}.margin"][-1] == 0.0
