"""Six machines, each against a truth of another packaging or another step, with noise, and with a model error that must be noticed.

Truth runs as FMUs of pythonfmu, or with half of the macro step, and never with the numbers that the model has.
"""

from __future__ import annotations

import cosimo
import numpy as np
import pytest
from cosimo.components.core.kernels import COMPILED

pytestmark = pytest.mark.skipif(not COMPILED, reason="derivatives are those of machine code")


def measured(result, noise, every, seed=0):
    """(plan of [[measured]], data) with white noise on every so many rows."""
    rng, rows = np.random.default_rng(seed), slice(every, None, every)
    time = result.time[rows]
    data = {n: (time, result[n][rows] + s * rng.standard_normal(time.size)) for n, s in noise.items()}
    return [{"signal": n, "noise": s} for n, s in noise.items()], data


def within(found, name, value, numerical=0.0):
    """Whether a true value lies within three standard deviations and the numerical error."""
    parameter = found[name]
    return abs(parameter.value - value) < 3.0 * parameter.deviation + numerical


BEARING = {"stop_time": 0.3, "bearing.clearance.radial_clearance": 6e-6}


def test_the_clearance_and_the_load_of_a_bearing_from_displacements():
    model = cosimo.load_scene("ball-bearing-clearance").with_changes(BEARING)
    true = {"bearing.clearance.radial_clearance": 5e-6, "bearing.load": 206.0, "master.step": 5e-5}
    run = cosimo.run(model.with_changes(true), in_process=True, verify="no")
    names, data = measured(run, {"bearing.displacement_x": 2e-7, "bearing.displacement_y": 2e-7}, 20)
    plan = {
        "measured": names,
        "estimated": {"bearing.clearance.radial_clearance": {"deviation": "20 %"}, "bearing.load": {"deviation": "10 %"}},
        "states": {"bearing.velocity_x": {"walk": 2e-3}, "bearing.velocity_y": {"walk": 2e-3}},
        "suspected": ["bearing.contact_stiffness", "bearing.speed"],
    }
    found = cosimo.estimate(model, plan, data=data, halved=False)
    assert found.explains
    assert within(found, "bearing.clearance.radial_clearance", 5e-6)
    assert within(found, "bearing.load", 206.0)
    assert found["bearing.clearance.radial_clearance"].deviation < 1e-7
    fast = cosimo.estimate(model.with_changes({"bearing.speed": 1.01 * 104.72}), plan, data=data, halved=False)
    assert not fast.explains  # a speed that is 1 % wrong
    assert "bearing.speed" in str(fast.verdict)


@pytest.mark.full
def test_the_inertia_of_a_gimbal_from_its_angles():
    model = cosimo.load_scene("gimbal-scan").with_changes({"stop_time": 3.0})
    true = {"body.frame_inertia": 0.022, "body.inner_inertia": 0.045}
    run = cosimo.run(model.with_changes(true), in_process=False, verify="no")
    names, data = measured(run, {"body.outer_angle": 1e-3, "body.inner_angle": 1e-3}, 10)
    plan = {
        "measured": names,
        "estimated": {"body.frame_inertia": {"deviation": "15 %"}, "body.inner_inertia": {"deviation": "15 %"}},
        "suspected": ["body.stick_friction.*", "body.gravity.mass", "*_motor.constant"],
    }
    found = cosimo.estimate(model, plan, data=data, halved=False)
    assert found.explains
    assert within(found, "body.frame_inertia", 0.022)
    assert within(found, "body.inner_inertia", 0.045)
    sticky = cosimo.estimate(model.with_changes({"body.stick_friction.outer_level": 0.08}), plan, data=data, halved=False)
    assert not sticky.explains
    level = next(s for s in sticky.verdict.suspects if s.name == "body.stick_friction.outer_level")
    assert level.at + level.change == pytest.approx(0.05, abs=3.0 * level.deviation)


@pytest.mark.full
def test_the_contact_force_of_a_pantograph_that_nobody_measures():
    model = cosimo.load_scene("lumped-catenary").with_changes({"stop_time": 2.0})
    run = cosimo.run(model.with_changes({"pantograph.static_force": 126.0, "master.step": 5e-4}), in_process=False, verify="no")
    names, data = measured(run, {"pantograph.head_velocity": 5e-3, "pantograph.frame_height": 1e-3}, 10)
    plan = {
        "measured": names,
        "estimated": {"pantograph.static_force": {"deviation": "8 N"}},
        "states": {"pantograph.head_velocity": {"walk": 0.01}, "catenary.wire_velocity": {"walk": 0.01}},
        "suspected": ["catenary.mean_stiffness", "catenary.mass", "pantograph.head_mass"],
    }
    found = cosimo.estimate(model, plan, data=data, halved=False)
    assert found.explains
    assert within(found, "pantograph.static_force", 126.0)
    force, deviation = found.series("pantograph.contact_force")
    true = np.interp(found.time, run.time, run["pantograph.contact_force"])
    late = found.time > 0.3
    assert np.mean(np.abs(force - true)[late] < 1.96 * deviation[late]) > 0.92
    assert np.sqrt(np.mean((force - true)[late] ** 2)) < 1.0  # N, of a force that moves by 14 N
    soft = cosimo.estimate(model.with_changes({"catenary.mean_stiffness": 0.95 * 2807.0}), plan, data=data, halved=False)
    assert not soft.explains  # a tension that is 5 % wrong


