"""Parameters of a scene from measurements: least squares within bounds over runs, with their uncertainty."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Unpack

import numpy as np

from ....components.core.errors import BadInput
from ...output import write_table
from ...scene.names import measure_of
from ...scene.scene import Scene, write_scene
from ...scene.tolerances import with_tolerances
from ...settings.answers import FitSettings
from ..analysis.least_squares import Fit, profile_end
from ..analysis.least_squares import fit as least_squares
from ..charts.chart import Chart
from ..sweep import Sweep
from ..validation.curves import CurveComparison
from .evaluations import SearchOptions
from .plan import other_starts
from .repetition import OF_DEVIATION
from .residual_tests import RESIDUAL_TESTS, ResidualTest, residual_tests
from .residuals import PointResults, Residuals, RunResiduals, residuals_of
from .searches import Ask, jacobian, run_searches

FITTED = "fitted.toml"
SAME_PLACE = 1e-2  # of the range between the bounds: fits nearer to one another than this are one


@dataclass(frozen=True)
class SceneFit:
    """Fitted parameters of a scene. fit: in the parameters' own units.  units: of measure by name.  charts: measured and fitted.
    scene: with the fitted values, their standard deviations and correlations as its tolerances; of several runs with what is common to
    them, and `scenes` are those of the runs, by condition.  tests: of the residuals.  targets: condition, quantity, measured, its
    deviation, fitted.  runs: that the search asked for, `computed` of them by this call.  sweeps: all of them, one of each run.
    derivatives: of each parameter whether its column of the Jacobian was exact, at how many of the `jacobians` points, and why not.
    """

    fit: Fit
    units: Mapping[str, str]
    scene: Scene
    start: Mapping[str, float]
    charts: tuple[Chart, ...]
    targets: tuple[tuple[str, str, float, float, float], ...]
    tests: tuple[ResidualTest, ...]
    scenes: Mapping[str, Scene]
    runs: int
    computed: int
    jacobians: int
    derivatives: Mapping[str, str]
    sweeps: tuple[Sweep, ...] = ()

    def __repr__(self) -> str:
        """A line a parameter, with its standard deviation."""
        state = "converged" if self.fit.converged else "not converged"
        lines = [f"<SceneFit of {self.scene.name}: {state}, {self.runs} runs, {self.jacobians} with derivatives beside them>"]
        for name, value, deviation, *_ in self.fit.rows():
            lines.append(f"{name}: {value:.6g} ± {deviation:.2g} {self.units[name] if self.units[name] != '1' else ''}".rstrip())
        return "\n".join([*lines, *self.fit.messages])

    def save(self, directory: str | Path) -> Path:
        """Write fitted.toml, the scene, and fit.csv: a row a parameter, with its correlations with the others; returns its path.

        Of several runs, fitted-CONDITION.toml is the scene of each, and residuals.csv has the tests of their residuals.
        """
        header = [
            "parameter",
            "unit",
            "value",
            "standard deviation",
            "low (95 %)",
            "high (95 %)",
            "start",
            "derivatives",
            *(f"correlation with {n}" for n in self.fit.names),
        ]
        rows = [
            (n, self.units[n], v, s, low, high, self.start[n], self.derivatives[n], *self.fit.correlation[k].tolist())
            for k, (n, v, s, low, high) in enumerate(self.fit.rows())
        ]
        remarks = ["Fitted values; tolerances are their standard deviations."]
        write_scene(self.scene, Path(directory) / FITTED, remarks)
        for condition, scene in self.scenes.items():
            write_scene(scene, Path(directory) / f"fitted-{condition}.toml", remarks)
        write_table(directory, "residuals.csv", RESIDUAL_TESTS, [test.row for test in self.tests])
        return write_table(directory, "fit.csv", header, rows)


def fit(
    scene: Scene,
    settings: FitSettings | Mapping[str, Any] | str | Path,
    directory: str | Path | None = None,
    *,
    folder: str | Path = ".",
    verify: bool = True,
    **how: Unpack[SearchOptions],
) -> SceneFit:
    """Fit parameters to measured curves, spectra and numbers. `folder`: of their files, where the settings are no file.

    Residuals are (simulated - measured) / standard deviation; of a curve one of each sample, where the run is evaluated. A curve is
    filtered on both sides where it has a cut-off; a spectrum is estimated as its settings say, and compared at the measured
    frequencies. Samples count as independent, which makes the deviations too small where they are not.

    `directory`: where the runs are kept; those of an earlier call are not run again. `verify`: whether the fitted run is made again
    with half of every step, which tells how large its numerical error is beside that of the measurements. `how`: who computes the
    runs of a Jacobian, and of several starts; no number depends on it. Raises `BadInput`, also where the start cannot be run, and
    `Stopped` where a signal has ended it.
    """
    with residuals_of(scene, settings, directory, Path(folder), **how) as residuals:
        return _Fitting(scene, residuals).answer(verify)


class _Fitting:
    """One fit: its searches over the unit cube."""

    def __init__(self, scene: Scene, residuals: Residuals):
        self.scene, self.residuals, self.wanted = scene, residuals, residuals.wanted
        self.low, self.width = residuals.low, residuals.high - residuals.low

    def answer(self, verify: bool) -> SceneFit:
        """Search from every start; the fit with the least residuals, what the others came to, and what shorter steps change."""
        residuals, names = self.residuals, self.residuals.names
        first = residuals.start
        (row,) = residuals.rows([first])
        if row.outcome != "done":
            raise BadInput("fit: start", f"a run that is {row.outcome}: {row.reason}", "a start that runs", "Give another start.")
        residuals.first(first, row)
        starts = [(first - self.low) / self.width, *other_starts(self.wanted.starts, len(names), self.wanted.seed)]
        rows = residuals.rows([self.low + u * self.width for u in starts])
        usable = [u for u, row in zip(starts, rows, strict=True) if row.outcome == "done"]
        searches = [self._search(u) for u in usable]
        fits = sorted(run_searches(searches, residuals.rows), key=lambda f: float(f.residuals @ f.residuals))
        messages = [f"{len(starts) - len(usable)} of {len(starts)} starts could not be run"] if len(usable) < len(starts) else []
        if self.wanted.profile:
            fits[0] = self._profiled(fits[0])
        best = _in_units(fits[0], self.low, self.width)
        messages += [*best.messages, *_others(best, [_in_units(f, self.low, self.width) for f in fits[1:]], self.width)]
        (row,) = residuals.rows([best.values])
        if row.outcome != "done":
            raise BadInput("fit", f"a last run that is {row.outcome}: {row.reason}", "runs that come to their end near the fit")
        messages += [row.reason] if row.reason else []
        messages += self._blurred(best, row) if verify else []
        each = residuals.runs
        fitted = [self._fitted(run.runs.whole, run, best) for run in each]
        for run, scene, of in zip(each, fitted, row.of, strict=True):
            comparisons = run.compared(scene, of)
            messages += [c.counted for c in comparisons if c.incomplete]
            messages += [text for text in (*(c.alone for c in comparisons), *(s.alone for s in run.spectra(scene, of))) if text]
            messages += [text for c in comparisons if (text := _between(c))]
        tests = residual_tests(residuals, best, row)
        messages += [test.words for test in tests if not test.holds]
        common = [names.index(n) for n in self.wanted.vary]
        values = dict(list(residuals.values(best.values).items())[: len(common)])
        whole = with_tolerances(self.scene.with_changes(values), list(self.wanted.vary), best.covariance[np.ix_(common, common)])
        several = len(each) > 1
        return SceneFit(
            replace(best, messages=tuple(messages)),
            {n: measure_of(self.scene, n.rpartition(": ")[2]) for n in names},
            whole if several else fitted[0],
            residuals.values(first),
            tuple(c for run, scene, of in zip(each, fitted, row.of, strict=True) for c in run.charts(scene, of)),
            tuple(
                (run.wanted.condition, t.quantity, t.value, t.deviation, run.target(of, t.quantity))
                for run, of in zip(each, row.of, strict=True)
                for t in run.wanted.targets
            ),
            tests,
            {run.wanted.condition: scene for run, scene in zip(each, fitted, strict=True)} if several else {},
            sum(run.runs.asked for run in each),
            sum(run.runs.computed for run in each),
            max(run.runs.derivatives.points for run in each),
            {n: residuals.how(n) for n in names},
            tuple(sweep for run in each if (sweep := run.runs.sweep()) is not None),
        )

    def _fitted(self, scene: Scene, run: RunResiduals, best: Fit) -> Scene:
        """The scene of a run with its fitted values, and their deviations as tolerances."""
        own = run.own
        changed = scene.with_changes(run.runs.values(best.values[own]))
        return with_tolerances(changed, run.runs.names, best.covariance[np.ix_(own, own)])

    def _blurred(self, best: Fit, rows: PointResults) -> list[str]:
        """What half of every step changes at the fit, where that is not small beside what is left of the residuals."""
        changes, texts = [], []
        for run, row in zip(self.residuals.runs, rows.of, strict=True):
            p = best.values[run.own]
            (again,), repeated = run.runs.repeated([p])
            if again is None or again.outcome != "done":
                texts += repeated.messages()
            else:
                changes.append(2.0 * (run(p, again) - run(p, row)))
        share = float(np.sqrt(np.mean(np.concatenate(changes) ** 2) / best.variance)) if changes and best.variance > 0.0 else 0.0
        if share > OF_DEVIATION:
            texts.append(
                f"the numerical error of the fitted run is {100.0 * share:.2g} % of the standard deviation of the measurements: "
                "reduce master.step"
            )
        return list(dict.fromkeys(texts))

    def _functions(self, ask: Ask) -> tuple[Callable[[np.ndarray], np.ndarray], Callable[[np.ndarray], np.ndarray]]:
        """Residuals (m,) and Jacobian (m, n) over the unit cube, by runs that are asked for."""

        def values(points: Sequence[np.ndarray]) -> list[np.ndarray]:
            p = [self.low + u * self.width for u in points]
            return [self.residuals(x, row) for x, row in zip(p, ask(p), strict=True)]

        def exact(u: np.ndarray) -> np.ndarray:
            p = self.low + u * self.width
            return self.residuals.slopes(p) * self.width

        step, names = self.wanted.step, self.residuals.names
        return lambda u: values([u])[0], lambda u: jacobian(values, u, step, names, exact(u))

    def _search(self, start: np.ndarray) -> Callable[[Ask], Fit]:
        names, wanted = self.residuals.names, self.wanted

        def search(ask: Ask) -> Fit:
            values, slopes = self._functions(ask)
            return least_squares(
                values,
                dict(zip(names, start.tolist(), strict=True)),
                dict.fromkeys(names, (0.0, 1.0)),
                noise_known=wanted.noise_known,
                most=wanted.evaluations,
                jacobian=slopes,
                loss=wanted.loss,
            )

        return search

    def _profiled(self, unit: Fit) -> Fit:
        """A fit over the unit cube with the ends of its profiles as intervals."""
        ends = [(k, way) for k in range(len(unit.names)) for way in (-1.0, 1.0)]

        def from_end(k: int, way: float) -> Callable[[Any], Any]:
            return lambda ask: profile_end(unit, *self._functions(ask), k, way)

        profiles = run_searches([from_end(*end) for end in ends], self.residuals.rows)
        texts = list(dict.fromkeys(text for _, text in profiles if text))
        intervals = np.array([end for end, _ in profiles]).reshape(-1, 2)
        return replace(unit, intervals=intervals, messages=(*unit.messages, *texts))


def _between(comparison: CurveComparison) -> str:
    """What a user should know where the rows of the run are too far apart for the instants of a measurement."""
    noise = comparison.noise or float(np.std(comparison.simulated - comparison.measured))
    share = float(np.sqrt(np.mean(comparison.between**2))) / noise if noise > 0.0 else 0.0
    if share <= OF_DEVIATION:
        return ""
    return (
        f"{comparison.curve.signal} between the rows of the run is known to {100.0 * share:.2g} % of the standard deviation of "
        f"{comparison.curve.file}: reduce record.interval"
    )


def _others(best: Fit, others: Sequence[Fit], width: np.ndarray) -> list[str]:
    """What fits from other starts tell: another minimum that the data do not distinguish from the best one."""
    if not others:
        return []
    elsewhere = [f for f in others if (np.abs(f.values - best.values) > SAME_PLACE * width).any()]
    texts = [f"{len(others) + 1 - len(elsewhere)} of {len(others) + 1} starts came to this fit"] if elsewhere else []
    for f in elsewhere:
        if best.chi_square(f) <= best.largest_chi_square:
            values = ", ".join(f"{n} = {v:.6g}" for n, v in zip(f.names, f.values, strict=True))
            texts.append(f"another fit explains the data as well, within 95 %: {values}")
    return list(dict.fromkeys(texts))


def _in_units(unit: Fit, low: np.ndarray, width: np.ndarray) -> Fit:
    """A fit over shares of the ranges as one in the parameters' units."""
    return replace(
        unit,
        values=low + unit.values * width,
        deviations=unit.deviations * width,
        covariance=unit.covariance * np.outer(width, width),
        intervals=low[:, None] + unit.intervals * width[:, None],
    )
