"""Statistics of signals over the macro steps of a run, one step after the other: what needs no whole signal.

A block of its own beside that of the master, so that a scene without such quantities has none of it. All samples have the same weight, as
in a recorded signal. Mean and squares by Welford's update, which loses no digits where a signal is small beside its mean (B. P.
Welford, Technometrics 4, 1962, 419-420).
"""

from __future__ import annotations

from collections import namedtuple
from collections.abc import Mapping
from math import sqrt
from typing import Any

import numpy as np

from ....components.core.kernels import kernel, kernel_tuple
from ...units.calls import load

NEAR = 1.0 - 1e-12  # of the transient: rounding of a time that ends there
COUNT, SQUARES, MEAN, DEVIATION, LOW, HIGH = range(6)  # samples; sum of the squared deviations from the mean; the statistics
COLUMNS = {"mean": MEAN, "standard deviation": DEVIATION, "minimum": LOW, "maximum": HIGH}  # by the kind of a quantity
# at: (n,) addresses of the signals' numbers; values: (n, 6), zero at the start; transient: (1,) s, behind which samples count
RunningStatistics = kernel_tuple(namedtuple("RunningStatistics", "at values transient"))  # type: ignore[misc]


def statistics_of(signals: int, transient: float) -> Any:
    """What the kernel works on, for so many signals."""
    return RunningStatistics(np.zeros(signals, dtype=np.int64), np.zeros((signals, 6)), np.array([transient]))


@kernel
def take_figures(t, h, f):
    """The sample of the instant t; up to the transient the figures are those of the present sample alone."""
    counts = t >= f.transient[0] * NEAR
    for k in range(f.at.size):
        x, values = load(f.at[k]), f.values[k]
        if not counts or values[COUNT] == 0.0:
            values[COUNT], values[SQUARES], values[MEAN], values[LOW], values[HIGH] = 0.0, 0.0, x, x, x
        if counts:
            values[COUNT] += 1.0
            away = x - values[MEAN]
            values[MEAN] += away / values[COUNT]
            values[SQUARES] += away * (x - values[MEAN])
            values[LOW], values[HIGH] = min(values[LOW], x), max(values[HIGH], x)
        values[DEVIATION] = sqrt(values[SQUARES] / max(values[COUNT], 1.0))
    return 0


KERNELS: Mapping[str, Any] = {"take_figures": take_figures}
