"""Hard cases of the heat components: no load, no heat, infinite conductances and capacities, steps of a quarter hour."""

from __future__ import annotations

import math

import numpy as np
import pytest
from cosimo.components.bearings.conductance import AngularContactConductance
from cosimo.components.bearings.temperatures import BearingTemperatures
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import read_scene

pytestmark = pytest.mark.full

SIDES = ("gas_path", "convection", "radiation")


def temperatures(effects=(), **values):
    """An initialized network."""
    made = BearingTemperatures(effects, values)
    made.initialize(0.0)
    return made


def test_without_load_only_the_side_paths_are_left():
    for effects in ((), ("ball_bulk",), ("film",), ("ball_bulk", "ring_walls", "film")):
        made = AngularContactConductance(effects)
        made.initialize(0.0)
        assert made["conductance"] == 0.0
        assert made["loaded_balls"] == 0.0
    made = AngularContactConductance(("ball_bulk", "ring_walls", "film", *SIDES))
    made.initialize(0.0)
    assert 0.0 < made["ball_conductance"] < made["conductance"] < 0.2  # the gap beside the contacts stays when they open


@pytest.mark.parametrize("effects", [(), ("film",), SIDES, ("ball_bulk", "ring_walls", "film", "lubricant_path", *SIDES)])
def test_the_conductance_is_finite_and_continuous_down_to_no_load(effects):
    """Over fifteen decades, towards the value without load; the cube root still leaves 1e-3 at 1e-9 N."""
    made = AngularContactConductance(effects)
    made.initialize(0.0)
    none = made["conductance"]
    values = []
    for force in 10.0 ** np.arange(3.0, -13.0, -1.0):
        made.set("axial_force", force)
        made.refresh()
        values.append(made["conductance"])
    values = np.array(values)
    assert np.isfinite(values).all()
    assert (np.diff(values) <= 0.0).all()
    assert values[-1] == pytest.approx(none, abs=1e-3 * values[0])


def test_balls_unload_one_after_the_other():
    made = AngularContactConductance((), {"axial_force": 500.0}, preset="7210B")
    made.initialize(0.0)
    counts, values = [], []
    for radial in np.linspace(0.0, 5e3, 60):
        made.set("radial_force", radial)
        made.refresh()
        counts.append(made["loaded_balls"])
        values.append(made["conductance"])
    assert counts[0] == 16
    assert counts[-1] <= 3
    assert (np.diff(counts) <= 0).all()
    # no jump where a ball lifts off: the largest change between neighbours is that of the steepest stretch
    assert np.abs(np.diff(values)).max() < 0.2 * values[0]


def test_a_load_that_comes_and_goes_leaves_no_trace():
    made = AngularContactConductance(("ball_bulk", "gas_path"))
    made.initialize(0.0)
    before = made.y.copy()
    for force in (3000.0, 1e-9, 50.0, 0.0):
        made.set("axial_force", force)
        made.set("radial_force", 0.5 * force)
        made.step(made.t, 0.1)
    np.testing.assert_array_equal(made.y, before)


@pytest.mark.parametrize("conductance", [0.0, 1e-12, 1e6, 1e12])
def test_conductances_without_measure(conductance):
    made = temperatures((), friction_power=20.0, conductance=conductance, substep=100.0)
    for k in range(200):
        made.step(1000.0 * k, 1000.0)
    rise = made.x[:3] - 293.15
    assert np.isfinite(rise).all()
    if conductance >= 1e6:
        # one mass: P over both ways out, equal to 20 W / 1e6 W/K in all parts
        np.testing.assert_allclose(rise, 20.0 / 1.2, rtol=0.0, atol=1e-3)
    elif conductance == 0.0:
        assert rise[0] == pytest.approx(0.25 * 20.0 / 0.2, rel=1e-6)
        assert rise[2] == pytest.approx(0.25 * 20.0 / 1.0, rel=1e-6)
        assert rise[1] == pytest.approx(10.0 * 2e5 / 15.0, rel=1e-9)  # the balls keep all that is theirs


