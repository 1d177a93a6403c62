"""What a run is off measurements, over their standard deviations: for a fit, and for a likelihood."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from math import log, pi
from pathlib import Path
from typing import Any, Unpack

import numpy as np

from ....components.core.errors import BadInput
from ...scene.measured import Measured, read_curve, units_of
from ...scene.scene import Scene
from ...settings.answers import FitSettings, FittedCurve
from ...settings.messages import validated
from ...settings.plan import KeepSettings
from ..validation.curves import CurveComparison, compare_curve
from ..validation.spectra import compare_spectrum, read_spectrum
from .columns import column_name, keep_for
from .evaluations import Evaluations, SearchOptions, evaluations
from .measures import PointResult
from .plan import read_settings


@dataclass(frozen=True)
class KeptRun:
    """Signals of a point, as a comparison with a measurement reads them."""

    scene: Scene
    row: PointResult

    @property
    def time(self) -> np.ndarray:
        return self.row.time

    @property
    def measures(self) -> Mapping[str, str]:
        return self.row.units

    def __getitem__(self, name: str) -> np.ndarray:
        return self.row.signals[name]


class Residuals:
    """Of the runs of a fit. wanted: its settings.  size: residuals, as many as at the first run; 0 before."""

    def __init__(self, wanted: FitSettings, curves: Sequence[tuple[FittedCurve, Measured]], folder: Path, runs: Evaluations):
        self.wanted, self.curves, self.folder, self.runs, self.size = wanted, curves, folder, runs, 0

    def __call__(self, p: np.ndarray, row: PointResult) -> np.ndarray:
        """All residuals at parameters p, (m,); NaN where the run failed.

        Raises `BadInput` where the stretch that both have depends on the parameters.
        """
        if row.outcome != "done":
            return np.full(max(self.size, 1), np.nan)
        whole = np.concatenate([part for part, _ in self._parts(row)])
        if self.size and whole.size != self.size:
            raise BadInput(
                "fit: measurements",
                f"{whole.size} samples within a run with {self.runs.values(p)}, {self.size} within the first one",
                "a stretch that does not depend on them",
                "Cut the measurement to what every run covers.",
            )
        return whole

    def _parts(self, row: PointResult) -> Iterator[tuple[np.ndarray, float]]:
        """Residuals and the standard deviation of each measurement; 1 where that is not known."""
        for comparison in self.compared(self.runs.scene, row):
            noise = comparison.noise or 1.0
            yield (comparison.simulated - comparison.measured) / noise, noise
        for s in self.wanted.spectra:
            yield compare_spectrum(s, self.folder, KeptRun(self.runs.scene, row)).residuals, s.noise or 1.0
        for t in self.wanted.targets:
            yield np.array([(self.target(row, t.quantity) - t.value) / t.deviation]), t.deviation

    def log_density(self, row: PointResult) -> float:
        """Of the measurements, with independent normal noise of their standard deviations; minus infinity where the run failed."""
        if row.outcome != "done":
            return -np.inf
        return -sum(0.5 * float(r @ r) + r.size * (log(s) + 0.5 * log(2.0 * pi)) for r, s in self._parts(row))

    def compared(self, scene: Scene, row: PointResult) -> list[CurveComparison]:
        """Every curve beside a run."""
        return [compare_curve(curve, measured, KeptRun(scene, row)) for curve, measured in self.curves]

    def target(self, row: PointResult, quantity: str) -> float:
        """A number of a run."""
        return row.numbers[column_name(row.numbers, quantity, "fit: targets")]


@contextmanager
def residuals_of(
    scene: Scene,
    settings: FitSettings | Mapping[str, Any] | str | Path,
    directory: str | Path | None,
    folder: Path,
    **how: Unpack[SearchOptions],
) -> Iterator[Residuals]:
    """Of a scene and what is measured of it; arguments as of `fitting.fit`. Raises `BadInput`."""
    data, name, folder = read_settings(settings, "fit", scene, folder)
    wanted = validated(FitSettings, data, name)
    units = units_of(scene)
    curves = [(curve, read_curve(curve, folder, units)) for curve in wanted.curves]
    for spectrum in wanted.spectra:
        read_spectrum(spectrum, folder, units.get(spectrum.signal, ""))
    signals = [s for c in wanted.curves for s in (c.signal, c.over) if s] + [s.signal for s in wanted.spectra]
    keep = keep_for([t.quantity for t in wanted.targets], KeepSettings())
    keep = keep.model_copy(update={"signals": tuple(dict.fromkeys(signals))})
    needed = {"fit: targets": [t.quantity for t in wanted.targets]}
    with evaluations(scene, wanted.vary, keep, needed, directory, **how) as runs:
        yield Residuals(wanted, curves, folder, runs)
