"""A linearly implicit integrator as a template, for stiff equations that are not to limit the step.

Besides `derivatives` and `outputs` (see integrators.py) a component supplies

    jacobian(t, x, u, band, p, *effects)        band: (n, 2 n - 1), d(dx[i])/d(x[j]) is added at band[i, n - 1 + j - i]

and binds `rodas3` to the three.
"""

from __future__ import annotations

import math

from .banded import factor_general, solve_general
from .kernels import DONE, NOT_FINITE, hold_inputs

GAMMA = 0.5


def derivatives(t, x, u, dx, p, *effects):
    """Placeholder that `bind` replaces."""
    raise NotImplementedError


def jacobian(t, x, u, band, p, *effects):
    """Placeholder that `bind` replaces."""
    raise NotImplementedError


def outputs(t, x, u, y, p, *effects):
    """Placeholder that `bind` replaces."""
    raise NotImplementedError


def rodas3(t, h, n, x, u, y, work, counts, p, *effects):
    """Rodas3: n equal steps from t to t + h, then the outputs; third order, L-stable, four stages, one factorisation a step.

    Stage i solves (1/(gamma d) - J) k_i = f(t + a_i d, x + sum a_ij k_j) + sum c_ij k_j / d + gamma_i d f_t. Linear
    invariants, such as a balance of energy whose terms are states, are kept to rounding. There are no exchanges of rows: the
    matrix must not need them, as that of a network of capacities and conductances does not.

    u: (3, m), inputs u[0] + u[1] s + u[2] s² at t + s.  work: (n + 7, max(2 n - 1, m)).  counts: steps, derivative calls.
    Source: Sandu et al., Atmos. Environ. 31 (1997) 3459-3472.
    """
    nx, nu = x.size, u.shape[1]
    band = work[:nx, : 2 * nx - 1]
    k1, k2, k3, k4, f, xs = (work[nx, :nx], work[nx + 1, :nx], work[nx + 2, :nx], work[nx + 3, :nx], work[nx + 4, :nx],
                             work[nx + 5, :nx])
    us = work[nx + 6, :nu]
    d = h / n
    instant = 1e-5 * d  # of the difference that gives f_t; its error is of that order of the next one's
    for i in range(n):
        s = i * d
        for j in range(nu):
            us[j] = u[0, j] + s * (u[1, j] + s * u[2, j])
        band[:, :] = 0.0
        jacobian(t + s, x, us, band, p, *effects)
        for j in range(nx):
            for k in range(2 * nx - 1):
                band[j, k] = -band[j, k]
            band[j, nx - 1] += 1.0 / (GAMMA * d)
        factor_general(band)
        derivatives(t + s, x, us, f, p, *effects)
        for j in range(nu):
            us[j] = u[0, j] + (s + instant) * (u[1, j] + (s + instant) * u[2, j])
        derivatives(t + s + instant, x, us, xs, p, *effects)
        for j in range(nx):
            change = (xs[j] - f[j]) * (d / instant)  # d f_t
            k1[j] = f[j] + 0.5 * change
            xs[j] = f[j] + 1.5 * change
        solve_general(band, k1)
        for j in range(nx):
            k2[j] = xs[j] + 4.0 * k1[j] / d
        solve_general(band, k2)
        for j in range(nu):
            us[j] = u[0, j] + (s + d) * (u[1, j] + (s + d) * u[2, j])
        for j in range(nx):
            xs[j] = x[j] + 2.0 * k1[j]
        derivatives(t + s + d, xs, us, k3, p, *effects)
        for j in range(nx):
            k3[j] += (k1[j] - k2[j]) / d
        solve_general(band, k3)
        for j in range(nx):
            xs[j] += k3[j]
        derivatives(t + s + d, xs, us, k4, p, *effects)
        for j in range(nx):
            k4[j] += (k1[j] - k2[j] - 8.0 / 3.0 * k3[j]) / d
        solve_general(band, k4)
        for j in range(nx):
            x[j] = xs[j] + k4[j]
    counts[0] += n
    counts[1] += 4 * n
    hold_inputs(u, h)
    outputs(t + h, x, u[0], y, p, *effects)
    for j in range(nx):
        if not math.isfinite(x[j]):
            return NOT_FINITE
    return DONE
