"""CPU times that can be compared: checked against one another when they are measured, and carried from machine to machine.

A time that another measurement of the same thing does not confirm says something of the machine's load and nothing of the
setting; it is measured again, and refused if the measurements still differ. CPU time is not lengthened by programs that take
turns on the processor, but by those that share its caches and clock.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import inf, isnan, nan, sin
from statistics import median as median_of
from time import process_time

import numpy as np

SCATTER = 0.2  # of the smallest time, by which the next one may be longer
ATTEMPTS = 6  # measurements until a time is refused
STEPS = 10000  # of the calibration workload: some 20 ms
CALIBRATIONS = 5


@dataclass(frozen=True)
class Timing:
    """Measured times of one thing, s. seconds: the smallest.  spread: largest minus smallest.

    scatter: the second smallest over the smallest, minus 1. Both are NaN for a single measurement, which nothing confirms.
    """

    seconds: float
    median: float
    spread: float
    scatter: float

    @property
    def confirmed(self) -> bool:
        """Whether two measurements agree within `SCATTER`."""
        return self.scatter <= SCATTER


def timing_of(times: Sequence[float]) -> Timing:
    """Of at least one measured time, s."""
    first, *rest = sorted(times)
    scatter = (rest[0] / first - 1.0 if first > 0.0 else inf) if rest else nan
    return Timing(first, median_of(times), max(times) - first if rest else nan, scatter)


def repeated(measure: Callable[[], float], *, repeats: int, patience: float = inf, confirm: bool = True) -> Timing:
    """Times that `measure` gives, s: `repeats` of them, fewer where they take more than `patience` seconds together.

    confirm: at least two, and up to `ATTEMPTS` while no two agree.
    """
    times: list[float] = []

    def needed() -> bool:
        if not times or (len(times) < repeats and sum(times) < patience):
            return True
        return confirm and (len(times) < 2 or (len(times) < ATTEMPTS and not timing_of(times).confirmed))

    while needed():
        times.append(measure())
    return timing_of(times)


def workload() -> float:
    """A fixed amount of work like that of a stepping loop: a few numbers in plain Python, small arrays in NumPy."""
    x, v, h = 1.0, 0.0, 1e-2
    matrix, state = np.eye(8) * 0.5 + 0.05, np.linspace(0.0, 1.0, 8)
    for k in range(STEPS):
        for _ in range(4):
            force = -x - 0.1 * v - 0.2 * x * x * x + 0.3 * sin(h * k)
            v += 0.25 * h * force
            x += 0.25 * h * v
        state = matrix @ state
        state[0] = x
    return x + float(state.sum())


def calibrate() -> Timing:
    """CPU time of `workload` on this machine now."""
    workload()

    def measure() -> float:
        start = process_time()
        workload()
        return process_time() - start

    return repeated(measure, repeats=CALIBRATIONS)


def scaled(seconds: float, there: float, here: float) -> float:
    """A time measured where the calibration took `there` seconds, as it is expected where it takes `here` seconds."""
    return seconds if isnan(there) or isnan(here) else seconds * here / there
