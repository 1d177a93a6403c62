"""Attitude of the hull: through the vertical, over many steps, and at rest in the end."""

import math

import numpy as np
import pytest
from cosimo.components.rov.hull import RovHull
from cosimo.components.rov.vehicles import WATER
from cosimo.tests.support import initialized
from scipy.spatial.transform import Rotation

BALL = {f"inertia_{a}": 0.16 for a in "xyz"} | {"centre_of_gravity_z": 0.0}  # keeps any angular velocity


FREE = ("added_mass", "coriolis", "restoring")


ANGLES = ("roll", "pitch", "yaw")


def started(effects=FREE, **parameters) -> RovHull:
    return initialized(RovHull(effects, parameters))


def quaternion(hull: RovHull) -> np.ndarray:
    return np.array([hull[f"quaternion_{n}"] for n in "wxyz"])


def turned(hull: RovHull) -> Rotation:
    return Rotation.from_quat(np.roll(quaternion(hull), -1))


@pytest.mark.full
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_loop_through_both_verticals(sign):
    """Pitching at 1 rad/s with some roll and yaw: the attitude is exact all along, and the angles said always give it back."""
    hull = started((), **BALL, start_roll=0.4, start_yaw=1.0, start_pitch_rate=sign, substep=1e-3)
    start = turned(hull)
    seen, last = set(), None
    for k in range(700):  # more than a whole turn
        hull.step(k * 0.01, 0.01)
        exact = start * Rotation.from_rotvec([0.0, sign * hull.t, 0.0])
        assert (turned(hull) * exact.inv()).magnitude() <= 1e-12 * (k + 1)
        said = Rotation.from_euler("ZYX", [hull["yaw"], hull["pitch"], hull["roll"]])
        valid = hull["attitude_valid"]
        assert (said * exact.inv()).magnitude() <= (1e-9 if valid else math.radians(0.2))
        q = quaternion(hull)
        assert last is None or np.linalg.norm(q - last) < 0.01  # no change of sign on the way
        last = q
        seen.add(valid)
    assert 1.0 in seen


@pytest.mark.full
@pytest.mark.parametrize("up", [1.0, -1.0])
def test_through_the_vertical_itself(up):
    """Exactly at +-90 degrees roll keeps its last value and yaw goes on; a tenth of a degree past it both are told again."""
    hull = started((), **BALL, start_pitch=up * math.radians(89.0), start_yaw=0.7, start_pitch_rate=up * math.radians(0.1))
    said = []
    for k in range(20):
        hull.step(k, 1.0)
        said.append([hull[n] for n in (*ANGLES, "attitude_valid")])
    said = np.array(said)
    inside = said[:, 3] == 0.0
    # 89.9 to 90.1 degrees: the steps that end 10 s after the start, and by rounding those at the border
    assert set(np.flatnonzero(inside)) - {8, 10} == {9}
    np.testing.assert_allclose(said[inside, 0], 0.0, atol=1e-12)
    np.testing.assert_allclose(said[inside, 2], 0.7, atol=1e-9)
    np.testing.assert_allclose(said[9, 1], up * 0.5 * math.pi, atol=1e-9)
    np.testing.assert_allclose(np.abs(said[11:, 0]), math.pi, atol=1e-9)  # over the top: on its back, and facing back
    np.testing.assert_allclose(np.cos(said[11:, 2] - 0.7), -1.0, atol=1e-9)


@pytest.mark.full
def test_righting_moment_is_regular_in_the_vertical():
    """Nose up at rest is an angle of 90 degrees of a pendulum like any other, and the acceleration W z_g / (I + A)."""
    hull = started(
        (*FREE, "external"),
        start_pitch=0.5 * math.pi,
        centre_of_gravity_z=0.0,
        **{"restoring.buoyancy": 112.8, "restoring.centre_of_buoyancy_z": -0.02},
    )
    assert hull["external.angular_acceleration_y"] == pytest.approx(-0.02 * 112.8 / 0.28, rel=1e-14)
    hull.step(0.0, 0.5)
    assert hull["pitch"] < math.radians(89.0)
    assert hull["attitude_valid"] == 1.0


@pytest.mark.full
@pytest.mark.parametrize("substep", [0.01, 0.1, 0.5])
def test_a_norm_that_drifts_turns_nothing(substep):
    """RK4 shortens q by (w h/2)^6/144 a step; over many steps in one macro step that adds up, and turns nothing."""
    rate, n = 2.0, 2000
    hull = started((), **BALL, start_yaw_rate=rate, substep=substep)
    hull.step(0.0, n * substep)
    half = 0.5 * rate * substep
    step = complex(1.0 - half**2 / 2.0 + half**4 / 24.0, half - half**3 / 6.0)  # RK4's factor for q' = i w/2 q
    assert abs(step) ** n < (1.0 - 1e-6 if substep == 0.5 else 1.0)
    angle = 2.0 * n * np.angle(step)
    assert abs(math.remainder(hull["yaw"] - angle, 2.0 * math.pi)) <= 1e-9
    assert np.linalg.norm(quaternion(hull)) == pytest.approx(1.0, abs=3e-16)


@pytest.mark.full
def test_a_day_of_drifting_ends_upright_and_at_the_speed_of_the_water():
    hull = started(
        (*WATER, "current"),
        start_roll=3.0,
        start_pitch=0.3,
        start_yaw=-2.0,
        start_depth=1000.0,
        **{"restoring.buoyancy": 112.8},
        substep=0.05,
    )
    hull["current.velocity_north"], hull["current.velocity_east"] = 0.3, -0.4
    hull.step(0.0, 86400.0)
    np.testing.assert_allclose([hull["roll"], hull["pitch"]], 0.0, atol=1e-12)
    way = turned(hull).apply([hull["surge"], hull["sway"], hull["heave"]])
    np.testing.assert_allclose(way, [0.3, -0.4, 0.0], atol=1e-12)


@pytest.mark.full
def test_a_direction_of_any_length_is_the_same_direction():
    names = [f"thruster_direction_{a}[2]" for a in "xyz"]
    long = started((), **{n: 40.0 * RovHull.variables[n].start for n in names})
    np.testing.assert_allclose(long.arguments[0].thrusters, started(()).arguments[0].thrusters, atol=1e-15)
