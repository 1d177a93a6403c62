"""Equations of the gimbal at random states: Lagrange's, a cloud of point masses, and the balances of energy and momentum.

The component solves Euler's equations in the body's axes. Here stand Lagrange's equations written out for each direction of
the outer axis, and a body of point masses whose accelerations are second differences of their places in space.
"""

import math

import numpy as np
import pytest
from cosimo.components.two_axis_joint.gimbal import GimbalBody, gimbal_derivatives
from cosimo.tests.support import initialized

pytestmark = pytest.mark.interpreted

ORIENTATIONS = ("vertical", "horizontal")
INERTIAS = {"frame_inertia": 0.02, "cross_inertia": 0.07, "inner_inertia": 0.09, "axial_inertia": 0.04}
G, MASS, DISTANCE, SPIN, OUTER_DAMPING, INNER_DAMPING = 9.81, 2.0, 0.15, 0.5, 0.03, 0.02
DAMPING = {"viscous.outer_coefficient": OUTER_DAMPING, "viscous.inner_coefficient": INNER_DAMPING}
LAGRANGE = ("gravity", "rotor", "viscous")
EVERYTHING = (*LAGRANGE, "base_motion", "payload", "reactions")
SEEDS = range(5)


def gimbal(effects, orientation, **parameters) -> GimbalBody:
    return initialized(GimbalBody(effects, INERTIAS | {"axis_orientation": orientation} | parameters))


