"""CPU times that can be compared: checked against one another when they are measured.

A time that another measurement of the same thing does not confirm says something of the machine's load and nothing of the
setting; it is measured again, and refused if the measurements still differ. CPU time is not lengthened by programs that take
turns on the processor, but by those that share its caches and clock.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import inf, nan
from statistics import median as median_of

SCATTER = 0.2  # of the smallest time, by which the next one may be longer
ATTEMPTS = 6  # measurements until a time is refused


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
