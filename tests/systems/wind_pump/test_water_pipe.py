"""The pipe: heads, the column that swings on the air vessel, and a tank that fills, runs over and empties in time."""

import math

import numpy as np
import pytest
from cosimo.components.wind_pump.pipe import WaterPipe, pipe_derivatives
from cosimo.tests.support import initialized

pytestmark = pytest.mark.interpreted


def unit(effects=(), parameters=None, flow=0.0, **inputs):
    """An initialized pipe."""
    pipe = WaterPipe(effects, parameters)
    pipe.set("flow", flow)
    for name, value in inputs.items():
        pipe.set(name.replace("_", ".", 1), value)
    return initialized(pipe)


@pytest.mark.known_answers(WaterPipe="friction")
@pytest.mark.parametrize("flow", [0.0, 1e-3, -1e-3])
def test_head_is_height_and_friction(flow):
    assert unit(flow=flow)["head"] == 20.0
    assert unit(["friction"], None, flow)["head"] == pytest.approx(20.0 + 1e6 * flow * abs(flow), rel=1e-15)


@pytest.mark.full
def test_delivered_is_the_integral_of_the_flow():
    pipe = unit(flow=1e-3)
    pipe.u[1, 0], pipe.u[2, 0] = 2e-4, -1e-5
    pipe.step(0.0, 10.0)
    assert pipe["delivered"] == pytest.approx(1e-2 + 1e-2 - 1e-2 / 3.0, rel=1e-12)


@pytest.mark.known_answers(WaterPipe="air_vessel")
def test_the_column_swings_on_the_air_at_its_frequency():
    """w² = n p A / (rho L V); a small push, without friction, is back after a period, and has turned after half of it."""
    pipe = unit(["air_vessel"], {"substep": 1e-3})
    area = 0.25 * math.pi * 0.035**2
    pressure = 101325.0 + 1000.0 * 9.81 * 20.0
    omega = math.sqrt(1.2 * pressure * area / (1000.0 * 30.0 * 5e-3))
    assert pipe.stable_step() == pytest.approx(2.61 / omega, rel=1e-12)
    pipe.x[2] = 1e-7
    pipe.refresh()
    half = math.pi / omega
    pipe.step(0.0, half)
    assert pipe["outflow"] == pytest.approx(-1e-7, rel=1e-5)  # the air is a little stiffer one way than the other
    pipe.step(half, half)
    assert pipe["outflow"] == pytest.approx(1e-7, rel=1e-5)


def test_the_swinging_column_keeps_its_energy_and_friction_takes_it():
    """Column, air and water lifted: d/dt (rho L q²/(2A) + rho g H delivered + W_air) = -rho g K |q|³ without inflow."""
    for effects, loss in ((("air_vessel",), 0.0), (("friction", "air_vessel"), 1e6)):
        pipe = unit(effects)
        rng = np.random.default_rng(6)
        for _ in range(20):
            q, gas = rng.normal(scale=1e-3), 5e-3 * rng.uniform(0.7, 1.4)
            x, dx = np.array([0.0, gas, q]), np.zeros(3)
            pipe_derivatives(0.0, x, pipe.u[0], dx, *pipe.arguments)
            absolute = (101325.0 + 9810.0 * 20.0) * (5e-3 / gas) ** 1.2
            area = 0.25 * math.pi * 0.035**2
            column = 1000.0 * 30.0 / area * q * dx[2]
            air = -(absolute - 101325.0) * dx[1]  # what its expansion does against the atmosphere is not lost
            lifted = 9810.0 * 20.0 * dx[0]
            assert column + air + lifted == pytest.approx(-9810.0 * loss * abs(q) ** 3, abs=1e-12 * abs(9810.0 * 20.0 * q))


@pytest.mark.full
def test_an_air_vessel_evens_out_a_pulsating_flow():
    """Half sine waves of 1 Hz; column and air alone have a period of 4.5 s: the pulsation does not get through."""
    pipe = unit(["friction", "air_vessel"], {"air_vessel.gas_volume": 0.05})
    h, out, into = 0.01, [], []
    for k in range(12_000):
        pipe.set("flow", 1e-3 * max(math.sin(2.0 * math.pi * (k + 0.5) * h), 0.0))
        pipe.step(k * h, h)
        out.append(pipe["outflow"])
        into.append(pipe["flow"])
    last = slice(-1000, None)
    assert np.mean(out[last]) == pytest.approx(np.mean(into[last]), rel=0.02)
    assert np.ptp(out[last]) < 0.2 * np.ptp(into[last])


@pytest.mark.known_answers(WaterPipe="tank")
@pytest.mark.full
def test_a_tank_fills_runs_over_and_empties_at_the_instants_of_its_volumes():
    """2 m² from 0.5 m to 2 m at 1e-3 m³/s: full after 3000 s; then demand 5e-3 empties it in 1000 s; volumes add up."""
    pipe = unit(["tank"], {"substep": 10.0}, flow=1e-3)
    pipe.step(0.0, 3000.0 - 1e-6)
    assert pipe["tank.overflowed"] == 0.0
    pipe.step(3000.0 - 1e-6, 500.0 + 1e-6)
    assert pipe["tank.level"] == 2.0
    assert pipe["head"] == 22.0
    assert pipe["tank.overflowed"] == pytest.approx(0.5, rel=1e-9)
    pipe.set("tank.demand", 5e-3)
    pipe.step(3500.0, 999.0)
    assert pipe["tank.level"] == pytest.approx(2.0 - 999.0 * 4e-3 / 2.0, abs=1e-9)
    pipe.step(4499.0, 101.0)
    assert pipe["tank.level"] == 0.0
    assert pipe["tank.supplied"] == pytest.approx(5e-3 * 1000.0 + 1e-3 * 100.0, rel=1e-9)  # empty: only what arrives
    stored = 2.0 * (pipe["tank.level"] - 0.5)
    assert pipe["delivered"] == pytest.approx(pipe["tank.supplied"] + pipe["tank.overflowed"] + stored, abs=1e-9)
    pipe.set("tank.demand", 0.0)
    pipe.step(4600.0, 100.0)
    assert pipe["tank.level"] == pytest.approx(0.05, rel=1e-9)
    assert pipe.work["events"] == 4


def test_an_empty_tank_from_which_is_drawn_stays_empty():
    pipe = unit(["tank"], {"tank.start_level": 0.0}, tank_demand=1e-3)
    pipe.step(0.0, 10.0)
    assert (pipe["tank.level"], pipe["tank.supplied"]) == (0.0, pytest.approx(0.0, abs=1e-15))
