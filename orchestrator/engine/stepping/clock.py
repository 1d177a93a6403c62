"""Time as an integer number of ticks; seconds are computed from it, never accumulated."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import reduce
from math import floor, gcd

import numpy as np

NEAR_MULTIPLE = 1e-12  # relative


def _written(seconds: float) -> Fraction:
    """The decimal number a user wrote: 0.1 is 1/10, not the binary number beside it."""
    return Fraction(repr(float(seconds)))


@dataclass(frozen=True)
class Clock:
    """Ticks of `numerator / denominator` seconds, the largest that divides all durations of a run; tick 0 is its start.

    Tick 0 is `origin` ticks behind t = 0, so that every instant of a run is a whole number of ticks, divided once.
    """

    numerator: int
    denominator: int
    origin: int = 0

    @classmethod
    def dividing(cls, *durations: float, start: float = 0.0) -> Clock:
        """The clock with the longest tick of which every duration (s, positive) and the start (s) are whole multiples."""
        tick = reduce(
            lambda a, b: Fraction(gcd(a.numerator * b.denominator, b.numerator * a.denominator), a.denominator * b.denominator),
            map(_written, (*durations, start)),
        )
        return cls(tick.numerator, tick.denominator, int(_written(start) / tick))

    def finer(self, parts: int) -> Clock:
        """A clock whose ticks are the given part of these."""
        return Clock(self.numerator, self.denominator * parts, self.origin * parts)

    def ticks(self, duration: float) -> int:
        """Whole ticks in a duration (s); exact for those the clock was made for."""
        return int(_written(duration) * self.denominator / self.numerator)

    def multiple(self, duration: float, unit: float) -> Fraction:
        """Ticks in a duration (s), which need not be whole, or in the multiple of a unit (s) that it is but for rounding."""
        count = round(duration / unit)
        near = count and abs(duration - count * unit) <= NEAR_MULTIPLE * duration
        return (count * _written(unit) if near else _written(duration)) * self.denominator / self.numerator

    def tick(self, t: float) -> int:
        """The tick at a time (s); exact for those the clock was made for."""
        return self.ticks(t) - self.origin

    def not_before(self, t: float) -> int:
        """The first tick that is not before a time (s)."""
        tick = floor(Fraction(t) * self.denominator / self.numerator) - self.origin
        return tick if self.time(tick) >= t else tick + 1

    def seconds(self, ticks: int) -> float:
        """Length of so many ticks, correctly rounded: Python divides integers exactly before it rounds."""
        return ticks * self.numerator / self.denominator

    def time(self, tick: int) -> float:
        """Time of a tick, s, correctly rounded."""
        return (self.origin + tick) * self.numerator / self.denominator

    def times(self, ticks: range) -> np.ndarray:
        """`time` of several ticks, (n,)."""
        ends = abs(self.origin + ticks[0]), abs(self.origin + ticks[-1])
        exact = max(max(ends) * self.numerator, self.denominator) < 2**53  # in floating point, too, so that one rounding is left
        whole = np.arange(ticks.start, ticks.stop, ticks.step) + (self.origin if exact else 0)
        return whole * self.numerator / self.denominator if exact else np.array([self.time(k) for k in ticks])
