"""Whether the macro steps of a run were short enough for its signals: judged at the end, from every step, however few.

Of each signal that the master reads, differences between neighbouring steps of equal length are summed:

    resolution      q = rms(x[n+1] - 2 x[n] + x[n-1]) / (4 std(x))    sin²(φ/2) of an oscillation with a phase φ per step;
                                                                      1 where every sample is on the other side than the last
    extrapolation   e = rms(x[n+1] - its extrapolation from the p + 1 samples before) / std(x)

Both fall with the step where the coupling is stable. One that is unstable, or that only a contact which opens keeps bounded,
has errors of extrapolation as large as the signal itself.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..engine.algorithms.gauss_seidel import GaussSeidel
from ..engine.algorithms.jacobi import Jacobi
from ..engine.algorithms.master import Master
from ..engine.coupling import Coupling
from ..engine.coupling.graph import Endpoint, is_discrete
from ..engine.stepping.observers import BatchObserver
from ..units.interface import Signal

CHUNK = 2048  # steps that are kept
PIECE = 12_000  # numbers that are added up together: arrays below the size for which memory comes from the system each time
TAIL = 3  # rows that the differences of the next ones need
NEGLIGIBLE = 1e-9  # of the largest value, or of the nominal one: a spread below it is rounding
PARTS = 4  # of a run, whose second differences are compared
# Set above what half of the shipped scenes have at their own settings, e up to 0.34 and q up to 0.32; docs/stability-hunt.md.
INACCURATE = 0.5  # e from which an extrapolation is no approximation of its signal
WRONG_STEP = 0.1  # of a signal's spread, that a single macro step is wrong by; shipped scenes have up to 0.06
UNRESOLVED = 0.4  # q from which samples do not show a signal: fewer than 4.6 of them in a period
SUSPICIOUS = 0.02  # e from which a coupling that does not die out is compared with its closed-form limit,
COARSE = 0.23  # and from which any is: 13 steps of linear extrapolation in a period
JUMP = 1e3  # largest error of an extrapolation over that of the step before: no coupling grows so fast, a set point jumps so
AT_REST = 1e6  # growth from which a signal stood still before its last part
GROWING = 1.5  # of the second differences, in the last part of a run
FEWEST = 3  # second differences from which a rate can be estimated


@dataclass(frozen=True)
class SignalResolution:
    """What the steps of a run say of one signal.

    resolution: q, extrapolation: e, as above; e is 0 where no unit extrapolates the signal, and where it jumps from rest.
    growth: rms of the second differences in the last quarter of the run over the largest of the quarters before.
    peak: largest absolute value.  spread: standard deviation.
    """

    end: Endpoint
    signal: Signal
    resolution: float
    extrapolation: float
    growth: float
    peak: float
    spread: float = 0.0

    @property
    def text(self) -> str:
        """The signal as messages name it."""
        return ".".join(self.end)


SUMS = ("_tail", "_tail_ticks", "_count", "_predictions", "_first", "_peak", "_total", "_total2", "_missed", "_seconds",
        "_triples", "_largest", "_before", "_last")


class StepResolution(BatchObserver):
    """Sums over all macro steps; a few array operations for some hundred of them."""

    def __init__(self, master: Master, steps: int):
        """`steps`: of the whole run, about."""
        interfaces = master.coupling.interfaces
        self._sample, self._degree = master.sample, master.degree
        self._signals = [(end, interfaces[end[0]].outputs[end[1]]) for end in master.positions]
        self._extrapolated = extrapolated(master)
        # the compliance at a contact's place follows its mesh, not the motion: it is right at every instant for itself
        self._judged = [not any(link.source == end and link.target[1].endswith("_compliance") for link in master.coupling.links)
                        for end, _ in self._signals]
        self._part = max(-(-steps // PARTS), 1)
        n = len(self._signals)
        self._rows: list[np.ndarray] = []  # blocks (k, n)
        self._ticks: list[Sequence[int]] = []
        self._tail, self._tail_ticks = np.zeros((0, n)), np.zeros(0, dtype=np.int64)
        self._buffered = self._count = self._predictions = 0
        self._first, self._peak = np.zeros(n), np.zeros(n)
        self._total, self._total2, self._missed = np.zeros(n), np.zeros(n), np.zeros(n)
        self._seconds, self._triples = np.zeros((PARTS, n)), np.zeros(PARTS)
        self._largest, self._before, self._last = np.zeros(n), np.zeros(n), np.zeros(n)  # errors of extrapolation

    def __call__(self, tick: int, t: float) -> None:
        self.observe_batch((tick,), (t,), np.array([self._sample()], dtype=float))

    def observe_batch(self, ticks: Sequence[int], times: Any, rows: np.ndarray) -> None:
        """As in `BatchObserver`."""
        self._rows.append(rows)
        self._ticks.append(ticks)
        self._buffered += len(ticks)
        if self._buffered >= CHUNK:
            self._add()

    def _add(self) -> None:
        """Add what was buffered to the sums, in pieces that stay in a near cache."""
        new, ticks = np.concatenate(self._rows), np.concatenate(self._ticks)
        self._rows, self._ticks, self._buffered = [], [], 0
        if not self._count:
            self._first = new[0].copy()
        size = max(PIECE // max(new.shape[1], 1), 1)
        for first in range(0, len(new), size):
            self._add_piece(new[first : first + size], ticks[first : first + size])

    def _add_piece(self, rows: np.ndarray, ticks: np.ndarray) -> None:
        known = len(self._tail)
        rows, ticks = np.concatenate((self._tail, rows)), np.concatenate((self._tail_ticks, ticks))
        signals = np.ascontiguousarray(rows.T)  # (n, steps): sums over long rows take a third of the time
        new = signals[:, known:]
        apart = new - self._first[:, None]
        self._total += apart.sum(axis=1)
        self._total2 += _squared(apart)
        self._peak = np.maximum(self._peak, np.maximum(new.max(axis=1), -new.min(axis=1)))
        seconds, ends = _differences(signals, ticks, 2, known)
        parts = np.minimum((self._count - known + ends) // self._part, PARTS - 1)
        for part in range(parts[0], parts[-1] + 1) if len(parts) else ():
            mine = slice(*np.searchsorted(parts, (part, part + 1)))
            self._seconds[part] += _squared(seconds[:, mine])
            self._triples[part] += mine.stop - mine.start
        missed = seconds if self._degree == 1 else _differences(signals, ticks, self._degree + 1, known)[0]
        self._missed += _squared(missed)
        self._predictions += missed.shape[1]
        self._find_largest(np.abs(missed))
        self._count += new.shape[1]
        self._tail, self._tail_ticks = rows[-TAIL:].copy(), ticks[-TAIL:].copy()

    def _find_largest(self, missed: np.ndarray) -> None:
        """Keep of each signal the largest error of an extrapolation so far, and the error of the step before it; (n, steps)."""
        if not missed.shape[1]:
            return
        at, signals = missed.argmax(axis=1), np.arange(len(missed))
        larger = missed[signals, at] > self._largest
        before = np.where(at > 0, missed[signals, at - 1], self._last)
        self._largest = np.where(larger, missed[signals, at], self._largest)
        self._before = np.where(larger, before, self._before)
        self._last = missed[:, -1].copy()

    def state(self) -> dict[str, Any]:
        """The sums so far, for a checkpoint."""
        if self._rows:
            self._add()
        return {name: getattr(self, name) for name in SUMS}

    def take(self, state: Mapping[str, Any]) -> None:
        """Go on from a `state`."""
        self._rows, self._ticks, self._buffered = [], [], 0
        for name in SUMS:
            setattr(self, name, state[name])

    def judge(self) -> list[SignalResolution]:
        """What the steps say of each signal that varies; call it once, at the end."""
        with np.errstate(all="ignore"):
            if self._rows:
                self._add()
            if self._triples.sum() < FEWEST:
                return []
            n = max(self._count, 1)
            spread = np.sqrt(np.maximum(self._total2 / n - (self._total / n) ** 2, 0.0))
            resolution = np.sqrt(self._seconds.sum(axis=0) / max(self._triples.sum(), 1.0)) / (4.0 * spread)
            errors = np.sqrt(self._missed / max(self._predictions, 1)) / spread
            by_part = np.sqrt(self._seconds / np.maximum(self._triples, 1.0)[:, None])
            by_part = by_part[self._triples > 0]
            growth = by_part[-1] / by_part[:-1].max(axis=0) if len(by_part) > 1 else np.zeros(len(spread))
            errors[(self._largest > JUMP * self._before) & (growth > AT_REST)] = 0.0  # a jump, which no extrapolation foretells
        return [SignalResolution(end, signal, float(resolution[k]), float(errors[k]) if end in self._extrapolated else 0.0,
                                 float(growth[k]), float(self._peak[k]), float(spread[k]))
                for k, (end, signal) in enumerate(self._signals)
                if self._judged[k] and not is_discrete(signal) and spread[k] > NEGLIGIBLE * max(self._peak[k], signal.nominal)]


def _differences(signals: np.ndarray, ticks: np.ndarray, order: int, known: int) -> tuple[np.ndarray, np.ndarray]:
    """(differences of an order (n, m), step that each ends at (m,)) among equal steps, of those that end behind `known` ones."""
    ends = np.arange(order, len(ticks))
    even = ends >= known
    changes = np.diff(ticks, n=2) != 0  # the k-th: at step k + 1
    for back in range(1, order):
        even &= ~changes[order - 1 - back : len(ticks) - 1 - back]
    differences = signals
    for _ in range(order):
        differences = differences[:, 1:] - differences[:, :-1]
    if (first := max(known - order, 0)) and even[first:].all():  # the usual case: no copy
        return differences[:, first:], ends[first:]
    return (differences, ends) if even.all() else (differences[:, even], ends[even])


def _squared(values: np.ndarray) -> np.ndarray:
    """Sums of squares over the steps, (n, steps) -> (n,)."""
    return np.einsum("ij,ij->i", values, values)


def extrapolated(master: Master) -> set[Endpoint]:
    """Outputs that some unit takes as an extrapolation over every step; none where steps are repeated or contacts solved."""
    if not isinstance(master, Jacobi | GaussSeidel):
        return set()
    late = master.late if isinstance(master, GaussSeidel) else [len(node.links) for node in master.nodes]
    rates = master.coupling.rates
    return {link.source for node, count in zip(master.nodes, late, strict=True) for k, link in enumerate(node.links)
            if k < count and k not in node.held and link.source[0] not in rates and node.unit.name not in rates}


def diverging(signals: Sequence[SignalResolution], coupling: Coupling) -> SignalResolution | None:
    """The signal between units that feed one another whose extrapolation fails, and more so in the last part of the run."""
    grown = [one for one in fed_back(signals, coupling) if one.extrapolation > INACCURATE and one.growth > GROWING]
    return max(grown, key=lambda one: one.extrapolation, default=None)


def worth_a_limit(signals: Sequence[SignalResolution], coupling: Coupling) -> tuple[bool, bool]:
    """(whether to ask for the closed-form limit, because a coupling is coarse or does not die out; whether it grows)."""
    coarse = [one for one in fed_back(signals, coupling) if one.extrapolation > SUSPICIOUS]
    return (any(one.extrapolation > COARSE or one.growth > 1.0 for one in coarse),
            any(one.growth > GROWING for one in coarse))


def fed_back(signals: Sequence[SignalResolution], coupling: Coupling) -> list[SignalResolution]:
    """Those between units that feed one another."""
    group = {name: k for k, names in enumerate(coupling.groups) for name in names}
    inner = {link.source for link in coupling.links if group[link.source[0]] == group[link.target[0]]}
    return [one for one in signals if one.end in inner]


def too_coarse(signals: Sequence[SignalResolution], coupling: Coupling, local: Mapping[Endpoint, float]) -> list[str]:
    """What a user should know of signals that the macro steps were too long for, without what would help.

    local: errors of single macro steps by signal, as of `RepeatedSteps.errors`.
    """
    texts = []
    shares = {one.text: local.get(one.end, 0.0) / one.spread for one in fed_back(signals, coupling)}
    wrong = max(shares, key=shares.__getitem__, default="")
    if wrong and shares[wrong] > WRONG_STEP:
        texts.append(f"a single macro step is wrong by {100.0 * shares[wrong]:.0f} % of the spread of {wrong} (rms), compared "
                     "with two steps of half its length")
    missed = max(signals, key=lambda one: one.extrapolation, default=None)
    if missed is not None and missed.extrapolation > INACCURATE:
        texts.append(f"the values extrapolated of {missed.text} over a macro step were wrong by "
                     f"{100.0 * missed.extrapolation:.0f} % of its spread (rms): the macro step is too long for this coupling, "
                     "which may be unstable")
    coarse = sorted((one for one in signals if one.resolution > UNRESOLVED), key=lambda one: -one.resolution)
    if coarse:
        others = f" and {len(coarse) - 1} other signals change" if len(coarse) > 1 else " changes"
        texts.append(f"{coarse[0].text}{others} from one macro step to the next as much as in the whole run: the steps are too "
                     "long to show them")
    return texts
