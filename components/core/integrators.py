"""Ordinary differential equations, advanced by the classic Runge-Kutta method: kernels as templates.

A component supplies:

    start(t, s, p, e) -> status                 the state, and what follows from the parameters
    derivatives(t, x, u, dx, s, p, e)           x: (n,) state; u: (m,) inputs at t; dx: (n,) result
    outputs(t, s, p, e) -> status               s.y for s.x and s.u[0] at t
    stable(t, s, p, e) -> s                     longest internal step, s, at which the method is stable, behind `start`

and what `ode_kernels` makes of them. `s` has the fields of `OdeComponent.shapes`.

A component whose derivatives are steepest about rest, which is the state zero without inputs, needs no `stable`: it follows
from them. Its `s` has `slopes`, (2, n, n).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, ClassVar

from .contract import KernelComponent, Kernels, Refusal
from .kernels import DONE, NOT_FINITE, OWN, bind, hold_inputs, inlined, kernel
from .spectrum import spectral_radius, step_within

# |eigenvalue times step| up to which RK4 is stable at any damping: 2.62 at 124 degrees, 2.79 and 2.83 on the axes
RK4_STABILITY_RADIUS = 2.61
SMALL = 1e-6  # change of a state, in its unit, for the slopes of derivatives
SUBSTEP, STABLE = 0, 1  # of `s.limits`: internal step in use, longest stable one, s
SUBSTEP_TOO_LONG = OWN  # status


def start(t, s, p, e):
    """Placeholder that `bind` replaces."""
    raise NotImplementedError


def derivatives(t, x, u, dx, s, p, e):
    """Placeholder that `bind` replaces."""
    raise NotImplementedError


def outputs(t, s, p, e):
    """Placeholder that `bind` replaces."""
    raise NotImplementedError


def stable(t, s, p, e):
    """Placeholder that `bind` replaces."""
    raise NotImplementedError


def find_slopes(t, x, u, by, s, p, e):
    """d(dx/dt)/dx at x for the inputs u into s.slopes[0], by differences over `by`; dx/dt into s.work[2]."""
    n = x.size
    here, there, moved = s.work[2, :n], s.work[3, :n], s.work[4, :n]
    for j in range(-1, n):  # a loop, for the derivatives to stand in the machine code once
        for i in range(n):
            moved[i] = x[i]
        if j < 0:
            derivatives(t, moved, u, here, s, p, e)
        else:
            moved[j] += by
            derivatives(t, moved, u, there, s, p, e)
            for i in range(n):
                s.slopes[0, i, j] = (there[i] - here[i]) / by


@kernel
def resting(x, p, e):
    """Changes the state zero to one about which nothing holds that would hide a slope; here nothing does."""


def stable_about_rest(t, s, p, e):
    """Limit of RK4, radius / max |eigenvalue| of the derivatives about rest, s.

    The slopes are those to both sides on average: at a kink, such as that of a loss in a gear, one side alone has damping that the
    other takes back.
    """
    x, u, n = s.work[0, : s.x.size], s.work[1, : s.u.shape[1]], s.x.size
    x[:] = 0.0
    u[:] = 0.0
    resting(x, p, e)
    find_slopes(t, x, u, -SMALL, s, p, e)
    for i in range(n):
        for j in range(n):
            s.slopes[1, i, j] = s.slopes[0, i, j]
    find_slopes(t, x, u, SMALL, s, p, e)
    for i in range(n):
        for j in range(n):
            s.slopes[0, i, j] = 0.5 * (s.slopes[0, i, j] + s.slopes[1, i, j])
    return step_within(RK4_STABILITY_RADIUS, spectral_radius(s.slopes[0], s.slopes[1]))


stable_about_rest.parts = ("find_slopes",)  # type: ignore[attr-defined]


def ode_initialize(t, s, p, e):
    """The start, and the limit of the internal step: behind it a run with a unilateral contact stays finite, and is wrong.

    `start` may put another internal step than the parameter into s.limits[SUBSTEP].
    """
    s.limits[SUBSTEP] = p.substep
    status = start(t, s, p, e)
    if status != DONE:
        return status
    s.limits[STABLE] = stable(t, s, p, e)
    if s.limits[SUBSTEP] > s.limits[STABLE]:
        return SUBSTEP_TOO_LONG
    return DONE


def rk4_step(t, since, d, x, end, s, p, e):
    """One step of the classic fourth-order Runge-Kutta method, from x at t + since, over d, to `end`; both may be one array.

    Inputs are s.u[0] + s.u[1] r + s.u[2] r² at t + r.
    """
    nx, nu, u = x.size, s.u.shape[1], s.u
    xs, us = s.work[4, :nx], s.work[5, :nu]
    for stage in range(4):  # a loop, for the derivatives to stand in the machine code once
        r = since if stage == 0 else since + d if stage == 3 else since + 0.5 * d
        for j in range(nu):
            us[j] = u[0, j] + r * (u[1, j] + r * u[2, j])
        if stage == 0:
            for j in range(nx):
                xs[j] = x[j]
        else:
            share = d if stage == 3 else 0.5 * d
            for j in range(nx):
                xs[j] = x[j] + share * s.work[stage - 1, j]
        derivatives(t + since + d if stage == 3 else t + r, xs, us, s.work[stage, :nx], s, p, e)
    for j in range(nx):
        end[j] = x[j] + d / 6.0 * (s.work[0, j] + 2.0 * (s.work[1, j] + s.work[2, j]) + s.work[3, j])


def finished(t, h, s, p, e):
    """End of a step from t over h: the inputs that were reached, the outputs, and whether the state is finite."""
    hold_inputs(s.u, h)
    outputs(t + h, s, p, e)
    for j in range(s.x.size):
        if not math.isfinite(s.x[j]):
            return NOT_FINITE
    return DONE


def internal_steps(h, s):
    """Number of equal internal steps over h."""
    return max(1, math.ceil(h / s.limits[SUBSTEP] * (1.0 - 1e-9)))


def rk4(t, h, s, p, e):
    """A step: equal steps of the classic fourth-order Runge-Kutta method from t to t + h, then the outputs."""
    n = internal_steps(h, s)
    d = h / n
    for i in range(n):
        rk4_step(t, i * d, d, s.x, s.x, s, p, e)
    s.counts[0] += n
    s.counts[1] += 4 * n
    return finished(t, h, s, p, e)


rk4.parts = ("rk4_step", "finished", "internal_steps")  # type: ignore[attr-defined]


def ode_kernels(
    module: str,
    start: Any,
    derivatives: Any,
    outputs: Any,
    stable: Any = None,
    step: Any = rk4,
    resting: Any = resting,
    **more: Any,
) -> Kernels:
    """The kernels of an `OdeComponent`; module: its `__name__`, with something behind where a module has several such.

    stable: None where it follows from the derivatives about rest; resting(x, p, e) then changes the state zero where something
    holds there, such as a shaft that sticks.  step: a template of a step, and `more` the kernels that this needs besides.
    """
    inlined(derivatives)
    if stable is None:
        stable = bind(stable_about_rest, module, derivatives=derivatives, resting=resting)
    return Kernels(
        bind(ode_initialize, module, start=start, stable=stable),
        bind(step, module, derivatives=derivatives, outputs=outputs, **more),
        outputs,
        derivatives,
    )


class OdeComponent(KernelComponent):
    """A component that is an ordinary differential equation; a subclass gives `kernels` by `ode_kernels`, and `states`.

    It has a parameter `substep` in s, which is refused above the longest stable step.
    """

    method: str = "RK4"  # its name in messages
    rows: ClassVar[int] = 6  # of the workspace of a step
    _forced_step = 0.0
    refusals: ClassVar[Mapping[int, Refusal]] = {
        SUBSTEP_TOO_LONG: Refusal("substep = {limits[0]} s", "at most {limits[1]} s, the limit of {method}", "Reduce substep.")
    }

    def states(self) -> int:
        """Number of states, for the present structure."""
        raise NotImplementedError

    def columns(self) -> int:
        """Least length of the rows of workspace."""
        return 1

    def shapes(self) -> dict[str, Any]:
        """`limits`: internal step in use and longest stable one, s.  `work`: (rows, at least n and m)."""
        n = self.states()
        return {"x": n, "limits": 2, "work": (self.rows, max(n, self.u.shape[1], self.columns()))}

    def stable_step(self) -> float:
        """Longest internal step, s, at which the method is stable for the present parameters and inputs."""
        return self.of_initialization("limits", STABLE)

    def internal_step(self) -> float:
        """Longest internal step that it takes, s: the parameter, unless an effect asks for a shorter one."""
        return self.of_initialization("limits", SUBSTEP)

    def force_internal_step(self, h: float) -> None:
        """Take internal steps of h, s, stable or not: for measurements of the stability limit."""
        self._forced_step = h

    def _initialize(self, t: float) -> int:
        status = super()._initialize(t)
        if self._forced_step and status in (DONE, SUBSTEP_TOO_LONG):  # which is found out last
            self.arguments[0].limits[SUBSTEP], status = self._forced_step, DONE
        return status
