"""Implicit integration of a beam rotor: generalised-alpha method on banded matrices.

A step solves A dq = f - K q + P v + R a for the change dq of the displacements. The matrices are those of the shaft, its disks
and supports, to which the present speed adds the gyroscopic and circulatory ones, and the bearings at the ports their tangents;
they are put together and factored anew only where speed or tangents have changed.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..core.banded import factor_general, solve_general
from ..core.generalized_alpha import generalized_alpha
from ..core.kernels import DONE, NOT_FINITE, hold_inputs, kernel, kernel_tuple
from .frame import add_frame_load, frame_outputs
from .model import HALF, WIDTH
from .ports import add_loads, add_tangents, follow_tangents, port_outputs
from .spin import acceleration_at, angle_after, speed_at

SYSTEM, STIFFNESS, BY_VELOCITY, BY_ACCELERATION = range(4)  # A, K, P and R in `Solver.fixed` and `Solver.now`


@kernel_tuple
class Solver(NamedTuple):
    """Matrices of one step length, and room to work; bands (N, 15)."""

    step: np.ndarray  # (1,) s, to which `fixed` belongs; NaN: to none
    fixed: np.ndarray  # (4, N, 15) at speed 0 and without ports
    now: np.ndarray  # (4, N, 15) of the last step; A as its factors
    room: np.ndarray  # (4, N + 14) right-hand side; displacement, velocity and acceleration between zeros
    speed: np.ndarray  # (1,) rad/s, to which `now` belongs; NaN: to none
    tangents: np.ndarray  # (k, 2, 4, 4) of the ports, to which `now` belongs


def make_solver(size: int, ports: int) -> Solver:
    """Room for a shaft of `size` degrees of freedom and so many ports; no step length yet."""
    fixed = np.zeros((4, size, WIDTH))
    return Solver(np.array([math.nan]), fixed, np.zeros_like(fixed), np.zeros((4, size + 2 * HALF)), np.array([math.nan]),
                  np.zeros((ports, 2, 4, 4)))


@kernel
def set_step(method, mass, damping, stiffness, solver):
    """Matrices of another step length, of bands of mass, damping and stiffness, (N, 15) each."""
    d, am, af, gamma, beta = method.step, method.alpha_m, method.alpha_f, method.gamma, method.beta
    m, c, k = (1.0 - am) / (beta * d * d), (1.0 - af) * gamma / (beta * d), 1.0 - af
    v_v, v_a = velocity_shares(method)
    a_v, a_a = -(1.0 - am) / (beta * d), am - (1.0 - am) * (0.5 / beta - 1.0)
    fixed = solver.fixed
    for i in range(mass.shape[0]):
        for j in range(mass.shape[1]):
            fixed[SYSTEM, i, j] = m * mass[i, j] + c * damping[i, j] + k * stiffness[i, j]
            fixed[STIFFNESS, i, j] = stiffness[i, j]
            fixed[BY_VELOCITY, i, j] = -a_v * mass[i, j] - v_v * damping[i, j]
            fixed[BY_ACCELERATION, i, j] = -a_a * mass[i, j] - v_a * damping[i, j]
    solver.step[0], solver.speed[0] = d, math.nan
    solver.tangents[:] = 0.0


@kernel
def velocity_shares(method):
    """The velocity at which a step's forces are taken is v_v v + v_a a and a share of dq / d."""
    gamma_beta = method.gamma / method.beta
    v_v = method.alpha_f + (1.0 - method.alpha_f) * (1.0 - gamma_beta)
    return v_v, (1.0 - method.alpha_f) * method.step * (1.0 - 0.5 * gamma_beta)


