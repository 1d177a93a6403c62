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
from .step_sums import PARTS, Sums, add_steps

CHUNK = 2048  # steps that are kept
NEGLIGIBLE = 1e-9  # of the largest value, or of the nominal one: a spread below it is rounding
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


class StepResolution(BatchObserver):
    """Sums over all macro steps, added to by some hundred of them at a time."""

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
        self._rows: list[np.ndarray] = []  # blocks (k, n)
        self._ticks: list[Sequence[int]] = []
        self._buffered = 0
        self._sums = Sums.zeros(len(self._signals))

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
        """Add what was buffered to the sums."""
        if self._rows:
            ticks = np.concatenate([_wrapped(some) for some in self._ticks])
            with np.errstate(over="ignore"):  # differences of ticks, without Numba
                add_steps(np.concatenate(self._rows), ticks, self._degree, self._part, self._sums)
        self._rows, self._ticks, self._buffered = [], [], 0

    def state(self) -> dict[str, Any]:
        """The sums so far, for a checkpoint."""
        self._add()
        return self._sums._asdict()

    def take(self, state: Mapping[str, Any]) -> None:
        """Go on from a `state`."""
        self._rows, self._ticks, self._buffered = [], [], 0
        for mine, kept in zip(self._sums, (state[name] for name in Sums._fields), strict=True):
            mine[:] = kept

    def judge(self) -> list[SignalResolution]:
        """What the steps say of each signal that varies; call it once, at the end."""
        self._add()
        sums = self._sums
        steps, predictions, triples = sums.counts[0], sums.counts[1], sums.counts[2:]
        if triples.sum() < FEWEST:
            return []
        with np.errstate(all="ignore"):
            spread = np.sqrt(np.maximum(sums.total2 / steps - (sums.total / steps) ** 2, 0.0))
            resolution = np.sqrt(sums.seconds.sum(axis=0) / triples.sum()) / (4.0 * spread)
            errors = np.sqrt(sums.missed / max(predictions, 1)) / spread
            by_part = np.sqrt(sums.seconds[triples > 0] / triples[triples > 0, None])
            growth = by_part[-1] / by_part[:-1].max(axis=0) if len(by_part) > 1 else np.zeros(len(spread))
            errors[(sums.largest > JUMP * sums.before) & (growth > AT_REST)] = 0.0  # a jump, which no extrapolation foretells
        return [SignalResolution(end, signal, float(resolution[k]), float(errors[k]) if end in self._extrapolated else 0.0,
                                 float(growth[k]), float(sums.peak[k]), float(spread[k]))
                for k, (end, signal) in enumerate(self._signals)
                if self._judged[k] and not is_discrete(signal) and spread[k] > NEGLIGIBLE * max(sums.peak[k], signal.nominal)]


def _wrapped(ticks: Sequence[int]) -> np.ndarray:
    """Ticks modulo 2^64, (k,) int64: their differences are exact however fine the clock is."""
    try:
        if isinstance(ticks, range):  # which `asarray` takes one by one
            return np.arange(ticks.start, ticks.stop, ticks.step, dtype=np.int64)
        return np.asarray(ticks, dtype=np.int64)
    except OverflowError:
        return np.array([tick % 2**64 for tick in ticks], dtype=np.uint64).view(np.int64)


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
