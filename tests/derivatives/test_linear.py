"""A scene as a linear system: modes against matrices written down by hand, responses against runs in time."""

from __future__ import annotations

import csv
import json

import cosimo
import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.components.core.kernels import COMPILED
from cosimo.orchestrator.derivatives.linear import Linear
from cosimo.orchestrator.harness.report.studies.modes import nyquist
from cosimo.orchestrator.harness.studies.modes import modes
from cosimo.orchestrator.systems import read_scene
from cosimo.tests.commands import exit_code
from cosimo.tests.derivatives.test_coupled_step import by_hand, on_spring
from scipy.io import loadmat
from scipy.linalg import expm

pytestmark = pytest.mark.skipif(not COMPILED, reason="derivatives are those of machine code")
OUTPUTS = ["mass.base_x", "mass.base_velocity_x", "spring.second_force_x"]
INPUT = "spring.first_x"


def linear_of(scene, at=0.1, **given):
    with cosimo.open(scene) as session:
        session.initialize()
        session.until(at)
        return session.linearize(**given)


def nearest_rate(linear, rate):
    return min((mode.rate for mode in linear.modes()), key=lambda r: abs(r - rate))


@pytest.mark.parametrize("degree", [0, 1, 2])
def test_the_eigenvalues_of_a_mass_on_a_spring_are_those_of_the_matrix_by_hand(degree):
    h = 0.02
    linear = linear_of(on_spring(**{"master.extrapolation": degree, "master.step": h}), outputs=OUTPUTS).reduced()
    assert linear.A.size == 0  # no input reaches anything
    linear = linear_of(on_spring(**{"master.extrapolation": degree, "master.step": h}), inputs=[INPUT], outputs=OUTPUTS).reduced()
    hand = [x for x in np.linalg.eigvals(by_hand(degree, h)) if abs(x) > 1e-4]
    found = [x for x in np.linalg.eigvals(linear.A) if abs(x) > 1e-4]
    np.testing.assert_allclose(np.sort_complex(found), np.sort_complex(hand), rtol=0, atol=1e-11)


@pytest.mark.parametrize(("degree", "order"), [(0, 1), (1, 2), (2, 3)])
def test_modes_come_near_to_the_motion_with_the_order_of_the_coupling(degree, order):
    exact = -3.0 + 1j * np.sqrt(91.0)
    errors = []
    for h in (4e-3, 2e-3):
        linear = linear_of(on_spring(**{"master.extrapolation": degree, "master.step": h}), outputs=OUTPUTS)
        mode = next(m for m in linear.modes() if m.kind == "coupling")
        assert mode.damping == pytest.approx(0.3, abs=0.02)
        errors.append(abs(mode.rate - exact))
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.1)


def test_modes_of_an_upright_double_pendulum_are_those_of_two_rods_by_hand():
    """M a'' = g K a of the angles from the upward vertical, rods of 1 kg and 1 m."""
    with cosimo.open("double-pendulum") as session:
        session["chain.start_first_angle"] = session["chain.start_second_angle"] = "180 deg"
        session.initialize()
        upright = session.linearize(inputs=["chain.first_torque"])
    masses, weights = np.array([[4.0 / 3.0, 0.5], [0.5, 1.0 / 3.0]]), 9.81 * np.diag([1.5, 0.5])
    squares = np.linalg.eigvals(np.linalg.solve(masses, weights))
    expected = np.sort(np.concatenate([np.sqrt(squares), -np.sqrt(squares)]))
    assert np.sort([mode.rate.real for mode in upright.modes()]) == pytest.approx(expected, rel=1e-8)


def gimbal(step: float) -> dict:
    """A body in gimbals that hangs at rest, with a torque motor on each axis."""
    motor = {"component": "TorqueMotor", "effects": ["inductance"], "parameters": {"inductance": {"inductance": 1e-2}}}
    start = {"start_inner_angle": 0.0, "start_outer_angle": 0.0, "axis_orientation": "horizontal", "substep": step}
    return {
        "stop_time": 1.0,
        "connections": [
            "body.outer_rate -> outer.rate",
            "body.inner_rate -> inner.rate",
            "outer.torque -> body.outer_torque",
            "inner.torque -> body.inner_torque",
        ],
        "units": {
            "body": {"component": "GimbalBody", "effects": ["gravity", "viscous"], "parameters": start},
            "outer": motor,
            "inner": motor,
        },
        "master": {"step": step, "extrapolation": 2},
    }


