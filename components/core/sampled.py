"""Controllers that look at their inputs at whole multiples of a period, and hold their outputs in between. Kernels as templates.

A component supplies:

    start(t, s, p, e) -> status                 the state before the first sample, and what follows from the parameters
    sample(t, u, s, p, e)                       u: (m,) inputs at t; changes s.x by one sample at time t
    outputs(t, s, p, e) -> status               s.y, what the last sample gave

`p` has the field `period`, s. The number of the next sample is the state's first element.
"""

from __future__ import annotations

import math
import sys
from typing import Any, ClassVar

from .contract import KernelComponent, Kernels
from .integrators import finished, start
from .kernels import DONE, bind, kernel

NEXT = 0  # of the state
UNCERTAIN = 4.0 * sys.float_info.epsilon  # of a time, which masters form as differences and sums of times


def sample(t, u, s, p, e):
    """Placeholder that `bind` replaces."""
    raise NotImplementedError


def sampled_initialize(t, s, p, e):
    """The start, and the sample at it."""
    status = start(t, s, p, e)
    if status != DONE:
        return status
    s.x[NEXT] = math.floor((t + 1e-9 * p.period + UNCERTAIN * abs(t)) / p.period) + 1.0
    sample(t, s.u[0], s, p, e)
    return DONE


def sampled(t, h, s, p, e):
    """All samples after t up to t + h, and the outputs; inputs at a sample's instant are those of their polynomials."""
    x, u = s.x, s.u
    now = s.work[0, : u.shape[1]]
    while x[NEXT] * p.period <= t + h + 1e-9 * p.period + UNCERTAIN * abs(t + h):
        since = min(max(x[NEXT] * p.period - t, 0.0), h)
        for j in range(u.shape[1]):
            now[j] = u[0, j] + since * (u[1, j] + since * u[2, j])
        sample(x[NEXT] * p.period, now, s, p, e)
        x[NEXT] += 1.0
        s.counts[1] += 1
    s.counts[0] += 1
    return finished(t, h, s, p, e)


sampled.parts = ("finished",)  # type: ignore[attr-defined]


@kernel
def integrated(integral, gain, error, back, period):
    """An integral after a sample; `back`: what a limit takes from it per time. Without gain it stays: nothing would refill it."""
    return integral + period * (gain * error + back) if gain > 0.0 else integral


def sampled_kernels(module: str, start: Any, sample: Any, outputs: Any) -> Kernels:
    """The kernels of a `SampledComponent`; module: its `__name__`."""
    return Kernels(
        bind(sampled_initialize, module, start=start, sample=sample),
        bind(sampled, module, sample=sample, outputs=outputs),
        outputs,
    )


class SampledComponent(KernelComponent):
    """A controller with a period; it samples at the start and at every whole multiple of the period.

    All outputs change at samples only: they are discrete, whatever their kind. A subclass gives `kernels` by `sampled_kernels`,
    and `states`.
    """

    holds_outputs: ClassVar[bool] = True
    counters: ClassVar[tuple[str, ...]] = ("steps", "samples")
    work_shape: ClassVar[tuple[int, int]] = (1, 1)  # the first row is the step's own

    def states(self) -> int:
        """Number of states, for the present structure."""
        raise NotImplementedError

    def shapes(self) -> dict[str, Any]:
        """`work`: as the class says, and at least as long as there are inputs."""
        rows, columns = self.work_shape
        return {"x": self.states(), "work": (rows, max(self.u.shape[1], columns))}


# -- tables over time as parameters: arrays with more rows than a time history may need -------------------------------------------
@kernel
def rows_in_use(time):
    """Number of rows before the time falls; those behind are unused, and zero."""
    n = 1
    while n < time.size and not time[n] < time[n - 1]:
        n += 1
    return n


@kernel
def is_zero_behind(column, rows):
    """Whether a column of a table is zero behind the rows in use."""
    largest = 0.0
    for i in range(rows, column.size):
        largest = max(largest, abs(column[i]))
    return largest == 0.0
