"""How far runs of one scene with different macro steps are apart, and what error of the first follows.

With x, x2, x4 of the same signal at the macro steps H, H/2 and H/4, and the differences d = |x - x2| and d2 = |x2 - x4|:

    error of x  =  2 d           from two runs: exact for first order, too large for higher ones
                   d + 2 d2      from three runs: 2 d at first order, 3/2 d at second, 3 d where nothing converges

The true error of order p is d 2^p / (2^p - 1). Richardson, "The approximate arithmetical solution by finite differences"
(Phil. Trans. R. Soc. A 210, 1911); Roache, "Perspective: a method for uniform reporting of grid refinement studies"
(J. Fluids Eng. 116, 1994).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import isfinite, log2, nan

import numpy as np

from ..engine.coupling.graph import is_discrete
from ..results import Result
from .thresholds import APART, CONVERGING, HARDLY, ORDER_UNSURE, PARTS, SAME_SPREAD, TOGETHER

HIGHEST_ORDER = 4.0  # that two differences are taken for
SURE, UNSURE = 2.0, 3.0  # error over the difference of two runs: at first order, and where the order is not known


@dataclass(frozen=True)
class Difference:
    """Of two runs in one signal, in parts of the signal's scale.

    rms, largest: over all rows.  parts: (PARTS,) rms in equal parts of the run.  spread: deviation of the first over the second.
    """

    rms: float
    largest: float
    parts: np.ndarray
    spread: float = 1.0


@dataclass(frozen=True)
class SignalError:
    """Estimated error of a signal, in parts of its scale: rms and largest. order: that was seen; NaN from two runs.

    parted: whether histories have parted while statistics agree, as in a chaotic motion.  grown: deviation over that of the
    finest run.
    """

    rms: float
    largest: float
    order: float = nan
    parted: bool = False
    grown: float = 1.0

    def to_json(self) -> dict[str, float | bool | None]:
        """The object of run.json; what is not known is null."""
        numbers = {"rms": self.rms, "max": self.largest, "order": self.order}
        return {k: v if isfinite(v) else None for k, v in numbers.items()} | ({"parted": True} if self.parted else {})


def scale_of(values: np.ndarray) -> float:
    """What errors of a signal are shares of: its standard deviation, or of one that hardly varies its rms; 0 of one that is 0."""
    known = values[np.isfinite(values)]
    if not known.size:
        return 0.0
    return max(float(known.std()), HARDLY * float(np.sqrt(np.mean(known**2))))


def differences(first: Result, second: Result) -> dict[str, Difference]:
    """Of every recorded signal of two runs of a scene, at the times of the first; `second` has the shorter steps.

    Signals that jump between values, and texts, differ by the share of rows in which they are not the same.
    """
    here, there = _common_rows(first.time, second.time)
    compared = {}
    for name in first.columns:
        a = first[name] if here is None else first[name][here]
        if _discrete(first, name):
            k = np.searchsorted(second.time, first.time, side="right") - 1 if there is None else there
            compared[name] = _in_parts(np.where(a == second[name][np.maximum(k, 0)], 0.0, 1.0), 1.0)
            continue
        b = np.interp(first.time, second.time, second[name]) if there is None else second[name][there]
        compared[name] = difference(a, b)
    for name in first.texts:
        k = np.maximum(np.searchsorted(second.time, first.time, side="right") - 1, 0)
        compared[name] = _in_parts(np.where(first[name] == second[name][k], 0.0, 1.0), 1.0)
    return compared


def difference(first: np.ndarray, second: np.ndarray) -> Difference:
    """Of two histories of a signal, (n,) each, the second being the finer; what only one of them has counts as a difference."""
    scale, own = scale_of(second), scale_of(first)
    gap = np.abs(first - second)
    gap[np.isnan(first) & np.isnan(second)] = 0.0
    gap[first == second] = 0.0  # infinities
    gap[~np.isfinite(gap)] = max(scale, own)
    return _in_parts(gap, scale or own, own / scale if scale else 1.0)


def _in_parts(gap: np.ndarray, scale: float, spread: float = 1.0) -> Difference:
    if not gap.size or not gap.any():
        return Difference(0.0, 0.0, np.zeros(PARTS), spread)
    with np.errstate(over="ignore"):
        gap = gap / scale
        parts = np.array([np.sqrt(np.mean(part**2)) if part.size else 0.0 for part in np.array_split(gap, PARTS)])
        return Difference(float(np.sqrt(np.mean(gap**2))), float(gap.max()), parts, spread)


def _common_rows(first: np.ndarray, second: np.ndarray) -> tuple[np.ndarray | None, np.ndarray | None]:
    """Rows of two runs at the same times; None where most rows of the first have none, as with steps of uneven length."""
    near = 1e-9 * max(float(first[-1]), 1e-300)
    k = np.minimum(np.searchsorted(second, first - near), second.size - 1)
    same = np.abs(second[k] - first) <= near
    return (np.flatnonzero(same), k[same]) if 2 * same.sum() >= first.size else (None, None)


def _discrete(result: Result, name: str) -> bool:
    """Whether a recorded signal changes at instants only."""
    unit, output = result.scene.split(name)
    signal = result.scene.coupling.interfaces[unit].outputs.get(output) if unit in result.scene.coupling.interfaces else None
    return signal is not None and is_discrete(signal)


def needs_third(compared: Mapping[str, Difference]) -> bool:
    """Whether two runs differ too much for an error of their difference alone."""
    return any(one.rms > ORDER_UNSURE for one in compared.values())


def signal_errors(first: Mapping[str, Difference], second: Mapping[str, Difference] | None) -> dict[str, SignalError]:
    """Errors of the signals of a run, from its differences to the second run, and from those of the second to the third.

    Without a third run, a difference that would have needed one counts three times.
    """
    return {name: _of_three(one, second[name]) if second is not None else _of_two(one) for name, one in first.items()}


def _of_two(d: Difference) -> SignalError:
    factor = UNSURE if d.rms > ORDER_UNSURE else SURE
    return SignalError(factor * d.rms, factor * d.largest, grown=d.spread)


def _of_three(d: Difference, d2: Difference) -> SignalError:
    order = min(log2(d.rms / d2.rms), HIGHEST_ORDER) if d.rms and d2.rms else nan
    parted = (d2.rms * CONVERGING > d.rms and max(d.parts[0], d2.parts[0]) < TOGETHER
              and max(d.parts[-1], d2.parts[-1]) > APART
              and all(1.0 / SAME_SPREAD < one.spread < SAME_SPREAD for one in (d, d2)))
    return SignalError(d.rms + 2.0 * d2.rms, d.largest + 2.0 * d2.largest, order, parted, d.spread * d2.spread)


def figure_errors(runs: Sequence[Mapping[str, float]], *, unsure: bool = False) -> dict[str, float]:
    """Errors of the first run's figures, from two or three runs, in the figures' own units; NaN where a run lacks a figure.

    `unsure`: of two runs that differ too much for an error of their difference alone.
    """
    first, second, *more = runs

    def error(name: str) -> float:
        d = abs(first[name] - second.get(name, nan))
        return d + 2.0 * abs(second.get(name, nan) - more[0].get(name, nan)) if more else (UNSURE if unsure else SURE) * d

    return {name: error(name) for name in first}


def worst_of(errors: Mapping[str, SignalError], of: Callable[[SignalError], float] = lambda one: one.rms) -> str:
    """The name of the signal with the largest error; "" of none."""
    return max(errors, key=lambda name: of(errors[name]), default="")
