"""Fatigue of a recorded stress: cycles counted by the rainflow method, and the damage they add up to after Palmgren and Miner."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ....components.core.errors import BadInput


@dataclass(frozen=True)
class Cycles:
    """Counted cycles, each (k,): range and mean in the unit of the stress, count 1 for whole cycles and 0.5 for half ones."""

    ranges: np.ndarray
    means: np.ndarray
    counts: np.ndarray


@dataclass(frozen=True)
class Endurance:
    """Cycles N that a stress amplitude a is endured: N = cycles (limit / a)^exponent.

    limit: Pa, amplitude endured `cycles` times.  ultimate: Pa, with which a mean stress lessens the amplitude that is endured
    (Goodman's line); infinite: the mean does not count. Amplitudes below the limit count as well ("elementary" Miner's rule):
    on the safe side for steel, which the original rule lets live for ever there.
    """

    limit: float
    cycles: float
    exponent: float
    ultimate: float = float("inf")

    def __post_init__(self) -> None:
        if not (self.limit > 0.0 and self.cycles > 0.0 and self.exponent > 0.0 and self.ultimate > self.limit):
            raise BadInput(
                "endurance",
                f"limit {self.limit:g}, cycles {self.cycles:g}, exponent {self.exponent:g}, ultimate {self.ultimate:g}",
                "positive numbers, and an ultimate stress above the limit",
            )

    def damage(self, cycles: Cycles) -> float:
        """Share of the life that the cycles use up, 1; infinite where a mean reaches the ultimate stress."""
        left = 1.0 - np.abs(cycles.means) / self.ultimate
        if (left <= 0.0).any():
            return float("inf")
        return float((cycles.counts / self.cycles * (0.5 * cycles.ranges / left / self.limit) ** self.exponent).sum())


def turning_points(values: Iterable[float]) -> np.ndarray:
    """The extremes of a signal in their order, its ends included; (n,) to (m,)."""
    x = np.asarray(list(values), dtype=float)
    if not np.isfinite(x).all():
        raise BadInput("turning points", "values that are no numbers", "a finite signal")
    x = x[np.concatenate(([True], np.diff(x) != 0.0))] if x.size else x
    if x.size < 3:
        return x
    slopes = np.diff(x)
    return x[np.concatenate(([True], slopes[1:] * slopes[:-1] < 0.0, [True]))]


def rainflow(values: Iterable[float]) -> Cycles:
    """Cycles of a signal (n,), of any unit.

    Source: ASTM E1049, rainflow counting: a range that a larger or equal one follows is a cycle, and a half cycle where it
    begins at the record's first point; what remains are half cycles. From memory; its worked example is a test.
    """
    kept: list[float] = []
    cycles: list[tuple[float, float, float]] = []
    for point in turning_points(values).tolist():
        kept.append(point)
        while len(kept) >= 3:
            last, before = abs(kept[-1] - kept[-2]), abs(kept[-2] - kept[-3])
            if last < before:
                break
            first = len(kept) == 3
            cycles.append((before, 0.5 * (kept[-2] + kept[-3]), 0.5 if first else 1.0))
            if first:
                del kept[0]
            else:
                del kept[-3:-1]
    cycles += [(abs(b - a), 0.5 * (a + b), 0.5) for a, b in pairwise(kept)]
    table = np.array(cycles, dtype=float).reshape(-1, 3)
    return Cycles(*table.T)