def test_modes_of_a_gimbal_with_motors_are_those_of_matrices_by_hand():
    """Of each axis angle, rate and current: I w' = -2 g l a - c w + k i, L i' = -R i - k w. The motors feel the axes at rest."""
    linear = linear_of(read_scene(gimbal(5e-4)), at=0.0)
    assert linear.remarks == ()
    for inertia in (0.05, 0.05):
        matrix = [[0.0, 1.0, 0.0], [-2.0 * 9.81 * 0.15 / inertia, -0.02 / inertia, 0.1 / inertia], [0.0, -10.0, -200.0]]
        for rate in np.linalg.eigvals(matrix):
            if rate.imag >= 0.0:
                assert abs(nearest_rate(linear, rate) - rate) < 3e-7 * abs(rate)
    shares = [mode.shares for mode in linear.modes() if mode.kind == "coupling"]
    assert shares[0]["body"] > 0.99


@pytest.mark.full
@pytest.mark.parametrize(("rpm", "substep"), [(1000, 5e-4), (4000, 5e-4), (4000, 1e-4)])
def test_whirls_of_a_rotor_are_those_of_the_book_whatever_the_step(rpm, substep):
    """Friswell et al., example 5.9.1, from matrices (the case's table): the midpoint rule's shift is taken back."""
    given = {"start_speed": rpm * np.pi / 30.0, "substep": substep, "start_fall": 0.0}
    rotor = {"component": "BeamRotor", "effects": ["gyroscopic", "disks", "linear_supports"], "parameters": given}
    scene = read_scene({"stop_time": 1.0, "units": {"rotor": rotor}, "master": {"step": 5e-4}})
    table = {
        1000: (86.35403, 86.95403, 268.86181, 279.62769, 687.11815, 746.02959),
        4000: (85.38947, 87.79586, 251.7846, 294.71333, 600.17936, 827.07536),
    }[rpm]
    found = sorted(mode.rate.imag for mode in linear_of(scene, at=2e-3).modes() if mode.rate.imag > 1.0)[:6]
    np.testing.assert_allclose(found, table, rtol=1e-7)


@pytest.mark.parametrize(
    "changes",
    [
        {"master.extrapolation": 0},
        {"master.extrapolation": 0, "master.algorithm": "jacobi"},
        {"master.extrapolation": 0, "master.algorithm": "jacobi", "master.feedthrough": "delayed"},
    ],
)
def test_the_matrices_give_what_a_session_does_under_any_input(changes):
    """The scene is linear, so deviations may be large. Its input acts on the force within the instant, and so on the next step."""
    rng = np.random.default_rng(2)
    with cosimo.open(on_spring(**changes)) as session:
        session.initialize()
        session.step(5)
        linear = session.linearize(inputs=[INPUT], outputs=OUTPUTS)
        still = session.save()
        free = [session.values(OUTPUTS)]
        for _ in range(30):
            session.step()
            free.append(session.values(OUTPUTS))
        session.restore(still)
        x = np.zeros(len(linear.states))
        for base in free:
            u = rng.standard_normal(1)
            session[INPUT] = float(u[0])
            np.testing.assert_allclose(session.values(OUTPUTS) - base, linear.C @ x + linear.D @ u, rtol=1e-9, atol=1e-9)
            x = linear.A @ x + linear.B @ u
            session.step()


