"""Gimbal against its closed forms: inertial motion, governor, pendulums, nutation and precession, dry friction, stops, order."""

import math
from itertools import pairwise

import numpy as np
import pytest
from cosimo.components.two_axis_joint.closed_forms import friction_turning_points, governor, governor_speed
from cosimo.components.two_axis_joint.gimbal import GimbalBody
from cosimo.tests.slopes import slope
from cosimo.tests.support import initialized
from cosimo.tests.systems.two_axis_joint.exact_motions import (
    inertial_period,
    nutation_frequency,
    pendulum_motion,
    pendulum_period,
    precession_rate,
)
from scipy.optimize import brentq

pytestmark = pytest.mark.interpreted

FRAME, ACROSS, INNER, OWN = 0.02, 0.03, 0.05, 0.06  # kg.m², of the inertial motion
MOMENT = 2.0 * 9.81 * 0.15  # N.m, m g l
GOVERNOR = {"cross_inertia": 0.06, "inner_inertia": 0.06, "axial_inertia": 0.02}


def gimbal(effects=(), **parameters) -> GimbalBody:
    return initialized(GimbalBody(effects, parameters))


def course(body: GimbalBody, duration: float, h: float) -> np.ndarray:
    """(time, outer angle, inner angle, outer rate, inner rate) after every step, (n, 5)."""
    rows = []
    for k in range(round(duration / h)):
        body.step(k * h, h)
        rows.append([(k + 1) * h, *body.y[:4]])
    return np.array(rows)


def crossing(body: GimbalBody, output: str, begin: float, end: float) -> float:
    """Time between `begin` and `end` at which an output passes 0; the body stands at time `begin` before and after."""
    start = body.save()

    def value(t):
        body.restore(start)
        if t > begin:
            body.step(begin, t - begin)
        return body[output]

    time = brentq(value, begin, end, xtol=1e-13)
    body.restore(start)
    return time


# -- inertial motion -------------------------------------------------------------------------------------------------------
@pytest.mark.first
@pytest.mark.parametrize("orientation", ["vertical", "horizontal"])
def test_inertial_motion_keeps_momentum_and_energy(orientation):
    body = gimbal(axis_orientation=orientation, start_outer_rate=5.0, start_inner_rate=2.0)
    momentum, energy = body["outer_momentum"], body["mechanical_energy"]
    body.step(0.0, 60.0)
    # RK4 at 1 ms and 10 rad/s loses (w h)^5 / 120 of a swing's energy a step at most, 1e-12; 60000 steps
    assert body["outer_momentum"] == pytest.approx(momentum, rel=1e-10)
    assert body["mechanical_energy"] == pytest.approx(energy, rel=1e-10)


@pytest.mark.parametrize(("amplitude", "published"), [(0.5, 1.6162719), (0.1, None), (1.4, None)])
def test_period_of_inertial_motion_is_that_of_the_quadrature(amplitude, published):
    """Momentum 0.4; published: 1.6162719 s at 0.5 rad, 1.6223115 s in the limit of small amplitudes."""
    p = 0.4
    expected = inertial_period(p, amplitude, FRAME, INNER, ACROSS, OWN)
    if published is not None:
        assert expected == pytest.approx(published, abs=6e-8)
    inertia = FRAME + ACROSS * math.sin(amplitude) ** 2 + OWN * math.cos(amplitude) ** 2
    body = gimbal(start_inner_angle=amplitude, start_outer_rate=p / inertia)
    body.step(0.0, 0.9 * expected)
    whole = crossing(body, "inner_rate", 0.9 * expected, 1.1 * expected)
    assert whole == pytest.approx(expected, rel=1e-10)


def test_small_inertial_oscillation():
    p = 0.4
    frequency = p / (FRAME + OWN) * math.sqrt((OWN - ACROSS) / INNER)
    assert frequency == pytest.approx(3.8729833, abs=5e-8)
    body = gimbal(start_inner_angle=1e-4, start_outer_rate=p / (FRAME + OWN))
    body.step(0.0, 1.5)
    assert crossing(body, "inner_rate", 1.5, 1.7) == pytest.approx(2.0 * math.pi / frequency, rel=1e-8)  # 1e-4² of curvature


