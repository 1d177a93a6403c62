"""Rows and angles of the hand: signs of the row rules, inverse table, small angles, roll, against rotations of scipy."""

import math

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.components.wrist.kinematics import (
    DEFAULT_AXES,
    DISTAL_TILT,
    OPENSIM_HALF,
    PROXIMAL_TILT,
    RULES,
    Axes,
    crossing,
    forward,
    hand_rotation,
    inverse,
    jacobian,
    pose,
    row_rotation,
    small_angle_matrix,
    turned,
)
from scipy.spatial.transform import Rotation

HALF = Axes(OPENSIM_HALF, 0.0, 0.0, 0.0)
POSITIONS = [(0.3, -0.2), (-0.7, 0.5), (0.6, 0.6), (-0.1, -0.9)]


def tilted(proximal: float, distal: float) -> Axes:
    """Axes with tilts in degrees."""
    return Axes(RULES, math.radians(proximal), math.radians(distal), 0.0)


def rotation(q1: float, q2: float, axes: Axes) -> tuple[Rotation, Rotation]:
    """(proximal row, hand), by rotation vectors of scipy."""
    if axes.model == OPENSIM_HALF:
        row = Rotation.from_rotvec([0.0, 0.0, 0.5 * q1]) * Rotation.from_rotvec([0.5 * q2, 0.0, 0.0])
        return row, row * row
    n_p = np.array([math.sin(axes.proximal_tilt), 0.0, math.cos(axes.proximal_tilt)])
    n_d = np.array([-math.sin(axes.distal_tilt), 0.0, math.cos(axes.distal_tilt)])
    row = Rotation.from_rotvec(q1 * n_p)
    return row, row * Rotation.from_rotvec(q2 * n_d)


@pytest.mark.parametrize("axes", [DEFAULT_AXES, tilted(10.0, 35.0), HALF])
@pytest.mark.parametrize(("q1", "q2"), POSITIONS)
def test_angles_are_those_of_the_composed_rotations(axes, q1, q2):
    row, hand = rotation(q1, q2, axes)
    assert forward(q1, q2, axes) == pytest.approx(hand.as_euler("ZXY"), abs=1e-14)
    v = (0.3, -0.5, 0.8)
    of_row = row_rotation(q1, q2, axes)
    assert turned(of_row, v) == pytest.approx(row.apply(v), abs=1e-15)
    assert turned(hand_rotation(of_row, q2, axes), v) == pytest.approx(hand.apply(v), abs=1e-15)


@pytest.mark.parametrize("axes", [DEFAULT_AXES, HALF])
@pytest.mark.parametrize(("q1", "q2"), POSITIONS)
def test_turning_of_row_and_hand_is_the_rate_of_their_rotation(axes, q1, q2):
    """Angular velocity from R(q + d) R(q - d)^T, and the rates of the angles from their differences."""
    d, at = 1e-5, pose(q1, q2, axes)
    for i, (of_row, of_hand) in enumerate(((at.proximal_1, at.hand_1), (at.proximal_2, at.hand_2))):
        step = d * np.eye(2)[i]
        after, before = rotation(q1 + step[0], q2 + step[1], axes), rotation(q1 - step[0], q2 - step[1], axes)
        for turning, a, b in zip((of_row, of_hand), after, before, strict=True):
            assert turning == pytest.approx((a * b.inv()).as_rotvec() / (2.0 * d), abs=1e-9)
        difference = (np.array(forward(q1 + step[0], q2 + step[1], axes)) - forward(q1 - step[0], q2 - step[1], axes)) / (2 * d)
        assert jacobian(q1, q2, axes)[:, i] == pytest.approx(difference, abs=1e-9)
    assert [[at.flexion_1, at.flexion_2], [at.deviation_1, at.deviation_2]] == pytest.approx(jacobian(q1, q2, axes)[:2])


# -- the rules of the rows -------------------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("target", "proximal", "distal", "roll"),
    [((40.0, 0.0), 33.435, 11.076, -2.932), ((0.0, 15.0), 12.540, -16.779, 1.595), ((0.0, -25.0), -21.844, 28.123, 4.681)],
)
def test_inverse_table(target, proximal, distal, roll):
    """Numbers to 0.001 degrees from a computation of its own, by Newton's method on the two rotations."""
    found = np.degrees(inverse(*np.radians(target)))
    assert found == pytest.approx([proximal, distal, roll], abs=6e-4)


