"""The longest stable step: from a first one, longer or shorter until the other side is reached, then between the two."""

from __future__ import annotations

import math
from collections.abc import Callable

from .disturbance import Growth, Own

ACCURACY = 1.005  # of a limit: the shortest step seen to be unstable over the longest one seen to be stable


def longest_stable(growth: Callable[[float], Growth], own: Own, even: float, first: float, least: float, most: float,
                   pace: float = 2.0) -> tuple[float, str, float]:
    """(longest stable step, what the next longer one did, the longest or shortest step that was tried), s.

    own, even: the growth that is allowed, see `Own.allows`.  first, least, most: steps, s.  The longest stable step is infinite
    where `most` is stable, and 0 where `least` is not.  pace: factor of one trial to the next.
    """
    seen = ""

    def grows(h: float) -> bool:
        nonlocal seen
        measured = growth(h)
        if unstable := not own.allows(measured, even):
            seen = f"at {h:.4g} s: {measured.text(h)}"
        return unstable

    h = low = high = min(first, most)
    if grows(h):
        while grows(h := h / pace):
            high = h
            if h <= least:
                return 0.0, seen, h
        low = h
    else:
        while not grows(h := min(pace * h, most)):
            low = h
            if h == most:
                return math.inf, "", h
        high = h
    tried = high
    while high > ACCURACY * low:
        middle = math.sqrt(low * high)
        low, high = (low, middle) if grows(middle) else (middle, high)
        tried = high
    return low, seen, tried
