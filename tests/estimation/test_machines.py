"""Six machines, each against a truth of another model or another packaging, with noise, and with a model error that must be noticed.

Truth is the solution of equations that share no code with the model, or runs as FMUs of pythonfmu, and never with the numbers that the
model has: see `machines`.
"""

from __future__ import annotations

import numpy as np
import pytest
from cosimo.components.core.kernels import COMPILED
from cosimo.tests.estimation.machines import BEARING, CATENARY, CLEARANCE, FORCE, GIMBAL, LOAD, LOST, TROCAR, VEHICLE, WIND_PUMP

pytestmark = pytest.mark.skipif(not COMPILED, reason="derivatives are those of machine code")


def within(found, name, value, numerical=0.0):
    """Whether a true value lies within three standard deviations and the numerical error."""
    parameter = found[name]
    return abs(parameter.value - value) < 3.0 * parameter.deviation + numerical


def test_the_clearance_and_the_load_of_a_bearing_from_displacements():
    data = BEARING.measured(BEARING.truth({CLEARANCE: 5e-6, LOAD: 206.0}))
    found = BEARING.estimate(data)
    assert found.explains
    assert within(found, CLEARANCE, 5e-6)
    assert within(found, LOAD, 206.0)
    assert found[CLEARANCE].deviation < 1e-7
    fast = BEARING.estimate(data, BEARING.model(**BEARING.wrong))
    assert not fast.explains  # a speed that is 1 % wrong
    assert "bearing.speed" in str(fast.verdict)


@pytest.mark.full
def test_the_inertia_of_a_gimbal_from_its_angles():
    data = GIMBAL.measured(GIMBAL.truth({"body.frame_inertia": 0.022, "body.inner_inertia": 0.045}))
    found = GIMBAL.estimate(data)
    assert found.explains
    assert within(found, "body.frame_inertia", 0.022)
    assert within(found, "body.inner_inertia", 0.045)
    sticky = GIMBAL.estimate(data, GIMBAL.model(**GIMBAL.wrong))
    assert not sticky.explains
    level = next(s for s in sticky.verdict.suspects if s.name == "body.stick_friction.outer_level")
    assert level.at + level.change == pytest.approx(0.05, abs=3.0 * level.deviation)


@pytest.mark.full
def test_the_contact_force_of_a_pantograph_that_nobody_measures():
    run = CATENARY.truth({FORCE: 126.0})
    data = CATENARY.measured(run)
    found = CATENARY.estimate(data)
    assert found.explains
    assert within(found, FORCE, 126.0)
    force, deviation = found.series("pantograph.contact_force")
    true = np.interp(found.time, run.time, run["pantograph.contact_force"])
    late = found.time > 0.3
    assert np.mean(np.abs(force - true)[late] < 1.96 * deviation[late]) > 0.92
    assert np.sqrt(np.mean((force - true)[late] ** 2)) < 1.0  # N, of a force that moves by 14 N
    soft = CATENARY.estimate(data, CATENARY.model(**CATENARY.wrong))
    assert not soft.explains  # a tension that is 5 % wrong


@pytest.mark.full
def test_the_head_of_a_wind_pump_from_speeds_and_wind():
    data = WIND_PUMP.measured(WIND_PUMP.truth({"pipe.static_head": 22.0}))
    found = WIND_PUMP.estimate(data)
    assert found.explains
    assert within(found, "pipe.static_head", 22.0)
    light = WIND_PUMP.estimate(data, WIND_PUMP.model(**WIND_PUMP.wrong))
    assert not light.explains


@pytest.mark.full
def test_the_friction_of_a_trocar_from_feed_rotation_and_currents():
    """Joints that stick and slip, a controller that samples every second step, by the extended filter."""
    data = TROCAR.measured(TROCAR.truth({"wheels.trocar_friction.level": 2.3}))
    found = TROCAR.estimate(data)
    assert found.explains
    assert within(found, "wheels.trocar_friction.level", 2.3)
    stiff = TROCAR.estimate(data, TROCAR.model(**TROCAR.wrong))
    assert not stiff.explains


WRENCH = ("force_z", "moment_x", "moment_y")


@pytest.mark.full
def test_the_current_and_a_lost_thruster_of_an_underwater_vehicle():
    data = VEHICLE.measured(LOST.truth({"current.speed": 0.25}))
    known = VEHICLE.estimate(data)
    assert not known.explains  # without a loss
    assert "8." in str(known.verdict) or "9." in str(known.verdict)
    walks = {"force_z": 1.0, "moment_x": 0.1, "moment_y": 0.2}
    lost = {f"hull.external.{n}": {"deviation": 0.05, "walk": w} for n, w in walks.items()}
    model = VEHICLE.model()
    model = model.with_changes({"units.hull.effects": [*model.units["hull"].effects, "external"]})
    found = VEHICLE.estimate(data, model, estimated={**VEHICLE.unknown, **lost})
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
