"""Measured curves beside signals of a run: read, filtered alike, compared where both exist."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import isclose
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from ....components.core.columns import Columns, read_table
from ....components.core.errors import BadInput
from ....components.core.measure import conversion_of
from ...run.instants import at_instants
from ...settings.case import CurveSettings
from ..analysis.signals import Filter, amplitude_spectrum, uniform
from ..charts.chart import Chart, Panel, Series

if TYPE_CHECKING:
    from ...scene.scene import Scene

EDGE = 2.0  # periods of the cut-off at either end, which a filter distorts
STATISTICS: Mapping[str, Callable[[np.ndarray], Any]] = {
    "mean": np.mean,
    "standard deviation": np.std,
    "maximum": np.max,
    "minimum": np.min,
}
EMPTY, OUTSIDE = "without a number", "outside of the run"
LEAST = 8  # samples of both within the stretch that is compared
COARSER = 3.0  # a spacing twice as wide changes a curve with kinks by at least so many times what the spacing itself leaves open
SHOWN = (
    0.9  # of half the samples a second: what a measurement shows at the frequency where it is (an anti-aliasing filter's reach)
)
SHARP = 12  # order of the filter that takes the rest away


class Scaling(Protocol):
    """Settings of a measured curve or spectrum."""

    separator: str
    scale: float

    @property
    def model_fields_set(self) -> set[str]: ...


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
class Measured:
    """A measured curve. abscissa, ordinate: (n,), the former rising.  empty: lines of the file that have no number."""

    abscissa: np.ndarray
    ordinate: np.ndarray
    empty: int = 0


@dataclass(frozen=True)
class CurveComparison:
    """A measured curve and the run at the measured instants, where both exist.

    time: (n,) s of the run, rising.  abscissa: (n,) what the measurement is over.  measured, simulated: (n,), filtered alike.
    between: (n,) estimate of what the run may be off there because it is recorded at rows only.  left_out: why -> how many
    samples of the file are not compared.
    """

    curve: CurveSettings
    unit: str
    time: np.ndarray
    abscissa: np.ndarray
    measured: np.ndarray
    simulated: np.ndarray
    between: np.ndarray
    left_out: Mapping[str, int]

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
        """Both over the abscissa, and their amplitude spectra."""
        c = self.curve
        label = f"{c.signal}, {self.unit}"
        lines = (Series("measured", self.abscissa, self.measured), Series("simulated", self.abscissa, self.simulated))
        history = Panel(label, lines, x_label=c.over or "time, s")
        rate, _, both = uniform(self.time, self.measured, self.simulated)
        series, highest = [], c.cutoff or 0.5 * rate
        for name, values in zip(("measured", "simulated"), both, strict=True):
            f, a = amplitude_spectrum(values, rate)
            shown = (f > 0.0) & (f <= 1.5 * highest)
            series.append(Series(name, f[shown], a[shown]))
        spectrum = Panel(f"amplitude, {self.unit}", tuple(series), x_label="frequency, Hz")
        how = str(Filter(c.cutoff)) if c.cutoff else "unfiltered"
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
    x = measured.abscissa
    rounding = 1e-9 * (way[-1] - way[0])
    inside = (x >= way[0] - rounding) & (x <= way[-1] + rounding)
    at, y = at_instants(x[inside], way, time), measured.ordinate[inside]
    trim = EDGE / curve.cutoff if curve.cutoff else 0.0
    begin, end = (at[0] + trim, at[-1] - trim) if at.size else (np.inf, -np.inf)
    kept = (at >= max(begin, result.scene.counts_from)) & (at <= end)
    if kept.sum() < LEAST:
        raise BadInput(
            where,
            f"measured from {x[0]:.4g} to {x[-1]:.4g}, simulated from {way[0]:.4g} to {way[-1]:.4g}: {kept.sum()} samples",
            f"a stretch that both have, with {LEAST} samples or more without the transient and the ends of the filter",
            "Look at abscissa, shift and over.",
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
    return CurveComparison(curve, unit, at[kept], x[inside][kept], y[kept], s[kept], between[kept], left_out)


def _as_sampled(cutoff: float, at: np.ndarray, time: np.ndarray, values: np.ndarray, where: str) -> tuple[np.ndarray, np.ndarray]:
    """(even times, values) of the run without what samples at these instants would show at other frequencies."""
    run_rate, even, (values,) = uniform(time, values)
    rate = 1.0 / float(np.median(np.diff(at)))
    for name, r in (("the run", run_rate), ("the file", rate)):
        if not cutoff < 0.5 * r:
            raise BadInput(where, f"a cut-off of {cutoff:g} Hz at {r:g} samples a second of {name}", f"less than {0.5 * r:g} Hz")
    highest = SHOWN * 0.5 * rate
    return even, Filter(highest, SHARP).apply(values, run_rate) if cutoff < highest < 0.45 * run_rate else values


def _filtered(cutoff: float, at: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Samples (n,) at these instants after the low-pass filter."""
    rate, even, (values,) = uniform(at, values)
    return np.interp(at, even, Filter(cutoff).apply(values, rate))


