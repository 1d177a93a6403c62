"""Sums over the signals of all macro steps, in machine code; in a file of its own, whose imports are what that depends on."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...components.core.kernels import kernel, kernel_tuple

TAIL = 3  # rows that the differences of the next ones need
PARTS = 4  # of a run, whose second differences are compared


@kernel_tuple
class Sums(NamedTuple):
    """Of S signals over the steps so far; arrays that `add_steps` adds to.

    rows: (TAIL, S), the last ones, the newest behind; first: the first one; peak: largest absolute value; total, total2: of
    the deviation from `first`, and of its square; missed: of squared errors of extrapolation; largest, before: the largest such
    error, and the one of the step before; last: of the last step; (S,) each.  seconds: (PARTS, S), of squared second differences.
    ticks: (TAIL,), of `rows`.  counts: (2 + PARTS,), steps, errors of extrapolation, second differences in each part.
    """

    rows: np.ndarray
    first: np.ndarray
    peak: np.ndarray
    total: np.ndarray
    total2: np.ndarray
    missed: np.ndarray
    largest: np.ndarray
    before: np.ndarray
    last: np.ndarray
    seconds: np.ndarray
    ticks: np.ndarray
    counts: np.ndarray

    @classmethod
    def zeros(cls, n: int) -> Sums:
        """Of n signals and no step."""
        numbers = {name: np.zeros(n) for name in cls._fields}
        return cls(**numbers | {"rows": np.zeros((TAIL, n)), "seconds": np.zeros((PARTS, n)),
                                "ticks": np.zeros(TAIL, dtype=np.int64), "counts": np.zeros(2 + PARTS, dtype=np.int64)})


@kernel
def add_steps(new, new_ticks, degree, part, sums):
    """Rows (k, S) behind k further steps, which end at `new_ticks`, to the sums; part: steps in a part of the run.

    A difference counts where the steps that it spans are equal.
    """
    rows, first, peak, total, total2, missed, largest, before, last, seconds, ticks, counts = sums
    signals = first.size
    for i in range(len(new)):
        steps, tick = counts[0], new_ticks[i]
        length = tick - ticks[2]
        even = steps > 1 and length == ticks[2] - ticks[1]
        predicted = steps > 0 if degree == 0 else even if degree == 1 else even and steps > 2 and length == ticks[1] - ticks[0]
        mine = min(steps // part, PARTS - 1)
        for k in range(signals):
            x, x1, x2, x3 = new[i, k], rows[2, k], rows[1, k], rows[0, k]
            if steps == 0:
                first[k] = x
            apart, slope, bend = x - first[k], x - x1, (x - x1) - (x1 - x2)
            total[k] += apart
            total2[k] += apart * apart
            peak[k] = max(peak[k], abs(x))
            if even:
                seconds[mine, k] += bend * bend
            if predicted:
                wrong = slope if degree == 0 else bend if degree == 1 else bend - ((x1 - x2) - (x2 - x3))
                missed[k] += wrong * wrong
                if abs(wrong) > largest[k]:
                    largest[k], before[k] = abs(wrong), last[k]
                last[k] = abs(wrong)
            rows[0, k], rows[1, k], rows[2, k] = x2, x1, x
        ticks[0], ticks[1], ticks[2] = ticks[1], ticks[2], tick
        counts[0] += 1
        counts[1] += predicted
        counts[2 + mine] += even
