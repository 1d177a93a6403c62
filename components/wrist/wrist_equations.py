"""Equations of the wrist, for numbers only: inertia, what acts on the two coordinates, energy and losses.

State x = (q1, q2, q1', q2'). Without finite rotations (`morphology` off) everything is taken at rest, the equations are linear:
M q'' + D q' + A^T K A q = A^T (tau_flexion, tau_deviation) + (proximal torque, distal torque).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ..core.contact import stop_depth, stop_torque
from ..core.kernels import kernel, kernel_tuple
from .kinematics import DISTAL_TILT, PROXIMAL_TILT, RULES, Axes, Pose, combined, cross, dot, pose
from .ligament_springs import bundle_pull

Q1, Q2, RATE_1, RATE_2 = range(4)
TAU_FLEXION, TAU_DEVIATION, PROXIMAL_TORQUE, DISTAL_TORQUE = range(4)
TENDONS = 4
UPRIGHT = 0.05  # cosine of a deviation at which flexion and roll are hardly distinct
FARTHEST = 3.0  # rad of flexion


@kernel_tuple
class Hand(NamedTuple):
    """Axes, inertia, passive stiffness by the angles of the hand, damping by coordinate; SI."""

    axes: Axes
    mass: float
    distance: float
    transverse: float
    axial: float
    row: float
    flexion_stiffness: float
    deviation_stiffness: float
    coupling_stiffness: float
    proximal_damping: float
    distal_damping: float
    substep: float


@kernel
def axes_of(p, e):
    """Where the axes lie at rest."""
    if e.morphology is not None:
        return Axes(p.coupling_model, e.morphology.proximal_tilt, e.morphology.distal_tilt, e.morphology.row_offset)
    return Axes(p.coupling_model, PROXIMAL_TILT, DISTAL_TILT, 0.0)


@kernel
def hand_of(p, e):
    """The hand with its axes from the parameters."""
    return Hand(
        axes_of(p, e),
        p.hand_mass,
        p.hand_distance,
        p.transverse_inertia,
        p.axial_inertia,
        p.row_inertia,
        p.flexion_stiffness,
        p.deviation_stiffness,
        p.coupling_stiffness,
        p.proximal_damping,
        p.distal_damping,
        p.substep,
    )


@kernel
def wrist_pose(x, c, morphology):
    """The pose, or its linear part about rest."""
    if morphology is not None:
        return pose(x[Q1], x[Q2], c.axes)
    at = pose(0.0, 0.0, c.axes)
    return Pose(
        at.proximal_1,
        at.proximal_2,
        at.hand_1,
        at.hand_2,
        at.row,
        at.hand,
        at.flexion_1 * x[Q1] + at.flexion_2 * x[Q2],
        at.deviation_1 * x[Q1] + at.deviation_2 * x[Q2],
        0.0,
        at.flexion_1,
        at.flexion_2,
        at.deviation_1,
        at.deviation_2,
        0.0,
        0.0,
    )


@kernel
def point_turning(at, distance, c):
    """Derivatives by q1 and q2 of the place of the point on the hand's long axis at a distance from the wrist's centre, m/rad."""
    offset = c.axes.offset
    lever = distance - offset
    return (
        combined(offset, cross(at.proximal_1, at.row), lever, cross(at.hand_1, at.hand)),
        combined(offset, cross(at.proximal_2, at.row), lever, cross(at.hand_2, at.hand)),
    )


@kernel
def spun(w, at, c):
    """The hand's tensor of inertia times a vector."""
    return combined(c.transverse, w, (c.axial - c.transverse) * dot(w, at.hand), at.hand)


@kernel
def mass_matrix(at, c):
    """(m11, m12, m22), kg.m2."""
    v1, v2 = point_turning(at, c.distance, c)
    spun_2 = spun(at.hand_2, at, c)
    return (
        c.mass * dot(v1, v1) + dot(at.hand_1, spun(at.hand_1, at, c)) + c.row * dot(at.proximal_1, at.proximal_1),
        c.mass * dot(v1, v2) + dot(at.hand_1, spun_2) + c.row * dot(at.proximal_1, at.proximal_2),
        c.mass * dot(v2, v2) + dot(at.hand_2, spun_2) + c.row * dot(at.proximal_2, at.proximal_2),
    )


