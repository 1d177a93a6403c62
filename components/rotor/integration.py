"""Implicit integration of a beam rotor: generalised-alpha method on banded matrices.

A step solves A dq = f - K q + P v + R a for the change dq of the displacements. The matrices are those of the shaft, its disks
and supports, to which the present speed adds the gyroscopic and circulatory ones, and the bearings at the ports their tangents;
they are put together and factored anew only where speed or tangents have changed.
"""

from __future__ import annotations

import math

from ..core.generalized_alpha import generalized_alpha
from ..core.kernels import DONE, NOT_FINITE, hold_inputs, kernel
from ..core.linear import factor_general, solve_general
from .frame import add_frame_load, frame_outputs
from .model import DOFS, HALF, WIDTH, add_band
from .ports import add_loads, add_tangents, follow_tangents, port_outputs
from .spin import acceleration_at, angle_after, speed_at
from .supports import add_supports, follow_speed

NODES, WATCHED = 0, 1  # of `s.mesh`: number of nodes; first degree of freedom of the watched one
STEP, SPEED = 0, 1  # of `s.prepared`: step length in s to which `s.fixed` belongs and speed to which `s.now` does; NaN: to none
SYSTEM, STIFFNESS, BY_VELOCITY, BY_ACCELERATION = range(4)  # A, K, P and R in `s.fixed` and `s.now`


@kernel
def set_step(method, s):
    """Matrices of another step length."""
    d, am, af, gamma, beta = method.step, method.alpha_m, method.alpha_f, method.gamma, method.beta
    m, c, k = (1.0 - am) / (beta * d * d), (1.0 - af) * gamma / (beta * d), 1.0 - af
    v_v, v_a = velocity_shares(method)
    a_v, a_a = -(1.0 - am) / (beta * d), am - (1.0 - am) * (0.5 / beta - 1.0)
    fixed, mass, damping, stiffness = s.fixed, s.mass, s.damping, s.stiffness
    for i in range(DOFS * s.mesh[NODES]):
        for j in range(WIDTH):
            fixed[SYSTEM, i, j] = m * mass[i, j] + c * damping[i, j] + k * stiffness[i, j]
            fixed[STIFFNESS, i, j] = stiffness[i, j]
            fixed[BY_VELOCITY, i, j] = -a_v * mass[i, j] - v_v * damping[i, j]
            fixed[BY_ACCELERATION, i, j] = -a_a * mass[i, j] - v_a * damping[i, j]
    if s.spans is None:
        hold(s.supports, c, k, v_v, v_a, fixed)
    s.prepared[STEP], s.prepared[SPEED] = d, math.nan
    s.tangents[:] = 0.0


@kernel
def hold(supports, c, k, v_v, v_a, bands):
    """Add the supports to A, K, P and R."""
    add_supports(supports, k, c, bands[SYSTEM])
    add_supports(supports, 1.0, 0.0, bands[STIFFNESS])
    add_supports(supports, 0.0, -v_v, bands[BY_VELOCITY])
    add_supports(supports, 0.0, -v_a, bands[BY_ACCELERATION])


@kernel
def velocity_shares(method):
    """The velocity at which a step's forces are taken is v_v v + v_a a and a share of dq / d."""
    gamma_beta = method.gamma / method.beta
    v_v = method.alpha_f + (1.0 - method.alpha_f) * (1.0 - gamma_beta)
    return v_v, (1.0 - method.alpha_f) * method.step * (1.0 - 0.5 * gamma_beta)


