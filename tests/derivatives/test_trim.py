"""Steady states of the coupled step against closed forms, roots of equations by hand, and long runs; what has none is refused."""

from __future__ import annotations

import json
import math

import cosimo
import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.components.core.kernels import COMPILED
from cosimo.orchestrator.systems import read_scene
from cosimo.tests.commands import exit_code
from scipy.optimize import brentq

if COMPILED:
    from cosimo.orchestrator.derivatives.newton import newton
    from cosimo.orchestrator.derivatives.trim import trim

pytestmark = pytest.mark.skipif(not COMPILED, reason="derivatives are those of machine code")
K1 = 2.0 / math.pi * 0.05 * 20.0 * 2.0 * 0.05  # of the default inertial converter, kg m²
K2 = 2.0 / math.pi * 0.05**2 * 20.25
LOAD = 13.2435  # N.m


def wind_pump(**changes):
    """Farm windmill, averaged converter, a load that does not pulsate."""
    scene = {
        "stop_time": 1.0,
        "connections": ["turbine.speed -> converter.turbine_speed", "converter.turbine_torque -> turbine.torque"],
        "units": {
            "turbine": {"component": "WindTurbine", "parameters": {"curve": "farm", "wind": 3.0, "start_speed": 2.5}},
            "converter": {"component": "AveragedConverter", "parameters": {"load_torque": LOAD, "start_speed": 2.0}},
        },
        "master": {"step": 1e-2, "extrapolation": 1},
    }
    return read_scene(scene).with_changes(changes)


def rates(wind: float, turbine: float, pump: float) -> tuple[float, float]:
    """Of turbine and driven shaft, by hand."""
    crank = 6.0 * turbine
    drive = 0.5 * 1.225 * math.pi * 1.5**3 * wind**2 * 0.5 * (1.0 - turbine * 1.5 / wind / 2.4)
    passed = K1 * crank**2 - K2 * crank * pump
    return (drive - 6.0 * passed * pump / crank) / 15.0, passed - LOAD


def test_the_wind_pump_of_the_printed_example_over_the_wind():
    """Farm windmill of 1.5 m with a gear of 6 on the default converter: printed speeds and ratios."""
    found = trim(wind_pump(), over=("turbine.wind", (2.0, 2.5, 3.0, 6.0)))
    speeds = np.array([[s.outputs["turbine.speed"], s.outputs["converter.speed"]] for _, s in found.points])
    np.testing.assert_allclose(speeds[:, 0], [2.428, 2.466, 2.518, 3.349], atol=5e-4)
    np.testing.assert_allclose(speeds[:, 0] / speeds[:, 1], [4.228, 1.701, 0.953, 0.174], atol=5e-4)
    for (wind, state), (turbine, pump) in zip(found.points, speeds, strict=True):
        np.testing.assert_allclose(rates(wind, turbine, pump), 0.0, atol=1e-10)
        assert state.stable
        assert state.moving == {"turbine.x[1] (turbine.angle)": pytest.approx(turbine)}


def test_eigenvalues_are_those_of_the_matrix_by_hand():
    """Of the equations at the point, within what the coupling's step adds."""
    with cosimo.open(wind_pump(**{"master.step": 1e-3})) as session:
        state = session.trim()
    turbine, pump = state.outputs["turbine.speed"], state.outputs["converter.speed"]
    slope = -0.5 * 1.225 * math.pi * 1.5**4 * 3.0 * 0.5 / 2.4
    matrix = [
        [(slope - 36.0 * K1 * pump) / 15.0, -6.0 * (6.0 * K1 * turbine - 2.0 * K2 * pump) / 15.0],
        [72.0 * K1 * turbine - 6.0 * K2 * pump, -6.0 * K2 * turbine],
    ]
    expected = max(np.linalg.eigvals(matrix), key=lambda value: value.imag)
    (rate,) = (mode.rate for mode in state.linear.modes() if mode.kind == "coupling")
    assert abs(rate - expected) < 1e-5 * abs(expected)