@pytest.mark.parametrize("angle", [1.0, 10.0, 25.0])
def test_signs_of_the_rows_are_those_of_the_rule(angle):
    """Radial deviation: the proximal row flexes, the distal one extends. Flexion: both flex. Opposite motions: the reverse."""
    for sign in (1.0, -1.0):
        proximal, distal, _ = inverse(0.0, sign * math.radians(angle))
        assert (sign * proximal > 0.0, sign * distal < 0.0) == (True, True)
        proximal, distal, _ = inverse(sign * math.radians(angle), 0.0)
        assert (sign * proximal > 0.0, sign * distal > 0.0) == (True, True)


def test_equal_shares_contradict_the_rule():
    """With half of everything to each row, no row flexes or extends in deviation."""
    first, second, _ = inverse(0.0, 0.3, HALF)
    assert first == pytest.approx(0.0, abs=1e-13)
    assert second == pytest.approx(0.3, rel=1e-13)


def test_roll_stays_small():
    """Below 5 degrees at the ends of the table's motions and of pure flexion; 7.06 in ulnar deviation with smaller tilts."""
    ends = [(40.0, 0.0), (-40.0, 0.0), (0.0, 15.0), (0.0, -25.0)]
    assert max(abs(math.degrees(inverse(*np.radians(end))[2])) for end in ends) < 5.0
    assert abs(math.degrees(inverse(0.0, math.radians(-25.0), tilted(10.0, 35.0))[2])) == pytest.approx(7.06, abs=6e-3)


@pytest.mark.parametrize("axes", [DEFAULT_AXES, tilted(10.0, 35.0), tilted(-20.0, 60.0), HALF])
def test_inverse_is_the_inverse(axes):
    for flexion in np.linspace(-0.9, 0.9, 7):
        for deviation in np.linspace(-0.4, 0.4, 5):
            q1, q2, roll = inverse(flexion, deviation, axes)
            assert forward(q1, q2, axes) == pytest.approx((flexion, deviation, roll), abs=2e-13)
            assert rotation(q1, q2, axes)[1].as_euler("ZXY")[2] == pytest.approx(roll, abs=2e-13)


# -- small angles ----------------------------------------------------------------------------------------------------------
def test_small_angles():
    """A and its inverse; what is left is odd, of third order. Roll: products of the angles, by composition to second order."""
    a, b = PROXIMAL_TILT, DISTAL_TILT
    matrix = small_angle_matrix()
    assert matrix == pytest.approx(np.array([[math.cos(a), math.cos(b)], [math.sin(a), -math.sin(b)]]), abs=1e-15)
    assert np.linalg.det(matrix) == pytest.approx(-math.sin(a + b), rel=1e-14) == pytest.approx(-crossing(DEFAULT_AXES))
    assert np.linalg.inv(matrix) == pytest.approx(np.array([[0.8165, 0.8165], [0.2989, -1.1154]]), abs=5e-5)
    assert small_angle_matrix(HALF) == pytest.approx(np.eye(2), abs=1e-15)

    def rest(size: float) -> np.ndarray:
        q = size * np.array([1.0, -0.7])
        flexion, deviation, roll = forward(*q)
        expected = -0.5 * (q[0] * q[1] * math.sin(a + b) + flexion * deviation)
        return np.abs([*(np.array([flexion, deviation]) - matrix @ q), roll - expected])

    assert np.log2(rest(0.04) / rest(0.02)) == pytest.approx([3.0, 3.0, 4.0], abs=0.05)


# -- where there is no inverse ---------------------------------------------------------------------------------------------
@pytest.mark.parametrize("tilts", [(0.0, 0.0), (30.0, -30.0), (0.5, 0.5), (90.0, 90.0)])
def test_parallel_axes_are_refused(tilts):
    with pytest.raises(BadInput, match="one motion instead of two"):
        inverse(0.1, 0.1, tilted(*tilts))


def test_axes_that_are_nearly_parallel_reach_little():
    """At a sine of 0.0698 between the axes (2 and 2 degrees) the deviation ends near that angle."""
    axes = tilted(2.0, 2.0)
    inverse(0.0, 0.9 * math.radians(2.0), axes)
    with pytest.raises(BadInput, match="angles that the rows can reach"):
        inverse(0.0, 0.2, axes)


def test_angles_beyond_the_reach_are_refused():
    with pytest.raises(BadInput, match="can reach"):
        inverse(-1.0, math.radians(75.0))