@pytest.mark.parametrize("capacity", [1e-9, 1e-3])
def test_tiny_capacities_and_a_step_of_a_thousand_seconds(capacity):
    """Time constants of nanoseconds: every step ends in the steady state of its inputs."""
    values = {f"{part}_capacity": capacity for part in ("inner", "ball", "outer")}
    made = temperatures((), friction_power=20.0, substep=1000.0, **values)
    slow = temperatures((), friction_power=20.0, substep=10.0)
    for k in range(3):
        made.step(1000.0 * k, 1000.0)
    slow.step(0.0, 1e5)
    np.testing.assert_allclose(made.x[:3], slow.x[:3], rtol=0.0, atol=1e-3)
    balance = made["heat_supplied"] - made["heat_stored"] - made["heat_released"]
    assert abs(balance) < 1e-6 * made["heat_supplied"]  # stiffness times rounding


def test_one_tiny_mass_among_heavy_ones():
    """Balls of 1 mg between rings of a tonne."""
    made = temperatures((), friction_power=20.0, ball_capacity=5e-4, inner_capacity=5e5, outer_capacity=5e5, substep=1000.0)
    made.step(0.0, 1000.0)
    inner, ball, outer = made.x[:3]
    # 10 W through 2 G to either side
    assert ball - 0.5 * (inner + outer) == pytest.approx(10.0 / (4.0 * 0.2), rel=1e-2)


def test_steps_of_any_length_give_the_same_end():
    """Macro steps of 1000 s and of 10 s with a substep of 10 s: the same internal steps, bit-identical but for the times."""
    ends = []
    for step in (10.0, 1000.0):
        made = temperatures(("radiation", "housing"), friction_power=20.0, substep=10.0)
        for k in range(int(2000.0 / step)):
            made.step(k * step, step)
        ends.append(made.x.copy())
    np.testing.assert_allclose(ends[0], ends[1], rtol=1e-13)


def test_very_hot_and_absolute_zero():
    made = temperatures(("radiation",), friction_power=1e5, start_temperature=0.0, ambient=0.0, substep=1.0)
    for k in range(100):
        made.step(10.0 * k, 10.0)
    assert np.isfinite(made.x).all()
    assert (made.x[:3] > 0.0).all()
    assert math.isfinite(made["clearance_change"])


# -- both together -----------------------------------------------------------------------------------------------------
def coupled(step, stop, algorithm="gauss-seidel"):
    """The conductance under a constant load, its radiation at the temperatures it brings about; 40 W of friction."""
    scene = read_scene({
        "stop_time": stop,
        "connections": [
            "path.conductance -> heat.conductance",
            "heat.inner_temperature -> path.radiation.inner_temperature",
            "heat.outer_temperature -> path.radiation.outer_temperature",
        ],
        "units": {
            "path": {"component": "AngularContactConductance", "effects": ["ball_bulk", "gas_path", "radiation"],
                     "parameters": {"axial_force": 300.0, "radiation.emissivity": 1.0}},
            "heat": {"component": "BearingTemperatures", "parameters": {"friction_power": 40.0, "substep": min(step, 20.0)}},
        },
        "master": {"algorithm": algorithm, "step": step},
    })  # fmt: skip
    result = run(scene, in_process=True)
    assert result.outcome == "done", result.message
    return result


def test_conductance_and_temperatures_settle_whatever_the_step():
    """The steady state does not know the step, up to more than an hour."""
    ends = []
    for step in (20.0, 200.0, 4000.0):
        result = coupled(step, 40000.0)
        ends.append([result[f"heat.{part}_temperature"][-1] for part in ("inner", "ball", "outer")])
    np.testing.assert_allclose(ends[1:], np.array(ends[:1]).repeat(2, 0), rtol=0.0, atol=1e-2)  # K, of a rise of 40 K


def test_first_order_in_the_macro_step_without_extrapolation():
    """Held inputs: what couples is the weak radiation, so the error is small, and falls with the step."""
    fine = coupled(2.0, 800.0)["heat.inner_temperature"][-1]
    errors = [abs(coupled(step, 800.0, "jacobi")["heat.inner_temperature"][-1] - fine) for step in (100.0, 50.0)]
    assert errors[0] < 0.05  # K
    assert errors[1] < 0.7 * errors[0]