@pytest.mark.parametrize(("step", "extrapolation"), [(1e-2, 1), (2e-2, 0), (1e-3, 2)])
def test_the_wind_at_which_the_pump_turns_as_wanted(step, extrapolation):
    """A root of the equations by hand, whatever the coupling."""
    wanted = 3.0
    turbine = (K2 * wanted + math.sqrt((K2 * wanted) ** 2 + 4.0 * K1 * LOAD)) / (2.0 * K1) / 6.0
    wind = brentq(lambda w: rates(w, turbine, wanted)[0], 2.0, 6.0, xtol=1e-13)
    with cosimo.open(wind_pump(**{"master.step": step, "master.extrapolation": extrapolation})) as session:
        session.initialize()
        session.step(3)
        before = session.values(["turbine.speed"])
        state = session.trim(["turbine.wind"], {"converter.speed": "3 rad/s"})
        assert session.values(["turbine.speed"]) == before
    assert state.free["turbine.wind"] == pytest.approx(wind, rel=1e-10)
    assert state.outputs["turbine.speed"] == pytest.approx(turbine, rel=1e-10)
    assert state.outputs["converter.speed"] == pytest.approx(wanted, rel=1e-10)


def hull(**parameters):
    given = {"restoring": {"weight": 112.8, "buoyancy": 112.8}, **parameters}
    effects = ["added_mass", "coriolis", "linear_drag", "quadratic_drag", "restoring", "current"]
    return read_scene({
        "stop_time": 1.0,
        "units": {"hull": {"component": "RovHull", "effects": effects, "parameters": given}},
        "master": {"step": 0.02},
    })  # fmt: skip


def test_a_neutral_vehicle_needs_the_thrust_of_its_drag(monkeypatch):
    """Ahead at 0.5 m/s with the thrusters at 60 deg to starboard and port: 2 T cos 30° = d u + D u². Nothing holds its heading."""
    solutions = []

    def recorded(*given):
        solutions.append(newton(*given))
        return solutions[-1]

    monkeypatch.setattr("cosimo.orchestrator.derivatives.trim.newton", recorded)
    want = {"hull.surge": "0.5 m/s", "hull.sway": 0.0, "hull.yaw_rate": 0.0}
    with cosimo.open(hull()) as session:
        state = session.trim([f"hull.thrust[{k}]" for k in (1, 2, 3)], want, moving=["hull.position_north", "hull.depth"])
    assert all(one.converged and one.steps < 10 for one in solutions)
    thrust = (4.03 * 0.5 + 18.18 * 0.25) / (2.0 * math.cos(math.pi / 6.0))
    found = [state.free[f"hull.thrust[{k}]"] for k in (1, 2, 3)]
    np.testing.assert_allclose(np.abs(found), [0.0, thrust, thrust], rtol=1e-9, atol=1e-10)
    pitch = state.outputs["hull.pitch"]
    speeds = {name.rpartition(".")[2]: rate for name, rate in state.moving.items()}
    assert speeds == {"position_north)": pytest.approx(0.5 * math.cos(pitch)), "depth)": pytest.approx(-0.5 * math.sin(pitch))}


def test_a_vehicle_without_thrust_goes_with_the_current_and_a_position_that_moves_is_named():
    with cosimo.open(hull()) as session:
        session["hull.current.velocity_north"] = 0.3
        with pytest.raises(BadInput, match=r"hull\.x\[0\] \(hull\.position_north\) by 0\.3 per s moves on"):
            session.trim()
        state = session.trim(moving=["hull.position_north"])
    assert state.outputs["hull.surge"] == pytest.approx(0.3, rel=1e-9)


def test_a_rotor_hangs_in_its_support_by_its_weight():
    """m g / k, while its angle turns; unbalance is a forcing, which has orbits and no steady state."""
    rotor = {"component": "JeffcottRotor", "effects": ["gravity"]}
    scene = read_scene({"stop_time": 1.0, "units": {"rotor": rotor}, "master": {"step": 1e-3}})
    with cosimo.open(scene) as session:
        mass, stiffness = session["rotor.mass"], session["rotor.stiffness"]
        state = session.trim()
    assert state.outputs["rotor.displacement_y"] == pytest.approx(-9.81 * mass / stiffness, rel=1e-10)
    assert state.stable
    with pytest.raises(BadInput, match="cosimo orbit"):
        trim(scene.with_changes({"rotor.effects.unbalance": True}))


