"""Counts of files, threads and processes: what has just ended may still be counted for a moment, longer on a busy machine."""

from collections.abc import Callable
from time import monotonic, sleep
from typing import TypeVar

PATIENCE = 30.0  # s, at most
CALM = 0.5  # s for which a count that has come to rest has stayed the same

T = TypeVar("T")


def at_rest(counted: Callable[[], T], wanted: T | None = None) -> T:
    """What is counted, as soon as it is `wanted`, or after `PATIENCE`; where nothing is wanted, once it changes no more."""
    value, since = counted(), monotonic()
    end = since + PATIENCE
    while value != wanted and monotonic() < end and (wanted is not None or monotonic() < since + CALM):
        sleep(0.02)
        now = counted()
        if now != value:
            value, since = now, monotonic()
    return value
