"""What the axes of a hull have to do with one another in the water: the numbers beside the diagonals of added mass and drag.

Beside the masses and coefficients of each axis, which are the diagonals of three matrices, (6, 6), in the order surge, sway, heave,
roll, pitch, yaw:

    added mass M_A, symmetric:   kinetic energy of the water 1/2 nu^T M_A nu
    drag D nu + D2 |nu| nu:      row i is the force or moment about axis i, column j the speed along axis j, |nu_j| nu_j for D2

An added mass whose water would have negative kinetic energy, and drag that would give energy at some velocity, are refused.
Source: Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control, Wiley 2011, chapters 6 and 8.
"""

from __future__ import annotations

import math

from ..core.component import Effect
from ..core.contract import Refusal
from ..core.kernels import DONE, OWN, kernel
from ..core.spectrum import spectral_radius
from ..core.variables import parameter

NEGATIVE_MASS, DRIVING_DRAG, DRIVING_SQUARE, LONE = OWN + 2, OWN + 3, OWN + 4, OWN + 7  # statuses
PRINTED = 1e-5  # of an eigenvalue, where the diagonal is 1: tables are printed with four or five digits
DOWNWARDS, STEP = 100, 0.1  # steps of a descent, and how far each follows the slope, where the diagonal is 1
VELOCITY = "({refused[1]}, {refused[2]}, {refused[3]}) m/s, ({refused[4]}, {refused[5]}, {refused[6]}) rad/s"
REFUSALS = {
    NEGATIVE_MASS: Refusal(
        "added_mass with added_mass_coupling: a matrix with the eigenvalue {refused[0]}, scaled to 1 on its diagonal",
        "none below 0",
        "The water would have negative kinetic energy: check signs and axes of the numbers beside the diagonal.",
    ),
    DRIVING_DRAG: Refusal(
        "linear_drag with linear_drag_coupling: a symmetric part with the eigenvalue {refused[0]}, scaled to 1 on its diagonal",
        "none below 0",
        "The water would drive the hull: check signs and axes of the numbers beside the diagonal.",
    ),
    DRIVING_SQUARE: Refusal(
        f"quadratic_drag with quadratic_drag_coupling: {{refused[0]}} W from the water at {VELOCITY}",
        "drag that takes energy at every velocity",
        "Check signs and axes of the numbers beside the diagonal.",
    ),
    LONE: Refusal(
        "a number beside the diagonal for axis {refused[0]}, of surge, sway, heave, roll, pitch, yaw, which has none on it",
        "coupling of axes that have an added mass or drag of their own",
        "Give added_mass, linear_drag or quadratic_drag of this axis.",
    ),
}
FORCES = "surge by sway, surge by heave, sway by surge, sway by heave, heave by surge, heave by sway"
MOMENTS = "roll by pitch, roll by yaw, pitch by roll, pitch by yaw, yaw by roll, yaw by pitch"
ROWS = "row by row"


class AddedMassCoupling(Effect):
    """Added mass between the axes, a symmetric matrix with `added_mass` on its diagonal, in Coriolis forces, too."""

    requires = ("added_mass",)
    explicit_only = True

    force = parameter(0.0, "kg", "surge and sway, surge and heave, sway and heave", size=3)
    mixed = parameter(0.0, "kg.m", f"surge, sway, heave with roll, pitch, yaw, {ROWS}", size=9)
    moment = parameter(0.0, "kg.m2", "roll and pitch, roll and yaw, pitch and yaw", size=3)


class LinearDragCoupling(Effect):
    """Linear drag between the axes: force and moment per speed along, and rate about, other axes."""

    requires = ("linear_drag",)
    explicit_only = True

    force_by_speed = parameter(0.0, "N.s/m", f"drag: {FORCES}", size=6)
    force_by_rate = parameter(0.0, "N.s", f"surge, sway, heave by roll, pitch, yaw, {ROWS}", size=9)
    moment_by_speed = parameter(0.0, "N.s", f"roll, pitch, yaw by surge, sway, heave, {ROWS}", size=9)
    moment_by_rate = parameter(0.0, "N.m.s", f"drag: {MOMENTS}", size=6)