@kernel
def advance_rotor(t, h, n, x, u, y, counts, speed, radius, watched, load, mass, damping, stiffness, solver, ports, gyroscopic,
                  circulatory, imbalance, run_up, frame):
    """n equal steps from t to t + h, then the outputs.

    x: displacement, velocity, acceleration, (N,) each, angle.  radius: spectral, of `generalized_alpha`.  load: (N,) constant
    forces.  mass, damping, stiffness: (N, 15) bands.  gyroscopic, circulatory: (N, 15)
    per rad/s, or None.  imbalance: (k, 3) first degree of freedom, kg.m, rad; or None.  frame: `Frame` or None.
    counts: steps, factorizations.
    """
    N = load.size
    method = generalized_alpha(h / n, radius)
    if solver.step[0] != method.step:
        set_step(method, mass, damping, stiffness, solver)
    q, v, a = x[:N], x[N : 2 * N], x[2 * N : 3 * N]
    b = solver.room[0, :N]
    d, af, gamma, beta = method.step, method.alpha_f, method.gamma, method.beta
    for step in range(n):
        start = t + step * d
        s = (step + 1.0 - af) * d  # forces are taken here
        now = speed_at(t + s, speed, run_up)
        if follow_tangents(s, ports, u, solver.tangents) or solver.speed[0] != now:
            prepare(now, method, solver, ports, gyroscopic, circulatory)
            counts[1] += 1
        for j in range(N):
            b[j] = load[j]
        b[watched] += u[0, 0] + s * (u[1, 0] + s * u[2, 0])
        b[watched + 1] += u[0, 1] + s * (u[1, 1] + s * u[2, 1])
        add_loads(s, ports, u, b)
        if frame is not None:
            add_frame_load(s, now, frame, u, b)
        if imbalance is not None:
            angle = angle_after(x[3 * N], start, (1.0 - af) * d, speed, run_up)
            add_imbalance(angle, now, acceleration_at(t + s, speed, run_up), imbalance, b)
        add_history(solver, q, v, a, af < 0.5)  # the midpoint rule does without the acceleration
        solve_general(solver.now[SYSTEM], b)
        for j in range(N):
            v_old, a_old = v[j], a[j]
            q[j] += b[j]
            v[j] = gamma / (beta * d) * b[j] + (1.0 - gamma / beta) * v_old + d * (1.0 - 0.5 * gamma / beta) * a_old
            a[j] = b[j] / (beta * d * d) - v_old / (beta * d) - (0.5 / beta - 1.0) * a_old
        x[3 * N] = angle_after(x[3 * N], start, d, speed, run_up)
    counts[0] += n
    hold_inputs(u, h)
    rotor_outputs(t + h, x, u, y, N, speed, watched, ports, run_up, frame)
    total = 0.0
    for j in range(N):
        total += q[j]
    return DONE if math.isfinite(total) else NOT_FINITE


@kernel
def prepare(speed, method, solver, ports, gyroscopic, circulatory):
    """Matrices at this speed with the ports' present tangents, and the factors of A."""
    v_v, v_a = velocity_shares(method)
    k = 1.0 - method.alpha_f
    c = k * method.gamma / (method.beta * method.step)
    now, fixed = solver.now, solver.fixed
    for i in range(4):
        for j in range(now.shape[1]):
            for m in range(now.shape[2]):
                now[i, j, m] = fixed[i, j, m]
    if gyroscopic is not None:
        add_band(c * speed, gyroscopic, now[SYSTEM])
        add_band(-v_v * speed, gyroscopic, now[BY_VELOCITY])
        add_band(-v_a * speed, gyroscopic, now[BY_ACCELERATION])
    if circulatory is not None:
        add_band(k * speed, circulatory, now[SYSTEM])
        add_band(speed, circulatory, now[STIFFNESS])
    add_tangents(ports, solver.tangents, k, c, now[SYSTEM])
    add_tangents(ports, solver.tangents, 1.0, 0.0, now[STIFFNESS])
    add_tangents(ports, solver.tangents, 0.0, -v_v, now[BY_VELOCITY])
    add_tangents(ports, solver.tangents, 0.0, -v_a, now[BY_ACCELERATION])
    factor_general(now[SYSTEM])
    solver.speed[0] = speed


@kernel
def add_band(factor, band, result):
    """result += factor * band."""
    for i in range(band.shape[0]):
        for k in range(band.shape[1]):
            result[i, k] += factor * band[i, k]


@kernel
def add_history(solver, q, v, a, accelerated):
    """Add -K q + P v + R a to the right-hand side; the zeros around the vectors spare the loops their bounds."""
    N, room = q.size, solver.room
    K, P, R = solver.now[STIFFNESS], solver.now[BY_VELOCITY], solver.now[BY_ACCELERATION]
    for j in range(N):
        room[1, HALF + j], room[2, HALF + j] = q[j], v[j]
        if accelerated:
            room[3, HALF + j] = a[j]
    for i in range(N):
        value = 0.0
        for k in range(WIDTH):
            value += P[i, k] * room[2, i + k] - K[i, k] * room[1, i + k]
        if accelerated:
            for k in range(WIDTH):
                value += R[i, k] * room[3, i + k]
        room[0, i] += value


@kernel
def add_imbalance(angle, speed, acceleration, imbalance, b):
    """Add the inertia forces of masses that turn with the shaft, U (w² cos + w' sin, w² sin - w' cos)."""
    for k in range(imbalance.shape[0]):
        j, moment, phase = int(imbalance[k, 0]), imbalance[k, 1], imbalance[k, 2]
        cosine, sine = math.cos(angle + phase), math.sin(angle + phase)
        b[j] += moment * (speed * speed * cosine + acceleration * sine)
        b[j + 1] += moment * (speed * speed * sine - acceleration * cosine)


@kernel
def rotor_outputs(t, x, u, y, N, speed, watched, ports, run_up, frame):
    """Motion of the watched node (its first degree of freedom is given), speed and angle, then the ports and the frame."""
    now = speed_at(t, speed, run_up)
    y[0], y[1], y[2], y[3] = x[watched], x[watched + 1], x[N + watched], x[N + watched + 1]
    y[4], y[5] = now, x[3 * N]
    port_outputs(ports, x[:N], x[N : 2 * N], now, y)
    if frame is not None:
        frame_outputs(frame, ports, x[:N], x[N : 2 * N], u, y)
