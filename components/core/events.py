"""Runge-Kutta with events: dry friction that sticks, stops, one-way clutches, valves. Kernels as templates.

Between events the equations are smooth; which ones hold is a mode, kept in the state as whole numbers whose derivative is
zero. Besides what an `OdeComponent` has (see `integrators`) a component supplies

    guards(t, x, u, g, s, p, e)                 g: (k,) result; each is positive as long as the present mode holds
    switch(which, t, x, u, s, p, e)             guard `which` has reached zero: puts the next mode into x; x may jump, too

and has the kernels of `event_kernels`. Where nothing that is on has events, `guards_count` is zero, `s.guards` is None, and steps
are those of `integrators.rk4`. A substep at whose end a guard is negative is cut where the first one changes sign, to the
last digits; the substep is resumed behind the event. A guard may rest at zero. After a switch it may, by rounding, be a little
less; if it stays less, `switch` is called again: a mode must be able to last. A guard that goes below zero and comes back within
a substep is not seen: the substep has to resolve the motion between events.
"""

from __future__ import annotations

from typing import Any, ClassVar

from .integrators import Kernels, OdeComponent, finished, internal_steps, ode_kernels, rk4_step
from .kernels import DONE, NOT_CONVERGED

MOST_EVENTS = 64  # in one substep, above which the modes chase each other
HALVINGS = 90  # of which two in three are more than the bits of a fraction
SHORTEST = 1e-6  # of a substep, that a mode has to last
ROWS = 9  # of the workspace


def guards(t, x, u, g, s, p, e):
    """Placeholder that `bind` replaces."""
    raise NotImplementedError


def switch(which, t, x, u, s, p, e):
    """Placeholder that `bind` replaces."""
    raise NotImplementedError


def lowest_guard(t, since, x, s, p, e):
    """(value, index) of the smallest guard at t + since."""
    g, us, m = s.guards, s.work[8], s.u.shape[1]
    for j in range(m):
        us[j] = s.u[0, j] + since * (s.u[1, j] + since * s.u[2, j])
    guards(t + since, x, us[:m], g, s, p, e)
    which = 0
    for i in range(1, g.size):
        if g[i] < g[which]:
            which = i
    return g[which], which


def event_steps(t, h, n, s, p, e):
    """n equal steps of the classic Runge-Kutta method from t to t + h, cut at events; the status.

    The instant of an event is found by false position (Illinois) and bisection on the length of the last step, the smallest
    of all guards being followed: it is where the first of them changes sign.
    """
    x, counts = s.x, s.counts
    nx, nu = x.size, s.u.shape[1]
    end, us = s.work[6, :nx], s.work[8]
    d = h / n
    for i in range(n):
        since, left, events = i * d, d, 0
        while left > 0.0:
            rk4_step(t, since, left, x, end, s, p, e)
            counts[1] += 4
            last, which = lowest_guard(t, since + left, end, s, p, e)
            if not last < 0.0:
                for j in range(nx):
                    x[j] = end[j]
                break
            low, cut = 0.0, left
            first, now = lowest_guard(t, since, x, s, p, e)
            while first <= 0.0 and cut > SHORTEST * left:  # just switched: does the guard rise before it falls?
                cut *= 0.5
                rk4_step(t, since, cut, x, end, s, p, e)
                counts[1] += 4
                low = cut
                first, now = lowest_guard(t, since + cut, end, s, p, e)  # it may be another that falls
            taken = 0.0
            if first >= 0.0:
                high, low_value, high_value, side = left, first, last, 0
                taken, cut = left, left
                for trial in range(HALVINGS):
                    narrow = 4e-16 * (abs(t) + since + high)
                    if high - low <= narrow:
                        break
                    cut = low + (high - low) * low_value / (low_value - high_value)
                    if trial % 3 > (1 if low_value > 0.0 else 0):  # from zero, as by a guard that rests there, more often
                        cut = 0.5 * (low + high)
                    cut = min(max(cut, low + 0.5 * narrow), high - 0.5 * narrow)  # else one end would stay where it is
                    rk4_step(t, since, cut, x, end, s, p, e)
                    counts[1] += 4
                    value, index = lowest_guard(t, since + cut, end, s, p, e)
                    if value < 0.0:
                        high, high_value, which = cut, value, index
                        if side == -1:
                            low_value *= 0.5
                        side = -1
                    else:
                        low, low_value = cut, value
                        if side == 1:
                            high_value *= 0.5
                        side = 1
                taken = high
                if cut != high:
                    rk4_step(t, since, high, x, end, s, p, e)
                    counts[1] += 4
                for j in range(nx):
                    x[j] = end[j]
            else:
                which = now
            for j in range(nu):
                us[j] = s.u[0, j] + (since + taken) * (s.u[1, j] + (since + taken) * s.u[2, j])
            switch(which, t + since + taken, x, us[:nu], s, p, e)
            counts[2] += 1
            events += 1
            if events > MOST_EVENTS:
                return NOT_CONVERGED
            since, left = since + taken, left - taken
    return DONE


event_steps.parts = ("lowest_guard",)  # type: ignore[attr-defined]


def rk4_events(t, h, s, p, e):
    """A step of the classic Runge-Kutta method, cut at events where there are guards; then the outputs."""
    n = internal_steps(h, s)
    if s.guards is not None:
        status = event_steps(t, h, n, s, p, e)
        if status != DONE:
            return status
    else:
        d = h / n
        for i in range(n):
            rk4_step(t, i * d, d, s.x, s.x, s, p, e)
        s.counts[1] += 4 * n
    s.counts[0] += n
    return finished(t, h, s, p, e)


rk4_events.parts = ("rk4_step", "event_steps", "finished", "internal_steps")  # type: ignore[attr-defined]


def event_kernels(module: str, *, guards: Any, switch: Any, step: Any = rk4_events, **ode: Any) -> Kernels:
    """The kernels of an `EventComponent`: those of `ode_kernels`, with guards and their switch."""
    return ode_kernels(module, step=step, guards=guards, switch=switch, **ode)._replace(derivatives=None)


class EventComponent(OdeComponent):
    """An ordinary differential equation with modes; a subclass gives what an `OdeComponent` gives and `guards_count`.

    `guards_count` may be a property that is zero where nothing that is on has events.
    """

    counters: ClassVar[tuple[str, ...]] = ("steps", "derivative_calls", "events")
    guards_count: int = 1
    rows = ROWS

    def columns(self) -> int:
        """Least length of the rows of workspace."""
        return max(self.guards_count, 1)

    def shapes(self) -> dict[str, Any]:
        """As of an `OdeComponent`; `guards`: (k,), or None."""
        return super().shapes() | {"guards": self.guards_count or None}
