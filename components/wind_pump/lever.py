"""Mechanics of a floating lever between a crank, a mass and a pair of one-way clutches: accelerations and joint forces.

A massless lever carries the mass m at one end; a slider of mass m_y, with coordinate y, guides the other; the pin of a crank of
radius r and angle phi moves it in between. The arms are l2 from slider to crank pin and l1 = b l2 from there to the mass. With
small angles of the lever only the displacements across it count: s = r sin phi of the pin and, with a = 1 + b,

    x = a s - b y                                            of the mass,

    (J1 + m a² r² cos² phi) phi'' - m a b r cos phi y'' = T + m a² r² sin phi cos phi phi'²
    -m a b r cos phi phi'' + (m b² + m_y) y'' = -F - m a b r sin phi phi'²

T: torque on the crank, J1: its inertia, F: force of the clutches against the slider.
"""

from __future__ import annotations

import math

from ..core.kernels import kernel


@kernel
def lever_matrix(angle, rate, torque, p):
    """(m11, m12, m22, q1, q2) of the two equations above with F = 0."""
    sine, cosine = math.sin(angle), math.cos(angle)
    reach = (1.0 + p.lever_ratio) * p.crank_radius
    carried = p.lever_mass * reach * cosine
    rush = p.lever_mass * reach * sine * rate * rate
    return (
        p.crank_inertia + carried * reach * cosine,
        -p.lever_ratio * carried,
        p.lever_mass * p.lever_ratio**2 + p.slider_mass,
        torque + rush * reach * cosine,
        -p.lever_ratio * rush,
    )


@kernel
def free_lever(angle, rate, torque, force, p):
    """(phi'', y'') where the force F on the slider is known, N."""
    m11, m12, m22, q1, q2 = lever_matrix(angle, rate, torque, p)
    q2 -= force
    determinant = m11 * m22 - m12 * m12
    return (m22 * q1 - m12 * q2) / determinant, (m11 * q2 - m12 * q1) / determinant


@kernel
def engaged_lever(angle, rate, torque, side, load, p):
    """(phi'', y'', F) where the slider drives the driven shaft, y' = side * arm * speed, against the torque `load`, N.m."""
    m11, m12, m22, q1, q2 = lever_matrix(angle, rate, torque, p)
    carried = p.driven_inertia / p.clutch_arm**2
    q2 -= side * load / p.clutch_arm
    determinant = m11 * (m22 + carried) - m12 * m12
    y = (m11 * q2 - m12 * q1) / determinant
    return ((m22 + carried) * q1 - m12 * q2) / determinant, y, side * load / p.clutch_arm + carried * y


@kernel
def locked_lever(angle, rate, torque, p):
    """(phi'', F) where the slider cannot move: both clutches hold it, as the driven shaft stands."""
    m11, m12, _, q1, q2 = lever_matrix(angle, rate, torque, p)
    acceleration = q1 / m11
    return acceleration, q2 - m12 * acceleration


@kernel
def joint_forces(angle, rate, crank_acceleration, slider_acceleration, p):
    """Forces across the lever at its pins, N: (crank on lever, lever on mass, lever on slider).

    The displacements (phi, s, x, y) with s and x kept as coordinates have a diagonal mass matrix M and the constraints
    r sin phi - s = 0, a s - b y - x = 0, that is A q'' = gamma. The rows of M q'' + A^T lambda = Q for x, s and y are
    m x'' = lambda_2, lambda_1 = a lambda_2 and m_y y'' = b lambda_2 - F: linear relations once the motion is known.
    """
    a = 1.0 + p.lever_ratio
    pin = p.crank_radius * (math.cos(angle) * crank_acceleration - math.sin(angle) * rate * rate)
    on_mass = p.lever_mass * (a * pin - p.lever_ratio * slider_acceleration)
    return a * on_mass, on_mass, p.lever_ratio * on_mass
