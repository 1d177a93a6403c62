"""Values of parameters over which something is repeated: lists, and evenly spaced ranges, by full names."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from sys import float_info
from typing import Any

import numpy as np

from ...components.core.errors import BadInput

RANGE = ("from", "to", "points")
MOST_POINTS = 1_000_000  # of one range; each is a run


def _finite(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= float_info.max


def ranged(table: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Nested tables as full names of parameters, each with its values; ranges as evenly spaced ones."""
    for key, value in table.items():
        name = prefix + key
        if not isinstance(value, Mapping):
            yield name, value
        elif not value.keys() & set(RANGE):
            yield from ranged(value, name + ".")
        else:
            first, last, points = (value.get(k) for k in RANGE)
            countable = isinstance(points, int) and 2 <= points <= MOST_POINTS
            if len(value) != 3 or not (_finite(first) and _finite(last) and countable):
                raise BadInput(name, repr(dict(value)), f"{{ from = first value, to = last value, points = 2 to {MOST_POINTS} }}")
            yield name, np.linspace(float(first), float(last), points).tolist()  # type: ignore[arg-type]
