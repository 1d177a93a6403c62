"""How far runs of one scene with different macro steps are apart, and what error of the first follows.

With x, x2, x4 of the same signal at the macro steps H, H/2 and H/4, and the differences d = |x - x2| and d2 = |x2 - x4|:

    error of x  =  2 d           from two runs: exact for first order, too large for higher ones
                   d + 2 d2      from three runs: 2 d at first order, 3/2 d at second, 3 d where nothing converges

The true error of order p is d 2^p / (2^p - 1). Richardson, "The approximate arithmetical solution by finite differences"
(Phil. Trans. R. Soc. A 210, 1911); Roache, "Perspective: a method for uniform reporting of grid refinement studies"
(J. Fluids Eng. 116, 1994).
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import inf, isfinite, log2, nan

import numpy as np

from ..engine.coupling.graph import is_discrete
from ..units.interface import Signal
from .instants import at_instants
from .key_results import KeyResults
from .results import Result
from .run_record import Excerpt, SignalRecord, known
from .thresholds import (
    APART,
    BULK,
    CONVERGING,
    FEW,
    FEWEST_ROWS,
    HARDLY,
    LATER,
    NOTHING,
    ORDER_UNSURE,
    SAME_SPREAD,
    SECTIONS,
    TOGETHER,
)

HIGHEST_ORDER = 4.0  # that two differences are taken for
EXCERPT = 160  # rows of two signals where they differ most
SURE, UNSURE = 2.0, 3.0  # error over the difference of two runs: at first order, and where the order is not known


@dataclass(frozen=True)
class Difference:
    """Of two runs in one signal, in parts of the signal's scale.

    rms, largest: over all rows.  sections: (SECTIONS,) rms in equal sections of the run.  spread: deviation of the first over the
    second.
    reach, late: range of the first, and of its last half, over the range of the second; late is 0 of one that decays.
    rest: rms without the few rows in which most of it is; as large as `rms` where it is not in few rows.
    """

    rms: float
    largest: float
    sections: np.ndarray
    spread: float = 1.0
    rest: float = inf
    reach: float = 1.0
    late: float = 1.0

    @property
    def ends(self) -> tuple[float, float]:
        """rms in the first and in the last eighth of the run."""
        n = max(self.sections.size // 8, 1)
        return _rms(self.sections[:n]), _rms(self.sections[-n:])

    @property
    def together(self) -> float:
        """Share of the run before two histories part that begin alike; infinite where they do not, or come together again."""
        k = int(np.argmax(self.sections > APART))
        parted = self.sections[0] < TOGETHER and np.median(self.sections[k:]) > APART
        return (k + 1) / self.sections.size if parted else inf


@dataclass(frozen=True)
class SignalError:
    """Estimated error of a signal, in parts of its scale: rms and largest. order: that was seen; NaN from two runs.

    half: rms error of the run with half the step; NaN from two runs.  parted: whether histories have parted while statistics
    agree, as in a chaotic motion.  shifted: whether the error is that of jumps at other instants, in few rows.  grown: deviation
    over that of the finest run.  late: range in the last half of the run over that of the whole finest run.  coupling: share of
    the error that half the macro step alone shows; NaN where it is not known.
    """

    rms: float
    largest: float
    order: float = nan
    half: float = nan
    parted: bool = False
    shifted: bool = False
    grown: float = 1.0
    late: float = 1.0
    coupling: float = nan

    @property
    def record(self) -> SignalRecord:
        """As it is written."""
        rms, largest, order, coupling = map(known, (self.rms, self.largest, self.order, self.coupling))
        return SignalRecord(rms=rms, max=largest, order=order, coupling=coupling, parted=self.parted, shifted=self.shifted)


def scale_of(values: np.ndarray, nominal: float = 0.0) -> float:
    """What errors of a signal are shares of: its standard deviation; of one that hardly varies, its size.

    nominal: the declared size, which tells rounding from a signal where all of it is small.
    """
    known = values[np.isfinite(values)]
    size = float(np.sqrt(np.mean(known**2))) if known.size else 0.0
    return max(float(known.std()) if known.size else 0.0, HARDLY * size, NOTHING * nominal)


def differences(first: Result, second: Result) -> dict[str, Difference]:
    """Of every recorded signal of two runs of a scene, at the times of the first; `second` has the shorter steps.

    Flags, modes, counts and texts differ by the share of the time in which they are not the same.
    """
    here, there = common_rows(first.time, second.time)
    before = np.maximum(np.searchsorted(second.time, first.time, side="right") - 1, 0) if there is None else there
    compared = {}
    for name in (*first.columns, *first.texts):
        signal = _signal(first, name)
        a = first[name] if here is None else first[name][here]
        if signal is None or signal.kind != "real" or (signal.unit == "1" and _whole(a) and _whole(second[name])):
            compared[name] = _of_shares(a != second[name][before])
            continue
        stepwise = there is not None or is_discrete(signal)
        b = second[name][before] if stepwise else at_instants(first.time, second.time, second[name])
        compared[name] = difference(a, b, signal.nominal, angle=signal.unit == "rad")
    return compared


def difference(first: np.ndarray, second: np.ndarray, nominal: float = 0.0, *, angle: bool = False) -> Difference:
    """Of two histories of a signal, (n,) each, the second being the finer; what only one of them has counts as a difference.

    angle: in rad; of one that begins anew after each turn, whole turns are no difference.
    """
    scale, own = scale_of(second, nominal), scale_of(first, nominal)
    with np.errstate(invalid="ignore"):
        gap = np.abs(first - second)
    if angle and (_begins_anew(first) or _begins_anew(second)):
        gap = np.abs((gap + np.pi) % (2.0 * np.pi) - np.pi)
    gap[np.isnan(first) & np.isnan(second)] = 0.0
    gap[first == second] = 0.0  # infinities
    gap[~np.isfinite(gap)] = max(scale, own)
    if not gap.any():
        return Difference(0.0, 0.0, np.zeros(SECTIONS))
    with np.errstate(over="ignore"):
        gap = gap / (scale or own)
        most = np.partition(gap, gap.size - few)[: gap.size - few] if 0 < (few := int(FEW * gap.size)) < gap.size else gap
        rest = np.sqrt(np.sum(most**2) / gap.size)
        rms = _rms(gap)
        return Difference(
            rms,
            float(gap.max()),
            np.sqrt(_in_sections(gap**2)),
            own / scale if scale else 1.0,
            float(rest) if rest**2 < (1.0 - BULK) * rms**2 else rms,
            *_ranges(first, second),
        )


def _ranges(first: np.ndarray, second: np.ndarray) -> tuple[float, float]:
    """Ranges of a history and of its last half, over the range of the finer one; 1 where that stands still, 0 of one that decays."""
    known = [v[np.isfinite(v)] for v in (second, first, first[first.size // 2 :])]
    whole, reach, late = (float(np.ptp(v)) if v.size else 0.0 for v in known)
    late = 0.0 if _decays(first) else late
    return (reach / whole, late / whole) if whole > 0.0 else (1.0, 1.0)


def _decays(values: np.ndarray) -> bool:
    """Whether, behind the first, each quarter has a smaller range than the one before, or so few rows that quarters tell nothing."""
    if values.size < FEWEST_ROWS:
        return True
    ends = np.linspace(0, values.size - 1, 5).astype(int)
    ranges = [float(np.ptp(values[a : b + 1])) for a, b in itertools.pairwise(ends[1:])]
    return all(b < a for a, b in itertools.pairwise(ranges))


def _of_shares(other: np.ndarray) -> Difference:
    """Of values that are the same or not, (n,)."""
    return Difference(float(other.mean()), float(other.max(initial=0)), _in_sections(other))


def _whole(values: np.ndarray) -> bool:
    """Whether all values are whole numbers, as of a flag that is no Boolean."""
    return bool(np.all(values == np.rint(values)))


def _in_sections(values: np.ndarray) -> np.ndarray:
    """Means of (n,) values in as many sections as even as can be, as `np.array_split` makes them; 0 in one without values."""
    n, longer = divmod(values.size, SECTIONS)
    means, first = np.zeros(SECTIONS), longer * (n + 1)
    if longer:
        means[:longer] = values[:first].reshape(longer, n + 1).mean(axis=1)
    if n:
        means[longer:] = values[first:].reshape(SECTIONS - longer, n).mean(axis=1)
    return means


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2))) if values.size else 0.0


def _begins_anew(angle: np.ndarray) -> bool:
    """Whether an angle jumps back by a turn and stays within one."""
    return bool(np.ptp(angle) < 2.0 * np.pi + 1e-6 and np.abs(np.diff(angle)).max(initial=0.0) > np.pi)


def common_rows(first: np.ndarray, second: np.ndarray) -> tuple[np.ndarray | None, np.ndarray | None]:
    """Rows of two runs at the same times; None where most rows of the first have none, as with steps of uneven length."""
    near = 1e-9 * max(float(first[-1]), 1e-300)
    k = np.minimum(np.searchsorted(second, first - near), second.size - 1)
    same = np.abs(second[k] - first) <= near
    return (np.flatnonzero(same), k[same]) if 2 * same.sum() >= first.size else (None, None)


def others(n: int, rows: np.ndarray) -> np.ndarray:
    """Of n rows those that are none of `rows`, in their order."""
    left = np.ones(n, dtype=bool)
    left[rows] = False
    return np.flatnonzero(left)


def _signal(result: Result, name: str) -> Signal | None:
    """The declaration of a recorded output."""
    unit, output = result.scene.split(name)
    interface = result.scene.coupling.interfaces.get(unit)
    return interface.outputs.get(output) if interface is not None else None


def between_rows(first: Result, second: Result) -> dict[str, float]:
    """How far signals depart from straight lines between the rows of the first run (rms, shares of their scales).

    Read from the rows that the second run has between them; of numbers that are no flags. What departs by much is not shown by
    its rows: extremes, counts and shares of time miss what lies between two.
    """
    there = common_rows(first.time, second.time)[1]
    if there is None or 2 * second.rows < 3 * there.size or there.size < FEWEST_ROWS:
        return {}
    between = there[0] + others(there[-1] - there[0], there[:-1] - there[0])
    gaps = {}
    for name, x in ((name, second[name]) for name in second.columns):
        signal = _signal(first, name)
        if signal is None or signal.kind != "real" or (signal.unit == "1" and _whole(x)) or not np.isfinite(x).all():
            continue
        if scale := scale_of(x, signal.nominal):
            gaps[name] = _rms(x[between] - np.interp(second.time[between], second.time[there], x[there])) / scale
    return gaps


def excerpt(first: Result, second: Result, name: str) -> Excerpt | None:
    """`EXCERPT` rows of a signal of two runs about the one where they differ most; None of flags and of equal signals."""
    if name not in first.columns:
        return None
    here, there = common_rows(first.time, second.time)
    rows = np.arange(first.rows) if here is None else here
    a = first[name][rows]
    b = np.interp(first.time, second.time, second[name]) if there is None else second[name][there]
    gap = np.abs(a - b)
    if not (np.isfinite(a).all() and np.isfinite(b).all() and gap.any()):
        return None
    begin = max(min(int(gap.argmax()) - EXCERPT // 2, rows.size - EXCERPT), 0)
    shown = slice(begin, begin + EXCERPT)
    time, run, finer = (tuple(column[shown].tolist()) for column in (first.time[rows], a, b))
    return Excerpt(signal=name, time=time, run=run, finer=finer)


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
    return SignalError(factor * d.rms, factor * d.largest, shifted=d.rest < d.rms, grown=d.spread, late=d.late)


def _of_three(d: Difference, d2: Difference) -> SignalError:
    order = min(log2(d.rms / d2.rms), HIGHEST_ORDER) if d.rms and d2.rms else nan
    (first, last), (first2, last2) = d.ends, d2.ends
    later = max(first, first2) < TOGETHER and max(last, last2) > APART
    at_once = isfinite(d.together) and d2.together < LATER * d.together  # a drift takes twice as long with half the step
    alike = all(1.0 / SAME_SPREAD < one.spread < SAME_SPREAD for one in (d, d2))
    parted = d2.rms * CONVERGING > d.rms and alike and (later or at_once)
    return SignalError(
        d.rms + 2.0 * d2.rms,
        d.largest + 2.0 * d2.largest,
        order,
        2.0 * d2.rms,
        parted,
        d.rest < d.rms,
        grown=d.spread * d2.spread,
        late=d.late * d2.reach,
    )


def figure_errors(runs: Sequence[KeyResults], *, unsure: bool = False) -> dict[str, float]:
    """Errors of the first run's figures, from two or three runs, in the figures' own units; NaN where a run lacks a figure.

    `unsure`: of two runs that differ too much for an error of their difference alone.
    """
    first, second, *more = runs
    gaps = first.gaps(second)
    if not more:
        return {name: (UNSURE if unsure else SURE) * gap for name, gap in gaps.items()}
    further = second.gaps(more[0])
    return {name: gap + 2.0 * further.get(name, nan) for name, gap in gaps.items()}


def worst_of(errors: Mapping[str, SignalError], of: Callable[[SignalError], float] = lambda one: one.rms) -> str:
    """The name of the signal with the largest error; "" of none."""
    return max(errors, key=lambda name: of(errors[name]), default="")
