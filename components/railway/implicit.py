"""Implicit integration of the wires: generalised-alpha method with an active set for the slack droppers."""

from __future__ import annotations

import math

from ..core.banded import factor_band, solve_band
from ..core.generalized_alpha import generalized_alpha
from ..core.kernels import DONE, NOT_CONVERGED, NOT_FINITE, OUT_OF_RANGE, kernel
from .contact import add_contacts, contact_columns, contact_count, element_at, in_range
from .wires import WHISPER, tension_and_bending

MAX_ITERATIONS = 50  # of the active set in one step; 1 to 3 are usual


@kernel
def effective_band(method, stiffness, mesh, alpha, beta, band):
    """Band of the matrix that every step solves with, without droppers, into band (N, w); stiffness: of the wires, (N, w)."""
    h = method.step
    k = 1.0 - method.alpha_f
    m, c = (1.0 - method.alpha_m) / (method.beta * h**2), k * method.gamma / (method.beta * h)
    for i in range(band.shape[0]):
        for j in range(band.shape[1]):
            band[i, j] = (c * beta + k) * stiffness[i, j]
        mass = 0.0 if math.isinf(mesh.mass[i]) else mesh.mass[i]
        band[i, 0] += (m + c * alpha) * mass + c * mesh.ground_damping[i] + k * mesh.ground[i]


@kernel
def factor_with_droppers(band, factors, taut, weight, first, mesh):
    """Factors of `band` plus the taut droppers' stiffness times `weight`, rows from `first` on; taut: (d,) 0 or 1."""
    N = band.shape[0]
    for i in range(first, N - 2):  # element by element: a copy of arrays that might overlap would allocate
        for j in range(band.shape[1]):
            factors[i, j] = band[i, j]
    for k in range(mesh.dropper.size):
        j = 2 * mesh.dropper[k]
        if j >= first and taut[k] > 0.0:
            stiffness = weight * mesh.dropper_stiffness[k]
            factors[j, 0] += stiffness
            factors[j + 1, 0] += stiffness
            factors[j, 1] -= stiffness
    factor_band(factors, 2, first, N - 2)


@kernel
def implicit_steps(h, n, x, u, mesh, work, counts, radius, prepared, stiffness, band, factors, factored, slack, bending, damping,
                   second, further):
    """n equal generalised-alpha steps over h.  x: displacement, velocity, acceleration, (N,) each, contacts, taut (d,).

    radius: spectral, of `generalized_alpha`.  prepared: (1,) the step that `band` was computed for, s.
    factored: (d,) the droppers that `factors` holds as taut, or -1 where nothing is factored yet.
    The equation of motion holds at t + (1 - alpha_f) h for the displacement; a dropper is taut if its tension is positive there.
    """
    N, droppers = mesh.mass.size, mesh.dropper.size
    q, v, a, taut = x[:N], x[N : 2 * N], x[2 * N : 3 * N], x[x.size - droppers :]
    z, base, w, kink, b = work[0], work[1], work[2], work[3], work[4]
    d = h / n
    method = generalized_alpha(d, radius)
    am, af, gamma, beta_n = method.alpha_m, method.alpha_f, method.gamma, method.beta
    alpha, beta = 0.0, 0.0
    if damping is not None:
        alpha, beta = damping.alpha, damping.beta
    if d != prepared[0]:
        effective_band(method, stiffness, mesh, alpha, beta, band)
        prepared[0] = d
        factored[:] = -1.0
    v_v, v_a = af + (1.0 - af) * (1.0 - gamma / beta_n), (1.0 - af) * d * (1.0 - 0.5 * gamma / beta_n)
    a_v, a_a = -(1.0 - am) / (beta_n * d), am - (1.0 - am) * (0.5 / beta_n - 1.0)
    for step in range(n):
        s = (step + 1.0 - af) * d
        position = u[0, 0] + s * (u[1, 0] + s * u[2, 0])
        for k in range(contact_count(second, further)):
            at, _ = contact_columns(k, second, further)
            if not (in_range(u[0, at] + s * (u[1, at] + s * u[2, at]), mesh) and in_range(u[0, at], mesh)):
                return OUT_OF_RANGE
        for j in range(2, N - 2):
            velocity = v_v * v[j] + v_a * a[j]
            inertia = mesh.mass[j] * (a_v * v[j] + a_a * a[j] + alpha * velocity)
            base[j] = WHISPER - inertia - mesh.ground[j] * q[j] - mesh.ground_damping[j] * velocity
            z[j] = q[j] + beta * velocity
        tension_and_bending(z, w, kink, mesh.tension, mesh.curvature, mesh.bending_gradient, mesh.inverse_length, bending)
        for j in range(2, N - 2):
            base[j] += mesh.inverse_length[j] * (w[j + 2] - w[j]) - mesh.inverse_length[j - 2] * (w[j] - w[j - 2])
        add_contacts(s, u, base, mesh, second, further)

        for _ in range(MAX_ITERATIONS):
            first = N
            for k in range(droppers):
                if taut[k] != factored[k]:
                    first = min(first, 2 * mesh.dropper[k]) if factored[k] >= 0.0 else 2
                    factored[k] = taut[k]
            if first < N:
                factor_with_droppers(band, factors, taut, 1.0 - af, first, mesh)
                counts[2] += 1
            for j in range(2, N - 2):
                b[j] = base[j]
            for k in range(droppers):
                j = 2 * mesh.dropper[k]
                change = mesh.dropper_stiffness[k] * (q[j + 1] - q[j]) if taut[k] > 0.0 else -mesh.preload[k]
                b[j] += change
                b[j + 1] -= change
            solve_band(factors, b, 2, N - 2)
            counts[1] += 1
            changed = 0
            if slack is not None:
                for k in range(droppers):
                    j = 2 * mesh.dropper[k]
                    stretch = q[j + 1] - q[j] + (1.0 - af) * (b[j + 1] - b[j])
                    now = 1.0 if mesh.preload[k] + mesh.dropper_stiffness[k] * stretch > 0.0 else 0.0
                    if now != taut[k]:
                        taut[k] = now
                        changed += 1
            if changed == 0:
                break
        if changed > 0:
            return NOT_CONVERGED
        for j in range(2, N - 2):
            v_old, a_old = v[j], a[j]
            q[j] += b[j]
            v[j] = gamma / (beta_n * d) * b[j] + (1.0 - gamma / beta_n) * v_old + d * (1.0 - 0.5 * gamma / beta_n) * a_old
            a[j] = b[j] / (beta_n * d * d) - v_old / (beta_n * d) - (0.5 / beta_n - 1.0) * a_old
    counts[0] += n
    if not math.isfinite(q[2 * element_at(position, mesh)]):
        return NOT_FINITE
    return DONE
