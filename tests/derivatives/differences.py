"""What differences of runs say of a derivative."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

LENGTHS = 1e-3, 1e-4, 1e-5, 1e-6  # of differences, relative to the value or absolute


class Verdict(NamedTuple):
    """kind: "exact", "one-sided, told", "wrong, told" or "wrong"."""

    kind: str
    error: float


def verdict(exact: np.ndarray, base: np.ndarray, at: Callable[[float], np.ndarray | None], size: float, told: bool) -> Verdict:
    """A derivative, (n,), against central differences, then against those of either side.

    base: the numbers.  at: those where the parameter is moved so far; None where that cannot run.  size: of the parameter.
    told: whether a decision was noted to stand at its boundary.
    """

    def fits(differences: list[tuple[float, np.ndarray]]) -> float:
        """The largest disagreement behind what differences resolve; infinite where there are none."""
        if len(differences) < 2:
            return np.inf
        values = np.array([d for _, d in differences])
        between = np.abs(np.diff(values, axis=0))
        best = np.argmin(np.where(np.isnan(between), np.inf, between), axis=0)
        columns = np.arange(base.size)
        value, unsure = values[best, columns], between[best, columns]
        lengths = np.array([d for d, _ in differences])
        rounding = 1e-14 * np.max(np.abs(base)) / lengths[best + 1]
        error = np.abs(exact - value) - 20.0 * unsure - rounding
        return float(np.max(error / np.maximum(np.maximum(np.abs(value), np.abs(exact)), 1e-12), initial=0.0))

    central, sides = [], {1: [], -1: []}
    for length in LENGTHS:
        d = length * size
        ahead, back, near, behind = (at(way * d) for way in (1.0, -1.0, 0.5, -0.5))
        if ahead is not None and back is not None and near is not None and behind is not None:
            central.append((d, (4.0 * (near - behind) / d - (ahead - back) / (2.0 * d)) / 3.0))
        for way, far, half in ((1, ahead, near), (-1, back, behind)):
            if far is not None and half is not None:
                sides[way].append((d, way * (4.0 * half - far - 3.0 * base) / d))
    errors = [fits(some) for some in (central, sides[1], sides[-1])]
    limit = 1e-5
    if errors[0] < limit or (errors[1] < limit and errors[2] < limit):
        return Verdict("exact", errors[0])
    if min(errors[1:]) < limit:
        return Verdict("one-sided, told" if told else "wrong", min(errors[1:]))
    return Verdict("wrong, told" if told else "wrong", min(errors))
