"""The five pairs of isometric ligaments: where they are attached, how long they are, how they pull.

Which pairs are isometric is Sandow's (conference abstract, 2008): lunate-radius, trapezium-scaphoid, scapho-lunate,
luno-triquetral, radio-triquetral. Everything else here is ours:

- The bones of the proximal row turn along one arc to different extents (that they do so is of the abstract of Sandow, 2020):
  the scaphoid by the whole row angle, lunate and triquetrum by a share of it. The trapezium goes with the distal row.
- A ligament is exactly isometric where one of its ends lies on the axis about which its bones turn against each other. Here
  one end lies beside it by `off_axis`, towards the other end: the ligament is shortest at rest, and the less isometric, the
  farther beside. Ends are fixed in the bones; an axis that is moved leaves them where they are.
- Tension over strain s beyond the slack length L0, of stiffness k at large strain, with a toe of width e:
  T = k L0 s² / (2 e) up to s = e, then k L0 (s - e / 2), times (1 + damping * strain rate) and never less than zero.
"""

from __future__ import annotations

import math

import numpy as np

from ..core.kernels import kernel
from .kinematics import (
    DISTAL_TILT,
    PROXIMAL_TILT,
    ROW_OFFSET,
    Axes,
    combined,
    cross,
    dot,
    hand_rotation,
    hand_turning,
    row_rotation,
    row_turning,
    turned,
)

LIGAMENTS = ("lunate_radius", "trapezium_scaphoid", "scapho_lunate", "luno_triquetral", "radio_triquetral")
COUNT = len(LIGAMENTS)
TRAPEZIUM_SCAPHOID = 1
STIFFNESS, OFF_AXIS, TOE_STRAIN = 5e4, 3e-3, 0.03  # N/m, m, 1: when nothing else is said

# Columns of ligaments, (5, 12), one row a ligament in the order of `LIGAMENTS`. First both ends at rest in the radius, m. EXTENT:
# share of the row angle by which the bone at an end turns; the second end of trapezium-scaphoid goes with the distal row.
# SLACK: m. SPRING: N/m, 0 for a cut one. TOE, GROWTH: e and damping, see above.
EXTENT_1, EXTENT_2, SLACK, SPRING, TOE, GROWTH = range(6, 12)
COLUMNS = 12


@kernel
def place_ends(j, about, first_along, second_along, distance, off_axis, ligaments):
    """Ends of ligament j on its axis at rest and beside it, m; about: the row, 0 proximal, 1 distal."""
    x, z, middle = math.sin(PROXIMAL_TILT), math.cos(PROXIMAL_TILT), 0.0
    if about == 1:
        x, z, middle = -math.sin(DISTAL_TILT), math.cos(DISTAL_TILT), ROW_OFFSET
    ends = ligaments[j]
    ends[0], ends[1], ends[2] = first_along * x, middle + distance, first_along * z
    ends[3], ends[4], ends[5] = second_along * x, middle + math.copysign(1.0, distance) * off_axis, second_along * z


@kernel
def attach(off_axis, ligaments):
    """Ends at rest, for distances (5,) m of the second ends from the axes as they are by default."""
    place_ends(0, 0, 0.0, 0.0, -12e-3, off_axis[0], ligaments)
    place_ends(1, 1, 15e-3, 15e-3, -8e-3, off_axis[1], ligaments)
    place_ends(2, 0, 8e-3, 3e-3, 6e-3, off_axis[2], ligaments)
    place_ends(3, 0, -3e-3, -9e-3, 6e-3, off_axis[3], ligaments)
    place_ends(4, 0, 6e-3, -12e-3, -14e-3, off_axis[4], ligaments)


@kernel
def set_extents(j, first, second, ligaments):
    """Shares of the row angle by which the bones at both ends of ligament j turn."""
    ligaments[j, EXTENT_1], ligaments[j, EXTENT_2] = first, second


@kernel
def make_ligaments(p, ligaments):
    """Springs from the parameters of `Constraint`, or those of the same names of `LigamentBundle`."""
    attach(p.off_axis, ligaments)
    set_extents(0, 0.0, p.lunate_extent, ligaments)
    set_extents(1, 1.0, 1.0, ligaments)
    set_extents(2, 1.0, p.lunate_extent, ligaments)
    set_extents(3, p.lunate_extent, p.triquetrum_extent, ligaments)
    set_extents(4, 0.0, p.triquetrum_extent, ligaments)
    for j in range(COUNT):
        x, y, z = (ligaments[j, 3] - ligaments[j, 0], ligaments[j, 4] - ligaments[j, 1], ligaments[j, 5] - ligaments[j, 2])
        ligaments[j, SLACK] = math.sqrt(x * x + y * y + z * z) / (1.0 + p.prestrain)
        ligaments[j, SPRING] = 0.0 if p.cut == j + 1 else p.stiffness[j]
        ligaments[j, TOE], ligaments[j, GROWTH] = p.toe, p.damping


