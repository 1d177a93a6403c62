"""Key results of a run, numbers by name with their units of measure; and what holds where a run has none, or has no number for one.

There are three rules, and each use names its own:

    key_results     refuses what cannot be computed of a run: for what is about the figures themselves, such as derivatives
    known_results   has no figures then: for errors, which a run without figures does not have
    at, gaps        NaN for a figure that a run does not have: what is computed from it is not known, nor is it left out
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from math import isfinite, nan
from typing import Any

import numpy as np

from ...components.core.errors import BadInput
from .results import Result

STATISTICS: dict[str, Callable[[np.ndarray], Any]] = {  # statistics of a signal
    "minimum": np.min,
    "maximum": np.max,
    "mean": np.mean,
    "standard deviation": np.std,
}


class KeyResults(dict[str, float]):
    """Numbers by name. units: of measure, by the same names."""

    def __init__(self, numbers: Mapping[str, float] | None = None, units: Mapping[str, str] | None = None):
        super().__init__(numbers or {})
        self.units = dict(units or {})

    @classmethod
    def of(cls, rows: Iterable[tuple[str, Any, str]]) -> KeyResults:
        """Of names with numbers and units."""
        figures = cls()
        figures.add(rows)
        return figures

    def add(self, rows: Iterable[tuple[str, Any, str]]) -> None:
        """Take in names with numbers and units; a name that is there keeps its number."""
        for name, value, unit in rows:
            self.setdefault(name, float(value))
            self.units.setdefault(name, unit)

    def at(self, names: Iterable[str]) -> np.ndarray:
        """(n,) numbers; NaN where there is none."""
        return np.array([self.get(name, nan) for name in names], dtype=float)

    def gaps(self, other: Mapping[str, float]) -> dict[str, float]:
        """How far each is from another run's; NaN where that has none."""
        return {name: abs(value - other.get(name, nan)) for name, value in self.items()}

    def finite_gaps(self, other: Mapping[str, float]) -> dict[str, float]:
        """The same of those of which both runs have a finite number."""
        return {name: gap for name, gap in self.gaps(other).items() if isfinite(gap)}


def after_transient(result: Result) -> slice:
    """The samples from [analysis] transient on; all without it."""
    transient = result.scene.analysis.transient
    first = int(np.searchsorted(result.time, result.scene.counts_from))
    if first >= result.time.size - 1:
        where, length = f"{result.scene.name}: analysis.transient", result.time[-1] - result.time[0]
        raise BadInput(where, f"{transient:g} s", f"less than the length of the run, {length:g} s")
    return slice(first, None)


def key_results(result: Result) -> KeyResults:
    """Those of the run's system; raises `BadInput` where they cannot be computed."""
    return KeyResults.of((row.name, row.value, row.unit) for row in result.summary)


def known_results(result: Result) -> KeyResults:
    """The same; none where they cannot be computed."""
    try:
        return key_results(result)
    except BadInput:
        return KeyResults()