@kernel
def gyroscopic(at, rate_1, rate_2, c):
    """Torques that the motion takes at constant rates of the coordinates, N.m."""
    row, hand = combined(rate_1, at.proximal_1, rate_2, at.proximal_2), combined(rate_1, at.hand_1, rate_2, at.hand_2)
    both = rate_1 * rate_2
    of_row = cross(at.proximal_1, at.proximal_2)  # the second axis is carried by what turns about the first
    of_rest = cross(combined(1.0, at.hand_1, -1.0, at.proximal_1), combined(1.0, at.hand_2, -1.0, at.proximal_2))
    row_2 = (both * of_row[0], both * of_row[1], both * of_row[2])
    hand_2 = combined(1.0, cross(row, hand), both, combined(1.0, of_row, 1.0, of_rest))
    offset = c.axes.offset
    lever = c.distance - offset
    centre_2 = combined(
        offset,
        combined(1.0, cross(row_2, at.row), 1.0, cross(row, cross(row, at.row))),
        lever,
        combined(1.0, cross(hand_2, at.hand), 1.0, cross(hand, cross(hand, at.hand))),
    )
    moment = combined(1.0, spun(hand_2, at, c), 1.0, cross(hand, spun(hand, at, c)))
    v1, v2 = point_turning(at, c.distance, c)
    return (
        c.mass * dot(v1, centre_2) + dot(at.hand_1, moment) + c.row * dot(at.proximal_1, row_2),
        c.mass * dot(v2, centre_2) + dot(at.hand_2, moment) + c.row * dot(at.proximal_2, row_2),
    )


@kernel
def limit_torques(at, x, flexion_rate, deviation_rate, interaction):
    """Torques of the limits on flexion, on deviation, and of the contact of the rows on the distal coordinate, N.m."""
    k, d = interaction.stiffness, interaction.dissipation
    return (
        stop_torque(at.flexion, flexion_rate, interaction.flexion_lower, interaction.flexion_upper, k, d),
        stop_torque(at.deviation, deviation_rate, interaction.deviation_lower, interaction.deviation_upper, k, d),
        stop_torque(x[Q2], x[RATE_2], interaction.contact_lower, interaction.contact_upper, interaction.contact_stiffness, d),
    )


@kernel
def weight(load, c):
    """Weight of the hand in the radius, N."""
    return c.mass * load.gravity_x, c.mass * load.gravity_y, c.mass * load.gravity_z


@kernel
def torques(at, x, u, c, ligaments, interaction, load):
    """What acts on the two coordinates but inertia, N.m."""
    flexion_rate = at.flexion_1 * x[RATE_1] + at.flexion_2 * x[RATE_2]
    deviation_rate = at.deviation_1 * x[RATE_1] + at.deviation_2 * x[RATE_2]
    flexing = u[TAU_FLEXION] - c.flexion_stiffness * at.flexion - c.coupling_stiffness * at.deviation
    deviating = u[TAU_DEVIATION] - c.coupling_stiffness * at.flexion - c.deviation_stiffness * at.deviation
    first = u[PROXIMAL_TORQUE] - c.proximal_damping * x[RATE_1]
    second = u[DISTAL_TORQUE] - c.distal_damping * x[RATE_2]
    if interaction is not None:
        on_flexion, on_deviation, on_contact = limit_torques(at, x, flexion_rate, deviation_rate, interaction)
        flexing += on_flexion
        deviating += on_deviation
        second += on_contact
    if load is not None:
        for j in range(TENDONS):
            flexing += load.flexion_arm[j] * u[load.u + j]
            deviating += load.deviation_arm[j] * u[load.u + j]
        v1, v2 = point_turning(at, c.distance, c)
        down = weight(load, c)
        tip_1, tip_2 = point_turning(at, load.tool_distance, c)
        force = (u[load.u + TENDONS], u[load.u + TENDONS + 1], u[load.u + TENDONS + 2])
        first += dot(v1, down) + dot(tip_1, force)
        second += dot(v2, down) + dot(tip_2, force)
    if ligaments is not None:
        of_first, of_second, _, _ = bundle_pull(x[Q1], x[Q2], x[RATE_1], x[RATE_2], c.axes, ligaments)
        first += of_first
        second += of_second
    return (
        first + at.flexion_1 * flexing + at.deviation_1 * deviating,
        second + at.flexion_2 * flexing + at.deviation_2 * deviating,
    )