def attachments(off_axis: np.ndarray) -> np.ndarray:
    """The result of `attach`, (5, 6) m."""
    ligaments = np.zeros((COUNT, COLUMNS))
    attach(np.asarray(off_axis, dtype=float), ligaments)
    return ligaments[:, :EXTENT_1]


@kernel
def end_of_bone(q1, q2, extent, axes, point):
    """(place, its derivatives by q1 and by q2) of a point of the proximal row that turns to an extent of the row's angle."""
    place = turned(row_rotation(extent * q1, extent * q2, axes), point)
    first, second = row_turning(extent * q1, axes)
    by_1, by_2 = cross(first, place), cross(second, place)
    return place, (extent * by_1[0], extent * by_1[1], extent * by_1[2]), (extent * by_2[0], extent * by_2[1], extent * by_2[2])


@kernel
def end_of_hand(q1, q2, axes, point):
    """(place, its derivatives by q1 and by q2) of a point of the distal row."""
    row = row_rotation(q1, q2, axes)
    middle = turned(row, (0.0, axes.offset, 0.0))
    arm = turned(hand_rotation(row, q2, axes), (point[0], point[1] - axes.offset, point[2]))
    row_1, row_2 = row_turning(q1, axes)
    hand_1, hand_2 = hand_turning(row_1, row_2, row, axes)
    return (
        combined(1.0, middle, 1.0, arm),
        combined(1.0, cross(row_1, middle), 1.0, cross(hand_1, arm)),
        combined(1.0, cross(row_2, middle), 1.0, cross(hand_2, arm)),
    )


@kernel
def ligament_length(j, q1, q2, axes, ligaments):
    """(length, its derivatives by q1 and by q2) of ligament j (from 0), m and m/rad."""
    e = ligaments
    a, a_1, a_2 = end_of_bone(q1, q2, e[j, EXTENT_1], axes, (e[j, 0], e[j, 1], e[j, 2]))
    if j == TRAPEZIUM_SCAPHOID:
        b, b_1, b_2 = end_of_hand(q1, q2, axes, (e[j, 3], e[j, 4], e[j, 5]))
    else:
        b, b_1, b_2 = end_of_bone(q1, q2, e[j, EXTENT_2], axes, (e[j, 3], e[j, 4], e[j, 5]))
    r = combined(1.0, b, -1.0, a)
    length = math.sqrt(dot(r, r))
    return length, dot(r, combined(1.0, b_1, -1.0, a_1)) / length, dot(r, combined(1.0, b_2, -1.0, a_2)) / length


@kernel
def spring_tension(strain, toe):
    """(tension, energy) per k L0 and per k L0²."""
    if strain <= 0.0:
        return 0.0, 0.0
    if strain < toe:
        return strain * strain / (2.0 * toe), strain * strain * strain / (6.0 * toe)
    return strain - 0.5 * toe, 0.5 * strain * (strain - toe) + toe * toe / 6.0


@kernel
def ligament_pull(j, q1, q2, rate_1, rate_2, axes, ligaments):
    """(tension, strain, torque on q1, torque on q2, energy, power lost) of ligament j."""
    length, by_1, by_2 = ligament_length(j, q1, q2, axes, ligaments)
    slack, stiffness = ligaments[j, SLACK], ligaments[j, SPRING]
    strain = length / slack - 1.0
    per_k, energy = spring_tension(strain, ligaments[j, TOE])
    elastic = stiffness * slack * per_k
    growth = by_1 * rate_1 + by_2 * rate_2
    tension = elastic * max(0.0, 1.0 + ligaments[j, GROWTH] * growth / slack)
    return (tension, strain, -tension * by_1, -tension * by_2, stiffness * slack * slack * energy, (tension - elastic) * growth)


@kernel
def bundle_pull(q1, q2, rate_1, rate_2, axes, ligaments):
    """(torque on q1, torque on q2, energy, power lost) of all of them."""
    torque_1 = torque_2 = energy = lost = 0.0
    for j in range(COUNT):
        if ligaments[j, SPRING] > 0.0:
            _, _, first, second, stored, heat = ligament_pull(j, q1, q2, rate_1, rate_2, axes, ligaments)
            torque_1 += first
            torque_2 += second
            energy += stored
            lost += heat
    return torque_1, torque_2, energy, lost


@kernel
def write_bundle(q1, q2, rate_1, rate_2, y, at, axes, ligaments):
    """Tensions and strains into the outputs from `at` on."""
    for j in range(COUNT):
        y[at + j], y[at + COUNT + j], _, _, _, _ = ligament_pull(j, q1, q2, rate_1, rate_2, axes, ligaments)


def lengths(q1: float, q2: float, axes: Axes, ligaments: np.ndarray) -> np.ndarray:
    """Lengths and their derivatives by q1 and q2, (5, 3), m and m/rad."""
    return np.array([ligament_length(j, q1, q2, axes, ligaments) for j in range(COUNT)])
