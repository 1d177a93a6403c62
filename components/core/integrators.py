"""Explicit integrators as templates: a component binds one to its own `derivatives` and `outputs`.

The kernels a component supplies:

    derivatives(t, x, u, dx, p, *effects)       x: (n,) state; u: (m,) inputs at t; dx: (n,) result
    outputs(t, x, u, y, p, *effects)            y: (k,) result

and what it gets back, `advance(t, h, n, x, u, y, work, counts, p, *effects) -> status`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from .component import Component
from .errors import BadInput
from .kernels import DONE, NOT_FINITE, hold_inputs

# |eigenvalue times step| up to which RK4 is stable at any damping: 2.62 at 124 degrees, 2.79 and 2.83 on the axes
RK4_STABILITY_RADIUS = 2.61


def derivatives(t, x, u, dx, p, *effects):
    """Placeholder that `bind` replaces."""
    raise NotImplementedError


def outputs(t, x, u, y, p, *effects):
    """Placeholder that `bind` replaces."""
    raise NotImplementedError


def rk4_step(t, s, d, x, end, u, work, p, *effects):
    """One step of the classic fourth-order Runge-Kutta method, from x at t + s to `end` at t + s + d; both may be one array.

    u: (3, m), inputs u[0] + u[1] s + u[2] s² at t + s.  work: (6, max(len(x), m)).
    """
    nx, nu = x.size, u.shape[1]
    k1, k2, k3, k4, xs = work[0, :nx], work[1, :nx], work[2, :nx], work[3, :nx], work[4, :nx]
    us = work[5, :nu]
    for j in range(nu):
        us[j] = u[0, j] + s * (u[1, j] + s * u[2, j])
    derivatives(t + s, x, us, k1, p, *effects)
    middle = s + 0.5 * d
    for j in range(nu):
        us[j] = u[0, j] + middle * (u[1, j] + middle * u[2, j])
    for j in range(nx):
        xs[j] = x[j] + 0.5 * d * k1[j]
    derivatives(t + middle, xs, us, k2, p, *effects)
    for j in range(nx):
        xs[j] = x[j] + 0.5 * d * k2[j]
    derivatives(t + middle, xs, us, k3, p, *effects)
    for j in range(nu):
        us[j] = u[0, j] + (s + d) * (u[1, j] + (s + d) * u[2, j])
    for j in range(nx):
        xs[j] = x[j] + d * k3[j]
    derivatives(t + s + d, xs, us, k4, p, *effects)
    for j in range(nx):
        end[j] = x[j] + d / 6.0 * (k1[j] + 2.0 * (k2[j] + k3[j]) + k4[j])


def rk4(t, h, n, x, u, y, work, counts, p, *effects):
    """The classic fourth-order Runge-Kutta method: n equal steps from t to t + h, then the outputs.

    u: (3, m), inputs u[0] + u[1] s + u[2] s² at t + s.  work: (6, max(len(x), m)).  counts: steps, derivative calls.
    """
    d = h / n
    for i in range(n):
        rk4_step(t, i * d, d, x, x, u, work, p, *effects)
    counts[0] += n
    counts[1] += 4 * n
    hold_inputs(u, h)
    outputs(t + h, x, u[0], y, p, *effects)
    for j in range(x.size):
        if not math.isfinite(x[j]):
            return NOT_FINITE
    return DONE


rk4.parts = ("rk4_step",)  # type: ignore[attr-defined]


class OdeComponent(Component):
    """A component that is an ordinary differential equation, advanced by a bound template.

    A subclass gives `advance` and `output_kernel` (kernels), `initial_state()`, `stable_step()`, and has a parameter
    `substep` in s, which is refused above the stable step.
    """

    method: str = "RK4"  # what messages call it
    advance: Callable[..., int]
    output_kernel: Callable[..., None]

    def kernel_arguments(self) -> tuple[Any, ...]:
        """What the kernels get as `p, *effects`. Override it to hand over what follows from the parameters instead of them."""
        return self._declared_arguments()

    def internal_step(self) -> float:
        """Longest internal step, s. Override it where an effect asks for a shorter one than the parameter `substep`."""
        return float(self.get("substep"))

    def initial_state(self) -> np.ndarray:
        """State at the start for the present inputs and `self.arguments`, shape (n,)."""
        raise NotImplementedError

    def _initialize(self, t: float) -> int:
        self._substep = self.internal_step()
        if self._substep > (limit := self.stable_step()):
            # with a unilateral contact the run would stay finite, and be wrong silently
            raise BadInput(self.name, f"substep = {self._substep:g} s", f"at most {limit:.3g} s, the limit of {self.method}",
                           "Reduce substep.")
        self.arguments = self.kernel_arguments()
        self.x = np.ascontiguousarray(self.initial_state(), dtype=float)
        self._work = np.zeros((6, max(self.x.size, self.u.shape[1], 1)))
        return DONE

    def _step(self, t: float, h: float) -> int:
        n = max(1, math.ceil(h / self._substep * (1.0 - 1e-9)))
        return type(self).advance(t, h, n, self.x, self.u, self.y, self._work, self.counts, *self.arguments)

    def _outputs(self, t: float) -> None:
        type(self).output_kernel(t, self.x, self.u[0], self.y, *self.arguments)
