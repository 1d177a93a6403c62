"""Measured curves beside signals of a run: filtered alike, compared where both exist."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np

from ....components.core.errors import BadInput
from ...run.instants import at_instants
from ...run.key_results import STATISTICS
from ...scene.measured import FEWEST, Measured
from ...scene.sums import parts_alone
from ...settings.case import CurveSettings
from ..analysis.signals import ButterworthFilter, amplitude_spectrum, uniform
from ..charts.chart import Chart, Panel, Series

if TYPE_CHECKING:
    from ...scene.scene import Scene

EDGE = 2.0  # periods of the cut-off at either end, which a filter distorts
EMPTY, OUTSIDE = "without a number", "outside of the run"
COARSER = 3.0  # a spacing twice as wide changes a curve with kinks by at least so many times what the spacing itself leaves open
SHOWN = (
    0.9  # of half the samples a second: what a measurement shows at the frequency where it is (an anti-aliasing filter's reach)
)
SHARP = 12  # order of the filter that takes the rest away


class RecordedRun(Protocol):
    """A run, or what is kept of one. time: (n,) s.  measures: units by signal."""

    @property
    def time(self) -> np.ndarray: ...

    @property
    def scene(self) -> Scene: ...

    @property
    def measures(self) -> Mapping[str, str]: ...

    def __getitem__(self, name: str) -> np.ndarray: ...


@dataclass(frozen=True)
class CurveComparison:
    """A measured curve and the run at the measured instants, where both exist.

    time: (n,) s of the run, rising.  x: (n,) what the measurement is over.  measured, simulated: (n,), filtered alike.
    between: (n,) estimate of what the run may be off there because it is recorded at rows only.  left_out: why -> how many
    samples of the file are not compared.  noise: standard deviation of the measurement; None: not known.  alone: that the signal
    is a part of a sum, in a sentence, where the rest is not zero among the compared instants.
    """

    curve: CurveSettings
    unit: str
    time: np.ndarray
    x: np.ndarray
    measured: np.ndarray
    simulated: np.ndarray
    between: np.ndarray
    left_out: Mapping[str, int]
    noise: float | None = None
    alone: str = ""

    @property
    def numbers(self) -> Mapping[str, tuple[float, float, float]]:
        """Kind of tolerance -> (measured, simulated, size that a tolerance is a share of)."""
        m, s = self.measured, self.simulated
        spread = float(np.std(m))
        both = {kind: (float(f(m)), float(f(s))) for kind, f in STATISTICS.items()}
        numbers = {kind: (measured, simulated, abs(measured)) for kind, (measured, simulated) in both.items()}
        return numbers | {"difference": (0.0, float(np.sqrt(np.mean((s - m) ** 2))), spread)}

    @property
    def incomplete(self) -> bool:
        """Whether samples are not compared that the settings do not leave out."""
        return bool(self.left_out[EMPTY] or self.left_out[OUTSIDE])

    @property
    def counted(self) -> str:
        """How many samples are compared, and why the others are not."""
        left = {why: count for why, count in self.left_out.items() if count}
        whole = self.time.size + sum(left.values())
        why = "".join(f"{', ' if k else ': '}{count} {reason}" for k, (reason, count) in enumerate(left.items()))
        return f"{self.time.size} of {whole} samples of {self.curve.file} are compared{why}."

    def chart(self) -> Chart:
        """Both over time or `over`, and their amplitude spectra."""
        c = self.curve
        label = f"{c.signal}, {self.unit}"
        lines = (Series("measured", self.x, self.measured), Series("simulated", self.x, self.simulated))
        history = Panel(label, lines, x_label=c.over or "time, s")
        rate, _, both = uniform(self.time, self.measured, self.simulated)
        series, highest = [], c.cutoff or 0.5 * rate
        for name, values in zip(("measured", "simulated"), both, strict=True):
            f, a = amplitude_spectrum(values, rate)
            shown = (f > 0.0) & (f <= 1.5 * highest)
            series.append(Series(name, f[shown], a[shown]))
        spectrum = Panel(f"amplitude, {self.unit}", tuple(series), x_label="frequency, Hz")
        how = str(ButterworthFilter(c.cutoff)) if c.cutoff else "unfiltered"
        span = f"from {self.time[0]:.4g} to {self.time[-1]:.4g} s of the run"
        text = f"Measured: {c.file}. Both {how}, at the measured instants {span}. {self.counted}"
        where = f", {c.condition}" if c.condition else ""
        return Chart(f"{c.signal} against the measurement{where}", "", (history, spectrum), text, columns=1, height=260)


def compare_curve(curve: CurveSettings, measured: Measured, result: RecordedRun) -> CurveComparison:
    """The comparison of a measured curve with a run, which is evaluated at the measured instants: a run is dense and without noise.

    A filter goes over both sequences of samples alike, so that neither their spacing nor a gap makes a difference. Before it the run
    loses what the measurement's spacing cannot show. Raises `BadInput` where the signal cannot be used, or both share no stretch.
    """
    where = f"curve {curve.file}"
    time, simulated = result.time, np.asarray(result[curve.signal], dtype=float)
    way = np.asarray(result[curve.over], dtype=float) if curve.over else time
    if not (np.diff(way) > 0.0).all():
        raise BadInput(where, f"over = {curve.over!r}, which does not rise throughout the run", "a signal that rises")
    x = measured.x
    rounding = 1e-9 * (way[-1] - way[0])
    inside = (x >= way[0] - rounding) & (x <= way[-1] + rounding)
    at, y = at_instants(x[inside], way, time), measured.y[inside]
    trim = EDGE / curve.cutoff if curve.cutoff else 0.0
    begin, end = (at[0] + trim, at[-1] - trim) if at.size else (np.inf, -np.inf)
    kept = (at >= max(begin, result.scene.counts_from)) & (at <= end)
    if kept.sum() < FEWEST:
        raise BadInput(
            where,
            f"measured from {x[0]:.4g} to {x[-1]:.4g}, simulated from {way[0]:.4g} to {way[-1]:.4g}: {kept.sum()} samples",
            f"a stretch that both have, with {FEWEST} samples or more without the transient and the ends of the filter",
            "Look at time, shift and over.",
        )
    if curve.cutoff is not None:
        time, simulated = _as_sampled(curve.cutoff, at, time, simulated, where)
    s = at_instants(at, time, simulated)
    between = np.abs(s - at_instants(at, time[::2], simulated[::2])) / COARSER
    if curve.cutoff is not None:
        y, s = (_filtered(curve.cutoff, at, values) for values in (y, s))
    left_out = {
        EMPTY: measured.empty,
        OUTSIDE: int(x.size - at.size),
        "within the transient or the ends of the filter": int(at.size - kept.sum()),
    }
    unit = result.measures.get(curve.signal, "")
    rows = (result.time >= at[kept][0]) & (result.time <= at[kept][-1])
    alone = parts_alone(result.scene, [curve.signal], lambda name: result[name][rows])
    return CurveComparison(
        curve, unit, at[kept], x[inside][kept], y[kept], s[kept], between[kept], left_out, measured.noise, "; ".join(alone)
    )


def _as_sampled(cutoff: float, at: np.ndarray, time: np.ndarray, values: np.ndarray, where: str) -> tuple[np.ndarray, np.ndarray]:
    """(even times, values) of the run without what samples at these instants would show at other frequencies."""
    run_rate, even, (values,) = uniform(time, values)
    rate = 1.0 / float(np.median(np.diff(at)))
    for name, r in (("the run", run_rate), ("the file", rate)):
        if not cutoff < 0.5 * r:
            raise BadInput(where, f"a cut-off of {cutoff:g} Hz at {r:g} samples a second of {name}", f"less than {0.5 * r:g} Hz")
    highest = SHOWN * 0.5 * rate
    return even, ButterworthFilter(highest, SHARP).apply(values, run_rate) if cutoff < highest < 0.45 * run_rate else values


def _filtered(cutoff: float, at: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Samples (n,) at these instants after the low-pass filter."""
    rate, even, (values,) = uniform(at, values)
    return np.interp(at, even, ButterworthFilter(cutoff).apply(values, rate))