def units_of(scene: Scene) -> dict[str, str]:
    """Units of measure of all outputs, by "unit.output"."""
    return {f"{u}.{n}": s.unit for u, i in scene.coupling.interfaces.items() for n, s in i.outputs.items()}


def read_curve(curve: CurveSettings, folder: Path, units: Mapping[str, str]) -> Measured:
    """The file's two columns in the units of time and signal, shifted; faults are one `BadInput` with file, line and column.

    units: of the signals of the run.
    """
    x, y = units.get(curve.over, "") if curve.over else "s", units.get(curve.signal, "")
    return read_columns(folder / curve.file, (curve.abscissa, x), (curve.ordinate, y), curve)


def read_columns(path: Path, abscissa: tuple[str, str], ordinate: tuple[str, str], settings: Scaling) -> Measured:
    """Two columns of a CSV by their names, each in a unit, the first one rising; faults are one `BadInput` with file and line.

    A line whose cell is empty or NaN in either column is left out and counted: loggers write so what they have not measured.
    """
    table = read_table(path, "curve", settings.separator)
    x = table.numbers(*abscissa)
    y = table.numbers(ordinate[0], _unit(table, *ordinate, settings))
    line, kept = np.array([number for number, _ in table.rows]), ~np.isnan(x + y)
    line, x, y = line[kept], x[kept], y[kept]
    if len(x) < LEAST:
        raise BadInput(str(path), f"{len(x)} lines of numbers", f"{LEAST} or more")
    if not (np.diff(x) > 0.0).all():
        k = int(np.argmin(np.diff(x) > 0.0)) + 1
        what = f"{x[k]:.9g} behind {x[k - 1]:.9g} of line {line[k - 1]}"
        raise BadInput(f"{path}, line {line[k]}", f"{abscissa[0]} that does not rise: {what}", "rising numbers")
    shift, offset = getattr(settings, "shift", 0.0), getattr(settings, "offset", 0.0)
    return Measured(x + shift, settings.scale * y + offset, int((~kept).sum()))


def _unit(table: Columns, name: str, unit: str, settings: Scaling) -> str:
    """The unit in which a column is read: that of the signal, or "" where the user's own factor leads there from that of the header."""
    written = table.unit(name, unit)
    if "scale" not in settings.model_fields_set or not written or not unit:
        return unit
    where, shown = f"{table.where}, column {name!r}", f"scale = {settings.scale:g} beside the unit {written!r}"
    if not isclose(abs(settings.scale), factor := conversion_of(written, unit, where, shown)[0], rel_tol=1e-6):
        raise BadInput(where, shown, f"scale = {factor:g}, which leads from {written} to {unit}, or no scale")
    return ""