@pytest.mark.parametrize("degree", [0, 1])
def test_the_frequency_response_is_that_of_a_run_under_a_sine(degree):
    """A force on the tip acts within no instant, so that extrapolation goes on as without it. It is small, for it turns the body."""
    name, size = (INPUT, 1.0) if degree == 0 else ("mass.tip_force_x", 1e-3)
    scene = on_spring(**{"master.extrapolation": degree, "stop_time": 30.0, "mass.start_velocity_x": 0.0})
    period = 100
    with cosimo.open(scene) as session:
        session.initialize()
        session.step(4)
        linear = session.linearize(inputs=[name], outputs=OUTPUTS)
        frequency, rows = 1.0 / (period * linear.step), []
        for k in range(15 * period):
            session[name] = size * float(np.cos(2.0 * np.pi * k / period))
            rows.append(session.values(OUTPUTS))
            session.step()
    turns = np.exp(-2j * np.pi * np.arange(period) / period)
    measured = 2.0 / (period * size) * turns @ np.array(rows[-period:])
    expected = linear.response(frequency)[0, :, 0]
    assert np.abs(measured).min() > 1e-3
    np.testing.assert_allclose(measured, expected, rtol=1e-7)


def test_a_session_goes_on_as_without_it():
    scene = on_spring()
    values = []
    for asks in (True, False):
        with cosimo.open(scene) as session:
            session.initialize()
            session.step(3)
            if asks:
                session.linearize()
            session.step(3)
            values.append(session.values(OUTPUTS))
    np.testing.assert_array_equal(*values)


def test_matrices_are_written_for_numpy_and_matlab_and_handed_to_control(tmp_path):
    linear = linear_of(on_spring(), inputs=[INPUT], outputs=OUTPUTS).reduced()
    with np.load(linear.save(tmp_path / "linear.npz")) as file:
        np.testing.assert_array_equal(file["A"], linear.A)
        assert list(file["states"]) == list(linear.states)
    matlab = loadmat(linear.save(tmp_path / "linear.mat"))
    np.testing.assert_array_equal(matlab["B"], linear.B)
    assert [cell[0] for cell in matlab["outputs"].ravel()] == OUTPUTS
    with pytest.raises(BadInput, match=r"\.npz or \.mat"):
        linear.save(tmp_path / "linear.csv")
    pytest.importorskip("control")
    system = linear.to_control()
    given = system(np.exp(2j * np.pi * 1.5 * linear.step))
    np.testing.assert_allclose(given[:, 0], linear.response(1.5)[0, :, 0], rtol=1e-9)
    assert system.dt == linear.step


@pytest.mark.parametrize(
    ("changes", "given", "words"),
    [
        ({}, {"inputs": ["mass.base_force_x"]}, "a free input"),
        ({}, {"outputs": ["mass.base_xx"]}, "mass.base_x"),
        ({"master.algorithm": "iterative"}, {}, "iterative"),
        ({}, {"steps": 0}, "1 at least"),
        ({"units.mass.every": 3}, {"steps": 4}, r"a multiple of the 3 of mass\.every"),
        ({}, {"inputs": [INPUT, INPUT]}, "more than once"),
        ({}, {"outputs": [*OUTPUTS, OUTPUTS[0]]}, "more than once"),
    ],
)
def test_what_is_no_linear_system_is_refused_by_name(changes, given, words):
    with pytest.raises(BadInput, match=words):
        linear_of(on_spring(**changes), **given)


def test_a_session_of_fmus_is_refused():
    with cosimo.open(on_spring(), in_process=False) as session:
        session.initialize()
        with pytest.raises(BadInput, match="opened as an FMU"):
            session.linearize()


def test_frequencies_beyond_the_samples_are_refused():
    with pytest.raises(BadInput, match="half of one in a step"):
        linear_of(on_spring(), inputs=[INPUT]).response([1e3])


def test_the_response_at_rest_is_that_of_the_spring_alone():
    """The mass follows the other end of the spring; that the mass may turn and move sideways does not matter."""
    linear = linear_of(on_spring(), inputs=[INPUT], outputs=["mass.base_x"])
    assert linear.response([0.0]) == pytest.approx(np.ones((1, 1, 1)), rel=1e-9)
    assert linear.response([]).shape == (0, 1, 1)


