"""Joint forces of the inertial converter: Lagrange multipliers, balances of each part, and stresses at stall."""

import math

import numpy as np
import pytest
from cosimo.components.wind_pump.converter import (
    ANGLE,
    FREE,
    RATE,
    SPEED,
    TWIST,
    VELOCITY,
    InertialConverter,
    converter_derivatives,
)
from cosimo.components.wind_pump.driven_shaft import STANDING

pytestmark = pytest.mark.full

LEVER = {
    "crank_inertia": 0.8,
    "crank_radius": 0.06,
    "lever_ratio": 1.7,
    "lever_mass": 15.0,
    "slider_mass": 0.9,
    "clutch_arm": 0.07,
    "driven_inertia": 0.6,
}
B, A, R, RHO = 1.7, 2.7, 0.06, 0.07
PINS = ("stresses.crank_pin_force", "stresses.mass_pin_force", "stresses.slider_pin_force")
MODES = (STANDING, FREE, 1.0, -1.0)


def at_random(mode: float, seed: int) -> tuple[InertialConverter, np.ndarray]:
    """A converter in a random state of the mode, and the slope of that state."""
    rng = np.random.default_rng(seed)
    converter = InertialConverter(["stresses"], LEVER)
    converter.set("turbine_speed", rng.normal(3.0, 1.0))
    converter.set("load_torque", rng.uniform(1.0, 20.0))
    converter.initialize(0.0)
    speed = 0.0 if mode == STANDING else rng.uniform(0.1, 5.0)
    velocity = RHO * speed * (mode if mode in (1.0, -1.0) else rng.uniform(-1.0, 1.0))
    converter.x[:] = [0.01 * rng.normal(), rng.uniform(0.0, 7.0), 20.0 * rng.normal(), 0.01 * rng.normal(), velocity, speed, mode]
    converter.refresh()
    slope = np.zeros(7)
    converter_derivatives(0.0, converter.x, converter.u[0], slope, *converter.arguments)
    return converter, slope


def multipliers(converter: InertialConverter, mode: float) -> tuple[np.ndarray, np.ndarray]:
    """(q'', lambda) of M q'' + A^T lambda = Q, A q'' = gamma for q = (phi, s, x, y, theta), as one linear system.

    Constraints: r sin phi - s = 0, a s - b y - x = 0, and those of the clutches: side * y - rho theta = 0 where one drives, y
    and theta at rest where the shaft stands.
    """
    angle, rate, load = converter.x[ANGLE], converter.x[RATE], converter["load_torque"]
    torque = 1e4 * converter.x[TWIST] + 30.0 * (6.0 * converter["turbine_speed"] - rate)
    mass = np.diag([0.8, 0.0, 15.0, 0.9, 0.6])
    forces = np.array([torque, 0.0, 0.0, 0.0, -load])
    rows = [[R * math.cos(angle), -1.0, 0.0, 0.0, 0.0], [0.0, A, -1.0, -B, 0.0]]
    if mode in (1.0, -1.0):
        rows.append([0.0, 0.0, 0.0, mode, -RHO])
    elif mode == STANDING:
        rows += [[0.0, 0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 0.0, 1.0]]
    constraints = np.array(rows)
    gamma = np.zeros(len(rows))
    gamma[0] = R * math.sin(angle) * rate**2
    n = len(rows)
    matrix = np.block([[mass, constraints.T], [constraints, np.zeros((n, n))]])
    solved = np.linalg.solve(matrix, np.concatenate((forces, gamma)))
    return solved[:5], solved[5:]


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("seed", range(5))
def test_accelerations_and_joint_forces_are_those_of_the_multipliers(mode, seed):
    """The slider's pin is a part of the second constraint's force: b lambda_2."""
    converter, slope = at_random(mode, seed)
    accelerations, forces = multipliers(converter, mode)
    np.testing.assert_allclose(slope[[RATE, VELOCITY, SPEED]], accelerations[[0, 3, 4]], rtol=1e-10, atol=1e-10)
    np.testing.assert_allclose([converter[n] for n in PINS], [forces[0], forces[1], B * forces[1]], rtol=1e-10)
    clutch = mode * forces[2] if mode in (1.0, -1.0) else forces[2] if mode == STANDING else 0.0
    assert converter["driving_torque"] == pytest.approx(RHO * abs(clutch), rel=1e-10)


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("seed", range(5))
def test_every_part_is_in_balance(mode, seed):
    """Newton and Euler for crank, massless lever, mass, slider and driven shaft, each cut free."""
    converter, slope = at_random(mode, 100 + seed)
    x = converter.x
    on_lever, on_mass, on_slider = (converter[n] for n in PINS)
    sine, cosine = math.sin(x[ANGLE]), math.cos(x[ANGLE])
    torque = converter["turbine_torque"] / 6.0
    size = abs(on_lever) + 1.0
    assert 0.8 * slope[RATE] == pytest.approx(torque - R * cosine * on_lever, abs=1e-11 * size)
    assert on_lever == pytest.approx(on_mass + on_slider, rel=1e-12)  # the lever across itself
    assert on_lever * 1.0 == pytest.approx(on_mass * (1.0 + B), rel=1e-12)  # and about the slider, arms 1 and 1 + b
    mass_acceleration = A * R * (cosine * slope[RATE] - sine * x[RATE] ** 2) - B * slope[VELOCITY]
    assert 15.0 * mass_acceleration == pytest.approx(on_mass, rel=1e-11)
    clutch = on_slider - 0.9 * slope[VELOCITY]
    assert RHO * abs(clutch) == pytest.approx(converter["driving_torque"], abs=1e-11 * size)
    assert np.sign(converter["engaged"]) == (0.0 if mode == FREE else np.sign(clutch))
    if mode != STANDING:
        expected = math.copysign(RHO, mode) * clutch if mode != FREE else 0.0
        assert 0.6 * slope[SPEED] == pytest.approx(expected - converter["load_torque"], abs=1e-11 * size)
    mass_velocity = A * R * cosine * x[RATE] - B * x[VELOCITY]
    power = on_lever * R * cosine * x[RATE] - on_mass * mass_velocity - on_slider * x[VELOCITY]
    assert power == pytest.approx(0.0, abs=1e-11 * size * (1.0 + abs(mass_velocity)))  # a rigid lever takes none


