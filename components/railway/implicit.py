"""Implicit integration of the wires: generalised-alpha method with an active set for the slack droppers."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..core.generalized_alpha import generalized_alpha
from ..core.kernels import DONE, NOT_CONVERGED, NOT_FINITE, OUT_OF_RANGE, kernel, kernel_tuple
from ..core.linear import factor_band, solve_band
from .contact import add_contact, element_at, in_range
from .gust_loads import LOADS, add_gusts, follow_gusts, gust_state
from .wires import DENORMAL_GUARD, add_jumps, state_rows, tension_and_bending

RIGID_CLAMP = 1e10  # N/m, of a clamp between two wires; 1e5 times the stiffness of an element
MAX_ITERATIONS = 50  # of the active set in one step; 1 to 3 are usual


@kernel_tuple
class Solver(NamedTuple):
    """Matrices of the method; stiffness of the wires, (N, w) N/m."""

    stiffness: np.ndarray
    band: np.ndarray  # (N, w) the matrix that every step solves with, without droppers
    factors: np.ndarray  # (N, w)
    factored: np.ndarray  # (d,) the droppers that `factors` holds as taut, or -1 where nothing is factored yet
    prepared: np.ndarray  # (1,) the step that `band` was computed for, s


@kernel
def start_solver(band, solver):
    """Nothing is factored yet; band: of all wires, (N, 3 W + 1) N/m."""
    for j in range(band.shape[0]):
        for k in range(solver.stiffness.shape[1]):
            solver.stiffness[j, k] = band[j, k]
    solver.factored[:] = -1.0
    solver.prepared[0] = 0.0


@kernel
def effective_band(method, stiffness, mesh, alpha, beta, gusts, band):
    """Band of the matrix that every step solves with, without droppers, into band (N, w); stiffness: of the wires, (N, w)."""
    h = method.step
    k = 1.0 - method.alpha_f
    m, c = (1.0 - method.alpha_m) / (method.beta * h**2), k * method.gamma / (method.beta * h)
    for i in range(band.shape[0]):
        for j in range(band.shape[1]):
            band[i, j] = (c * beta + k) * stiffness[i, j]
        mass = 0.0 if math.isinf(mesh.mass[i]) else mesh.mass[i]
        band[i, 0] += (m + c * alpha) * mass + c * mesh.ground_damping[i] + k * mesh.ground[i]
        if gusts is not None:
            band[i, 0] += c * gusts.push[0, i]
    for i in range(mesh.clamped.size):
        a, b = mesh.clamped[i], mesh.clamp[i]
        band[a, 0] += k * RIGID_CLAMP
        band[b, 0] += k * RIGID_CLAMP
        band[min(a, b), abs(a - b)] -= k * RIGID_CLAMP


@kernel
def factor_with_droppers(band, factors, taut, weight, first, mesh):
    """Factors of `band` plus the taut droppers' stiffness times `weight`, rows from `first` on; taut: (d,) 0 or 1."""
    N, W = band.shape[0], mesh.bending_gradient.size
    for i in range(first, N - W):  # element by element: a copy of arrays that might overlap would allocate
        for j in range(band.shape[1]):
            factors[i, j] = band[i, j]
    for k in range(mesh.dropper.size):
        a, b = mesh.lower[k], mesh.upper[k]
        if min(a, b) >= first and taut[k] > 0.0:
            stiffness = weight * mesh.dropper_stiffness[k]
            factors[a, 0] += stiffness
            factors[b, 0] += stiffness
            factors[min(a, b), abs(a - b)] -= stiffness
    factor_band(factors, W, first, N - W)


