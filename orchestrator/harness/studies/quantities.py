"""Quantities of interest of a run, and their errors against a reference as shares that a user reads in percent.

The error of a quantity is its distance from the reference's over the range that the reference's signal goes through, or over
its magnitude where it is constant; of a low-pass-filtered signal, over its standard deviation, as contact forces are compared.
The distance of two histories is the larger one of two rms values: over the part of the run in which the reference moves, so that
rest does not make an error smaller, and over the whole run, for a law that creeps at rest. The largest distance is given, too.
The error of a run is the largest error of its quantities.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import inf, isfinite

import numpy as np

from ....components.core.errors import BadInput
from ...run.key_results import STATISTICS
from ...run.results import Result
from ...scene.scene import Scene
from ...settings.study import Wanted, wanted
from ...units.interface import Signal
from ..analysis.signals import ButterworthFilter, amplitude_at, uniform

CONSTANT = 1e-6  # of a signal's magnitude or nominal value: what varies less is constant
MOVES = 0.01  # of the whole range: a reference that covers more within `ABOUT` of the run moves there
ABOUT = 0.01
EDGE = 2.0  # periods of the cut-off: within them of an end of a run, a filtered signal depends on how it is continued there


@dataclass(frozen=True)
class TimeHistory:
    """What a solution gives of its signals. time: (n,) s; columns: "unit.output" -> (n,)."""

    time: np.ndarray
    columns: Mapping[str, np.ndarray]


@dataclass(frozen=True)
class Quantity:
    """One quantity of a scene's runs.

    signal: "unit.output".  kind: of `settings.study.QUANTITY_KINDS`.  frequency: Hz, of an amplitude.
    transient: s from the start that do not count.  nominal: of the signal, the scale where a reference is zero throughout.
    unit: of measure; angles in rad are compared as directions, because some units give them from 0 to a full turn.
    cutoff: Hz, of the `ButterworthFilter` that the whole signal goes through first, after which both ends lose `EDGE`; 0 without.
    """

    name: str
    signal: str
    kind: str
    frequency: float
    transient: float
    nominal: float
    unit: str = ""
    cutoff: float = 0.0

    def value(self, history: TimeHistory) -> float:
        """The number that a history gives; NaN for the kind "time history", which only a comparison has."""
        time, x = self._kept(history)
        if self.kind == "time history":
            return float("nan")
        if self.kind == "end":
            return float(x[-1])
        if self.kind in STATISTICS:
            return float(STATISTICS[self.kind](x))
        rate, _, (even,) = uniform(time, x)
        return amplitude_at(even, rate, self.frequency)

    def error(self, history: TimeHistory, reference: TimeHistory) -> float:
        """Distance over the reference's range; infinite where the history has no finite number for it or ends early.

        A history is compared at its own instants, between which the reference is interpolated linearly.
        """
        if history.time.size < 2 or history.time[-1] < reference.time[-1] - 1e-9 * abs(reference.time[-1]):
            return inf
        if self.kind == "time history":
            there, distances = self._distances(history, reference)
            distance = max(float(np.sqrt(np.mean(part**2))) for part in (distances, distances[moving(there)]))
        else:
            distance = abs(float(self._apart(np.array(self.value(history) - self.value(reference)))))
        return distance / self.scale(reference) if isfinite(distance) else inf

    def largest(self, history: TimeHistory, reference: TimeHistory) -> float:
        """As `error`, with the largest distance of two histories in the place of its rms."""
        if self.kind != "time history" or not isfinite(self.error(history, reference)):
            return self.error(history, reference)
        return float(np.abs(self._distances(history, reference)[1]).max()) / self.scale(reference)

    def _distances(self, history: TimeHistory, reference: TimeHistory) -> tuple[np.ndarray, np.ndarray]:
        """(n,) the reference at the history's instants, and how far the history is from it; NaN where it is not finite."""
        time, x = self._kept(history)
        there = self._signal(reference)
        there = np.interp(time, reference.time, np.unwrap(there) if self.unit == "rad" else there)
        return there, self._apart(x - there)

    def between_samples(self, reference: TimeHistory) -> float:
        """How far a sampled extreme may be from the true one, by a parabola through it and its neighbours, over the scale."""
        if self.kind not in ("maximum", "minimum"):
            return 0.0
        _, x = self._kept(reference)
        k = int(np.argmax(x) if self.kind == "maximum" else np.argmin(x))
        if not 0 < k < x.size - 1:
            return 0.0
        before, at, after = (float(v) for v in x[k - 1 : k + 2])
        bend = abs(before - 2.0 * at + after)
        return (before - after) ** 2 / (8.0 * bend * self.scale(reference)) if bend > 0.0 else 0.0

    def scale(self, reference: TimeHistory) -> float:
        """Range of the reference's signal, or its magnitude where it is constant, or its nominal value where that is zero.

        Of a filtered signal its standard deviation is in the place of the range.
        """
        _, x = self._kept(reference)
        size, width = float(np.abs(x).max()), float(np.std(x) if self.cutoff else np.ptp(x))
        if width > CONSTANT * max(size, self.nominal):
            return width
        return size if size > CONSTANT * self.nominal else self.nominal

    def _apart(self, differences: np.ndarray) -> np.ndarray:
        return np.remainder(differences + np.pi, 2.0 * np.pi) - np.pi if self.unit == "rad" else differences

    def _kept(self, history: TimeHistory) -> tuple[np.ndarray, np.ndarray]:
        """Instants and signal after the transient, without the ends that a filter distorts."""
        time, x, edge = history.time, self._signal(history), EDGE / self.cutoff if self.cutoff else 0.0
        since = time - time[0]
        first = min(int(np.searchsorted(since, max(self.transient, edge) * (1.0 - 1e-12))), time.size - 1)
        last = int(np.searchsorted(since, (since[-1] - edge) * (1.0 + 1e-12), side="right"))
        return time[first : max(last, first + 1)], x[first : max(last, first + 1)]

    def _signal(self, history: TimeHistory) -> np.ndarray:
        """The signal or the filtered one, (n,), at the history's instants; NaN where these are too far apart for the filter."""
        x = history.columns[self.signal]
        if not self.cutoff or not np.isfinite(x).all():
            return x
        rate, even, (samples,) = uniform(history.time, x)
        if not self.cutoff < 0.5 * rate:
            return np.full_like(x, np.nan)
        return np.interp(history.time, even, ButterworthFilter(self.cutoff).apply(samples, rate))


