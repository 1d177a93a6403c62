"""Quantities of interest of a run, and how far they are from a reference: errors a user can read as percent.

The error of a quantity is its distance from the reference's over the range that the reference's signal goes through, or over
its magnitude where it is constant. The error of a run is the largest of its quantities'.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import inf, isfinite

import numpy as np

from ...scene.scene import Scene
from ...settings.study import Wanted, wanted
from ..analysis.signals import amplitude_at, uniform
from ..sweep import KINDS

CONSTANT = 1e-6  # of a signal's magnitude or nominal value: what varies less is constant


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
    """

    name: str
    signal: str
    kind: str
    frequency: float
    transient: float
    nominal: float
    unit: str = ""

    def value(self, history: TimeHistory) -> float:
        """The number that a history gives; NaN for the kind "time history", which only a comparison has."""
        x, time = self._kept(history, history.time)
        if self.kind == "time history":
            return float("nan")
        if self.kind == "end":
            return float(x[-1])
        if self.kind in KINDS:
            return float(KINDS[self.kind](x))
        rate, _, (even,) = uniform(time, x)
        return amplitude_at(even, rate, self.frequency)

    def error(self, history: TimeHistory, reference: TimeHistory) -> float:
        """Distance over the reference's range; infinite where the history has no finite number for it or ends early.

        A history is compared at its own instants, between which the reference is interpolated linearly.
        """
        if history.time.size < 2 or history.time[-1] < reference.time[-1] * (1.0 - 1e-9):
            return inf
        scale = self.scale(reference)
        if self.kind == "time history":
            x, time = self._kept(history, history.time)
            there = reference.columns[self.signal]
            there = np.interp(time, reference.time, np.unwrap(there) if self.unit == "rad" else there)
            distance = float(np.sqrt(np.mean(self._apart(x - there) ** 2))) if np.isfinite(x).all() else inf
        else:
            distance = abs(float(self._apart(np.array(self.value(history) - self.value(reference)))))
        return distance / scale if isfinite(distance) else inf

    def between_samples(self, reference: TimeHistory) -> float:
        """How far a sampled extreme may be from the true one, by a parabola through it and its neighbours, over the scale."""
        if self.kind not in ("maximum", "minimum"):
            return 0.0
        x, _ = self._kept(reference, reference.time)
        k = int(np.argmax(x) if self.kind == "maximum" else np.argmin(x))
        if not 0 < k < x.size - 1:
            return 0.0
        before, at, after = (float(v) for v in x[k - 1 : k + 2])
        bend = abs(before - 2.0 * at + after)
        return (before - after) ** 2 / (8.0 * bend * self.scale(reference)) if bend > 0.0 else 0.0

    def scale(self, reference: TimeHistory) -> float:
        """Range of the reference's signal, or its magnitude where it is constant, or its nominal value where that is zero."""
        x, _ = self._kept(reference, reference.time)
        size, width = float(np.abs(x).max()), float(np.ptp(x))
        if width > CONSTANT * max(size, self.nominal):
            return width
        return size if size > CONSTANT * self.nominal else self.nominal

    def _apart(self, differences: np.ndarray) -> np.ndarray:
        return np.remainder(differences + np.pi, 2.0 * np.pi) - np.pi if self.unit == "rad" else differences

    def _kept(self, history: TimeHistory, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The signal after the transient, and its instants."""
        first = min(int(np.searchsorted(time, self.transient * (1.0 - 1e-12))), time.size - 1)
        return history.columns[self.signal][first:], time[first:]


def quantities_of(scene: Scene) -> tuple[Quantity, ...]:
    """The quantities that the scene names, or else the history and the maximum of every recorded signal."""
    coupling = scene.coupling
    texts = [wanted(text) for text in scene.study.quantities] or [
        Wanted(".".join(end), kind, 0.0) for end in coupling.signals for kind in ("time history", "maximum")]
    transient = scene.analysis.transient
    quantities = []
    for signal, kind, frequency in texts:
        unit, output = scene.split(signal)
        of = coupling.interfaces[unit].outputs[output]
        name = f"{signal}, {kind.replace('F Hz', f'{frequency:g} Hz')}"
        quantities.append(Quantity(name, signal, kind, frequency, transient, of.nominal, of.unit))
    return tuple(quantities)


def recording(scene: Scene) -> Scene:
    """The scene with what its quantities need among the recorded signals."""
    recorded = [".".join(end) for end in scene.coupling.signals]
    missing = [q.signal for q in quantities_of(scene) if q.signal not in recorded]
    return scene.with_changes({"record.signals": [*recorded, *dict.fromkeys(missing)]}) if missing else scene


def errors(quantities: Sequence[Quantity], history: TimeHistory, reference: TimeHistory) -> dict[str, float]:
    """Error of each quantity by its name."""
    return {q.name: q.error(history, reference) for q in quantities}


def percent(share: float) -> str:
    """An error as a user reads it."""
    if not isfinite(share):
        return "–"
    return f"{100.0 * share:.3g} %" if abs(share) < 10.0 else f"{100.0 * share:.0f} %" if abs(share) < 1e4 else "beyond 1e6 %"
