"""A Runge-Kutta method of order eight for smooth components, as an effect of theirs: few long internal steps at high accuracy.

Source: the eighth-order solution of DOP853, Hairer, Norsett & Wanner, Solving Ordinary Differential Equations I, 2nd ed. 1993,
coefficients as in SciPy's module of that name; without its error estimate, as the internal steps of a component are given.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from .component import Effect
from .integrators import RK4_STABILITY_RADIUS, OdeComponent
from .kernels import DONE, NOT_FINITE, hold_inputs

STABILITY_RADIUS = 5.9  # |eigenvalue times step|: 5.96 on the imaginary axis, 6.27 or more in the left half-plane
STAGES = 12
ROWS = STAGES + 2  # of the workspace
NODES = np.array([
    0.0, 0.05260015195876773, 0.0789002279381516, 0.1183503419072274, 0.2816496580927726, 0.3333333333333333, 0.25,
    0.3076923076923077, 0.6512820512820513, 0.6, 0.8571428571428571, 1.0,
])
WEIGHTS = np.array([
    0.054293734116568765, 0.0, 0.0, 0.0, 0.0, 4.450312892752409, 1.8915178993145003, -5.801203960010585, 0.3111643669578199,
    -0.1521609496625161, 0.20136540080403034, 0.04471061572777259,
])
MATRIX = np.array([
    [
        0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
    ],
    [
        0.05260015195876773, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
    ],
    [
        0.0197250569845379, 0.0591751709536137, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
    ],
    [
        0.02958758547680685, 0.0, 0.08876275643042054, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
    ],
    [
        0.2413651341592667, 0.0, -0.8845494793282861, 0.924834003261792, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
    ],
    [
        0.037037037037037035, 0.0, 0.0, 0.17082860872947386, 0.12546768756682242, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
    ],
    [
        0.037109375, 0.0, 0.0, 0.17025221101954405, 0.06021653898045596, -0.017578125, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
    ],
    [
        0.03709200011850479, 0.0, 0.0, 0.17038392571223998, 0.10726203044637328, -0.015319437748624402,
        0.008273789163814023, 0.0, 0.0, 0.0, 0.0, 0.0,
    ],
    [
        0.6241109587160757, 0.0, 0.0, -3.3608926294469414, -0.868219346841726, 27.59209969944671, 20.154067550477894,
        -43.48988418106996, 0.0, 0.0, 0.0, 0.0,
    ],
    [
        0.47766253643826434, 0.0, 0.0, -2.4881146199716677, -0.590290826836843, 21.230051448181193, 15.279233632882423,
        -33.28821096898486, -0.020331201708508627, 0.0, 0.0, 0.0,
    ],
    [
        -0.9371424300859873, 0.0, 0.0, 5.186372428844064, 1.0914373489967295, -8.149787010746927, -18.52006565999696,
        22.739487099350505, 2.4936055526796523, -3.0467644718982196, 0.0, 0.0,
    ],
    [
        2.273310147516538, 0.0, 0.0, -10.53449546673725, -2.0008720582248625, -17.9589318631188, 27.94888452941996,
        -2.8589982771350235, -8.87285693353063, 12.360567175794303, 0.6433927460157636, 0.0,
    ],
])  # fmt: skip


def derivatives(t, x, u, dx, p, *effects):
    """Placeholder that `bind` replaces."""
    raise NotImplementedError


def outputs(t, x, u, y, p, *effects):
    """Placeholder that `bind` replaces."""
    raise NotImplementedError


def rk8(t, h, n, x, u, y, work, counts, p, *effects):
    """n equal steps of order eight from t to t + h, then the outputs.

    u: (3, m), inputs u[0] + u[1] s + u[2] s² at t + s.  work: (ROWS, max(len(x), m)).  counts: steps, derivative calls.
    """
    nx, nu = x.size, u.shape[1]
    xs, us = work[STAGES, :nx], work[STAGES + 1, :nu]
    d = h / n
    for step in range(n):
        for i in range(STAGES):
            for j in range(nx):
                change = 0.0
                for k in range(i):
                    change += MATRIX[i, k] * work[k, j]
                xs[j] = x[j] + d * change
            s = (step + NODES[i]) * d
            for j in range(nu):
                us[j] = u[0, j] + s * (u[1, j] + s * u[2, j])
            derivatives(t + s, xs, us, work[i, :nx], p, *effects)
        for j in range(nx):
            change = 0.0
            for i in range(STAGES):
                change += WEIGHTS[i] * work[i, j]
            x[j] += d * change
    counts[0] += n
    counts[1] += STAGES * n
    hold_inputs(u, h)
    outputs(t + h, x, u[0], y, p, *effects)
    for j in range(nx):
        if not math.isfinite(x[j]):
            return NOT_FINITE
    return DONE


class HighOrder(Effect):
    """Internal steps of order eight instead of four; `substep` may be some ten times as long at the same accuracy.

    For smooth equations, and inputs that are smooth over a macro step: otherwise its order falls, and nothing is gained.
    """

    explicit_only = True


class SmoothComponent(OdeComponent):
    """An `OdeComponent` with the effect `high_order`; a subclass gives `advance_high_order`, `rk8` bound to its kernels."""

    high_order = HighOrder
    advance_high_order: Callable[..., int]

    @property
    def method(self) -> str:  # type: ignore[override]
        """What messages call the method."""
        return "the method of order eight" if "high_order" in self.on else "RK4"

    @property
    def stability_radius(self) -> float:
        """|eigenvalue times internal step| up to which the method is stable at any damping."""
        return STABILITY_RADIUS if "high_order" in self.on else RK4_STABILITY_RADIUS

    def _initialize(self, t: float) -> int:
        status = super()._initialize(t)
        if "high_order" in self.on:
            self._work = np.zeros((ROWS, max(self.x.size, self.u.shape[1], 1)))
        return status

    def _step(self, t: float, h: float) -> int:
        if "high_order" in self.on:
            n = max(1, math.ceil(h / self._substep * (1.0 - 1e-9)))
            return type(self).advance_high_order(t, h, n, self.x, self.u, self.y, self._work, self.counts, *self.arguments)
        return super()._step(t, h)