@pytest.mark.full
def test_the_head_of_a_wind_pump_from_speeds_and_wind():
    model = cosimo.load_scene("wind-pump-gusts").with_changes({"stop_time": 8.0})
    run = cosimo.run(model.with_changes({"pipe.static_head": 22.0}), in_process=False, verify="no")
    names, data = measured(run, {"turbine.speed": 0.05, "converter.speed": 0.05, "wind.speed": 0.2}, 20)
    plan = {
        "measured": names,
        "estimated": {"pipe.static_head": {"deviation": "20 %"}},
        "states": {"turbine.speed": {"walk": 0.02}},
        "suspected": ["converter.lever_mass", "turbine.inertia", "turbine.density"],
    }
    found = cosimo.estimate(model, plan, data=data, halved=False)
    assert found.explains
    assert within(found, "pipe.static_head", 22.0)
    light = cosimo.estimate(model.with_changes({"converter.lever_mass": 44.0}), plan, data=data, halved=False)
    assert not light.explains


@pytest.mark.full
def test_the_friction_of_a_trocar_from_feed_rotation_and_currents():
    """Joints that stick and slip, a controller that samples every second step, by the extended filter."""
    model = cosimo.load_scene("friction-drive-step").with_changes({"stop_time": 0.8, "controller.effects.quantisation": False})
    run = cosimo.run(model.with_changes({"wheels.trocar_friction.level": 2.3}), in_process=False, verify="no")
    noise = {"wheels.feed": 2e-5, "wheels.rotation": 1e-3, "first_motor.current": 0.01, "second_motor.current": 0.01}
    names, data = measured(run, noise, 20)
    plan = {
        "measured": names,
        "estimated": {"wheels.trocar_friction.level": {"deviation": "20 %"}},
        "suspected": ["*_motor.shaft_friction.level", "*_motor.constant"],
    }
    found = cosimo.estimate(model, plan, data=data, halved=False)
    assert found.explains
    assert within(found, "wheels.trocar_friction.level", 2.3)
    stiff = cosimo.estimate(model.with_changes({"first_motor.shaft_friction.level": 0.016}), plan, data=data, halved=False)
    assert not stiff.explains


ROV = {"controller.set_north": 0.5, "stop_time": 10.0}
WRENCH = ("force_z", "moment_x", "moment_y")


@pytest.mark.full
def test_the_current_and_a_lost_thruster_of_an_underwater_vehicle():
    shipped = cosimo.load_scene("rov-thruster-failed")
    fault = {**shipped.settings()["faults"][0], "begin": 8.0}
    run = cosimo.run(shipped.with_changes({**ROV, "faults": [fault], "current.speed": 0.25}), in_process=True, verify="no")
    noise = {"hull.position_north": 0.02, "hull.position_east": 0.02, "hull.depth": 5e-3, "hull.roll": 3e-3, "hull.pitch": 3e-3}
    names, data = measured(run, noise, 5)
    model = shipped.with_changes({**ROV, "faults": [], "units.hull.effects": [*shipped.units["hull"].effects, "external"]})
    plan = {
        "measured": names,
        "estimated": {"current.speed": {"deviation": 0.1}, "current.direction": {"deviation": 0.4}},
        "suspected": ["hull.mass"],
    }
    known = cosimo.estimate(model, plan, data=data, halved=False)
    assert not known.explains  # without a loss
    assert "8." in str(known.verdict) or "9." in str(known.verdict)
    walks = {"force_z": 1.0, "moment_x": 0.1, "moment_y": 0.2}
    lost = {f"hull.external.{n}": {"deviation": 0.05, "walk": w} for n, w in walks.items()}
    found = cosimo.estimate(model, plan | {"estimated": plan["estimated"] | lost}, data=data, halved=False)
    assert within(found, "current.speed", 0.25)
    assert within(found, "current.direction", 0.5)
    names = [p.name for p in found.parameters]
    k = int(np.searchsorted(found.time, 9.0))  # a second behind the loss, by what was measured until then
    moment = {n: found.learnt.q[k, names.index(f"hull.external.{n}")] for n in WRENCH}
    sigma = {n: found.learnt.q_deviations[k, names.index(f"hull.external.{n}")] for n in WRENCH}
    assert moment["moment_y"] > 3.0 * sigma["moment_y"]  # a vertical thruster, in front: pitch
    assert abs(moment["moment_x"]) < 3.0 * sigma["moment_x"]  # of which only the fourth is on the middle line: no roll
    at_end = [found.learnt.q[-1, names.index(f"hull.external.{n}")] for n in WRENCH]
    assert -at_end[2] / at_end[0] == pytest.approx(0.225, abs=0.08)  # m, its place
