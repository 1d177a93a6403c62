"""Parameters of a scene from measurements: least squares within bounds over runs, with their uncertainty."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from ....components.core.errors import BadInput
from ...output import write_table
from ...scene.scene import Scene, read_toml
from ...settings.answers import FitSettings
from ...settings.messages import one_message
from ...settings.plan import KeepSettings
from ..analysis.least_squares import Fit
from ..analysis.least_squares import fit as least_squares
from ..charts.chart import Chart
from ..validation.curves import compare_curve, read_curve
from .evaluations import Evaluations, Summarize, column_name, keep_for
from .plan import unit_of


@dataclass(frozen=True)
class SceneFit:
    """Fitted parameters of a scene. fit: in the parameters' own units.  units: of measure by name.  charts: measured and fitted.
    scene: with the fitted values."""

    fit: Fit
    units: Mapping[str, str]
    scene: Scene
    start: Mapping[str, float]
    charts: tuple[Chart, ...]
    targets: tuple[tuple[str, float, float, float], ...]  # quantity, measured, its deviation, fitted
    runs: int

    def save(self, directory: str | Path) -> Path:
        """Write fit.csv: a row a parameter, with its correlations with the others."""
        header = ["parameter", "unit", "value", "standard deviation", "low (95 %)", "high (95 %)", "start",
                  *(f"correlation with {n}" for n in self.fit.names)]
        rows = [(n, self.units[n], v, s, low, high, self.start[n], *self.fit.correlation[k].tolist())
                for k, (n, v, s, low, high) in enumerate(self.fit.rows())]
        return write_table(directory, "fit.csv", header, rows)


def read_fit(path: str | Path) -> tuple[FitSettings, Path]:
    """A fit from its TOML file, and the folder of its measurements."""
    path = Path(path)
    return fit_settings(read_toml(path), path.name), path.parent


def fit_settings(data: FitSettings | Mapping[str, Any], name: str = "fit") -> FitSettings:
    """A fit from plain data, checked."""
    if isinstance(data, FitSettings):
        return data
    try:
        return FitSettings.model_validate(dict(data))
    except ValidationError as error:
        raise one_message(error, FitSettings, name) from None


def fit(scene: Scene, settings: FitSettings | Mapping[str, Any] | str | Path, *, folder: str | Path = ".",
        summarize: Summarize | None = None, observe: Callable[[int], None] = lambda n: None) -> SceneFit:
    """Fit parameters to measured curves and numbers. `folder`: of the curves' files, where the settings are no file themselves.

    Residuals are (simulated - measured) / standard deviation, curves at the run's instants where both exist. A curve is filtered
    on both sides where it has a cut-off; its samples count as independent, which makes the deviations too small where they are
    not. Raises `BadInput`, also where the start cannot be run.
    """
    if isinstance(settings, str | Path):
        settings, folder = read_fit(settings)
    wanted, folder = fit_settings(settings), Path(folder)
    for curve in wanted.curves:
        read_curve(curve, folder)
    signals = [s for c in wanted.curves for s in (c.signal, c.over) if s]
    keep = keep_for([t.quantity for t in wanted.targets], KeepSettings())
    keep = keep.model_copy(update={"signals": tuple(dict.fromkeys(signals))})
    runs = Evaluations(scene, wanted.vary, keep, summarize, observe)
    low, width = runs.low, runs.high - runs.low
    first = runs.start(wanted.vary)

    _check_start(runs, first)
    size = _residuals(runs, first, wanted, folder, 0).size

    def residuals(u: np.ndarray) -> np.ndarray:
        return _residuals(runs, low + u * width, wanted, folder, size)

    names = runs.names
    start = dict(zip(names, ((first - low) / width).tolist(), strict=True))
    known = bool(wanted.targets) or all(c.deviation is not None for c in wanted.curves)
    unit = least_squares(residuals, start, dict.fromkeys(names, (0.0, 1.0)), noise_known=known, step=wanted.step,
                         most=wanted.evaluations)
    scaled = _in_units(unit, low, width)
    result, row = runs.result(scaled.values), runs(scaled.values)
    if result is None or row.outcome != "done":
        raise BadInput("fit", f"a last run that is {row.outcome}: {row.reason}", "runs that come to their end near the fit")
    comparisons = [compare_curve(c, folder, result) for c in wanted.curves]
    targets = tuple((t.quantity, t.value, t.deviation, row.numbers[column_name(row.numbers, t.quantity, "fit: targets")])
                    for t in wanted.targets)
    return SceneFit(scaled, {n: unit_of(scene, n) for n in names}, result.scene, dict(zip(names, first.tolist(), strict=True)),
                    tuple(c.chart() for c in comparisons), targets, len(runs.history))


def _check_start(runs: Evaluations, first: np.ndarray) -> None:
    row = runs(first)
    if row.outcome != "done":
        raise BadInput("fit: start", f"a run that is {row.outcome}: {row.reason}", "a start that runs", "Give another start.")


def _residuals(runs: Evaluations, p: np.ndarray, wanted: FitSettings, folder: Path, size: int) -> np.ndarray:
    """All residuals at parameters p, (m,); NaN where the run failed; `size`: as many as at the start, 0 there.

    Raises `BadInput` where the stretch that both have depends on the parameters.
    """
    result, row = runs.result(p), runs(p)
    if result is None or row.outcome != "done":
        return np.full(max(size, 1), np.nan)
    parts: list[np.ndarray] = []
    for curve in wanted.curves:
        comparison = compare_curve(curve, folder, result)
        parts.append((comparison.simulated - comparison.measured) / (curve.deviation or 1.0))
    for target in wanted.targets:
        value = row.numbers[column_name(row.numbers, target.quantity, "fit: targets")]
        parts.append(np.array([(value - target.value) / target.deviation]))
    whole = np.concatenate(parts)
    if size and whole.size != size:
        raise BadInput("fit: curves", f"{whole.size} samples within a run, {size} within the first one",
                       "a stretch that does not depend on the parameters", "Cut the measurement to what every run covers.")
    return whole


def _in_units(unit: Fit, low: np.ndarray, width: np.ndarray) -> Fit:
    """A fit over shares of the ranges as one in the parameters' units."""
    return Fit(unit.names, low + unit.values * width, unit.deviations * width, unit.covariance * np.outer(width, width),
               unit.correlation, low[:, None] + unit.intervals * width[:, None], unit.residuals, unit.condition, unit.evaluations,
               unit.converged, unit.messages)