class QuadraticDragCoupling(Effect):
    """Quadratic drag between the axes: force and moment per |speed| speed of other axes."""

    requires = ("quadratic_drag",)
    explicit_only = True

    force_by_speed = parameter(0.0, "N.s2/m2", f"drag: {FORCES}", size=6)
    force_by_rate = parameter(0.0, "N.s2", f"surge, sway, heave by roll, pitch, yaw, {ROWS}", size=9)
    moment_by_speed = parameter(0.0, "N.s2/m", f"roll, pitch, yaw by surge, sway, heave, {ROWS}", size=9)
    moment_by_rate = parameter(0.0, "N.m.s2", f"drag: {MOMENTS}", size=6)


@kernel
def six(effect, row):
    """The six coefficients of an effect into row, (6,)."""
    row[0], row[1], row[2] = effect.surge, effect.sway, effect.heave
    row[3], row[4], row[5] = effect.roll, effect.pitch, effect.yaw


@kernel
def times(m, a, b, c, d, e, f):
    """Product of a matrix, (6, 6), and six numbers."""
    return (
        m[0, 0] * a + m[0, 1] * b + m[0, 2] * c + m[0, 3] * d + m[0, 4] * e + m[0, 5] * f,
        m[1, 0] * a + m[1, 1] * b + m[1, 2] * c + m[1, 3] * d + m[1, 4] * e + m[1, 5] * f,
        m[2, 0] * a + m[2, 1] * b + m[2, 2] * c + m[2, 3] * d + m[2, 4] * e + m[2, 5] * f,
        m[3, 0] * a + m[3, 1] * b + m[3, 2] * c + m[3, 3] * d + m[3, 4] * e + m[3, 5] * f,
        m[4, 0] * a + m[4, 1] * b + m[4, 2] * c + m[4, 3] * d + m[4, 4] * e + m[4, 5] * f,
        m[5, 0] * a + m[5, 1] * b + m[5, 2] * c + m[5, 3] * d + m[5, 4] * e + m[5, 5] * f,
    )


@kernel
def fill_masses(coupling, m):
    """The matrix of an `AddedMassCoupling`, (6, 6), without its diagonal."""
    m[:] = 0.0
    m[0, 1], m[0, 2], m[1, 2] = coupling.force[0], coupling.force[1], coupling.force[2]
    m[3, 4], m[3, 5], m[4, 5] = coupling.moment[0], coupling.moment[1], coupling.moment[2]
    for i in range(3):
        for j in range(3):
            m[i, 3 + j] = coupling.mixed[3 * i + j]
    for i in range(6):
        for j in range(i):
            m[i, j] = m[j, i]


@kernel
def fill_drag(coupling, m):
    """The matrix of a coupling of drag, (6, 6), without its diagonal."""
    m[:] = 0.0
    k = 0
    for i in range(3):
        for j in range(3):
            m[i, 3 + j], m[3 + i, j] = coupling.force_by_rate[3 * i + j], coupling.moment_by_speed[3 * i + j]
            if i != j:
                m[i, j], m[3 + i, 3 + j] = coupling.force_by_speed[k], coupling.moment_by_rate[k]
                k += 1


@kernel
def lone(diagonal, m):
    """Number of the first axis, from 1 on, that has something beside a diagonal of 0; 0: none. diagonal: (6,), m: (6, 6)."""
    for i in range(6):
        for j in range(6):
            if not diagonal[i] > 0.0 and (m[i, j] != 0.0 or m[j, i] != 0.0):
                return i + 1
    return 0


