"""Kernels of the hull: Newton-Euler equations about the body's origin, with everything the water adds."""

from __future__ import annotations

import math

from ..core.kernels import DONE, kernel
from ..core.linear import solve_dense
from ..core.rotation import quaternion_rate, to_body, to_world
from .coupling import times


class Righting:
    """The record `s.righting`: weight times its arm less buoyancy times its own, N.m."""

    x: float
    y: float
    z: float


@kernel
def water_velocity(x, u, current):
    """Velocity of the water in body axes, m/s."""
    if current is not None:
        i = current.u
        return to_body(x[3], x[4], x[5], x[6], u[i], u[i + 1], u[i + 2])
    return 0.0, 0.0, 0.0


@kernel
def tether_velocity(x, tether):
    """Velocity of the tether's attachment in body axes, m/s."""
    a, b, c = tether.attachment_x, tether.attachment_y, tether.attachment_z
    return x[7] + x[11] * c - x[12] * b, x[8] + x[12] * a - x[10] * c, x[9] + x[10] * b - x[11] * a


@kernel
def wrench(x, u, s, v, e):
    """Everything that accelerates the hull, (X, Y, Z, K, M, N): thrust, loads, Coriolis, drag and restoring forces.

    v: the parameters.
    """
    w, i, j, k = x[3], x[4], x[5], x[6]
    p, q, r = x[10], x[11], x[12]
    vx, vy, vz = x[7], x[8], x[9]
    X = Y = Z = K = M = N = 0.0
    T = s.thrusters
    for n in range(6):
        F = u[n]
        X, Y, Z = X + T[0, n] * F, Y + T[1, n] * F, Z + T[2, n] * F
        K, M, N = K + T[3, n] * F, M + T[4, n] * F, N + T[5, n] * F
    if e.further_thrusters is not None:
        for n in range(6, 8):
            F = u[e.further_thrusters.u + n - 6]
            X, Y, Z = X + T[0, n] * F, Y + T[1, n] * F, Z + T[2, n] * F
            K, M, N = K + T[3, n] * F, M + T[4, n] * F, N + T[5, n] * F
    cx, cy, cz = water_velocity(x, u, e.current)
    rx, ry, rz = vx - cx, vy - cy, vz - cz  # velocity through the water

    if e.coriolis is not None:
        gx, gy, gz = v.centre_of_gravity_x, v.centre_of_gravity_y, v.centre_of_gravity_z
        Px, Py, Pz = v.mass * (vx + q * gz - r * gy), v.mass * (vy + r * gx - p * gz), v.mass * (vz + p * gy - q * gx)
        Hx = v.inertia_x * p + v.mass * (gy * vz - gz * vy)
        Hy = v.inertia_y * q + v.mass * (gz * vx - gx * vz)
        Hz = v.inertia_z * r + v.mass * (gx * vy - gy * vx)
        X, Y, Z = X - (q * Pz - r * Py), Y - (r * Px - p * Pz), Z - (p * Py - q * Px)
        K -= q * Hz - r * Hy + vy * Pz - vz * Py
        M -= r * Hx - p * Hz + vz * Px - vx * Pz
        N -= p * Hy - q * Hx + vx * Py - vy * Px
        if e.added_mass is not None:
            added = e.added_mass
            Px, Py, Pz = added.surge * rx, added.sway * ry, added.heave * rz
            Hx, Hy, Hz = added.roll * p, added.pitch * q, added.yaw * r
            if e.added_mass_coupling is not None:
                a, b, c, d, f, g = times(s.water[0], rx, ry, rz, p, q, r)
                Px, Py, Pz, Hx, Hy, Hz = Px + a, Py + b, Pz + c, Hx + d, Hy + f, Hz + g
            X, Y, Z = X - (q * Pz - r * Py), Y - (r * Px - p * Pz), Z - (p * Py - q * Px)
            K -= q * Hz - r * Hy + ry * Pz - rz * Py
            M -= r * Hx - p * Hz + rz * Px - rx * Pz
            N -= p * Hy - q * Hx + rx * Py - ry * Px
    if e.linear_drag is not None:
        linear = e.linear_drag
        X, Y, Z = X - linear.surge * rx, Y - linear.sway * ry, Z - linear.heave * rz
        K, M, N = K - linear.roll * p, M - linear.pitch * q, N - linear.yaw * r
    if e.quadratic_drag is not None:
        square = e.quadratic_drag
        X, Y, Z = X - square.surge * abs(rx) * rx, Y - square.sway * abs(ry) * ry, Z - square.heave * abs(rz) * rz
        K, M, N = K - square.roll * abs(p) * p, M - square.pitch * abs(q) * q, N - square.yaw * abs(r) * r
    if e.linear_drag_coupling is not None:
        a, b, c, d, f, g = times(s.water[1], rx, ry, rz, p, q, r)
        X, Y, Z, K, M, N = X - a, Y - b, Z - c, K - d, M - f, N - g
    if e.quadratic_drag_coupling is not None:
        a, b, c, d, f, g = times(s.water[2], abs(rx) * rx, abs(ry) * ry, abs(rz) * rz, abs(p) * p, abs(q) * q, abs(r) * r)
        X, Y, Z, K, M, N = X - a, Y - b, Z - c, K - d, M - f, N - g
    if e.restoring is not None:
        dx, dy, dz = to_body(w, i, j, k, 0.0, 0.0, 1.0)  # downwards
        weight = e.restoring.weight - e.restoring.buoyancy  # in water
        X, Y, Z = X + weight * dx, Y + weight * dy, Z + weight * dz
        K += s.righting.y * dz - s.righting.z * dy
        M += s.righting.z * dx - s.righting.x * dz
        N += s.righting.x * dy - s.righting.y * dx
    if e.current is not None and e.added_mass is not None:
        n = e.current.u + 3
        ax, ay, az = to_body(w, i, j, k, u[n], u[n + 1], u[n + 2])
        if e.coriolis is not None:
            ax, ay, az = ax - (q * cz - r * cy), ay - (r * cx - p * cz), az - (p * cy - q * cx)
        X, Y, Z = X + e.added_mass.surge * ax, Y + e.added_mass.sway * ay, Z + e.added_mass.heave * az
        if e.added_mass_coupling is not None:
            a, b, c, d, f, g = times(s.water[0], ax, ay, az, 0.0, 0.0, 0.0)
            X, Y, Z, K, M, N = X + a, Y + b, Z + c, K + d, M + f, N + g
    if e.current is not None and e.pressure_gradient is not None:
        n = e.current.u + 3
        ax, ay, az = to_body(w, i, j, k, u[n], u[n + 1], u[n + 2])
        a, b, c = e.pressure_gradient.centre_x, e.pressure_gradient.centre_y, e.pressure_gradient.centre_z
        m = e.pressure_gradient.displaced_mass
        X, Y, Z = X + m * ax, Y + m * ay, Z + m * az
        K, M, N = K + m * (b * az - c * ay), M + m * (c * ax - a * az), N + m * (a * ay - b * ax)
    if e.tether is not None:
        n = e.tether.u
        fx, fy, fz = to_body(w, i, j, k, u[n], u[n + 1], u[n + 2])
        a, b, c = e.tether.attachment_x, e.tether.attachment_y, e.tether.attachment_z
        X, Y, Z = X + fx, Y + fy, Z + fz
        K, M, N = K + b * fz - c * fy, M + c * fx - a * fz, N + a * fy - b * fx
    if e.external is not None:
        n = e.external.u
        X, Y, Z = X + u[n], Y + u[n + 1], Z + u[n + 2]
        K, M, N = K + u[n + 3], M + u[n + 4], N + u[n + 5]
    return X, Y, Z, K, M, N