def moving(reference: np.ndarray) -> np.ndarray:
    """(n,) truth values: where a signal (n,) moves; everywhere for one that nowhere does."""
    from scipy.ndimage import maximum_filter1d, minimum_filter1d

    about = max(3, int(ABOUT * reference.size))
    covers = maximum_filter1d(reference, about) - minimum_filter1d(reference, about)
    there = covers > MOVES * np.ptp(reference)
    return there if there.any() else np.ones(reference.size, dtype=bool)


def quantities_of(scene: Scene) -> tuple[Quantity, ...]:
    """The quantities that the scene names, or else the history and the maximum of every recorded signal that is physical.

    Flags, counts and texts are none: of an instant that is a step late a history of 0 and 1 makes an error as large as its range.
    A scene that asks for the share of time of a flag names its mean.
    """
    coupling = scene.coupling
    texts = [wanted(text) for text in scene.study.quantities] or [
        Wanted(".".join(end), kind)
        for end in coupling.signals
        if _is_physical(coupling.interfaces[end[0]].outputs.get(end[1]))
        for kind in ("time history", "maximum")
    ]
    transient = scene.analysis.transient
    quantities = []
    for text in texts:
        unit, output = scene.split(text.signal)
        of = coupling.interfaces[unit].outputs[output]
        quantities.append(
            Quantity(str(text), text.signal, text.kind, text.frequency, transient, of.nominal, of.unit, text.cutoff)
        )
    return tuple(quantities)


def _is_physical(signal: Signal | None) -> bool:
    return signal is not None and signal.kind == "real"


def quantities_to_judge(scene: Scene) -> tuple[Quantity, ...]:
    """As `quantities_of`; raises `BadInput` without any, or where transient and the ends of a filter leave nothing of the run."""
    quantities = quantities_of(scene)
    if not quantities:
        raise BadInput(
            f"{scene.name}: study.quantities",
            "no quantity, and no recorded signal that is a physical one",
            'quantities = ["unit.output, time history"]',
            'Of a flag the share of time is "unit.output, mean".',
        )
    for q in quantities:
        if q.cutoff and scene.duration <= (shortest := max(q.transient, EDGE / q.cutoff) + EDGE / q.cutoff):
            raise BadInput(
                f"{scene.name}: study.quantities",
                f'"{q.name}" of a run of {scene.duration:g} s',
                f"a run of more than {shortest:g} s, with transient and both ends of the filter",
                "Lengthen the run, or filter at a higher frequency.",
            )
    return quantities


def recording(scene: Scene) -> Scene:
    """The scene with what its quantities need among the recorded signals."""
    recorded = [".".join(end) for end in scene.coupling.signals]
    missing = [q.signal for q in quantities_of(scene) if q.signal not in recorded]
    return scene.with_changes({"record.signals": [*recorded, *dict.fromkeys(missing)]}) if missing else scene


def errors(quantities: Sequence[Quantity], history: TimeHistory, reference: TimeHistory) -> dict[str, float]:
    """Error by its name of each quantity that the history has: a run without an effect lacks the effect's outputs."""
    return {q.name: q.error(history, reference) for q in quantities if q.signal in history.columns}


def distances(result: Result, finer: Result) -> dict[str, float]:
    """Distance of each quantity of a run from that of a finer run."""
    first, second = (TimeHistory(r.time, r.columns) for r in (result, finer))
    return errors(quantities_of(result.scene), first, second)


def percent(share: float) -> str:
    """An error as a user reads it."""
    if not isfinite(share):
        return "–"
    return f"{100.0 * share:.3g} %" if abs(share) < 10.0 else f"{100.0 * share:.0f} %" if abs(share) < 1e4 else "beyond 1e6 %"