@pytest.mark.parametrize(("start", "stable"), [(0.3, True), (3.0, False)])
def test_a_pendulum_hangs_stably_and_stands_unstably(start, stable):
    """From near either state; damped, with the eigenvalues of two rods by hand."""
    changes = {"chain.start_first_angle": start, "chain.start_second_angle": start}
    with cosimo.open(cosimo.load_scene("double-pendulum").with_changes(changes)) as session:
        state = session.trim()
    assert state.outputs["chain.first_angle"] == pytest.approx(0.0 if stable else math.pi, abs=1e-9)
    assert state.stable == stable
    masses, weights = np.array([[4.0 / 3.0, 0.5], [0.5, 1.0 / 3.0]]), 9.81 * np.diag([1.5, 0.5])
    roots = np.sort(np.sqrt(np.linalg.eigvals(np.linalg.solve(masses, weights))))
    found = [mode.rate.imag if stable else mode.rate.real for mode in state.linear.modes()]
    assert sorted(value for value in found if value > 0.0) == pytest.approx(roots, rel=1e-7)


@pytest.mark.full
def test_a_vehicle_on_station_is_where_a_long_run_ends():
    """Samples of a controller, six thrusters and a current: no number of Newton's is of the run."""
    scene = cosimo.load_scene("rov-station-keeping").with_changes({"current.effects.gust": False, "stop_time": 400.0})
    with cosimo.open(scene) as session:
        session.initialize()
        session.until(30.0)
        names = [f"thruster_{k}.thrust" for k in range(1, 7)] + ["hull.depth", "hull.yaw"]
        state = session.trim()
        session.until(400.0)
        np.testing.assert_allclose([state.outputs[n] for n in names], session.values(names), rtol=1e-6, atol=1e-7)
    assert state.stable


def test_what_has_no_steady_state_is_refused_with_the_reason():
    with pytest.raises(BadInput, match=r"cage_angle\) still changes by .* cosimo orbit finds"):
        trim(cosimo.load_scene("ball-bearing-clearance"))
    with pytest.raises(BadInput, match="depends on time"):
        trim(cosimo.load_scene("lumped-catenary"))
    with pytest.raises(BadInput, match=r"turbine.power_coefficient = 0\.\d* instead of 0.9"):
        trim(wind_pump(), ["turbine.start_speed"], {"turbine.power_coefficient": 0.9})
    with pytest.raises(BadInput, match="one wanted output for each"):
        trim(wind_pump(), ["turbine.wind"])
    with pytest.raises(BadInput, match=r"Did you mean 'converter\.speed'"):
        trim(wind_pump(), ["turbine.wind"], {"converter.sped": 3.0})
    with pytest.raises(BadInput, match="rad/s"):
        trim(wind_pump(), ["turbine.wind"], {"converter.speed": "3 m"})


def test_newton_has_no_unit_of_measure_and_tells_where_there_is_no_root():
    """x = 1e-7 and y = 1e5 from far away; x² = -1 has none."""

    def both(x):
        return np.array([(1e7 * x[0]) ** 3 - 1.0, x[1] * 1e-5 - 1.0]), np.diag([3e7 * (1e7 * x[0]) ** 2, 1e-5])

    found = newton(both, np.array([3e-7, 1e3]))
    assert found.converged
    assert found.x == pytest.approx([1e-7, 1e5], rel=1e-12)
    assert not newton(lambda x: (x**2 + 1.0, np.diag(2.0 * x)), np.array([2.0])).converged


def test_the_command_writes_a_table_matrices_and_a_page(tmp_path, capsys):
    path = tmp_path / "pump.toml"
    cosimo.write_scene(wind_pump(), path)
    options = ("--free", "turbine.wind", "--want", "converter.speed=3", "--inputs", "converter.load_torque")
    assert exit_code("trim", path, *options, "-o", tmp_path / "one", "--json") == 0
    (point,) = json.loads(capsys.readouterr().out)["points"]
    assert point["free"]["turbine.wind"] == pytest.approx(3.127600699)
    assert {f.name for f in (tmp_path / "one").iterdir()} == {"trim.csv", "linear.npz", "linear.mat", "report.html"}
    assert "Nyquist plot" in (tmp_path / "one" / "report.html").read_text()
    exit_code("trim", path, "--over", "turbine.wind=2:6:3", "-o", tmp_path / "over")
    rows = (tmp_path / "over" / "trim.csv").read_text().splitlines()
    assert [row.partition(",")[0] for row in rows[1:]] == ["2.0", "4.0", "6.0"]
