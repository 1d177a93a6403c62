"""Balls with inertia against rigid-body mechanics in space, solved by SciPy; at rest against the bearing without."""

import math

import numpy as np
import pytest
from cosimo.components.bearings.contacts import place_balls
from cosimo.components.bearings.deep_groove import DeepGrooveBearing
from cosimo.components.bearings.geometry import BallGeometry
from cosimo.components.bearings.inertia import Inertia, seated_ball
from cosimo.orchestrator.systems.bearings.support_tables import ball_rows
from scipy.optimize import fsolve

RPM = math.pi / 30.0
# Bearing 218 of textbooks: geometry from memory; the clearance gives its contact angle of 40 degrees
B218 = {
    "balls": 16,
    "ball_diameter": 22.225e-3,
    "pitch_diameter": 125.26e-3,
    "inner_conformity": 0.5232,
    "outer_conformity": 0.5232,
}
PLAY = 2.0 * (2.0 * 0.5232 - 1.0) * 22.225e-3 * (1.0 - math.cos(math.radians(40.0)))
THRUST = 17800.0  # N
DENSITY = 7800.0


def turning_force(mass: float, diameter: float, pitch: float, cage: float, angle: float) -> float:
    """Force at the outer contact, across its line and away from the shaft's plane, that turns a ball's axis with the cage, N.

    From angular velocities and vector products in space: the ball rolls on the outer race and does not spin on it.
    """
    r, along, z = np.eye(3)  # directions: out, with the rotation, along the shaft
    out = math.cos(angle) * r + math.sin(angle) * z
    arm, cage_turn = 0.5 * diameter * out, cage * z
    race = -np.cross(cage_turn, 0.5 * pitch * r + arm)  # velocity of the outer race seen from the cage
    # spin of the ball in the plane (r, z): no slip along, no spin about the contact's line
    rows = [[along @ np.cross(r, arm), along @ np.cross(z, arm)], [r @ out, z @ out]]
    spin = np.linalg.solve(rows, [along @ race, -cage_turn @ out]) @ np.array([r, z])
    rate = np.cross(cage_turn, 0.1 * mass * diameter**2 * spin)  # of the angular momentum
    across = -math.sin(angle) * r + math.cos(angle) * z
    return float(rate @ along / (np.cross(arm, across) @ along))


@pytest.mark.interpreted
@pytest.mark.known_answers(DeepGrooveBearing="ball_inertia")
@pytest.mark.parametrize("rpm", [0.0, 3000.0, 6000.0, 10000.0, 15000.0])
def test_a_bearing_under_thrust_is_that_of_mechanics_in_space(rpm):
    bearing = DeepGrooveBearing(["ball_inertia"], {**B218, "diametral_clearance": PLAY, "ball_inertia.density": DENSITY})
    bearing.set("speed", rpm * RPM)
    bearing.initialize(0.0)
    found = bearing.equilibrium(np.array([0.0, 0.0, THRUST, 0.0, 0.0]), held=("x", "y", "tilt_x", "tilt_y"))
    assert found.status == 0
    bearing.set("displacement_z", float(found.displacement[2]))
    bearing.refresh()
    geometry = BallGeometry(**B218)
    modulus = 2.06e11 / (1.0 - 0.3**2)
    inner, outer = (geometry.contact(race, modulus).stiffness for race in ("inner", "outer"))
    d, dm, length = geometry.ball_diameter, geometry.pitch_diameter, 0.0232 * geometry.ball_diameter
    mass, cage = DENSITY * math.pi * d**3 / 6.0, geometry.cage_ratio * rpm * RPM
    centrifugal, radial = mass * cage**2 * 0.5 * dm, 2.0 * length - 0.5 * PLAY

    def left(unknown):  # contact angles, and both loads over the thrust of a ball
        a_in, a_out, q_in, q_out = unknown
        q_in, q_out = q_in * THRUST / 16, q_out * THRUST / 16
        to_in, to_out = (length + (q / k) ** (2.0 / 3.0) for q, k in ((q_in, inner), (q_out, outer)))
        across = turning_force(mass, d, dm, cage, a_out)
        return [
            (to_in * math.cos(a_in) + to_out * math.cos(a_out) - radial) / radial,
            q_in * math.sin(a_in) * 16 / THRUST - 1.0,
            (q_in * math.cos(a_in) - q_out * math.cos(a_out) + centrifugal - across * math.sin(a_out)) * 16 / THRUST,
            (q_in * math.sin(a_in) - q_out * math.sin(a_out) + across * math.cos(a_out)) * 16 / THRUST,
        ]

    a_in, a_out, q_in, q_out = fsolve(left, [0.8, 0.6, 1.4, 1.8], xtol=1e-13)
    got = [bearing.get(f"ball_inertia.{name}") for name in ("inner_angle", "outer_angle", "outer_load", "centrifugal_force")]
    assert got == pytest.approx([a_in, a_out, q_out * THRUST / 16, centrifugal], rel=1e-9)
    assert found.ball_loads == pytest.approx([q_in * THRUST / 16] * 16, rel=1e-9)
    axial = sum(
        (length + (q * THRUST / 16 / k) ** (2 / 3)) * math.sin(a) for q, k, a in ((q_in, inner, a_in), (q_out, outer, a_out))
    )
    assert found.displacement[2] == pytest.approx(axial, rel=1e-9)