def test_turning_about_the_axis_of_least_inertia_is_unstable():
    """With the own axis' inertia below the one across, beta = 0 is left as cosh(k t), k = p / J sqrt((B - C) / A)."""
    p = 0.4
    growth = p / (FRAME + ACROSS) * math.sqrt((OWN - ACROSS) / INNER)
    body = gimbal(cross_inertia=OWN, axial_inertia=ACROSS, start_inner_angle=1e-7, start_outer_rate=p / (FRAME + ACROSS))
    body.step(0.0, 1.0)
    assert body["inner_angle"] == pytest.approx(1e-7 * math.cosh(growth), rel=1e-8)  # it has grown to 2.5e-5 rad


# -- governor ----------------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("share", [0.5, 0.9, 1.2, 2.0])
def test_governor_swings_out_above_its_speed(share):
    """A frame of huge inertia imposes the speed. Small oscillation about the angle of rest, below and above 8.5775871 rad/s."""
    critical = governor_speed(MOMENT, 0.06, 0.02)
    assert critical == pytest.approx(8.5775871, abs=5e-8)
    angle, frequency = governor(share * critical, MOMENT, 0.06, 0.06, 0.02)
    if share > 1.0:
        assert angle == pytest.approx(math.acos(1.0 / share**2), rel=1e-12)
    speed = {"frame_inertia": 1e9, "start_outer_rate": share * critical}
    still = gimbal(("gravity",), **GOVERNOR, **speed, start_inner_angle=angle)
    still.step(0.0, 1.0)
    assert still["inner_angle"] == pytest.approx(angle, abs=1e-9)
    body = gimbal(("gravity",), **GOVERNOR, **speed, start_inner_angle=angle + 1e-5)
    period = 2.0 * math.pi / frequency
    body.step(0.0, 0.8 * period)
    # the curvature of the potential changes by the amplitude, the period by its square or, at an angle, 1e-5 as well
    assert crossing(body, "inner_rate", 0.8 * period, 1.2 * period) == pytest.approx(period, rel=1e-6)


def test_governor_loses_its_hanging_rest_above_its_speed():
    growth = math.sqrt(0.04 / 0.06 * (10.0**2 - governor_speed(MOMENT, 0.06, 0.02) ** 2))
    body = gimbal(("gravity",), **GOVERNOR, frame_inertia=1e9, start_outer_rate=10.0, start_inner_angle=1e-6)
    body.step(0.0, 1.0)
    assert body["inner_angle"] == pytest.approx(1e-6 * math.cosh(growth), rel=1e-8)


# -- pendulums -----------------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize(("axis", "frequency"), [("outer", 6.0652700), ("inner", 7.0035706)])
def test_small_oscillations_about_both_axes_of_a_hanging_body(axis, frequency):
    """Horizontal outer axis: sqrt(m g l / (J_o + A)) and sqrt(m g l / B), published for J_o = 0.02, A = B = 0.06 kg.m²."""
    start = {"start_outer_angle": 0.0, "start_inner_angle": 0.0, f"start_{axis}_angle": 1e-4}
    body = gimbal(("gravity",), **GOVERNOR, axis_orientation="horizontal", **start)
    period = 2.0 * math.pi / frequency
    body.step(0.0, 0.9 * period)
    assert crossing(body, f"{axis}_rate", 0.9 * period, 1.1 * period) == pytest.approx(period, rel=2e-8)


