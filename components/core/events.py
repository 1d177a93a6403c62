"""Runge-Kutta with events: dry friction that sticks, stops, one-way clutches, valves.

Between events the equations are smooth; which ones hold is a mode, kept in the state as whole numbers whose derivative is
zero. Besides `derivatives` and `outputs` (see integrators.py) a component supplies

    guards(t, x, u, g, p, *effects)             g: (k,) result; each is positive as long as the present mode holds
    switch(which, t, x, u, p, *effects)         guard `which` has reached zero: puts the next mode into x; x may jump, too

and binds `rk4_events` to the four. A substep at whose end a guard is negative is cut where the first one changes sign, to the
last digits; the substep is resumed behind the event. A guard may rest at zero. After a switch it may, by rounding, be a little
less; if it stays less, `switch` is called again: a mode must be able to last. A guard that goes below zero and comes back within
a substep is not seen: the substep has to resolve the motion between events.
"""

from __future__ import annotations

import math
from typing import ClassVar

import numpy as np

from .integrators import OdeComponent, rk4_step
from .kernels import DONE, NOT_CONVERGED, NOT_FINITE, hold_inputs

MOST_EVENTS = 64  # in one substep, above which the modes chase each other
HALVINGS = 90  # of which two in three are more than the bits of a fraction
SHORTEST = 1e-6  # of a substep, that a mode has to last
ROWS = 9  # of the workspace


def derivatives(t, x, u, dx, p, *effects):
    """Placeholder that `bind` replaces."""
    raise NotImplementedError


def guards(t, x, u, g, p, *effects):
    """Placeholder that `bind` replaces."""
    raise NotImplementedError


def switch(which, t, x, u, p, *effects):
    """Placeholder that `bind` replaces."""
    raise NotImplementedError


def outputs(t, x, u, y, p, *effects):
    """Placeholder that `bind` replaces."""
    raise NotImplementedError


def lowest_guard(t, s, x, u, g, us, p, *effects):
    """(value, index) of the smallest guard at t + s."""
    for j in range(u.shape[1]):
        us[j] = u[0, j] + s * (u[1, j] + s * u[2, j])
    guards(t + s, x, us[: u.shape[1]], g, p, *effects)
    which = 0
    for i in range(1, g.size):
        if g[i] < g[which]:
            which = i
    return g[which], which


def rk4_events(t, h, n, k, x, u, y, work, counts, p, *effects):
    """The classic Runge-Kutta method with n equal substeps from t to t + h, cut at events; then the outputs.

    The instant of an event is found by false position (Illinois) and bisection on the length of the last step, the smallest
    of all guards being followed: it is where the first of them changes sign.

    k: number of guards.  u: (3, m), inputs u[0] + u[1] s + u[2] s² at t + s.  work: (ROWS, max(len(x), m, k)).
    counts: steps, derivative calls, events.
    """
    nx, nu = x.size, u.shape[1]
    end, g, us = work[6, :nx], work[7, :k], work[8, :]
    d = h / n
    for i in range(n):
        s, left, events = i * d, d, 0
        while left > 0.0:
            rk4_step(t, s, left, x, end, u, work, p, *effects)
            counts[1] += 4
            last, which = lowest_guard(t, s + left, end, u, g, us, p, *effects)
            if not last < 0.0:
                for j in range(nx):
                    x[j] = end[j]
                break
            low, cut = 0.0, left
            first, now = lowest_guard(t, s, x, u, g, us, p, *effects)
            while first <= 0.0 and cut > SHORTEST * left:  # just switched: does the guard rise before it falls?
                cut *= 0.5
                rk4_step(t, s, cut, x, end, u, work, p, *effects)
                counts[1] += 4
                low = cut
                first, now = lowest_guard(t, s + cut, end, u, g, us, p, *effects)  # it may be another that falls
            taken = 0.0
            if first >= 0.0:
                high, low_value, high_value, side = left, first, last, 0
                taken, cut = left, left
                for trial in range(HALVINGS):
                    narrow = 4e-16 * (abs(t) + s + high)
                    if high - low <= narrow:
                        break
                    cut = low + (high - low) * low_value / (low_value - high_value)
                    if trial % 3 > (1 if low_value > 0.0 else 0):  # from zero, as by a guard that rests there, more often
                        cut = 0.5 * (low + high)
                    cut = min(max(cut, low + 0.5 * narrow), high - 0.5 * narrow)  # else one end would stay where it is
                    rk4_step(t, s, cut, x, end, u, work, p, *effects)
                    counts[1] += 4
                    value, index = lowest_guard(t, s + cut, end, u, g, us, p, *effects)
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
                    rk4_step(t, s, high, x, end, u, work, p, *effects)
                    counts[1] += 4
                for j in range(nx):
                    x[j] = end[j]
            else:
                which = now
            for j in range(nu):
                us[j] = u[0, j] + (s + taken) * (u[1, j] + (s + taken) * u[2, j])
            switch(which, t + s + taken, x, us[:nu], p, *effects)
            counts[2] += 1
            events += 1
            if events > MOST_EVENTS:
                return NOT_CONVERGED
            s, left = s + taken, left - taken
    counts[0] += n
    hold_inputs(u, h)
    outputs(t + h, x, u[0], y, p, *effects)
    for j in range(nx):
        if not math.isfinite(x[j]):
            return NOT_FINITE
    return DONE


rk4_events.parts = ("rk4_step", "lowest_guard")  # type: ignore[attr-defined]


class EventComponent(OdeComponent):
    """An ordinary differential equation with modes, advanced by `rk4_events`.

    A subclass gives what an `OdeComponent` gives and `guards_count`, the number of its guards.
    """

    counters: ClassVar[tuple[str, ...]] = ("steps", "derivative_calls", "events")
    guards_count: ClassVar[int] = 1

    def _initialize(self, t: float) -> int:
        status = super()._initialize(t)
        self._work = np.zeros((ROWS, max(self.x.size, self.u.shape[1], self.guards_count)))
        return status

    def _step(self, t: float, h: float) -> int:
        n = max(1, math.ceil(h / self._substep * (1.0 - 1e-9)))
        return type(self).advance(t, h, n, self.guards_count, self.x, self.u, self.y, self._work, self.counts, *self.arguments)