@kernel
def motion(at, x, u, c, s, e):
    """(q1'', q2'', torques of rigid ligaments on q1 and q2); not a number where the model or the substep cannot follow."""
    m11, m12, m22 = mass_matrix(at, c)
    first, second = torques(at, x, u, c, s.ligaments, e.interaction, e.load)
    if e.morphology is not None:
        turning_1, turning_2 = gyroscopic(at, x[RATE_1], x[RATE_2], c)
        first -= turning_1
        second -= turning_2
        if math.cos(at.deviation) < UPRIGHT or abs(at.flexion) > FARTHEST:
            first = second = math.nan
    if max(abs(x[RATE_1]), abs(x[RATE_2])) * c.substep > 1.0:
        first = second = math.nan
    if e.constraint is not None:
        if s.held[0] != 0.0:
            return 0.0, second / m22, m12 * second / m22 - first, 0.0
        if s.held[1] != 0.0:
            return first / m11, 0.0, 0.0, m12 * first / m11 - second
    determinant = m11 * m22 - m12 * m12
    return (m22 * first - m12 * second) / determinant, (m11 * second - m12 * first) / determinant, 0.0, 0.0


@kernel
def wrist_derivatives(t, x, u, dx, s, p, e):
    """dx/dt."""
    c = hand_of(p, e)
    dx[Q1], dx[Q2] = x[RATE_1], x[RATE_2]
    dx[RATE_1], dx[RATE_2], _, _ = motion(wrist_pose(x, c, e.morphology), x, u, c, s, e)


@kernel
def wrist_energy(at, x, c, ligaments, interaction, load):
    """Kinetic energy, passive stiffness, ligaments, limits, and the weight's height over the hand at rest, J."""
    m11, m12, m22 = mass_matrix(at, c)
    energy = 0.5 * (m11 * x[RATE_1] * x[RATE_1] + m22 * x[RATE_2] * x[RATE_2]) + m12 * x[RATE_1] * x[RATE_2]
    energy += 0.5 * (c.flexion_stiffness * at.flexion * at.flexion + c.deviation_stiffness * at.deviation * at.deviation)
    energy += c.coupling_stiffness * at.flexion * at.deviation
    if interaction is not None:
        flexion = stop_depth(at.flexion, interaction.flexion_lower, interaction.flexion_upper)
        deviation = stop_depth(at.deviation, interaction.deviation_lower, interaction.deviation_upper)
        contact = stop_depth(x[Q2], interaction.contact_lower, interaction.contact_upper)
        energy += 0.5 * interaction.stiffness * (flexion * flexion + deviation * deviation)
        energy += 0.5 * interaction.contact_stiffness * contact * contact
    if load is not None:
        offset = c.axes.offset
        place = combined(offset, at.row, c.distance - offset, at.hand)
        energy -= dot(weight(load, c), (place[0], place[1] - c.distance, place[2]))
    if ligaments is not None:
        energy += bundle_pull(x[Q1], x[Q2], x[RATE_1], x[RATE_2], c.axes, ligaments)[2]
    return energy


@kernel
def power_lost(at, x, c, ligaments, interaction):
    """Power of damping, of the hysteresis of limits and of that of ligaments, W."""
    lost = c.proximal_damping * x[RATE_1] * x[RATE_1] + c.distal_damping * x[RATE_2] * x[RATE_2]
    if interaction is not None:
        flexion_rate = at.flexion_1 * x[RATE_1] + at.flexion_2 * x[RATE_2]
        deviation_rate = at.deviation_1 * x[RATE_1] + at.deviation_2 * x[RATE_2]
        with_losses = limit_torques(at, x, flexion_rate, deviation_rate, interaction)
        elastic = limit_torques(at, (x[Q1], x[Q2], 0.0, 0.0), 0.0, 0.0, interaction)
        lost -= dot(combined(1.0, with_losses, -1.0, elastic), (flexion_rate, deviation_rate, x[RATE_2]))
    if ligaments is not None:
        lost += bundle_pull(x[Q1], x[Q2], x[RATE_1], x[RATE_2], c.axes, ligaments)[3]
    return lost


@kernel
def row_flexion(x, c):
    """What the proximal and the distal row contribute to flexion, each against what carries it, rad."""
    if c.axes.model == RULES:
        return math.cos(c.axes.proximal_tilt) * x[Q1], math.cos(c.axes.distal_tilt) * x[Q2]
    return 0.5 * x[Q1], 0.5 * x[Q1]
