"""What differences of runs say of a derivative.

Each signal is judged by the largest of its values: a derivative is right to 1e-5, behind what differences resolve. That is what they
differ by at two distances. Where a decision stands at its boundary, a derivative is right only if they say so: they say nothing where
they do not resolve a twentieth of one that counts.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

# Lengths of differences, relative to the parameter or absolute
FIRST = 1e-4, 1e-5  # which settle most derivatives
FURTHER = 1e-2, 1e-3, 1e-4, 1e-5, 1e-6  # for those that bend much, or little
NEAR = 1e-7, 1e-8, 1e-9  # within a boundary that is all but reached
BESIDE = 1e-9  # so far from a boundary derivatives are those of its side
LIMIT = 1e-5  # of a relative disagreement
UNSURE = 3.0  # times what differences at two distances differ by
ALONE = 20.0  # the same of a single number, which may be the same at two distances by chance
SAID = 5e-2  # differences that resolve no more of a derivative say nothing of it
COUNTS = 1e-6  # a change by less of a signal, for all of the parameter, does not count


JUMPS, SILENT, OTHERS = "the run jumps there", "differences do not resolve it", "differences are others"
REST = 0.1  # of a move that is left of it at a thousandth of the distance, where the run jumps; a smooth one leaves a thousandth


class Verdict(NamedTuple):
    """kind: "exact", "one-sided, told", "wrong, told", "wrong", or "fixed" where no other value can run.  why: of one that is wrong."""

    kind: str
    error: float
    why: str = ""


Numbers = np.ndarray
At = Callable[[float], Numbers | None]  # so far from the value of the parameter; None where that cannot run
Differences = list[tuple[float, Numbers]]  # length, quotients


def verdict(exact: Numbers, base: Numbers, at: At, sizes: Sequence[float], told: bool, beside: At | None = None) -> Verdict:
    """A derivative against central differences, then against those of either side, then derivatives of either side against them.

    exact, base: the derivative and the numbers, (n,), or (n, S) of signals with a size each.  at: the numbers where the parameter is
    moved.  sizes: of the parameter, or several where it is 0.  told: whether a decision was noted to stand at its boundary.
    beside: the derivative where the parameter is moved.
    """
    exact, base = np.atleast_2d(exact), np.atleast_2d(base)
    found = [_with_size(exact, base, at, size, told, beside) for size in sizes]
    best = min(found, key=lambda one: (ORDER.index(one.kind), one.error))
    return best if told or best.kind in ("exact", "fixed") else Verdict("wrong", best.error, best.why)


ORDER = "exact", "one-sided, told", "wrong, told", "fixed"


def _with_size(exact: Numbers, base: Numbers, at: At, size: float, told: bool, beside: At | None) -> Verdict:
    runs: dict[float, Numbers | None] = {}

    def error_of(derivative: Numbers, differences: Differences) -> float:
        return _disagreement(derivative, base, differences, size, told)

    def moved(way: float) -> Numbers | None:
        if way not in runs:
            runs[way] = None if (some := at(way)) is None else np.atleast_2d(some)
        return runs[way]

    sides: dict[float, Differences] = {}
    for lengths in (FIRST, FURTHER, NEAR):
        central, above, below = _differences(base, moved, [length * size for length in lengths])
        if (error := error_of(exact, central)) < LIMIT:
            return Verdict("exact", error)
        if lengths is FURTHER:
            sides = {way: side for way, side in ((1.0, above), (-1.0, below)) if side}  # a limit has one side alone
            errors = [error_of(exact, side) for side in sides.values()]
            if max(errors, default=np.inf) < LIMIT or not sides:
                return Verdict("exact", max(errors)) if sides else Verdict("fixed", np.nan)
    if min(errors) >= LIMIT and told and beside is not None:
        tangents = {way: beside(way * BESIDE * size) for way in sides}
        errors += [error_of(t, sides[way]) for way, t in tangents.items() if t is not None]
    if min(errors) < LIMIT:
        return Verdict("one-sided, told", min(errors))
    why = JUMPS if any(_jumps(base, moved, way * size) for way in sides) else OTHERS if np.isfinite(min(errors)) else SILENT
    return Verdict("wrong, told", min(errors), why)


def _jumps(base: Numbers, moved: At, size: float) -> bool:
    """Whether a signal leaves its values at once."""
    far, near = (moved(length * size) for length in (FURTHER[1], FURTHER[-1]))
    if far is None or near is None:
        return False
    far, near = (np.max(np.abs(some - base), axis=0) for some in (far, near))
    noise = 1e-9 * np.maximum(np.max(np.abs(base), axis=0), 1e-9 * np.max(np.abs(base)))
    return bool(np.any((near > REST * far) & (near > noise)))


def _differences(base: Numbers, moved: At, lengths: list[float]) -> list[Differences]:
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


def _disagreement(exact: Numbers, base: Numbers, differences: Differences, size: float, told: bool) -> float:
    """The largest relative one of a signal behind what differences resolve; infinite where they have to say something and do not."""
    if len(differences) < 2:
        return float(np.inf)
    lengths, values = np.array([d for d, _ in differences]), np.array([d for _, d in differences])
    between = np.max(np.abs(np.diff(values, axis=0)), axis=1)  # of each pair of lengths and each signal
    best = np.argmin(np.where(np.isnan(between), np.inf, between), axis=0)
    signals = np.arange(base.shape[1])
    value = values[best, :, signals].T
    largest, all_of_them = np.max(np.abs(base), axis=0), np.max(np.abs(base))
    rounding = 1e-14 * np.maximum(largest, min(all_of_them, 1.0)) / lengths[best + 1]  # a small one may be a difference of others
    counts = COUNTS * np.maximum(largest, 1e-7 * min(all_of_them, 1.0)) / size
    unsure = (UNSURE if base.shape[0] > 1 else ALONE) * between[best, signals]
    slope = np.maximum(np.max(np.abs(value), axis=0), np.max(np.abs(exact), axis=0))
    silent = told & (unsure > SAID * slope) & (slope > counts)
    error = (np.max(np.abs(exact - value), axis=0) - unsure - rounding) / np.maximum(slope, 1e-12)
    return float(np.max(np.where(silent, np.inf, error), initial=0.0))
