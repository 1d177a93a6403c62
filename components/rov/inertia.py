"""Masses of the hull in kernels: matrices about the body's origin, (X, Y, Z, K, M, N)."""

from __future__ import annotations

import math

from ..core.kernels import DONE, kernel
from ..core.linear import solve_dense

THIRD = 2.0 * math.pi / 3.0


@kernel
def six(effect, row):
    """The six coefficients of an effect into row, (6,)."""
    row[0], row[1], row[2] = effect.surge, effect.sway, effect.heave
    row[3], row[4], row[5] = effect.roll, effect.pitch, effect.yaw


@kernel
def rigid_mass(p, matrix):
    """Mass matrix of the rigid body, (6, 6)."""
    m, x, y, z = p.mass, p.centre_of_gravity_x, p.centre_of_gravity_y, p.centre_of_gravity_z
    matrix[:] = 0.0
    matrix[0, 0], matrix[1, 1], matrix[2, 2] = m, m, m
    matrix[3, 3], matrix[4, 4], matrix[5, 5] = p.inertia_x, p.inertia_y, p.inertia_z
    matrix[0, 4], matrix[0, 5] = m * z, -m * y
    matrix[1, 3], matrix[1, 5] = -m * z, m * x
    matrix[2, 3], matrix[2, 4] = m * y, -m * x
    for i in range(3):
        for j in range(3, 6):
            matrix[j, i] = matrix[i, j]


@kernel
def least_moment(p):
    """Least principal moment of inertia about the centre of gravity, kg m²; not positive where no body has such numbers."""
    m, x, y, z = p.mass, p.centre_of_gravity_x, p.centre_of_gravity_y, p.centre_of_gravity_z
    a, b, c = p.inertia_x - m * (y * y + z * z), p.inertia_y - m * (x * x + z * z), p.inertia_z - m * (x * x + y * y)
    return least_eigenvalue(a, b, c, m * x * y, m * x * z, m * y * z)


@kernel
def least_eigenvalue(a, b, c, ab, ac, bc):
    """Least eigenvalue of a symmetric matrix, of its diagonal and what is beside it, in closed form."""
    beside = ab * ab + ac * ac + bc * bc
    if beside == 0.0:
        return min(a, b, c)
    mean = (a + b + c) / 3.0
    a, b, c = a - mean, b - mean, c - mean
    size = math.sqrt((a * a + b * b + c * c + 2.0 * beside) / 6.0)
    determinant = a * (b * c - bc * bc) - ab * (ab * c - bc * ac) + ac * (ab * bc - b * ac)
    turn = math.acos(min(max(0.5 * determinant / size**3, -1.0), 1.0)) / 3.0
    return mean + 2.0 * size * math.cos(turn + THIRD)


@kernel
def invert(matrix, added, inverse, A, b):
    """Inverse of a mass matrix, (6, 6), with added masses, (6,), on its diagonal; A, b: workspace; a status."""
    for k in range(6):
        for i in range(6):
            for j in range(6):
                A[i, j] = matrix[i, j]
            A[i, i] += added[i]
            b[i] = 1.0 if i == k else 0.0
        status = solve_dense(A, b)
        if status != DONE:
            return status
        for i in range(6):
            inverse[i, k] = b[i]
    return DONE