@pytest.mark.known_answers(GimbalBody="gravity")
@pytest.mark.parametrize(("amplitude", "ratio"), [(0.1, 1.00062536), (0.5 * math.pi, 1.18034060), (3.0, 2.57123395)])
def test_pendulum_of_any_amplitude(amplitude, ratio):
    frequency = math.sqrt(MOMENT / 0.06)
    period = pendulum_period(frequency, amplitude)
    assert period * frequency / (2.0 * math.pi) == pytest.approx(ratio, abs=5e-9)
    body = gimbal(("gravity",), **GOVERNOR, start_inner_angle=amplitude)
    times = np.arange(1, 41) * 0.05
    rows = course(body, 2.0, 0.05)
    angle, rate = pendulum_motion(frequency, amplitude, times)
    np.testing.assert_allclose(rows[:, 2], angle, atol=2e-9)
    np.testing.assert_allclose(rows[:, 4], rate, atol=2e-8)


# -- gyroscope -----------------------------------------------------------------------------------------------------------------
@pytest.mark.known_answers(GimbalBody="rotor")
def test_nutation_of_a_gyroscope():
    """h = 2 across the axes, J = 0.02 and 0.015: 115.4701 rad/s, on a circle whose sides are as the roots of the inertias."""
    inertias = {"frame_inertia": 0.005, "cross_inertia": 0.015, "inner_inertia": 0.015, "axial_inertia": 0.015}
    frequency = nutation_frequency(2.0, 0.02, 0.015)
    assert frequency == pytest.approx(115.4701, abs=5e-5)
    body = gimbal(
        ("rotor",),
        **inertias,
        **{"rotor.spin_momentum": 2.0},
        axis_orientation="horizontal",
        start_inner_angle=0.0,
        start_inner_rate=1e-3,
        substep=1e-4,
    )
    period = 2.0 * math.pi / frequency
    rows = course(body, period, period / 64)
    phase = frequency * rows[:, 0]
    # a rate of 1e-3 swings by 9e-6 rad: what is not linear is of that size
    np.testing.assert_allclose(rows[:, 4], 1e-3 * np.cos(phase), atol=1e-7)
    np.testing.assert_allclose(rows[:, 3], -1e-3 * math.sqrt(0.015 / 0.02) * np.sin(phase), atol=1e-7)


@pytest.mark.first(2)
@pytest.mark.parametrize("inclination", [0.0, 1.0, 1.4, 1.55, math.pi - 1.0])
def test_steady_precession_and_its_growth_towards_gimbal_lock(inclination):
    """Torque on the inner axis, answered by the outer one: -T / (h cos beta); exact for a body with equal moments."""
    inertias = {"cross_inertia": 0.015, "inner_inertia": 0.015, "axial_inertia": 0.015, "rotor.spin_momentum": 2.0}
    rate = -precession_rate(0.3, 2.0, inclination)
    body = GimbalBody(
        ("rotor",),
        {
            **inertias,
            "axis_orientation": "horizontal",
            "start_inner_angle": inclination,
            "start_outer_rate": rate,
            "substep": 1e-4,
        },
    )
    body.set("inner_torque", 0.3)
    body.initialize(0.0)
    body.step(0.0, 2.0)
    assert body["inner_angle"] == pytest.approx(inclination, abs=1e-9)
    assert body["outer_angle"] == pytest.approx(2.0 * rate, rel=1e-9)
    assert body["outer_rate"] == pytest.approx(-0.3 / (2.0 * math.cos(inclination)), rel=1e-9)


def test_a_rotor_does_no_work():
    body = gimbal(
        ("gravity", "rotor", "viscous"),
        start_outer_rate=3.0,
        start_inner_rate=-2.0,
        **{"viscous.outer_coefficient": 0.0, "viscous.inner_coefficient": 0.0},
    )
    energy, momentum = body["mechanical_energy"], body["outer_momentum"]
    body.step(0.0, 20.0)
    assert body["mechanical_energy"] == pytest.approx(energy, rel=1e-9)
    assert body["outer_momentum"] == pytest.approx(momentum, rel=1e-9)