@kernel
def hull_derivatives(t, x, u, dx, s, p, e):
    """dx/dt of x = (position in world axes, quaternion, velocities in body axes, roll kept)."""
    w, i, j, k = x[3], x[4], x[5], x[6]
    dx[0], dx[1], dx[2] = to_world(w, i, j, k, x[7], x[8], x[9])
    dx[3], dx[4], dx[5], dx[6] = quaternion_rate(w, i, j, k, x[10], x[11], x[12])
    X, Y, Z, K, M, N = wrench(x, u, s, p, e)
    m = s.inverse
    for n in range(6):
        dx[7 + n] = m[n, 0] * X + m[n, 1] * Y + m[n, 2] * Z + m[n, 3] * K + m[n, 4] * M + m[n, 5] * N
    dx[13] = 0.0


# -- masses: matrices about the body's origin, (X, Y, Z, K, M, N) ----------------------------------------------------------
THIRD = 2.0 * math.pi / 3.0


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
def invert(matrix, added, beside, inverse, A, b):
    """Inverse of a mass matrix, (6, 6), with added masses, (6,), on its diagonal; A, b: workspace; a status.

    beside: (6, 6) added mass beside the diagonal, or None.
    """
    for k in range(6):
        for i in range(6):
            for j in range(6):
                A[i, j] = matrix[i, j]
                if beside is not None:
                    A[i, j] += beside[i, j]
            A[i, i] += added[i]
            b[i] = 1.0 if i == k else 0.0
        status = solve_dense(A, b)
        if status != DONE:
            return status
        for i in range(6):
            inverse[i, k] = b[i]
    return DONE
