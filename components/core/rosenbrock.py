"""A linearly implicit integrator as a template, for stiff equations that are not to limit the step.

Besides `start`, `derivatives` and `outputs` (see `integrators`) a component supplies

    jacobian(t, x, u, band, s, p, e)            band: (n, 2 n - 1), d(dx[i])/d(x[j]) is added at band[i, n - 1 + j - i]

and gets its kernels from `stiff_kernels`.
"""

from __future__ import annotations

import math
from typing import Any

from .contract import Kernels
from .integrators import OdeComponent, derivatives, finished, internal_steps, ode_kernels
from .kernels import kernel
from .linear import factor_general, solve_general

GAMMA = 0.5
ROWS = 7  # of the workspace, besides those of the matrix


def jacobian(t, x, u, band, s, p, e):
    """Placeholder that `bind` replaces."""
    raise NotImplementedError


@kernel
def unlimited(t, s, p, e):
    """Longest internal step, s, at which the method is stable."""
    return math.inf


def rodas3(t, h, s, p, e):
    """Rodas3: equal steps from t to t + h, then the outputs; third order, L-stable, four stages, one factorisation a step.

    Stage i solves (1/(gamma d) - J) k_i = f(t + a_i d, x + sum a_ij k_j) + sum c_ij k_j / d + gamma_i d f_t. Linear
    invariants, such as a balance of energy whose terms are states, are kept to rounding. There are no exchanges of rows: the
    matrix must not need them, as that of a network of capacities and conductances does not.
    Source: Sandu et al., Atmos. Environ. 31 (1997) 3459-3472.
    """
    x, u, work = s.x, s.u, s.work
    nx, nu = x.size, u.shape[1]
    band = work[:nx, : 2 * nx - 1]
    k1, k2, k3, k4, f, xs = (
        work[nx, :nx],
        work[nx + 1, :nx],
        work[nx + 2, :nx],
        work[nx + 3, :nx],
        work[nx + 4, :nx],
        work[nx + 5, :nx],
    )
    us = work[nx + 6, :nu]
    n = internal_steps(h, s)
    d = h / n
    instant = 1e-5 * d  # of the difference that gives f_t; its error is of that order of the next one's
    for i in range(n):
        since = i * d
        for j in range(nu):
            us[j] = u[0, j] + since * (u[1, j] + since * u[2, j])
        band[:, :] = 0.0
        jacobian(t + since, x, us, band, s, p, e)
        for j in range(nx):
            for k in range(2 * nx - 1):
                band[j, k] = -band[j, k]
            band[j, nx - 1] += 1.0 / (GAMMA * d)
        factor_general(band)
        derivatives(t + since, x, us, f, s, p, e)
        for j in range(nu):
            us[j] = u[0, j] + (since + instant) * (u[1, j] + (since + instant) * u[2, j])
        derivatives(t + since + instant, x, us, xs, s, p, e)
        for j in range(nx):
            change = (xs[j] - f[j]) * (d / instant)  # d f_t
            k1[j] = f[j] + 0.5 * change
            xs[j] = f[j] + 1.5 * change
        solve_general(band, k1)
        for j in range(nx):
            k2[j] = xs[j] + 4.0 * k1[j] / d
        solve_general(band, k2)
        for j in range(nu):
            us[j] = u[0, j] + (since + d) * (u[1, j] + (since + d) * u[2, j])
        for j in range(nx):
            xs[j] = x[j] + 2.0 * k1[j]
        derivatives(t + since + d, xs, us, k3, s, p, e)
        for j in range(nx):
            k3[j] += (k1[j] - k2[j]) / d
        solve_general(band, k3)
        for j in range(nx):
            xs[j] += k3[j]
        derivatives(t + since + d, xs, us, k4, s, p, e)
        for j in range(nx):
            k4[j] += (k1[j] - k2[j] - 8.0 / 3.0 * k3[j]) / d
        solve_general(band, k4)
        for j in range(nx):
            x[j] = xs[j] + k4[j]
    s.counts[0] += n
    s.counts[1] += 4 * n
    return finished(t, h, s, p, e)


rodas3.parts = ("finished", "internal_steps")  # type: ignore[attr-defined]


def stiff_kernels(module: str, start: Any, derivatives: Any, jacobian: Any, outputs: Any) -> Kernels:
    """The kernels of a `StiffComponent`; module: its `__name__`."""
    return ode_kernels(
        module, start=start, derivatives=derivatives, outputs=outputs, stable=unlimited, step=rodas3, jacobian=jacobian
    )


class StiffComponent(OdeComponent):
    """An `OdeComponent` whose internal step is a matter of accuracy alone; its kernels are those of `stiff_kernels`."""

    method = "Rodas3"

    def shapes(self) -> dict[str, Any]:
        """As of an `OdeComponent`, with the workspace of the method: the matrix's band, and vectors."""
        n = self.states()
        return super().shapes() | {"work": (n + ROWS, max(2 * n - 1, self.u.shape[1]))}