@pytest.mark.interpreted
def test_at_rest_the_balls_have_none():
    effects = ("damping", "linearisation", "rating_life")
    given = {"displacement_x": 1.5e-5, "displacement_z": 4e-6, "tilt_x": 1e-4, "speed": 0.0}
    values = []
    for more in ((), ("ball_inertia",)):
        bearing = DeepGrooveBearing([*effects, *more])
        for name, value in given.items():
            bearing.set(name, value)
        bearing.initialize(0.0)
        values.append([bearing.get(n) for n in bearing.outputs if not n.startswith("ball_inertia")])
    np.testing.assert_allclose(values[1], values[0], rtol=1e-9, atol=1e-9)


@pytest.mark.interpreted
@pytest.mark.parametrize("speed", [50.0, 600.0, 2500.0])
def test_stiffness_is_the_derivative_of_the_force(speed):
    """All 25 elements, which the friction that turns the balls makes unsymmetric."""
    bearing = DeepGrooveBearing(
        ["ball_inertia", "linearisation"], {**B218, "diametral_clearance": PLAY, "linearisation.idle_stiffness": 0.0}
    )
    names = ("displacement_x", "displacement_y", "displacement_z", "tilt_x", "tilt_y")
    start = dict(zip(names, (5e-6, -2e-6, 6.9e-4, 2e-5, 1e-5), strict=True))
    forces = ("force_x", "force_y", "force_z", "moment_x", "moment_y")

    def loads(**change):
        for name, value in (start | change).items():
            bearing.set(name, value)
        bearing.refresh()
        return np.array([bearing.get(n) for n in forces])

    bearing.set("speed", speed)
    bearing.initialize(0.0)
    loads()
    stiffness = np.reshape([bearing.get(f"linearisation.stiffness[{k}]") for k in range(1, 26)], (5, 5))
    steps = [1e-9, 1e-9, 1e-9, 1e-8, 1e-8]
    columns = [(loads(**{n: start[n] - h}) - loads(**{n: start[n] + h})) / (2 * h) for n, h in zip(names, steps, strict=True)]
    scale = np.sqrt(np.outer(np.diag(stiffness), np.diag(stiffness)))
    np.testing.assert_allclose(np.transpose(columns) / scale, stiffness / scale, atol=1e-6)


@pytest.mark.interpreted
def test_balls_at_random_are_in_balance():
    """Loads apart by nine decades, pressed and in play."""
    random = np.random.default_rng(5)
    for _ in range(1000):
        lengths = random.uniform(0.005, 0.06, 2) * 0.0111
        force, angle = 10 ** random.uniform(-6.0, 3.5), random.uniform(-1.2, 1.2)
        apart = lengths.sum() + random.choice([-1.0, 1.0]) * 10 ** random.uniform(-9.0, -4.6)
        ends = np.array([apart * math.cos(angle), apart * math.sin(angle)])
        k = Inertia(*10 ** random.uniform(9.5, 10.5, 2), *lengths, force)
        ball = seated_ball(*ends, 0.0, k)
        out = np.array([math.cos(ball.outer_angle), math.sin(ball.outer_angle)])
        across = 0.4 * force * out[1] * np.array([out[1], -out[0]])
        left = ball.load * np.array([ball.cos_inner, ball.sin_inner]) - ball.outer_load * out + (force, 0.0) + across
        assert np.hypot(*left) < 1e-8 * (ball.load + ball.outer_load)
        at = ends - (lengths[0] + (ball.load / k.inner) ** (2 / 3)) * np.array([ball.cos_inner, ball.sin_inner])
        if ball.load > 0.0:
            np.testing.assert_allclose(
                at, (lengths[1] + (ball.outer_load / k.outer) ** (2 / 3)) * out, rtol=0, atol=1e-12 * apart
            )


@pytest.mark.interpreted
def test_balls_without_load_lean_on_the_outer_race():
    bearing = DeepGrooveBearing(["ball_inertia", "rating_life"], {"diametral_clearance": 2e-5})
    bearing.set("speed", 2000.0)
    bearing.initialize(0.0)
    force = bearing.get("ball_inertia.centrifugal_force")
    assert force > 50.0
    assert bearing.get("ball_inertia.outer_load") == force
    assert bearing.get("max_ball_load") == force
    assert bearing.get("loaded_balls") == 0
    assert bearing.get("force_x") == 0.0
    assert bearing.get("rating_life.rate") > 0.0  # of the outer race


def test_the_stiffness_of_a_table_of_supports_falls_with_the_speed():
    given = {**B218, "diametral_clearance": PLAY}
    rows = ball_rows(given, ["ball_inertia"], "", (0.0, -2000.0, THRUST), [0.0, 10000.0 * RPM])
    assert 0.4 < rows[1].stiffness[0, 0] / rows[0].stiffness[0, 0] < 0.6
    assert place_balls(3, columns=7).shape == (3, 7)