def test_a_frequency_at_a_pole_is_refused():
    """A sum of its input has one at 0 Hz."""
    one, none = np.ones((1, 1)), np.zeros((1, 1))
    total = Linear(one, one, one, none, 0.01, 0.0, ("x",), ("sum",), ("u",), ("y",), none[0], none[0], {})
    with pytest.raises(BadInput, match="no pole"):
        total.response([1.0, 0.0])


def test_steps_that_periods_fit_into_are_taken():
    assert linear_of(on_spring(**{"units.mass.every": 3}), steps=6).step == pytest.approx(6 * on_spring().master.step)


def test_a_value_that_the_scene_refuses_is_noted():
    found = modes(on_spring(), over=("mass.mass", [1.0, -1.0]))
    assert [value for value, _ in found.points] == [1.0]
    assert [value for value, _ in found.refused] == [-1.0]


@pytest.mark.full
def test_a_drive_that_sticks_is_refused_and_in_motion_has_modes():
    with cosimo.open("friction-drive-step") as session:
        session.initialize()
        with pytest.raises(BadInput, match="a joint sticks"):
            session.linearize()
        session.until(0.13)
        frequencies = [mode.frequency for mode in session.linearize().modes() if mode.kind == "coupling"]
    for expected in (98.58, 114.66):  # against differences of the map over a period of the controller
        assert min(abs(f - expected) for f in frequencies) < 0.01


def test_the_command_writes_tables_matrices_and_a_page(tmp_path, capsys):
    assert exit_code("modes", "mass-on-spring", "--at", "0.1", "--inputs", INPUT, "-o", tmp_path / "one", "--json") == 0
    rows = json.loads(capsys.readouterr().out)["modes"]
    assert [row["frequency, Hz"] for row in rows if row["kind"] == "coupling"] == [pytest.approx(1.56, abs=0.01)]
    assert {f.name for f in (tmp_path / "one").iterdir()} == {"modes.csv", "linear.npz", "linear.mat", "report.html"}
    assert f"By {INPUT}" in (tmp_path / "one" / "report.html").read_text()
    exit_code("modes", "mass-on-spring", "--over", "spring.stiffness=100,400", "-o", tmp_path / "over")
    table = list(csv.reader((tmp_path / "over" / "modes.csv").read_text().splitlines()))
    for stiffness, row in zip((100.0, 400.0), (row for row in table[1:] if row[4] == "coupling"), strict=True):
        eigenvalues = np.linalg.eigvals(by_hand(1, 5e-3, k=stiffness, c=4.0))
        exact = np.log(eigenvalues[np.argmax(eigenvalues.imag)]) / 5e-3
        assert [float(cell) for cell in row[:3]] == pytest.approx([stiffness, exact.real, exact.imag / (2.0 * np.pi)], rel=1e-9)


def held(A: np.ndarray, B: np.ndarray, C: np.ndarray, h: float, frequencies: np.ndarray) -> np.ndarray:
    """Responses of x' = A x + B u, y = C x to inputs that are held over h, by the matrix exponential."""
    n, m = B.shape
    exact = expm(np.block([[A, B], [np.zeros((m, n + m))]]) * h)
    z = np.exp(2j * np.pi * frequencies * h)
    return np.array([C @ np.linalg.solve(one * np.eye(n) - exact[:n, :n], exact[:n, n:]) for one in z])


def test_a_servo_motor_is_the_matrices_of_winding_and_shaft():
    """Angle, rate, current by voltage and load: L i' = V - R i - k N w, J w' = N k i - N² b w - load."""
    motor = {"component": "ServoMotor", "effects": ["inductance"], "parameters": {"substep": 1e-5}}
    scene = read_scene({"stop_time": 1.0, "units": {"motor": motor}, "master": {"step": 1e-3}})
    outputs = ["motor.angle", "motor.rate", "motor.current"]
    linear = linear_of(scene, at=0.0, inputs=["motor.voltage", "motor.load_torque"], outputs=outputs)
    R, L, k, N, J, b = 2.3, 0.238e-3, 23.4e-3, 19.0, 19.0**2 * 1e-6 + 1e-6, 1e-7
    A = np.array([[0.0, 1.0, 0.0], [0.0, -(N**2) * b / J, N * k / J], [0.0, -k * N / L, -R / L]])
    B = np.array([[0.0, 0.0], [0.0, -1.0 / J], [1.0 / L, 0.0]])
    f = np.array([1.0, 20.0, 200.0, 450.0])
    np.testing.assert_allclose(linear.response(f), held(A, B, np.eye(3), 1e-3, f), rtol=1e-6)
    assert max(mode.rate.real for mode in linear.modes() if mode.rate) == pytest.approx(np.linalg.eigvals(A)[1:].max(), rel=1e-6)