@kernel
def rotor_step(t, h, s, p, e):
    """Equal steps not longer than the parameter says, from t to t + h, then the outputs."""
    N, x, u = DOFS * s.mesh[NODES], s.x, s.u
    n = max(1, math.ceil(h / p.substep * (1.0 - 1e-9)))
    method = generalized_alpha(h / n, p.spectral_radius)
    if s.prepared[STEP] != method.step:
        set_step(method, s)
    q, v, a = x[:N], x[N : 2 * N], x[2 * N : 3 * N]
    b, system = s.room[0, :N], s.now[SYSTEM, :N]
    d, af, gamma, beta = method.step, method.alpha_f, method.gamma, method.beta
    for step in range(n):
        start = t + step * d
        since = (step + 1.0 - af) * d  # forces are taken here
        speed = speed_at(t + since, p.start_speed, e.run_up)
        if follow_tangents(since, s.ports, u, s.tangents) or s.prepared[SPEED] != speed:
            prepare(speed, method, s)
            s.counts[1] += 1
        for j in range(N):
            b[j] = s.load[j]
        watched = s.mesh[WATCHED]
        b[watched] += u[0, 0] + since * (u[1, 0] + since * u[2, 0])
        b[watched + 1] += u[0, 1] + since * (u[1, 1] + since * u[2, 1])
        add_loads(since, s.ports, u, b)
        if e.frame_rotation is not None:
            add_frame_load(since, speed, s, e.frame_rotation, b)
        if s.imbalance is not None:
            angle = angle_after(x[3 * N], start, (1.0 - af) * d, p.start_speed, e.run_up)
            add_imbalance(angle, speed, acceleration_at(t + since, p.start_speed, e.run_up), s.imbalance, b)
        add_history(s, q, v, a, af < 0.5)  # the midpoint rule does without the acceleration
        solve_general(system, b)
        for j in range(N):
            v_old, a_old = v[j], a[j]
            q[j] += b[j]
            v[j] = gamma / (beta * d) * b[j] + (1.0 - gamma / beta) * v_old + d * (1.0 - 0.5 * gamma / beta) * a_old
            a[j] = b[j] / (beta * d * d) - v_old / (beta * d) - (0.5 / beta - 1.0) * a_old
        x[3 * N] = angle_after(x[3 * N], start, d, p.start_speed, e.run_up)
    s.counts[0] += n
    hold_inputs(u, h)
    rotor_outputs(t + h, s, p, e)
    total = 0.0
    for j in range(N):
        total += q[j]
    return DONE if math.isfinite(total) else NOT_FINITE


@kernel
def prepare(speed, method, s):
    """Matrices at this speed with the ports' present tangents, and the factors of A."""
    N, now, fixed = DOFS * s.mesh[NODES], s.now, s.fixed
    v_v, v_a = velocity_shares(method)
    k = 1.0 - method.alpha_f
    c = k * method.gamma / (method.beta * method.step)
    for i in range(4):
        for j in range(N):
            for m in range(WIDTH):
                now[i, j, m] = fixed[i, j, m]
    if s.gyroscopic is not None:
        add_band(c * speed, s.gyroscopic[:N], now[SYSTEM])
        add_band(-v_v * speed, s.gyroscopic[:N], now[BY_VELOCITY])
        add_band(-v_a * speed, s.gyroscopic[:N], now[BY_ACCELERATION])
    if s.circulatory is not None:
        add_band(k * speed, s.circulatory[:N], now[SYSTEM])
        add_band(speed, s.circulatory[:N], now[STIFFNESS])
    if s.spans is not None:
        follow_speed(speed, s)
        hold(s.supports, c, k, v_v, v_a, now)
    add_tangents(s.ports, s.tangents, k, c, now[SYSTEM])
    add_tangents(s.ports, s.tangents, 1.0, 0.0, now[STIFFNESS])
    add_tangents(s.ports, s.tangents, 0.0, -v_v, now[BY_VELOCITY])
    add_tangents(s.ports, s.tangents, 0.0, -v_a, now[BY_ACCELERATION])
    factor_general(now[SYSTEM, :N])
    s.prepared[SPEED] = speed


@kernel
def add_history(s, q, v, a, accelerated):
    """Add -K q + P v + R a to the right-hand side; the zeros around the vectors spare the loops their bounds."""
    N, room = q.size, s.room
    K, P, R = s.now[STIFFNESS], s.now[BY_VELOCITY], s.now[BY_ACCELERATION]
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
    """Add the inertia forces of masses that turn with the shaft, U (w² cos + w' sin, w² sin - w' cos).

    imbalance: (k, 3) first degree of freedom, kg.m, rad.
    """
    for k in range(imbalance.shape[0]):
        j, moment, phase = int(imbalance[k, 0]), imbalance[k, 1], imbalance[k, 2]
        if moment != 0.0:
            cosine, sine = math.cos(angle + phase), math.sin(angle + phase)
            b[j] += moment * (speed * speed * cosine + acceleration * sine)
            b[j + 1] += moment * (speed * speed * sine - acceleration * cosine)


@kernel
def rotor_outputs(t, s, p, e):
    """Motion of the watched node, speed and angle, then the ports and the frame."""
    N, x, y, watched = DOFS * s.mesh[NODES], s.x, s.y, s.mesh[WATCHED]
    now = speed_at(t, p.start_speed, e.run_up)
    y[0], y[1], y[2], y[3] = x[watched], x[watched + 1], x[N + watched], x[N + watched + 1]
    y[4], y[5] = now, x[3 * N]
    port_outputs(s.ports, x[:N], x[N : 2 * N], now, y)
    if e.frame_rotation is not None:
        if s.spans is not None:
            follow_speed(now, s)
        frame_outputs(s, e.frame_rotation, x[:N], x[N : 2 * N])
    return DONE
