"""How fast disturbances grow with steps of some length, and the longest step with which they do not."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
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
    everywhere: whether it grows in every stretch of the run, and faster than with a quarter of the step.
    """

    step: float
    duration: float
    rate: float
    finer: float
    constant: bool
    failure: str = ""
    everywhere: bool = False

    @property
    def unstable(self) -> bool:
        """Whether the coupling makes disturbances grow that would not grow so by themselves."""
        excess = 0.0 if self.constant else math.log(GROWN) if self.everywhere else EXCESS
        return self.rate > max(FASTER * self.finer, self.finer + excess / self.duration, 0.0)

    @property
    def untold(self) -> str:
        """Why growth does not tell whether the coupling is stable; "" where it does."""
        if self.constant or self.unstable or (own := self.finer * self.duration) <= EXCESS:
            return ""
        return f"disturbances grow by themselves, with short steps by a factor of e^{own:.3g} in the run, and hide what the coupling adds"

    @property
    def lost(self) -> float:
        """Damping that the coupling takes away, 1/s, beside a quarter of the step; 0 where it adds some."""
        return max(self.rate - self.finer, 0.0) if math.isfinite(self.rate - self.finer) else 0.0

    @property
    def text(self) -> str:
        """What happens, for the reader."""
        rate = self.rate
        if self.failure or not math.isfinite(rate):
            return self.failure or ("grows beyond all numbers" if rate > 0.0 else "leaves nothing")
        if abs(rate) * self.duration <= (0.0 if self.constant else STILL):
            return "neither grows nor decays"
        return f"{'grows' if rate > 0.0 else 'decays'} by a factor of 2.7 in {1.0 / abs(rate * self.step):.3g} steps"


class Grown(NamedTuple):
    """What a push has grown by in a stretch, as logarithms: at its end, and in its mean."""

    whole: float
    mean: float


class StepLimit(NamedTuple):
    """The longest stable step, s: infinite where the longest one tried is stable, 0 where the shortest is not, NaN where it is not told.

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


def grown_in(sizes: np.ndarray, h: float, new: bool) -> Grown:
    """Of sizes (n,), h seconds apart, of a push that had size 1 before, or, new, begins with the first of them."""
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
        whole, mean = np.log([sizes[-1], sizes.mean()]) - (np.log(sizes[0]) if new else 0.0)
    if math.isfinite(whole) and math.isfinite(mean):
        return Grown(float(whole), float(mean))
    whole = growth_rate(sizes, h) * sizes.size * h
    return Grown(whole, 0.5 * whole)


def growth_along(grown: Sequence[Grown], length: float) -> float:
    """How fast a push grows along stretches of a length, s, from the mean of the first to that of the last, 1/s.

    Minus infinity where nothing is left; stretches in which units stick, and nothing is left of it, do not count.
    """
    left = [one for one in grown if one.whole > -math.inf]
    if len(left) < 2 or any(one.whole == math.inf for one in left):
        return max((one.whole for one in left), default=-math.inf) / length
    return (sum(one.whole for one in left[:-1]) + left[-1].mean - left[0].mean) / ((len(left) - 1) * length)


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