def placed(body: GimbalBody, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Random angles, rates and inputs for a body; returns (state's first four, inputs)."""
    draw = np.random.default_rng(seed)
    body.x[:4] = np.concatenate((draw.uniform(-math.pi, math.pi, 2), draw.uniform(-4.0, 4.0, 2)))
    body.u[0] = draw.uniform(-2.0, 2.0, body.u.shape[1])
    body.refresh()
    return body.x[:4].copy(), body.u[0].copy()


def rates_of(body: GimbalBody) -> np.ndarray:
    """dx/dt at the present state."""
    dx = np.zeros(body.x.size)
    gimbal_derivatives(0.0, body.x, body.u[0], dx, *body.arguments)
    return dx


@pytest.mark.known_answers(GimbalBody="viscous")
@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("orientation", ORIENTATIONS)
def test_accelerations_are_those_of_lagrange(orientation, seed):
    body = gimbal(LAGRANGE, orientation, **DAMPING)
    (alpha, beta, outer, inner), (first, second) = placed(body, seed)
    Jo, B, A, C = INERTIAS.values()  # frame, across, inner axis, own axis
    s, c, weight = math.sin(beta), math.cos(beta), MASS * G * DISTANCE
    if orientation == "vertical":
        inertia = Jo + B * s * s + C * c * c
        right = [
            first - (B - C) * math.sin(2.0 * beta) * outer * inner + SPIN * s * inner - OUTER_DAMPING * outer,
            second + (B - C) * outer**2 * s * c - weight * s - SPIN * outer * s - INNER_DAMPING * inner,
        ]
    else:
        inertia = Jo + B * c * c + C * s * s
        right = [
            first
            + (B - C) * math.sin(2.0 * beta) * outer * inner
            - weight * math.sin(alpha) * c
            - SPIN * c * inner
            - OUTER_DAMPING * outer,
            second - (B - C) * outer**2 * s * c - weight * math.cos(alpha) * s + SPIN * outer * c - INNER_DAMPING * inner,
        ]
    np.testing.assert_allclose(rates_of(body)[2:4], [right[0] / inertia, right[1] / A], rtol=1e-12, atol=1e-10)


# -- a cloud of point masses ---------------------------------------------------------------------------------------------
STEP = 5e-3  # s, of the differences: sixth order, 5 rad/s
SECOND = np.array([2.0, -27.0, 270.0, -490.0, 270.0, -27.0, 2.0]) / 180.0
FIRST = np.array([-1.0, 9.0, -45.0, 0.0, 45.0, -9.0, 1.0]) / 60.0


def cloud() -> tuple[np.ndarray, np.ndarray]:
    """Masses and places in body axes of points with the body's mass, centre and moments about the crossing; some negative."""
    second = 0.5 * (
        sum(INERTIAS[n] for n in ("cross_inertia", "inner_inertia", "axial_inertia"))
        - 2.0 * np.array([INERTIAS[n] for n in ("cross_inertia", "inner_inertia", "axial_inertia")])
    )
    masses, places = [MASS - second.sum()], [np.zeros(3)]
    for axis, moment in enumerate(second):
        for side in (1.0, -1.0):
            masses.append(0.5 * moment + (0.5 * side * MASS * DISTANCE if axis == 2 else 0.0))
            places.append(side * np.eye(3)[axis])
    return np.array(masses), np.array(places)


def turned(axis: int, angle: float) -> np.ndarray:
    """Rotation matrix about a coordinate axis."""
    s, c = math.sin(angle), math.cos(angle)
    R = np.eye(3)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    R[i, i], R[i, j], R[j, i], R[j, j] = c, -s, s, c
    return R


@pytest.mark.known_answers(GimbalBody=("payload", "reactions"))
@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("orientation", ORIENTATIONS)
def test_point_masses_give_the_same_torques_and_the_reactions(orientation, seed):
    """With the accelerations of the component, on a base that turns and accelerates, with rotor, frame and payload."""
    body = gimbal(EVERYTHING, orientation, **DAMPING)
    (alpha, beta, outer, inner), _ = placed(body, seed)
    outer_2, inner_2 = rates_of(body)[2:4]
    base_rate, base_2 = body["base_motion.rate"], body["base_motion.acceleration"]
    moving = np.array([body[f"base_motion.acceleration_{n}"] for n in "xyz"])
    axis = 2 if orientation == "vertical" else 0
    masses, places = cloud()
    points, spins, frames = [], [], []
    for k in range(-3, 4):
        t = k * STEP
        base = turned(2, base_rate * t + 0.5 * base_2 * t * t)
        frame = base @ turned(axis, alpha + outer * t + 0.5 * outer_2 * t * t)
        R = frame @ turned(1, beta + inner * t + 0.5 * inner_2 * t * t)
        points.append(0.5 * moving * t * t + places @ R.T)
        spins.append(SPIN * R[:, 2])
        about = outer + outer_2 * t + (base_rate + base_2 * t if axis == 2 else 0.0)
        frames.append(INERTIAS["frame_inertia"] * about * frame[:, axis])
    here = np.array(points[3])
    pull = masses[:, None] * (np.tensordot(SECOND, points, 1) / STEP**2 - np.array([0.0, 0.0, G]))
    on_body = np.cross(here, pull).sum(axis=0) + np.tensordot(FIRST, spins, 1) / STEP
    on_joint = on_body + np.tensordot(FIRST, frames, 1) / STEP
    R_outer = turned(axis, alpha)
    R = R_outer @ turned(1, beta)
    payload = R @ [body[f"payload.moment_{n}"] for n in "xyz"]
    # rounding of the second differences, 1e-15 m / (5 ms)² times masses and lengths of 1, and their sixth order: (5 rad/s h)^6
    close = {"rtol": 1e-7, "atol": 2e-8}
    np.testing.assert_allclose((on_joint - payload) @ R_outer[:, axis], body["outer_torque"] - OUTER_DAMPING * outer, **close)
    np.testing.assert_allclose((on_body - payload) @ R[:, 1], body["inner_torque"] - INNER_DAMPING * inner, **close)
    np.testing.assert_allclose([body[f"reactions.force_{n}"] for n in "xyz"], pull.sum(axis=0), **close)
    np.testing.assert_allclose([body[f"reactions.moment_{n}"] for n in "xyz"], on_joint - payload, **close)


# -- balances --------------------------------------------------------------------------------------------------------------
def along(body: GimbalBody, output: str) -> float:
    """Rate of an output along the motion, by central differences in the direction of dx/dt (inputs held)."""
    x, dx, values = body.x.copy(), rates_of(body), []
    for side in (-2.0, -1.0, 1.0, 2.0):
        body.x[:] = x + side * 1e-4 * dx
        body.refresh()
        values.append(body[output])
    body.x[:] = x
    body.refresh()
    return (values[0] - 8.0 * values[1] + 8.0 * values[2] - values[3]) / 12e-4


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("orientation", ORIENTATIONS)
def test_energy_changes_by_the_power_of_torques_and_dampers_only(orientation, seed):
    body = gimbal(EVERYTHING, orientation, **DAMPING)
    placed(body, seed)
    for n in ("rate", "acceleration", "acceleration_x", "acceleration_y", "acceleration_z"):
        body.set(f"base_motion.{n}", 0.0)
    body.refresh()
    outer, inner = body["outer_rate"], body["inner_rate"]
    power = body["outer_torque"] * outer + body["inner_torque"] * inner
    power += sum(body[f"payload.moment_{n}"] * body[f"payload.rate_{n}"] for n in "xyz")
    lost = OUTER_DAMPING * outer**2 + INNER_DAMPING * inner**2
    assert along(body, "mechanical_energy") == pytest.approx(power - lost, rel=1e-8, abs=1e-8)
    assert body.energy() == body["mechanical_energy"]


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("orientation", ORIENTATIONS)
def test_momentum_about_the_outer_axis_changes_by_torque_and_weight(orientation, seed):
    body = gimbal(LAGRANGE, orientation, **DAMPING)
    (alpha, beta, outer, _), (first, _) = placed(body, seed)
    weight = MASS * G * DISTANCE * math.sin(alpha) * math.cos(beta) if orientation == "horizontal" else 0.0
    assert along(body, "outer_momentum") == pytest.approx(first - OUTER_DAMPING * outer - weight, rel=1e-8, abs=1e-8)


@pytest.mark.parametrize("seed", SEEDS)
def test_bristles_and_stops_keep_the_balance_of_energy(seed):
    """Stored in bristles: k z z'; taken by them: (F - k z) v + k z (v - z'), by the stops: stiffness depth d v²."""
    limits = {"stops.outer_lower": -0.5, "stops.outer_upper": 0.3, "stops.inner_lower": -0.4, "stops.inner_upper": 0.2}
    body = gimbal(("lugre_friction", "stops"), "vertical", **limits)
    placed(body, seed)
    draw = np.random.default_rng(seed)
    body.x[4:] = draw.uniform(-3e-4, 3e-4, 2)
    body.x[:4] = draw.uniform(-0.6, 0.6, 2).tolist() + draw.uniform(-0.05, 0.05, 2).tolist()
    body.refresh()
    k, damping = body["lugre_friction.stiffness"], body["lugre_friction.damping"]
    dx = rates_of(body)
    lost = 0.0
    for axis, v, z, z_rate, angle in zip(("outer", "inner"), body.x[2:4], body.x[4:], dx[4:], body.x[:2], strict=True):
        lost += damping * z_rate * v + k * z * (v - z_rate)
        depth = max(angle - limits[f"stops.{axis}_upper"], limits[f"stops.{axis}_lower"] - angle, 0.0)
        lost += body["stops.stiffness"] * body["stops.dissipation"] * depth * v * v
    power = body["outer_torque"] * body["outer_rate"] + body["inner_torque"] * body["inner_rate"]
    assert along(body, "mechanical_energy") == pytest.approx(power - lost, rel=1e-7, abs=1e-7)


@pytest.mark.parametrize("orientation", ORIENTATIONS)
def test_a_base_that_turns_steadily_about_a_vertical_outer_axis_is_a_change_of_frame(orientation):
    """Vertical: alpha + W t is the angle in space. Horizontal: the same start in space gives another motion (no symmetry)."""
    rate, start = 0.7, {"start_outer_angle": 0.2, "start_inner_rate": 1.0}
    fixed = gimbal(("gravity", "base_motion"), orientation, start_outer_rate=1.5, **start)
    moving = gimbal(("gravity", "base_motion"), orientation, start_outer_rate=1.5 - rate, **start)
    moving.set("base_motion.rate", rate)
    for body in (fixed, moving):
        body.step(0.0, 2.0)
    same = abs(moving["outer_angle"] + 2.0 * rate - fixed["outer_angle"]) + abs(moving["inner_angle"] - fixed["inner_angle"])
    if orientation == "vertical":
        assert same < 1e-11
    else:
        assert same > 1e-2


@pytest.mark.known_answers(GimbalBody="base_motion")
def test_an_accelerating_base_is_another_direction_of_gravity():
    """Steady acceleration a along y tilts the rest position of a pendulum about a horizontal axis x by atan(a / g)."""
    body = GimbalBody(
        ("gravity", "base_motion", "viscous"),
        {"axis_orientation": "horizontal", "start_inner_angle": 0.0, "viscous.outer_coefficient": 0.5},
    )
    body.set("base_motion.acceleration_y", 3.0)
    body.initialize(0.0)
    body.step(0.0, 20.0)
    # the bob lags: the body hangs along z = (0, -sin, cos), against the acceleration for a positive angle
    assert body["outer_angle"] == pytest.approx(math.atan(3.0 / 9.81), abs=1e-10)
