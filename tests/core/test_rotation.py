"""Attitude against SciPy's rotations, at any norm, and near the vertical."""

import math

import numpy as np
import pytest
from cosimo.components.core.rotation import angles, quaternion_of_angles, quaternion_rate, to_body, to_world
from scipy.spatial.transform import Rotation

RANDOM = np.random.default_rng(5)


def theirs(q) -> Rotation:
    return Rotation.from_quat([*q[1:], q[0]])


@pytest.mark.parametrize("norm", [1.0, 1e-3, 40.0])
def test_vectors_turn_as_with_scipy_whatever_the_norm(norm):
    for _ in range(20):
        q, v = RANDOM.normal(size=4), RANDOM.normal(size=3)
        q *= norm / np.linalg.norm(q)
        np.testing.assert_allclose(to_world(*q, *v), theirs(q).apply(v), atol=1e-14)
        np.testing.assert_allclose(to_body(*q, *v), theirs(q).inv().apply(v), atol=1e-14)


def test_angles_are_yaw_then_pitch_then_roll():
    for roll, pitch, yaw in RANDOM.uniform([-3.1, -1.5, -3.1], [3.1, 1.5, 3.1], (50, 3)):
        q = quaternion_of_angles(roll, pitch, yaw)
        np.testing.assert_allclose(theirs(q).as_euler("ZYX"), [yaw, pitch, roll], atol=1e-13)
        np.testing.assert_allclose(angles(*q, 9.0), [roll, pitch, yaw, 1.0], atol=1e-13)
        np.testing.assert_allclose(angles(*(-3.0 * np.array(q)), 9.0), [roll, pitch, yaw, 1.0], atol=1e-13)


@pytest.mark.parametrize("pitch", [0.5 * math.pi, -0.5 * math.pi, math.radians(89.95), math.radians(-89.95)])
def test_near_the_vertical_the_roll_given_is_kept_and_the_attitude_is_still_told(pitch):
    for roll, yaw, other in RANDOM.uniform(-3.1, 3.1, (20, 3)):
        q = quaternion_of_angles(roll, pitch, yaw)
        np.testing.assert_allclose(angles(*q, roll)[:3], [roll, pitch, yaw], atol=1e-6)  # (pi/2 - pitch)² at most
        said = angles(*q, other)
        assert (said[0], said[3]) == (other, 0.0)
        apart = theirs(quaternion_of_angles(*said[:3])) * theirs(q).inv()
        assert apart.magnitude() <= 2.0 * (0.5 * math.pi - abs(pitch)) + 1e-7  # the tilt that is left out


def test_rate_is_the_derivative_of_the_attitude():
    """A turn about a fixed body axis, exp(t w): its central difference in t has an error of (w d)²/24."""
    q, w, d = np.array(quaternion_of_angles(0.3, -0.8, 2.0)), np.array([0.5, -1.2, 0.7]), 1e-3
    ends = [theirs(q) * Rotation.from_rotvec(s * d * w) for s in (-0.5, 0.5)]
    after, before = (np.roll(e.as_quat(), 1) for e in reversed(ends))
    before, after = (e * np.sign(e @ q) for e in (before, after))
    np.testing.assert_allclose(quaternion_rate(*q, *w), (after - before) / d, atol=1e-6)
    assert np.dot(q, quaternion_rate(*q, *w)) == pytest.approx(0.0, abs=1e-16)  # the norm stays
