"""Controllers that look at their inputs at whole multiples of a period, and hold their outputs in between.

The kernels a component supplies:

    sample(t, u, x, work, p, *effects)          u: (m,) inputs at t; x: (n,) state, changed by one sample at time t
    outputs(x, y)                               y: (k,) result, what the last sample gave

`p` has the field `period`, s. The number of the next sample is the state's first element.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, ClassVar

import numpy as np

from .component import Component
from .errors import BadInput
from .kernels import DONE, NOT_FINITE, hold_inputs, kernel

NEXT = 0  # of the state


def sample(t, u, x, work, p, *effects):
    """Placeholder that `bind` replaces."""
    raise NotImplementedError


def outputs(x, y):
    """Placeholder that `bind` replaces."""
    raise NotImplementedError


def sampled(t, h, u, x, y, work, counts, p, *effects):
    """All samples after t up to t + h, and the outputs; inputs at a sample's instant are those of their polynomials.

    u: (3, m), inputs u[0] + u[1] s + u[2] s² at t + s.  work: (rows, at least m), the first row is used.  counts: steps, samples.
    """
    now = work[0, : u.shape[1]]
    while x[NEXT] * p.period <= t + h + 1e-9 * p.period:
        s = min(max(x[NEXT] * p.period - t, 0.0), h)
        for j in range(u.shape[1]):
            now[j] = u[0, j] + s * (u[1, j] + s * u[2, j])
        sample(x[NEXT] * p.period, now, x, work, p, *effects)
        x[NEXT] += 1.0
        counts[1] += 1
    counts[0] += 1
    hold_inputs(u, h)
    outputs(x, y)
    for j in range(x.size):
        if not math.isfinite(x[j]):
            return NOT_FINITE
    return DONE


@kernel
def integrated(integral, gain, error, back, period):
    """An integral after a sample; `back`: what a limit takes from it per time. Without gain it stays: nothing would refill it."""
    return integral + period * (gain * error + back) if gain > 0.0 else integral


class SampledComponent(Component):
    """A controller with a period; it samples at the start and at every whole multiple of the period.

    A subclass gives `initial_state`, and binds `sample_kernel`, `output_kernel` and `advance` (of `sampled`) to its kernels.
    """

    counters: ClassVar[tuple[str, ...]] = ("steps", "samples")
    work_shape: ClassVar[tuple[int, int]] = (1, 1)
    sample_kernel: ClassVar[Callable[..., None]]
    output_kernel: ClassVar[Callable[..., None]]
    advance: ClassVar[Callable[..., int]]

    def kernel_arguments(self) -> tuple[Any, ...]:
        """What the kernels get as `p, *effects`."""
        return self._declared_arguments()

    def initial_state(self, t: float) -> np.ndarray:
        """State at the start for `self.arguments`, shape (n,), before the first sample; its first element is set afterwards."""
        raise NotImplementedError

    def _initialize(self, t: float) -> int:
        self.arguments = self.kernel_arguments()
        rows, columns = self.work_shape
        self._work = np.zeros((rows, max(self.u.shape[1], columns)))
        self.x = self.initial_state(t)
        return DONE

    def _start(self, t: float) -> int:
        self.x[NEXT] = math.floor(t / self.arguments[0].period * (1.0 + 1e-12)) + 1.0
        type(self).sample_kernel(t, self.u[0], self.x, self._work, *self.arguments)
        return DONE

    def _step(self, t: float, h: float) -> int:
        return type(self).advance(t, h, self.u, self.x, self.y, self._work, self.counts, *self.arguments)

    def _outputs(self, t: float) -> None:
        type(self).output_kernel(self.x, self.y)


def rows_in_use(where: str, time: np.ndarray, *columns: np.ndarray) -> np.ndarray:
    """Indices of the rows of a table over time, (n,), the last one in use repeated to the end.

    Rows behind the first fall of the time are unused, and zero; `BadInput` where one of them is not.
    """
    falls = np.flatnonzero(np.diff(time) < 0.0)
    end = int(falls[0]) if falls.size else time.size - 1
    if any(column[end + 1 :].any() for column in (time, *columns)):
        actual = f"time[{end + 1}] = {time[end]:g} s, then {time[end + 1]:g} s"
        raise BadInput(where, actual, "times that do not decrease, and zeros behind the last row")
    return np.minimum(np.arange(time.size), end)
