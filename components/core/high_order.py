"""A Runge-Kutta method of order eight for smooth components, as an effect of theirs: few long internal steps at high accuracy.

Source: the eighth-order solution of DOP853, Hairer, Norsett & Wanner, Solving Ordinary Differential Equations I, 2nd ed. 1993,
coefficients as in SciPy's module of that name; without its error estimate, as the internal steps of a component are given.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from .component import Effect
from .contract import Kernels
from .events import rk4_events
from .integrators import RK4_STABILITY_RADIUS, OdeComponent, derivatives, finished, internal_steps, ode_kernels, rk4
from .kernels import bind, kernel

RK8_STABILITY_RADIUS = 5.9  # |eigenvalue times step|: 5.96 on the imaginary axis, 6.27 or more in the left half-plane
STAGES = 12
ROWS = STAGES + 2  # of the workspace
NODES = np.array(
    [
        0.0,
        0.05260015195876773,
        0.0789002279381516,
        0.1183503419072274,
        0.2816496580927726,
        0.3333333333333333,
        0.25,
        0.3076923076923077,
        0.6512820512820513,
        0.6,
        0.8571428571428571,
        1.0,
    ]
)
WEIGHTS = np.array(
    [
        0.054293734116568765,
        0.0,
        0.0,
        0.0,
        0.0,
        4.450312892752409,
        1.8915178993145003,
        -5.801203960010585,
        0.3111643669578199,
        -0.1521609496625161,
        0.20136540080403034,
        0.04471061572777259,
    ]
)
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


def rk8_steps(t, h, n, s, p, e):
    """n equal steps of order eight from t to t + h."""
    x, u, work = s.x, s.u, s.work
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
            since = (step + NODES[i]) * d
            for j in range(nu):
                us[j] = u[0, j] + since * (u[1, j] + since * u[2, j])
            derivatives(t + since, xs, us, work[i, :nx], s, p, e)
        for j in range(nx):
            change = 0.0
            for i in range(STAGES):
                change += WEIGHTS[i] * work[i, j]
            x[j] += d * change


def of_order_four(t, h, s, p, e):
    """Placeholder that `bind` replaces."""
    raise NotImplementedError


def smooth_step(t, h, s, p, e):
    """A step by the method that is on: equal internal steps of order eight and the outputs, or the step of order four."""
    if e.high_order is None:
        return of_order_four(t, h, s, p, e)
    n = internal_steps(h, s)
    rk8_steps(t, h, n, s, p, e)
    s.counts[0] += n
    s.counts[1] += STAGES * n
    return finished(t, h, s, p, e)


smooth_step.parts = ("rk8_steps", "finished", "internal_steps")  # type: ignore[attr-defined]


def smooth_kernels(module: str, *, step: Any = rk4, **ode: Any) -> Kernels:
    """The kernels of a `SmoothComponent`: those of `ode_kernels`, with both methods; step: the template of order four."""
    kernels = ode_kernels(module, step=step, **ode)
    own = {name: function for name, function in ode.items() if function is not None}
    return kernels._replace(step=bind(smooth_step, module, of_order_four=kernels.step, **own))


def smooth_event_kernels(module: str, **events: Any) -> Kernels:
    """The kernels of a `SmoothComponent` that is an `EventComponent`, too: its events exclude the high order."""
    return smooth_kernels(module, step=rk4_events, **events)._replace(derivatives=None)


@kernel
def stability_radius(e):
    """|eigenvalue times internal step| up to which the method that is on is stable at any damping."""
    return RK8_STABILITY_RADIUS if e.high_order is not None else RK4_STABILITY_RADIUS


class HighOrder(Effect):
    """Internal steps of order eight instead of four; `substep` may be some ten times as long at the same accuracy.

    For smooth equations, and inputs that are smooth over a macro step: otherwise its order falls, and nothing is gained.
    """

    explicit_only = True


class SmoothComponent(OdeComponent):
    """An `OdeComponent` with the effect `high_order`; its kernels are those of `smooth_kernels`, or of `smooth_event_kernels`."""

    high_order = HighOrder

    @property
    def method(self) -> str:  # type: ignore[override]
        """The name of the method in messages."""
        return "the method of order eight" if "high_order" in self.on else "RK4"

    def shapes(self) -> dict[str, Any]:
        """As of an `OdeComponent`, with the workspace of the method that is on."""
        shapes = super().shapes()
        rows, columns = shapes["work"]
        return shapes | {"work": (max(rows, ROWS) if "high_order" in self.on else rows, columns)}
