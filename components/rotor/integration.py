"""Implicit integration of a beam rotor: generalised-alpha method on banded matrices."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..core.banded import add_product, factor_general, solve_general
from ..core.generalized_alpha import Method
from ..core.kernels import DONE, NOT_FINITE, hold_inputs, kernel, kernel_tuple
from .ports import add_loads, add_tangents, follow_tangents, port_outputs
from .spin import acceleration_at, angle_after, speed_at


@kernel_tuple
class Solver(NamedTuple):
    """Matrices of one step length, factored for the speed and the tangents of the last step, and room to work."""

    effective: np.ndarray  # (N, 15) what a step solves with, at speed 0 and without ports
    by_velocity: np.ndarray  # (N, 15) times the velocity at the start of a step: its share of the right-hand side
    by_acceleration: np.ndarray  # (N, 15)
    factors: np.ndarray  # (N, 15)
    room: np.ndarray  # (2, N)
    speed: np.ndarray  # (1,) rad/s, for which `factors` holds; NaN: nothing is factored
    tangents: np.ndarray  # (k, 2, 4, 4) of the ports, for which `factors` holds


@kernel_tuple
class Imbalance(NamedTuple):
    """Unbalanced masses."""

    dof: np.ndarray  # (k,) int, of x; that of y is the next
    moment: np.ndarray  # (k,) kg.m, mass times eccentricity
    phase: np.ndarray  # (k,) rad, ahead of the rotor's angle


def make_solver(method: Method, mass, damping, stiffness, ports: int) -> Solver:
    """A solver for bands of mass, damping and stiffness, (N, 15) each."""
    d, am, af, gamma, beta = method.step, method.alpha_m, method.alpha_f, method.gamma, method.beta
    m, c, k = (1.0 - am) / (beta * d * d), (1.0 - af) * gamma / (beta * d), 1.0 - af
    v_v, v_a = velocity_shares(method)
    a_v, a_a = -(1.0 - am) / (beta * d), am - (1.0 - am) * (0.5 / beta - 1.0)
    N = mass.shape[0]
    return Solver(m * mass + c * damping + k * stiffness, -a_v * mass - v_v * damping, -a_a * mass - v_a * damping,
                  np.zeros_like(mass), np.zeros((2, N)), np.array([math.nan]), np.zeros((ports, 2, 4, 4)))


@kernel
def velocity_shares(method):
    """The velocity at which a step's forces are taken is v_v v + v_a a + the solved increment's share."""
    gamma_beta = method.gamma / method.beta
    v_v = method.alpha_f + (1.0 - method.alpha_f) * (1.0 - gamma_beta)
    return v_v, (1.0 - method.alpha_f) * method.step * (1.0 - 0.5 * gamma_beta)


@kernel
def advance_rotor(t, h, n, x, u, y, counts, speed, watched, stiffness, load, method, solver, ports, gyroscopic, circulatory,
                  imbalance, run_up):
    """n equal steps from t to t + h, then the outputs.

    x: displacement, velocity, acceleration, (N,) each, angle.  stiffness: (N, 15).  load: (N,) constant forces.
    gyroscopic, circulatory: (N, 15) per rad/s, or None.  counts: steps, factorizations.
    """
    N = load.size
    q, v, a = x[:N], x[N : 2 * N], x[2 * N : 3 * N]
    b, z = solver.room[0], solver.room[1]
    d, af, gamma, beta = method.step, method.alpha_f, method.gamma, method.beta
    v_v, v_a = velocity_shares(method)
    for step in range(n):
        start = t + step * d
        s = (step + 1.0 - af) * d
        now = speed_at(t + s, speed, run_up)
        if follow_tangents(s, ports, u, solver.tangents) or solver.speed[0] != now:
            factor(now, method, solver, ports, gyroscopic, circulatory)
            counts[1] += 1
        for j in range(N):
            b[j] = load[j]
            z[j] = -q[j]
        b[watched] += u[0, 0] + s * (u[1, 0] + s * u[2, 0])
        b[watched + 1] += u[0, 1] + s * (u[1, 1] + s * u[2, 1])
        add_product(stiffness, z, b)
        add_product(solver.by_velocity, v, b)
        if method.alpha_f < 0.5:  # the midpoint rule does without the acceleration
            add_product(solver.by_acceleration, a, b)
        for j in range(N):
            z[j] = v_v * v[j] + v_a * a[j]
        add_loads(s, ports, u, solver.tangents, q, z, b)
        if imbalance is not None:
            angle = angle_after(x[3 * N], start, (1.0 - af) * d, speed, run_up)
            add_imbalance(angle, now, acceleration_at(t + s, speed, run_up), imbalance, b)
        if gyroscopic is not None or circulatory is not None:
            for j in range(N):
                z[j] *= -now
            if gyroscopic is not None:
                add_product(gyroscopic, z, b)
            if circulatory is not None:
                for j in range(N):
                    z[j] = -now * q[j]
                add_product(circulatory, z, b)
        solve_general(solver.factors, b)
        for j in range(N):
            v_old, a_old = v[j], a[j]
            q[j] += b[j]
            v[j] = gamma / (beta * d) * b[j] + (1.0 - gamma / beta) * v_old + d * (1.0 - 0.5 * gamma / beta) * a_old
            a[j] = b[j] / (beta * d * d) - v_old / (beta * d) - (0.5 / beta - 1.0) * a_old
        x[3 * N] = angle_after(x[3 * N], start, d, speed, run_up)
    counts[0] += n
    hold_inputs(u, h)
    rotor_outputs(t + h, x, y, N, speed, watched, ports, run_up)
    total = 0.0
    for j in range(N):
        total += q[j]
    return DONE if math.isfinite(total) else NOT_FINITE


@kernel
def factor(speed, method, solver, ports, gyroscopic, circulatory):
    """Factors of the matrix of a step at this speed with the ports' present tangents."""
    k = 1.0 - method.alpha_f
    c = k * method.gamma / (method.beta * method.step)
    factors = solver.factors
    factors[:] = solver.effective
    if gyroscopic is not None:
        for j in range(factors.shape[0]):
            for i in range(factors.shape[1]):
                factors[j, i] += c * speed * gyroscopic[j, i]
    if circulatory is not None:
        for j in range(factors.shape[0]):
            for i in range(factors.shape[1]):
                factors[j, i] += k * speed * circulatory[j, i]
    add_tangents(ports, solver.tangents, k, c, factors)
    factor_general(factors)
    solver.speed[0] = speed


@kernel
def add_imbalance(angle, speed, acceleration, imbalance, b):
    """Add the inertia forces of masses that turn with the shaft, U (w² cos + w' sin, w² sin - w' cos)."""
    for k in range(imbalance.dof.size):
        cosine, sine = math.cos(angle + imbalance.phase[k]), math.sin(angle + imbalance.phase[k])
        j, U = imbalance.dof[k], imbalance.moment[k]
        b[j] += U * (speed * speed * cosine + acceleration * sine)
        b[j + 1] += U * (speed * speed * sine - acceleration * cosine)


@kernel
def rotor_outputs(t, x, y, N, speed, watched, ports, run_up):
    """Motion of the watched node (its first degree of freedom is given), speed and angle, then the ports."""
    now = speed_at(t, speed, run_up)
    y[0], y[1], y[2], y[3] = x[watched], x[watched + 1], x[N + watched], x[N + watched + 1]
    y[4], y[5] = now, x[3 * N]
    port_outputs(ports, x[:N], x[N : 2 * N], now, y)
