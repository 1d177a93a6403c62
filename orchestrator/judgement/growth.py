"""How fast disturbances grow with steps of some length, and the longest step with which they do not."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..run.thresholds import EXCESS, FASTER, GROWN

PARTS = 4  # of a stretch: the first is for transients, growth is that from the second to the last
LARGEST = 1e250  # size up to which growth is seen
PACE = 1.25  # from one step that is tried to the next
STILL = 0.01  # growth along a run, as a logarithm, that is none


@dataclass(frozen=True)
class Growth:
    """What becomes of a disturbance with macro steps of a length `step`, s, in a run of `duration`, s.

    rate: 1/s, below 0 where it decays; infinite where the run ended, which `failure` tells.
    finer: 1/s, with a quarter of the step or less.
    constant: whether the derivative of a macro step is the same all along the run.
    fresh: both rates of pushes that begin anew in each stretch of the run, where `rate` and `finer` are those of one along the run.
    everywhere: whether that one grows in every stretch, and faster than with a quarter of the step.
    """

    step: float
    duration: float
    rate: float
    finer: float
    constant: bool
    failure: str = ""
    fresh: tuple[float, float] | None = None
    everywhere: bool = False

    @property
    def unstable(self) -> bool:
        """Whether the coupling makes disturbances grow that would not grow so by themselves."""
        if self._more(*(self.fresh or (self.rate, self.finer)), 0.0 if self.constant else EXCESS):
            return True
        return self.everywhere and self._more(self.rate, self.finer, math.log(GROWN))

    def _more(self, rate: float, finer: float, excess: float) -> bool:
        return rate > max(FASTER * finer, finer + excess / self.duration, 0.0)

    @property
    def lost(self) -> float:
        """Damping that the coupling takes away, 1/s, beside a quarter of the step; 0 where it adds some."""
        return max(self.rate - self.finer, 0.0) if math.isfinite(self.rate - self.finer) else 0.0

    @property
    def text(self) -> str:
        """What happens, for the reader."""
        rate = max(self.rate, self.fresh[0]) if self.fresh and self.unstable else self.rate
        if self.failure or not math.isfinite(rate):
            return self.failure or ("grows beyond all numbers" if rate > 0.0 else "leaves nothing")
        if abs(rate) * self.duration <= (0.0 if self.constant else STILL):
            return "neither grows nor decays"
        return f"{'grows' if rate > 0.0 else 'decays'} by a factor of 2.7 in {1.0 / abs(rate * self.step):.3g} steps"


class StepLimit(NamedTuple):
    """The longest stable step, s: infinite where the longest one tried is stable, 0 where the shortest is not.

    seen: what the next longer one does.  tried: the longest or shortest step that was tried, s.
    """

    longest: float
    seen: str
    tried: float


def limit_text(longest: float, tried: float) -> str:
    """A longest stable step, s, for the reader; see `StepLimit`."""
    if math.isnan(longest):
        return "not examined"
    beyond = {math.inf: "above", 0.0: "below"}.get(longest)
    return f"{beyond} {tried:.4g}" if beyond else f"{longest:.4g}"


def growth_rate(sizes: np.ndarray, h: float) -> float:
    """How fast sizes (n,), h seconds apart, grow from the second of `PARTS` to the last, 1/s; minus infinity where nothing is left."""
    whole = int(np.argmin(known)) if not (known := sizes < LARGEST).all() else sizes.size
    if (part := whole // PARTS) == 0:
        return math.inf
    early, late = (float(np.mean(some)) for some in (sizes[part : 2 * part], sizes[whole - part : whole]))
    if not (early and late):
        return -math.inf if early else math.inf if late else -math.inf
    return math.log(late / early) / ((whole - 2 * part) * h)


def longest_stable(grows: Callable[[float], str], first: float, least: float, most: float, accuracy: float) -> StepLimit:
    """Of steps between `least` and `most`, s. grows: what happens with a step, "" where that is stable.

    Steps are tried upwards from `first`, or downwards where that is unstable; longer ones than the limit may be stable again.
    accuracy: the shortest step seen to be unstable over the longest one seen to be stable.
    """
    low = high = min(first, most)
    if seen := grows(low):
        while more := grows(low := max(low / PACE, least)):
            high, seen = low, more
            if low == least:
                return StepLimit(0.0, f"at {low:.4g} s: {seen}", low)
    else:
        while not (seen := grows(high := min(PACE * high, most))):
            low = high
            if high == most:
                return StepLimit(math.inf, "", high)
    seen = f"at {high:.4g} s: {seen}"
    while high > accuracy * low:
        middle = math.sqrt(low * high)
        low, high = (low, middle) if grows(middle) else (middle, high)
    return StepLimit(low, seen, high)
