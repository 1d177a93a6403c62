"""Measured curves beside signals of a run: read, filtered alike, compared where both exist."""

from __future__ import annotations

import csv
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from ....components.core.errors import BadInput, nearest
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
LEAST = 8  # samples of both within the stretch that is compared


class Recorded(Protocol):
    """A run, or what is kept of one. time: (n,) s.  measures: units by signal."""

    @property
    def time(self) -> np.ndarray: ...

    @property
    def scene(self) -> Scene: ...

    @property
    def measures(self) -> Mapping[str, str]: ...

    def __getitem__(self, name: str) -> np.ndarray: ...


@dataclass(frozen=True)
class Comparison:
    """A measured curve and the simulated one over the stretch where both exist, on the same even instants.

    time: (n,) s of the run.  abscissa: (n,) what the measurement is over.  measured, simulated: (n,), filtered alike.
    rate: Hz.
    """

    curve: CurveSettings
    unit: str
    time: np.ndarray
    abscissa: np.ndarray
    measured: np.ndarray
    simulated: np.ndarray
    rate: float

    @property
    def numbers(self) -> Mapping[str, tuple[float, float, float]]:
        """Kind of tolerance -> (measured, simulated, size that a tolerance is a share of)."""
        m, s = self.measured, self.simulated
        spread = float(np.std(m))
        both = {kind: (float(f(m)), float(f(s))) for kind, f in STATISTICS.items()}
        numbers = {kind: (measured, simulated, abs(measured)) for kind, (measured, simulated) in both.items()}
        return numbers | {"difference": (0.0, float(np.sqrt(np.mean((s - m) ** 2))), spread)}

    def chart(self) -> Chart:
        """Both over the abscissa, and their amplitude spectra."""
        c = self.curve
        label = f"{c.signal}, {self.unit}"
        lines = (Series("measured", self.abscissa, self.measured), Series("simulated", self.abscissa, self.simulated))
        history = Panel(label, lines, x_label=c.over or "time, s")
        series, highest = [], c.cutoff or 0.5 * self.rate
        for name, values in (("measured", self.measured), ("simulated", self.simulated)):
            f, a = amplitude_spectrum(values, self.rate)
            shown = (f > 0.0) & (f <= 1.5 * highest)
            series.append(Series(name, f[shown], a[shown]))
        spectrum = Panel(f"amplitude, {self.unit}", tuple(series), x_label="frequency, Hz")
        how = str(Filter(c.cutoff)) if c.cutoff else "unfiltered"
        text = f"Measured: {c.file}. Both {how}, from {self.time[0]:.4g} to {self.time[-1]:.4g} s of the run."
        where = f", {c.condition}" if c.condition else ""
        return Chart(f"{c.signal} against the measurement{where}", "", (history, spectrum), text, columns=1, height=260)


def compare_curve(curve: CurveSettings, folder: Path, result: Recorded) -> Comparison:
    """The comparison of a curve with a run.

    Raises `BadInput` where the file or the signal cannot be used, or both share no stretch.
    """
    where = f"curve {curve.file}"
    x, y = read_curve(curve, folder)
    simulated = np.asarray(result[curve.signal], dtype=float)
    if curve.over:
        way = np.asarray(result[curve.over], dtype=float)
        if not (np.diff(way) > 0.0).all():
            raise BadInput(where, f"over = {curve.over!r}, which does not rise throughout the run", "a signal that rises")
        inside = (x >= way[0]) & (x <= way[-1])
        at = np.interp(x[inside], way, result.time)
        y = y[inside]
    else:
        way, at = result.time, x
    if at.size < LEAST:
        raise BadInput(where, f"{at.size} samples within the run", f"{LEAST} or more", "Look at abscissa, shift and over.")
    rate, instants, (even,) = uniform(result.time, simulated)
    measured_rate, measured_at, (measured,) = uniform(at, y)
    if curve.cutoff is not None:
        for name, r in (("the run", rate), ("the file", measured_rate)):
            if not curve.cutoff < 0.5 * r:
                raise BadInput(
                    where, f"a cut-off of {curve.cutoff:g} Hz at {r:g} samples a second of {name}", f"less than {0.5 * r:g} Hz"
                )
        low_pass = Filter(curve.cutoff)
        even, measured = low_pass.apply(even, rate), low_pass.apply(measured, measured_rate)
    trim = EDGE / curve.cutoff if curve.cutoff else 0.0
    begin = max(measured_at[0] + trim, instants[0] + trim, result.scene.analysis.transient)
    end = min(measured_at[-1], instants[-1]) - trim
    kept = (instants >= begin) & (instants <= end)
    if kept.sum() < LEAST:
        raise BadInput(
            where,
            f"measured {measured_at[0]:.4g} to {measured_at[-1]:.4g} s, simulated {instants[0]:.4g} to {instants[-1]:.4g} s",
            "a stretch that both have, without the transient and the ends of the filter",
            "Look at abscissa, shift and over.",
        )
    t = instants[kept]
    return Comparison(
        curve,
        result.measures.get(curve.signal, ""),
        t,
        np.interp(t, result.time, way),
        np.interp(t, measured_at, measured),
        even[kept],
        rate,
    )


def read_curve(curve: CurveSettings, folder: Path) -> tuple[np.ndarray, np.ndarray]:
    """(abscissa (n,), ordinate (n,)) of the file, scaled and shifted; faults are one `BadInput` with file and line."""
    x, y = read_columns(folder / curve.file, curve.abscissa, curve.ordinate, curve.separator)
    return x + curve.shift, y * curve.scale + curve.offset


def read_columns(path: Path, abscissa: str, ordinate: str, separator: str) -> tuple[np.ndarray, np.ndarray]:
    """Two columns (n,) of a CSV by their names, the first one rising; faults are one `BadInput` with file and line."""
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            lines = csv.reader(file, delimiter=separator)
            names = [name.strip() for name in next(lines, [])]
            places = []
            for name in (abscissa, ordinate):
                if name not in names:
                    raise BadInput(str(path), f"no column {name!r}", "a column of the first line", nearest(name, names))
                places.append(names.index(name))
            pairs = [_numbers(line, places, f"{path}:{lines.line_num}") for line in lines if any(cell.strip() for cell in line)]
    except OSError as error:
        raise BadInput("curve", repr(str(path)), "a file that can be read", f"{error.strerror}.") from None
    except (UnicodeDecodeError, csv.Error) as error:
        raise BadInput(str(path), f"what is no CSV in UTF-8 ({error})", "a CSV file") from None
    if len(pairs) < LEAST:
        raise BadInput(str(path), f"{len(pairs)} lines of numbers", f"{LEAST} or more")
    x, y = np.array(pairs).T
    if not (np.diff(x) > 0.0).all():
        line = int(np.argmin(np.diff(x) > 0.0)) + 3
        raise BadInput(f"{path}:{line}", f"{abscissa} that does not rise", "rising numbers")
    return x, y


def _numbers(line: list[str], places: list[int], where: str) -> tuple[float, float]:
    try:
        x, y = (float(line[place]) for place in places)
    except (ValueError, IndexError):
        raise BadInput(where, repr(",".join(line))[:80], "a number in both columns", "Decimals have a point.") from None
    if not np.isfinite((x, y)).all():
        raise BadInput(where, "a number that is not finite", "finite numbers")
    return x, y
