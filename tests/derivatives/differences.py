"""What differences of runs say of a derivative."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

# Lengths of differences, relative to the parameter or absolute
FIRST = 1e-4, 1e-5  # which settle most derivatives
FURTHER = 1e-3, 1e-4, 1e-5, 1e-6  # for those that bend much, or little
NEAR = 1e-8, 1e-9  # within a boundary that is all but reached
LIMIT = 1e-5  # of a relative disagreement
CLOSE = 1e-4  # of one that the differences show as a whole, whatever they resolve


class Verdict(NamedTuple):
    """kind: "exact", "one-sided, told", "wrong, told", "wrong", or "fixed" where no other value can run."""

    kind: str
    error: float


Differences = list[tuple[float, np.ndarray]]  # length, quotients


def verdict(exact: np.ndarray, base: np.ndarray, at: Callable[[float], np.ndarray | None], size: float, told: bool) -> Verdict:
    """A derivative against central differences, then against those of either side.

    exact, base: the derivative and the numbers, (n,), or (n, S) of signals with a size each.  at: the numbers where the parameter is
    moved so far; None where that cannot run.  size: of the parameter.  told: whether a decision was noted to stand at its boundary.
    """
    runs: dict[float, np.ndarray | None] = {}

    def moved(way: float) -> np.ndarray | None:
        if way not in runs:
            runs[way] = at(way)
        return runs[way]

    for lengths in (FIRST, FURTHER, NEAR):
        some = _differences(base, moved, [length * size for length in lengths])
        central = _disagreement(exact, base, some[0])
        if central < LIMIT and (lengths is FURTHER or np.linalg.norm(some[0][-1][1] - exact) <= CLOSE * np.linalg.norm(exact)):
            return Verdict("exact", central)
        if lengths is FURTHER:
            sides = [_disagreement(exact, base, side) for side in some[1:] if side]  # a limit has one side alone
            if max(sides, default=np.inf) < LIMIT or not sides:
                return Verdict("exact", max(sides)) if sides else Verdict("fixed", np.nan)
    kind = "one-sided" if (error := min(sides)) < LIMIT else "wrong"
    return Verdict(f"{kind}, told" if told else "wrong", error)


def _differences(base: np.ndarray, moved: Callable[[float], np.ndarray | None], lengths: list[float]) -> list[Differences]:
    """Quotients of the second order: central ones, above, below."""
    some: list[Differences] = [[], [], []]
    for d in lengths:
        ahead, back, near, behind = (moved(way * d) for way in (1.0, -1.0, 0.5, -0.5))
        if ahead is not None and back is not None and near is not None and behind is not None:
            some[0].append((d, (4.0 * (near - behind) / d - (ahead - back) / (2.0 * d)) / 3.0))
        for side, way, far, half in ((1, 1, ahead, near), (2, -1, back, behind)):
            if far is not None and half is not None:
                some[side].append((d, way * (4.0 * half - far - 3.0 * base) / d))
    return some


def _disagreement(exact: np.ndarray, base: np.ndarray, differences: Differences) -> float:
    """The largest relative one behind what differences resolve; infinite where there are none."""
    if len(differences) < 2:
        return float(np.inf)
    values = np.array([d for _, d in differences])
    between = np.abs(np.diff(values, axis=0))
    best = np.argmin(np.where(np.isnan(between), np.inf, between), axis=0)[None]
    value, unsure = (np.take_along_axis(one, best, 0)[0] for one in (values[:-1], between))
    lengths = np.array([d for d, _ in differences])
    size, largest = np.max(np.abs(base), axis=0 if base.ndim > 1 else None), np.max(np.abs(base))
    rounding = 1e-14 * np.maximum(size, min(largest, 1.0)) / lengths[best[0] + 1]  # a small one may be a difference of others
    error = np.abs(exact - value) - 20.0 * unsure - rounding
    return float(np.max(error / np.maximum(np.maximum(np.abs(value), np.abs(exact)), 1e-12), initial=0.0))