# -- dry friction and stops ------------------------------------------------------------------------------------------------------
@pytest.mark.known_answers(GimbalBody="stick_friction")
@pytest.mark.parametrize("substep", [1e-3, 1e-2])
def test_a_pendulum_with_dry_friction_turns_where_the_work_says_and_stays(substep):
    level = 0.2
    body = gimbal(
        ("gravity", "stick_friction"), **GOVERNOR, start_inner_angle=1.2, substep=substep, **{"stick_friction.inner_level": level}
    )
    turning = friction_turning_points(1.2, level, MOMENT)
    for a, b in pairwise(turning):  # the balance itself: height lost = friction times way
        assert MOMENT * (math.cos(b) - math.cos(a)) == pytest.approx(level * abs(b - a), rel=1e-12)
    rows = course(body, 8.0, 0.01)
    angle, rate = rows[:, 2], rows[:, 4]
    turned = np.flatnonzero(rate[:-1] * rate[1:] < 0.0)
    peaks = [angle[max(0, k - 1) : k + 3][np.abs(angle[max(0, k - 1) : k + 3]).argmax()] for k in turned]
    # a sample 5 ms beside the turn misses it by (w t)²/2 of 1.2 rad, 8e-4
    np.testing.assert_allclose(peaks[: len(turning) - 2], turning[1:-1], atol=1.5e-3)
    # RK4 damps by (w h)^6 / 144 a step, w = 7 rad/s, for 8 s, and times of events are exact to 1e-14 s or so
    assert angle[-1] == pytest.approx(turning[-1], abs=1.2 * 8.0 / substep * (7.0 * substep) ** 6 / 144.0 + 1e-11)
    assert rate[-1] == 0.0
    assert angle[-1] == angle[-50]  # it does not creep
    assert body["stick_friction.inner_stuck"] == 1.0
    assert body.work["events"] == len(turning) - 1


@pytest.mark.known_answers(GimbalBody=("smoothed_friction", "lugre_friction"))
@pytest.mark.full
def test_smoothed_friction_creeps_where_exact_friction_stands():
    """Under half the level: never at rest, but at the rate where tanh is 1/2 - that is the price of the smoothed law."""
    for effect, rate in (("smoothed_friction", 0.01 * math.atanh(0.5)), ("stick_friction", 0.0), ("lugre_friction", 0.0)):
        body = GimbalBody((effect,), {})
        body.set("inner_torque", 0.025)
        body.initialize(0.0)
        body.step(0.0, 10.0)
        assert body["inner_rate"] == pytest.approx(rate, abs=1e-9), effect
    assert body.x[5] == pytest.approx(0.025 / 200.0, rel=1e-9)  # bristles: bent by T / stiffness
    assert body["inner_angle"] - 0.5 < 2.0 * 0.025 / 200.0  # that bends by more while they begin to slip, and stays


@pytest.mark.known_answers(GimbalBody="stops")
def test_an_impact_on_a_stop_loses_what_the_law_says():
    """Hunt and Crossley: v / d - ln(1 + d v) / d² has the same value before and after, for v into the stop and out of it."""
    speed, d = 2.0, 0.2
    body = gimbal(
        ("stops",),
        start_inner_angle=1.29,
        start_inner_rate=speed,
        substep=1e-5,
        **{"stops.dissipation": d, "stops.stiffness": 1000.0},
    )
    body.step(0.0, 0.1)
    assert body["inner_angle"] < 1.3

    def left(v):
        return v / d - math.log1p(d * v) / d**2

    after = brentq(lambda v: left(v) - left(speed), -speed, -1e-3, xtol=1e-14)
    assert body["inner_rate"] == pytest.approx(after, rel=1e-7)
    assert body["outer_rate"] == 0.0


# -- order -----------------------------------------------------------------------------------------------------------------------
def test_the_method_is_of_fourth_order():
    substeps = np.array([2e-2, 1e-2, 5e-3])
    start = {"start_outer_rate": 3.0, "start_inner_rate": 2.0, "axis_orientation": "horizontal"}
    ends = []
    for substep in (*substeps, 5e-4):
        body = gimbal(("gravity", "rotor", "viscous"), substep=substep, **start)
        body.step(0.0, 1.0)
        ends.append(body.x.copy())
    errors = [np.abs(e - ends[-1]).max() for e in ends[:-1]]
    assert slope(substeps, errors) == pytest.approx(4.0, abs=0.2)