def test_a_vehicle_that_hovers_is_the_matrices_of_mass_drag_and_righting_moment():
    """M v' = -D v - K a + T F about rest, weight and buoyancy 112.8 N, centre of gravity 2 cm below the origin."""
    effects = ["added_mass", "coriolis", "linear_drag", "quadratic_drag", "restoring"]
    given = {"restoring": {"weight": 112.8, "buoyancy": 112.8}}
    units = {"hull": {"component": "RovHull", "effects": effects, "parameters": given}}
    scene = read_scene({"stop_time": 1.0, "units": units, "master": {"step": 0.02}})
    outputs = [f"hull.{name}" for name in ("surge", "sway", "heave", "roll_rate", "pitch_rate", "yaw_rate")]
    linear = linear_of(scene, at=0.0, inputs=["hull.thrust[2]", "hull.thrust[5]"], outputs=outputs)
    with cosimo.open(scene) as session:
        rigid = [session[f"hull.{n}"] for n in ("mass", "inertia_x", "inertia_y", "inertia_z", "centre_of_gravity_z")]
        axes = ("surge", "sway", "heave", "roll", "pitch", "yaw")
        added = np.diag([session[f"hull.added_mass.{a}"] for a in axes])
        drag = np.diag([session[f"hull.linear_drag.{a}"] for a in axes])
        places = np.array([session[f"hull.thruster_{a}"] for a in "xyz"]).T[[1, 4]]
        ways = np.array([session[f"hull.thruster_direction_{a}"] for a in "xyz"]).T[[1, 4]]
    m, ix, iy, iz, z = rigid
    masses = np.diag([m, m, m, ix, iy, iz]) + added
    masses[0, 4] = masses[4, 0] = m * z
    masses[1, 3] = masses[3, 1] = -m * z
    righting = np.diag([0.0, 0.0, 0.0, 112.8 * z, 112.8 * z, 0.0])
    wrench = np.hstack([ways, np.cross(places, ways)]).T
    A = np.block([[np.zeros((6, 6)), np.eye(6)], [-np.linalg.solve(masses, righting), -np.linalg.solve(masses, drag)]])
    B = np.vstack([np.zeros((6, 2)), np.linalg.solve(masses, wrench)])
    f = np.array([0.02, 0.3, 2.0, 20.0])
    C = np.hstack([np.zeros((6, 6)), np.eye(6)])
    np.testing.assert_allclose(linear.response(f), held(A, B, C, 0.02, f), rtol=1e-6, atol=1e-9)
    swings = sorted(value for value in np.linalg.eigvals(A).imag if value > 1e-6)
    assert sorted(mode.rate.imag for mode in linear.modes() if mode.rate.imag > 1e-6) == pytest.approx(swings, rel=1e-6)


def test_a_nyquist_plot_of_a_lightly_damped_mass_closes_its_circle():
    """Of the velocity by a force: 1 / c across. Points about the resonance are as near as its width asks."""
    mass = on_spring(**{"spring.damping": 0.5, "master.extrapolation": 1})
    figure = nyquist(linear_of(mass, inputs=[INPUT], outputs=["mass.base_velocity_x"]), INPUT).figure
    x, y = (np.array(figure["data"][0][axis], dtype=float) for axis in ("x", "y"))
    assert np.hypot(np.diff(x), np.diff(y)).max() < 0.12 * np.hypot(x, y).max()
