"""What runs are off measurements, over their standard deviations: for a fit, and for a likelihood.

Several runs have one vector of parameters: those of all runs, and behind them those of each run alone, "condition: unit.parameter".
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from math import log, pi
from pathlib import Path
from typing import Any, Unpack

import numpy as np

from ....components.core.errors import BadInput
from ...scene.measured import Measured, read_curve, units_of
from ...scene.scene import Scene
from ...scene.sums import sums_of
from ...settings.answers import FitSettings, FittedCurve, MeasuredRun
from ...settings.messages import validated
from ...settings.plan import KeepSettings
from ..charts.chart import Chart
from ..journal import Stopped
from ..validation.curves import CurveComparison, compare_curve
from ..validation.spectra import SpectrumComparison, compare_spectrum, read_spectrum
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


@dataclass(frozen=True)
class Misfit:
    """Residuals (m,) of one measurement of a run. noise: standard deviation, 1 where it is not known.  sampled: in the order of time."""

    what: str
    residuals: np.ndarray
    noise: float
    sampled: bool = False


class RunResiduals:
    """Of one measured run. own: places of its parameters among those of all, (k,).  size: of the first run; 0 before."""

    def __init__(
        self,
        wanted: MeasuredRun,
        curves: Sequence[tuple[FittedCurve, Measured]],
        folder: Path,
        runs: Evaluations,
        own: np.ndarray,
    ):
        self.wanted, self.curves, self.folder, self.runs, self.own, self.size = wanted, curves, folder, runs, own, 0

    def __call__(self, p: np.ndarray, row: PointResult) -> np.ndarray:
        """All residuals at its parameters p, (m,); NaN where the run failed.

        Raises `BadInput` where the stretch that both have depends on the parameters.
        """
        if row.outcome != "done":
            return np.full(max(self.size, 1), np.nan)
        whole = np.concatenate([part.residuals for part in self.parts(row)])
        if self.size and whole.size != self.size:
            raise BadInput(
                "fit: measurements",
                f"{whole.size} samples within a run with {self.runs.values(p)}, {self.size} within the first one",
                "a stretch that does not depend on them",
                "Cut the measurement to what every run covers.",
            )
        return whole

    def parts(self, row: PointResult) -> Iterator[Misfit]:
        """Each measurement beside a run."""
        for comparison in self.compared(self.runs.scene, row):
            noise = comparison.noise or 1.0
            yield Misfit(comparison.curve.signal, (comparison.simulated - comparison.measured) / noise, noise, sampled=True)
        for spectrum in self.spectra(self.runs.scene, row):
            s = spectrum.settings
            yield Misfit(f"spectrum of {s.signal}", spectrum.residuals, s.noise or 1.0)
        for t in self.wanted.targets:
            yield Misfit(t.quantity, np.array([(self.target(row, t.quantity) - t.value) / t.deviation]), t.deviation)

    def compared(self, scene: Scene, row: PointResult) -> list[CurveComparison]:
        """Every curve beside a run."""
        return [compare_curve(curve, measured, KeptRun(scene, row)) for curve, measured in self.curves]

    def spectra(self, scene: Scene, row: PointResult) -> list[SpectrumComparison]:
        """Every spectrum beside a run."""
        return [compare_spectrum(s, self.folder, KeptRun(scene, row)) for s in self.wanted.spectra]

    def charts(self, scene: Scene, row: PointResult) -> Iterator[Chart]:
        """Of curves and spectra, with the condition of the run."""
        for curve, measured in self.curves:
            named = curve.model_copy(update={"condition": self.wanted.condition or curve.condition})
            yield compare_curve(named, measured, KeptRun(scene, row)).chart()
        yield from (spectrum.chart() for spectrum in self.spectra(scene, row))

    def target(self, row: PointResult, quantity: str) -> float:
        """A number of a run."""
        return row.numbers[column_name(row.numbers, quantity, "fit: targets")]


@dataclass(frozen=True)
class PointResults:
    """What each of the runs gives at a point."""

    of: tuple[PointResult, ...]

    @property
    def outcome(self) -> str:
        """That of the first run that has failed."""
        return next((row.outcome for row in self.of if row.outcome != "done"), "done")

    @property
    def reason(self) -> str:
        """Of that run; else what is to be known of all."""
        failed = [row.reason for row in self.of if row.outcome != "done"]
        return failed[0] if failed else "; ".join(dict.fromkeys(row.reason for row in self.of if row.reason))


class Residuals:
    """Of all runs of a fit. wanted: its settings.  names, low, high: of the parameters, (n,).  start: where a search starts."""

    def __init__(self, wanted: FitSettings, runs: Sequence[RunResiduals], names: Sequence[str]):
        self.wanted, self.runs, self.names = wanted, runs, list(names)
        self.low, self.high, self.start = (np.empty(len(self.names)) for _ in range(3))
        for run in reversed(runs):  # what all have starts as in the first one
            self.low[run.own], self.high[run.own], self.start[run.own] = run.runs.low, run.runs.high, run.runs.start()

    def rows(self, points: Sequence[np.ndarray]) -> list[PointResults]:
        """Of each point (n,). A run is made once for all points that differ in the parameters of others alone."""
        each = [run.runs([np.asarray(p, dtype=float)[run.own] for p in points]) for run in self.runs]
        return [PointResults(of) for of in zip(*each, strict=True)]

    def __call__(self, p: np.ndarray, rows: PointResults) -> np.ndarray:
        """All residuals at parameters p, (m,), run after run; NaN where a run failed."""
        return np.concatenate([run(p[run.own], row) for run, row in zip(self.runs, rows.of, strict=True)])

    def first(self, p: np.ndarray, rows: PointResults) -> None:
        """From here on each run has as many residuals as now."""
        for run, row in zip(self.runs, rows.of, strict=True):
            run.size = run(p[run.own], row).size

    def slopes(self, p: np.ndarray) -> np.ndarray:
        """Exact derivatives of all residuals, (m, n); NaN in columns that a run has none of, no rows where no run has any."""
        blocks = []
        for run in self.runs:
            q = p[run.own]

            def residuals(row: PointResult, run: RunResiduals = run, q: np.ndarray = q) -> np.ndarray:
                return run(q, row)

            blocks.append(run.runs.slopes(q, residuals))
        if not any(block.shape[0] for block in blocks):
            return np.full((0, len(self.names)), np.nan)
        whole = [np.zeros((block.shape[0] or run.size, len(self.names))) for run, block in zip(self.runs, blocks, strict=True)]
        for run, block, rows in zip(self.runs, blocks, whole, strict=True):
            rows[:, run.own] = block if block.shape[0] else np.nan
        return np.concatenate(whole)

    def log_density(self, rows: PointResults) -> float:
        """Of the measurements, with independent normal noise of their standard deviations; minus infinity where a run failed."""
        if rows.outcome != "done":
            return -np.inf
        parts = [part for run, row in zip(self.runs, rows.of, strict=True) for part in run.parts(row)]
        return -sum(
            0.5 * float(p.residuals @ p.residuals) + p.residuals.size * (log(p.noise) + 0.5 * log(2.0 * pi)) for p in parts
        )

    def values(self, p: np.ndarray) -> dict[str, float]:
        """Parameters (n,) by name."""
        return dict(zip(self.names, np.asarray(p, dtype=float).tolist(), strict=True))

    def how(self, name: str) -> str:
        """What the derivatives by a parameter were, in words; of several runs those that were not exact alone."""
        k = self.names.index(name)
        texts = [r.runs.derivatives.how(r.runs.names[list(r.own).index(k)]) for r in self.runs if k in r.own]
        return "; ".join(dict.fromkeys(t for t in texts if t != "exact")) or "exact"


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
    own_names = [f"{r.condition}: {n}" if wanted.runs else n for r in wanted.runs for n in r.vary]
    names, runs = [*wanted.vary, *own_names], list[RunResiduals]()
    with ExitStack() as stack:
        for run in wanted.each:
            changed = _scene_of(scene, run, wanted, folder, f"{name}: runs: {run.condition}")
            units = units_of(changed)
            curves = [(curve, read_curve(curve, folder, units)) for curve in run.curves]
            for spectrum in run.spectra:
                read_spectrum(spectrum, folder, units.get(spectrum.signal, ""))
            signals = [s for c in run.curves for s in (c.signal, c.over) if s] + [s.signal for s in run.spectra]
            keep = keep_for([t.quantity for t in run.targets], KeepSettings())
            sums = [whole for s in signals for whole in sums_of(changed, [s]).values()]
            keep = keep.model_copy(update={"signals": tuple(dict.fromkeys([*signals, *sums]))})
            needed = {"fit: targets": [t.quantity for t in run.targets]}
            place = Path(directory) / run.condition if directory is not None and len(wanted.each) > 1 else directory
            some = stack.enter_context(evaluations(changed, {**wanted.vary, **run.vary}, keep, needed, place, **how))
            own = [names.index(n) for n in wanted.vary] + [names.index(f"{run.condition}: {n}") for n in run.vary]
            runs.append(RunResiduals(run, curves, folder, some, np.array(own, dtype=np.intp)))
        try:
            yield Residuals(wanted, runs, names)
        except Stopped as one:  # of one of them
            one.kept = sum(run.runs.kept for run in runs)
            raise


def _scene_of(scene: Scene, run: MeasuredRun, wanted: FitSettings, folder: Path, where: str) -> Scene:
    """The scene of a run. Raises `BadInput` for a change of what is fitted."""
    if both := next((n for n in run.changes if n in {**wanted.vary, **run.vary}), None):
        raise BadInput(f"{where}: changes", f"{both!r}, which is fitted", "settings that are not fitted")
    if run.input:
        scene = scene.with_input(folder / run.input)
    return scene.with_changes(run.changes) if run.changes else scene