@kernel
def implicit_steps(t, h, n, motion, mesh, solver, radius, laws):
    """n equal generalised-alpha steps over h from the time t; motion, laws: see `wires`.

    motion.work: (5, N or more).
    radius: spectral, of `generalized_alpha`.
    The equation of motion holds at t + (1 - alpha_f) h for the displacement; a dropper is taut if its tension is positive there.
    """
    N, droppers, W = mesh.mass.size, mesh.dropper.size, mesh.bending_gradient.size
    x, u, points, work = motion.x, motion.u, motion.points, motion.work
    band, factors, factored = solver.band, solver.factors, solver.factored
    (q, v, a), taut = state_rows(x, N), x[x.size - droppers :]
    z, base, w, kink, b = work[0, :N], work[1, :N], work[2, :N], work[3, :N], work[4, :N]
    d = h / n
    method = generalized_alpha(d, radius)
    am, af, gamma, beta_n = method.alpha_m, method.alpha_f, method.gamma, method.beta
    alpha, beta = 0.0, 0.0
    if laws.damping is not None:
        alpha, beta = laws.damping.alpha, laws.damping.beta
    if d != solver.prepared[0]:
        effective_band(method, solver.stiffness, mesh, alpha, beta, motion.gusts, band)
        solver.prepared[0] = d
        factored[:] = -1.0
    v_v, v_a = af + (1.0 - af) * (1.0 - gamma / beta_n), (1.0 - af) * d * (1.0 - 0.5 * gamma / beta_n)
    a_v, a_a = -(1.0 - am) / (beta_n * d), am - (1.0 - am) * (0.5 / beta_n - 1.0)
    for step in range(n):
        s = (step + 1.0 - af) * d
        for k in range(points.shape[0]):
            i = points[k, 0]
            position = u[0, i] + s * (u[1, i] + s * u[2, i])
            if not (in_range(position, mesh) and in_range(u[0, i], mesh)):
                return OUT_OF_RANGE
        for j in range(W, N - W):
            velocity = v_v * v[j] + v_a * a[j]
            inertia = mesh.mass[j] * (a_v * v[j] + a_a * a[j] + alpha * velocity)
            base[j] = DENORMAL_GUARD - inertia - mesh.ground[j] * q[j] - mesh.ground_damping[j] * velocity
            if motion.gusts is not None:
                base[j] -= motion.gusts.push[0, j] * velocity
            z[j] = q[j] + beta * velocity
        tension_and_bending(z, w, kink, mesh.tension, mesh.curvature, mesh.bending_gradient, mesh.inverse_length, laws.bending)
        for j in range(W, N - W):
            base[j] += mesh.inverse_length[j] * (w[j + W] - w[j]) - mesh.inverse_length[j - W] * (w[j] - w[j - W])
        add_jumps(z, base, 0, mesh.jump.size, mesh)
        for k in range(mesh.clamped.size):
            pull = RIGID_CLAMP * (q[mesh.clamp[k]] - q[mesh.clamped[k]])
            base[mesh.clamped[k]] += pull
            base[mesh.clamp[k]] -= pull
        for k in range(points.shape[0]):
            i, f = points[k, 0], points[k, 1]
            load = u[0, f] + s * (u[1, f] + s * u[2, f])
            add_contact(u[0, i] + s * (u[1, i] + s * u[2, i]), load, base, points[k, 4], mesh)

        if motion.gusts is not None:
            loads = x[gust_state(points, mesh) :]
            share = follow_gusts(t + s, 0, N // W - 1, loads, mesh, motion.gusts)
            add_gusts(share, loads[LOADS : LOADS + N], loads[LOADS + N : LOADS + 2 * N], base)

        for _ in range(MAX_ITERATIONS):
            first = N
            for k in range(droppers):
                if taut[k] != factored[k]:
                    first = min(first, mesh.lower[k], mesh.upper[k]) if factored[k] >= 0.0 else W
                    factored[k] = taut[k]
            if first < N:
                factor_with_droppers(band, factors, taut, 1.0 - af, first, mesh)
                motion.counts[2] += 1
            for j in range(W, N - W):
                b[j] = base[j]
            for k in range(droppers):
                i, j = mesh.lower[k], mesh.upper[k]
                change = mesh.dropper_stiffness[k] * (q[j] - q[i]) if taut[k] > 0.0 else -mesh.preload[k]
                b[i] += change
                b[j] -= change
            solve_band(factors, b, W, N - W)
            motion.counts[1] += 1
            changed = 0
            if laws.slack is not None:
                for k in range(droppers):
                    i, j = mesh.lower[k], mesh.upper[k]
                    stretch = q[j] - q[i] + (1.0 - af) * (b[j] - b[i])
                    now = 1.0 if mesh.preload[k] + mesh.dropper_stiffness[k] * stretch > 0.0 else 0.0
                    if now != taut[k]:
                        taut[k] = now
                        changed += 1
            if changed == 0:
                break
        if changed > 0:
            return NOT_CONVERGED
        for j in range(W, N - W):
            v_old, a_old = v[j], a[j]
            q[j] += b[j]
            v[j] = gamma / (beta_n * d) * b[j] + (1.0 - gamma / beta_n) * v_old + d * (1.0 - 0.5 * gamma / beta_n) * a_old
            a[j] = b[j] / (beta_n * d * d) - v_old / (beta_n * d) - (0.5 / beta_n - 1.0) * a_old
    motion.counts[0] += n
    if motion.gusts is not None:  # the outputs are those at t + h
        follow_gusts(t + h, 0, N // W - 1, x[gust_state(points, mesh) :], mesh, motion.gusts)
    if not math.isfinite(q[W * element_at(position, mesh)]):
        return NOT_FINITE
    return DONE