@kernel
def least_eigenvalue_scaled(diagonal, m, A, B):
    """Least eigenvalue of the symmetric part of a matrix, (6, 6), that is scaled to 1 on its diagonal.

    diagonal: (6,) of it, not negative; m: what is beside.  A, B: workspace, (6, 6).
    """
    bound = 0.0
    for i in range(6):
        total = 1.0
        for j in range(6):
            beside = 0.5 * (m[i, j] + m[j, i])
            A[i, j] = -beside / math.sqrt(diagonal[i] * diagonal[j]) if beside != 0.0 else 0.0
            total += abs(A[i, j])
        bound = max(bound, total)  # no eigenvalue is larger (Gershgorin)
    for i in range(6):
        A[i, i] = bound - (1.0 if diagonal[i] > 0.0 else 0.0)
    return bound - spectral_radius(A, B)


@kernel
def square_power(m, v):
    """Power v . (m |v| v) that quadratic drag takes; m: (6, 6), v: (6,)."""
    power = 0.0
    for i in range(6):
        for j in range(6):
            power += v[i] * m[i, j] * abs(v[j]) * v[j]
    return power


@kernel
def normalize(v):
    """A vector to length 1."""
    size = 0.0
    for i in range(v.size):
        size += v[i] * v[i]
    for i in range(v.size):
        v[i] /= math.sqrt(size)


@kernel
def least_square_power(diagonal, m, A, room, v):
    """Least power that quadratic drag takes at a velocity of length 1, of the matrix scaled to 1 on its diagonal; v: that velocity, scaled.

    Downhill from each of the directions between all axes, of which opposite ones have the same power. diagonal, m, A: as of
    `least_eigenvalue_scaled`; room: (2, 6).
    """
    for i in range(6):
        for j in range(6):
            A[i, j] = 1.0 if i == j and diagonal[i] > 0.0 else 0.0
            if m[i, j] != 0.0:
                A[i, j] += m[i, j] / (diagonal[i] ** (1.0 / 3.0) * diagonal[j] ** (2.0 / 3.0))
    least, slope, at = math.inf, room[0], room[1]
    for start in range(32):
        for i in range(6):
            at[i] = -1.0 if start >> i & 1 else 1.0
        normalize(at)
        for _ in range(DOWNWARDS):
            for i in range(6):
                slope[i] = 0.0
                for j in range(6):
                    slope[i] += A[i, j] * abs(at[j]) * at[j] + 2.0 * at[j] * A[j, i] * abs(at[i])
            for i in range(6):
                at[i] -= STEP * slope[i]
            normalize(at)
        power = square_power(A, at)
        if power < least:
            least = power
            for i in range(6):
                v[i] = at[i]
    return least


@kernel
def check_coupling(s, e, diagonal, A, B):
    """Fill `s.water`, (3, 6, 6), and refuse what is no water; s.added and diagonal: (6,), A, B: workspace, (6, 6). A status."""
    refused = s.refused
    if e.added_mass_coupling is not None:
        fill_masses(e.added_mass_coupling, s.water[0])
        refused[0] = lone(s.added, s.water[0])
        if refused[0] > 0.0:
            return LONE
        refused[0] = least_eigenvalue_scaled(s.added, s.water[0], A, B)
        if not refused[0] >= -PRINTED:
            return NEGATIVE_MASS
    if e.linear_drag_coupling is not None:
        fill_drag(e.linear_drag_coupling, s.water[1])
        six(e.linear_drag, diagonal)
        refused[0] = lone(diagonal, s.water[1])
        if refused[0] > 0.0:
            return LONE
        refused[0] = least_eigenvalue_scaled(diagonal, s.water[1], A, B)
        if not refused[0] >= -PRINTED:
            return DRIVING_DRAG
    if e.quadratic_drag_coupling is not None:
        fill_drag(e.quadratic_drag_coupling, s.water[2])
        six(e.quadratic_drag, diagonal)
        refused[0] = lone(diagonal, s.water[2])
        if refused[0] > 0.0:
            return LONE
        least = least_square_power(diagonal, s.water[2], A, B, refused[1:])
        if not least >= -PRINTED:
            refused[0] = -least
            for i in range(6):
                refused[1 + i] = refused[1 + i] / diagonal[i] ** (1.0 / 3.0) if diagonal[i] > 0.0 else 0.0
            return DRIVING_SQUARE
    return DONE
