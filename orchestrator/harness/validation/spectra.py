"""Measured spectra beside those of signals of a run, by one estimator, at the measured frequencies."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ....components.core.errors import BadInput
from ....components.core.measure import squared
from ...scene.measured import FEWEST, read_columns
from ...scene.sums import parts_alone
from ...settings.answers import SpectrumSettings
from ..analysis.signals import uniform, welch_spectrum
from ..charts.chart import Chart, Panel, Series
from .curves import RecordedRun


@dataclass(frozen=True)
class SpectrumComparison:
    """A measured spectrum and the simulated one at its frequencies. frequency: (n,) Hz.  measured, simulated: (n,), in `unit`.
    resolution: Hz, between the lines of the simulated one.  alone: as of `CurveComparison`."""

    settings: SpectrumSettings
    unit: str
    frequency: np.ndarray
    measured: np.ndarray
    simulated: np.ndarray
    resolution: float
    alone: str = ""

    @property
    def residuals(self) -> np.ndarray:
        """(n,) simulated less measured over the noise, of logarithms where the settings say so."""
        s = self.settings
        parts = [np.log(x) if s.logarithmic else x for x in (self.simulated, self.measured)]
        return (parts[0] - parts[1]) / (s.noise or 1.0)

    def chart(self) -> Chart:
        """Both over the frequency."""
        s = self.settings
        lines = (Series("measured", self.frequency, self.measured), Series("simulated", self.frequency, self.simulated))
        panel = Panel(f"{s.kind}, {self.unit}", lines, logarithmic=s.logarithmic, x_label="frequency, Hz")
        text = f"Measured: {s.file}. Simulated: {s.estimator}; lines {self.resolution:.4g} Hz apart."
        return Chart(f"Spectrum of {s.signal} against the measurement", "", (panel,), text, height=300)


def compare_spectrum(wanted: SpectrumSettings, folder: Path, result: RecordedRun) -> SpectrumComparison:
    """The spectrum of a signal after the transient beside the measured one. Between its lines, the simulated one is interpolated.

    Raises `BadInput` where the file or the record cannot be used.
    """
    where = f"spectrum {wanted.file}"
    f, measured = read_spectrum(wanted, folder, result.measures.get(wanted.signal, ""))
    rate, instants, (even,) = uniform(result.time, np.asarray(result[wanted.signal], dtype=float))
    x = even[instants >= result.scene.counts_from]
    samples = round(wanted.segment * rate) if wanted.segment is not None else x.size
    if not FEWEST <= samples <= x.size:
        raise BadInput(
            where,
            f"segments of {samples} samples of {x.size}",
            f"{FEWEST} or more, no more than the record has",
            "Look at segment, the transient and the length of the run.",
        )
    lines, spectrum = welch_spectrum(x, rate, samples, wanted.overlap, wanted.window, wanted.kind)
    if f[0] < lines[1] * (1.0 - 1e-9) or f[-1] > lines[-1] * (1.0 + 1e-9):
        raise BadInput(
            where,
            f"frequencies from {f[0]:g} to {f[-1]:g} Hz",
            f"from {lines[1]:.4g} Hz, the first line of segments "
            f"of {samples / rate:.4g} s, to {lines[-1]:.4g} Hz, half of the samples a second",
            "Give low and high.",
        )
    if wanted.logarithmic:
        with np.errstate(divide="ignore"):
            simulated = np.exp(np.interp(f, lines[1:], np.log(spectrum[1:])))
    else:
        simulated = np.interp(f, lines, spectrum)
    unit = result.measures.get(wanted.signal, "") or "1"
    unit = f"({unit})²/Hz" if wanted.kind == "power spectral density" else unit
    rows = result.time >= result.scene.counts_from
    alone = parts_alone(result.scene, [wanted.signal], lambda name: result[name][rows])
    return SpectrumComparison(wanted, unit, f, measured, simulated, float(lines[1]), "; ".join(alone))


def read_spectrum(wanted: SpectrumSettings, folder: Path, unit: str) -> tuple[np.ndarray, np.ndarray]:
    """(frequency (n,) Hz, spectrum (n,)) of the file between `low` and `high`; unit: of the signal. Faults are one `BadInput`."""
    path = folder / wanted.file
    unit = f"{squared(unit)}/Hz" if unit and wanted.kind == "power spectral density" else unit
    measured = read_columns(wanted, folder, (wanted.frequency, "Hz"), unit, "spectrum")
    f, y = measured.x, measured.y
    kept = (f > 0.0) & (f >= wanted.low) & (f <= (np.inf if wanted.high is None else wanted.high))
    f, y = f[kept], y[kept]
    if f.size < FEWEST:
        raise BadInput(str(path), f"{f.size} frequencies above 0 and between low and high", f"{FEWEST} or more")
    if (y <= 0.0).any() if wanted.logarithmic else (y < 0.0).any():
        raise BadInput(
            str(path), f"{wanted.column or wanted.signal} = {y.min():g}", "positive numbers", "Or logarithmic = false, for zeros."
        )
    return f, y
