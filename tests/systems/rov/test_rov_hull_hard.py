"""Hard cases of the hull: the vertical, long runs and large steps, speeds and numbers at the edge, refusals."""

from __future__ import annotations

import math

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.components.rov.hull import WATER, RovHull
from scipy.spatial.transform import Rotation

pytestmark = pytest.mark.full

BALL = {f"inertia_{a}": 0.16 for a in "xyz"} | {"centre_of_gravity_z": 0.0}  # keeps any angular velocity
FREE = ("added_mass", "coriolis", "restoring")
ANGLES = ("roll", "pitch", "yaw")


def started(effects=FREE, **parameters) -> RovHull:
    hull = RovHull(effects, parameters)
    hull.initialize(0.0)
    return hull


def quaternion(hull: RovHull) -> np.ndarray:
    return np.array([hull[f"quaternion_{n}"] for n in "wxyz"])


def turned(hull: RovHull) -> Rotation:
    return Rotation.from_quat(np.roll(quaternion(hull), -1))


# -- attitude ----------------------------------------------------------------------------------------------------------


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


@pytest.mark.parametrize(("roll", "yaw"), [(0.3, 0.5), (0.0, 0.0), (-2.0, 3.0), (7.0, -4.0)])
@pytest.mark.parametrize("pitch", [0.5 * math.pi, -0.5 * math.pi])
def test_a_start_in_the_vertical_tells_the_angles_given(roll, pitch, yaw):
    hull = started((), **BALL, start_roll=roll, start_pitch=pitch, start_yaw=yaw)
    assert hull["attitude_valid"] == 0.0
    wrapped = [math.remainder(a, 2.0 * math.pi) for a in (roll, pitch, yaw)]
    np.testing.assert_allclose([hull[n] for n in ANGLES], wrapped, atol=1e-12)


def test_a_start_beyond_the_vertical_is_the_same_attitude_in_other_words():
    hull = started((), start_roll=0.2, start_pitch=math.radians(120.0), start_yaw=0.1)
    np.testing.assert_allclose([hull[n] for n in ANGLES], [0.2 - math.pi, math.radians(60.0), 0.1 - math.pi], atol=1e-14)


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


# -- long runs, large steps ----------------------------------------------------------------------------------------------


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


def test_macro_steps_of_any_length_give_the_same_attitude():
    ends = []
    for parts in (1, 4, 100):
        hull = started(start_roll_rate=2.0, start_pitch_rate=-1.5, start_yaw_rate=1.0, start_surge=1.0, substep=0.01)
        for k in range(parts):
            hull.step(k * 10.0 / parts, 10.0 / parts)
        ends.append(np.array(hull.y))
    np.testing.assert_allclose(ends[1:], [ends[0]] * 2, atol=1e-9)  # rounding, which tumbling amplifies


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


# -- numbers at the edge ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("share", [1.0, 1e3, 1e6])
def test_added_mass_far_above_the_mass(share):
    """In one unit there is no limit on their ratio; F = (m + m_A) a at any."""
    hull = started((*FREE, "external"), **{"added_mass.heave": 11.5 * share, "restoring.buoyancy": 112.8})
    hull["external.force_z"] = 10.0
    hull.refresh()
    assert hull["external.acceleration_z"] == pytest.approx(10.0 / (11.5 * (1.0 + share)), rel=1e-12)
    hull.step(0.0, 100.0)
    assert hull["heave"] == pytest.approx(1000.0 / (11.5 * (1.0 + share)), rel=1e-9)


def test_the_same_flow_with_a_fitting_step_is_followed():
    """Speed through the water r' = -(X r + XX r²) / (m + m_A): r = X / ((X / r0 + XX) exp(X t / (m + m_A)) - XX)."""
    hull = started((*WATER, "current"), substep=1e-4, centre_of_gravity_z=0.0, **{"restoring.buoyancy": 112.8})
    hull["current.velocity_north"] = 200.0
    hull.step(0.0, 1.0)
    through = 4.03 / ((4.03 / 200.0 + 18.18) * math.exp(4.03 / 17.0) - 18.18)
    assert hull["surge"] == pytest.approx(200.0 - through, rel=1e-9)


def test_a_start_too_fast_for_the_step_is_refused():
    assert started(WATER, start_surge=40.0, substep=0.01)["surge"] == 40.0
    with pytest.raises(BadInput, match=r"substep = 0.05 s.*at most 0.0"):
        started(WATER, start_surge=40.0, substep=0.05)


def test_a_step_too_long_for_the_drag_is_refused():
    with pytest.raises(BadInput, match=r"substep.*Reduce substep"):
        started(WATER, substep=1.0)


def test_a_direction_of_any_length_is_the_same_direction():
    names = [f"thruster_direction_{a}[2]" for a in "xyz"]
    long = started((), **{n: 40.0 * RovHull.variables[n].start for n in names})
    np.testing.assert_allclose(long.arguments[0].thrusters, started(()).arguments[0].thrusters, atol=1e-15)


def test_all_axes_at_once_far_from_upright_keep_finite_and_come_to_rest():
    hull = started(
        WATER,
        start_surge=2.0,
        start_sway=-2.0,
        start_heave=2.0,
        start_roll_rate=6.0,
        start_pitch_rate=-6.0,
        start_yaw_rate=6.0,
        start_roll=2.0,
        **{"restoring.buoyancy": 112.8},
    )
    energy = hull.energy()
    for k in range(60):
        hull.step(k * 1.0, 1.0)
        assert hull.energy() < energy
        energy = hull.energy()
    np.testing.assert_allclose([hull["roll"], hull["pitch"]], 0.0, atol=1e-2)