@pytest.mark.known_answers(InertialConverter="stresses")
def test_stresses_at_stall_are_those_of_the_mass_alone():
    """A crank of constant speed w under a lever whose end is held: m a r w² sin phi at the mass, bending by the arm b l2."""
    converter = InertialConverter(["stresses"], {"gear_ratio": 1.0, "crank_inertia": 1e6, "start_angle": 0.5 * math.pi,
                                                 "shaft_damping": 0.0, "lever_ratio": 1.5, "stresses.lever_arm": 0.3,
                                                 "stresses.driven_shaft_diameter": 0.025})  # fmt: skip
    converter.set("turbine_speed", 10.0)
    converter.set("load_torque", 1e3)
    converter.initialize(0.0)
    force = 20.0 * 2.5 * 0.05 * 100.0
    assert converter["stresses.mass_pin_force"] == pytest.approx(-force, rel=1e-6)
    assert converter["stresses.crank_pin_force"] == pytest.approx(-2.5 * force, rel=1e-6)
    assert converter["stresses.slider_pin_force"] == pytest.approx(-1.5 * force, rel=1e-6)
    assert converter["stresses.lever_stress"] == pytest.approx(-force * 1.5 * 0.3 / (0.02 * 0.05**2 / 6.0), rel=1e-6)
    assert converter["stresses.pin_stress"] == pytest.approx(-2.5 * force / (math.pi * 0.01**2), rel=1e-6)
    polar = math.pi * 0.025**4 / 32.0
    assert converter["driving_torque"] == pytest.approx(0.05 * 1.5 * force, rel=1e-6)
    assert converter["stresses.driven_shaft_stress"] == pytest.approx(0.05 * 1.5 * force * 0.0125 / polar, rel=1e-6)
    assert converter["stresses.lever_angle"] == pytest.approx(0.05 / 0.3)
    assert converter["stresses.shaft_stress"] == 0.0


def test_torsion_of_the_input_shaft():
    converter = InertialConverter(["stresses"])
    converter.set("turbine_speed", 3.0)
    converter.initialize(0.0)
    converter.step(0.0, 0.2)
    torque = converter["turbine_torque"] / 6.0
    assert abs(torque) > 1e-3
    assert converter["stresses.shaft_stress"] == pytest.approx(torque * 0.015 / (math.pi * 0.03**4 / 32.0), rel=1e-12)
