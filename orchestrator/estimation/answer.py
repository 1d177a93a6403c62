"""What `cosimo estimate` answers: estimates with bands, innovations and a verdict, and the files that have them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import floor, isfinite, log10
from pathlib import Path
from typing import Any

import numpy as np

from ...components.core.errors import pick
from ..output import write_json, write_table
from ..scene.scene import Scene
from .bounds import Bounds
from .filtering import History, Innovations
from .measurements import Measurements
from .model import Unknown
from .observability import Observability
from .posterior import Posterior
from .verdict import Verdict

REACH = 1.959963984540054  # standard deviations of a band that holds 95 %


def shown(value: float, deviation: float) -> str:
    """ "112.7 ± 2.6": a number to the second digit of its standard deviation."""
    if not (isfinite(value) and isfinite(deviation) and deviation > 0.0):
        return f"{value:.6g}"
    places = 1 - floor(log10(deviation))
    if not 0 <= places < 8 or abs(value) >= 1e7:
        return f"{value:.6g} ± {deviation:.2g}"
    return f"{value:.{places}f} ± {deviation:.{places}f}"


@dataclass(frozen=True)
class Parameter:
    """A parameter or an input at the end of the measurement. before: expected, with its deviation.  low, high: of 95 %.

    error: numerical, of the steps, by which low and high stand further out; NaN where it is not known.  deviation: without it.
    walks: it is no constant.  bounds: that it keeps.
    """

    name: str
    unit: str
    value: float
    deviation: float
    low: float
    high: float
    before: float
    before_deviation: float
    walks: bool
    bounds: Bounds
    error: float = float("nan")

    @classmethod
    def of(cls, unknown: Unknown, q: float, deviation: float, ends: Sequence[float] = ()) -> Parameter:
        """Of the number q of an unknown, its standard deviation, and the ends of its 95 %; default: those of a normal distribution."""
        bounds = unknown.bounds
        low, high = sorted(bounds.outer(end) for end in ends or (q - REACH * deviation, q + REACH * deviation))
        before = unknown.deviation * bounds.slope(unknown.mean)
        walks = unknown.walk > 0.0
        return cls(
            unknown.name,
            unknown.unit,
            bounds.outer(q),
            deviation * bounds.slope(q),
            low,
            high,
            bounds.outer(unknown.mean),
            before,
            walks,
            bounds,
        )

    def with_error(self, error: float) -> Parameter:
        """With a numerical error, which the band then holds, too."""
        low, high = max(self.low - error, self.bounds.low), min(self.high + error, self.bounds.high)
        return replace(self, low=low, high=high, error=error)

    def to_json(self) -> dict[str, Any]:
        """As plain data."""
        return {
            "value": self.value,
            "unit": self.unit,
            "deviation": self.deviation,
            "low": self.low,
            "high": self.high,
            "error": self.error if isfinite(self.error) else None,
            "before": {"value": self.before, "deviation": self.before_deviation},
        }


@dataclass(frozen=True)
class FigureBand:
    """A figure: value, deviation, and 95 % between low and high, of the paths.

    at_mean: of the smoothed means.  error: numerical, of the steps, by which low and high stand further out; NaN where it is not
    known.
    """

    name: str
    unit: str
    value: float
    deviation: float
    low: float
    high: float
    at_mean: float
    error: float = float("nan")

    def with_error(self, error: float) -> FigureBand:
        """With a numerical error, which the band then holds, too; NaN where it is not known."""
        return replace(self, low=self.low - error, high=self.high + error, error=error) if isfinite(error) else self

    def to_json(self) -> dict[str, Any]:
        """As plain data."""
        numbers = {"value": self.value, "deviation": self.deviation, "low": self.low, "high": self.high}
        return {**numbers, "unit": self.unit, "error": self.error if isfinite(self.error) else None}


@dataclass(frozen=True)
class Estimate:
    """An estimated state and its parameters.

    how: the filter.  names: of signals and states, with units by name.  history: over time, see `series` and `walk`.  learnt: the
    same by the measurements up to each time alone.  figures: of the scene, over all that was
    measured.  noise: (k,) of the signals.  steps: numerical errors over time, (n, k) of `names`.
    posterior: of constants, where runs follow from them.
    """

    scene: Scene
    measured: Measurements
    how: str
    observability: Observability
    parameters: tuple[Parameter, ...]
    names: tuple[str, ...]
    units: Mapping[str, str]
    history: History
    learnt: History
    innovations: Innovations
    noise: np.ndarray
    verdict: Verdict
    figures: tuple[FigureBand, ...] = ()
    steps: np.ndarray | None = None
    posterior: Posterior | None = None

    @property
    def time(self) -> np.ndarray:
        """Of the estimates, (n,) s."""
        return self.history.time

    @property
    def explains(self) -> bool:
        """Whether the model explains the measurement."""
        return self.verdict.explains

    @property
    def log_likelihood(self) -> float:
        """Logarithm of the probability density of the whole measurement."""
        return self.innovations.log_likelihood

    def __getitem__(self, name: str) -> Parameter:
        """A parameter or an input, at the end of the measurement."""
        known = {p.name: p for p in self.parameters}
        pick(name, known, "estimate", "an estimated parameter")
        return known[name]

    @property
    def errors(self) -> dict[str, float]:
        """Numerical errors, rms over time, by name; empty where they are not known."""
        return {} if self.steps is None else dict(zip(self.names, np.sqrt(np.mean(self.steps**2, axis=0)).tolist(), strict=True))

    def series(self, name: str) -> tuple[np.ndarray, np.ndarray]:
        """(mean, standard deviation), (n,) each, of a signal or a state over `time`."""
        pick(name, self.names, "estimate", "a recorded output or a state")
        k = self.names.index(name)
        return self.history.values[:, k], self.history.deviations[:, k]

    def band(self, name: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """(mean, low, high), (n,) each, of a signal or a state over `time`; low, high: of 95 %, with the numerical error."""
        mean, deviation = self.series(name)
        reach = REACH * deviation + (0.0 if self.steps is None else self.steps[:, self.names.index(name)])
        return mean, mean - reach, mean + reach

    def walk(self, name: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """(value, low, high), (n,) each, over `time`: of an input that walks as it was, of a constant as it was learnt.

        low, high: of 95 %, with the numerical error at the end.
        """
        parameter, k = self[name], [p.name for p in self.parameters].index(name)
        known = self.history if parameter.walks else self.learnt
        q, deviation = known.q[:, k], REACH * known.q_deviations[:, k]
        ends = [np.array([parameter.bounds.outer(v) for v in values]) for values in (q, q - deviation, q + deviation)]
        error = parameter.error if isfinite(parameter.error) else 0.0
        low, high = parameter.bounds.low, parameter.bounds.high
        return ends[0], np.maximum(ends[1] - error, low), np.minimum(ends[2] + error, high)

    def __repr__(self) -> str:
        lines = [f"<Estimate of {self.scene.name}: {self.how}>", str(self.verdict)]
        for p in self.parameters:
            lines.append(f"{p.name}: {shown(p.value, p.deviation)} {'' if p.unit == '1' else p.unit}".rstrip())
        lines += [f"{f.name}: {shown(f.value, f.deviation)} {'' if f.unit == '1' else f.unit}".rstrip() for f in self.figures]
        return "\n".join([*lines, *self.verdict.remarks])

    def save(self, directory: str | Path) -> list[Path]:
        """Write estimate.json, states.csv and innovations.csv."""
        names = [p.name for p in self.parameters]
        units = {**self.units, **{p.name: p.unit for p in self.parameters}}
        walks = {n: self.walk(n) for n in names}
        header = ["time [s]"]
        for n in (*self.names, *names):
            unit = f" [{units[n]}]" if units[n] not in ("", "1") else ""
            header += [f"{n}{unit}", f"{n}, low{unit}", f"{n}, high{unit}"]
        columns = [self.time]
        for n in self.names:
            columns += list(self.band(n))
        for n in names:
            columns += list(walks[n])
        i = self.innovations
        rows = zip(
            i.time, [self.measured.signals[k] for k in i.which], i.measured, i.predicted, i.deviation, i.normalised, strict=True
        )
        header_of_innovations = ("time [s]", "signal", "measured", "predicted", "deviation", "normalised")
        files = [
            Path(directory) / "estimate.json",
            write_table(directory, "states.csv", header, np.array(columns).T.tolist()),
            write_table(directory, "innovations.csv", header_of_innovations, rows),
        ]
        write_json(files[0], self.to_json())
        return files

    def to_json(self) -> dict[str, Any]:
        """Parameters, verdict and how they were found, as plain data."""
        v = self.verdict
        return {
            "scene": self.scene.name,
            "filter": self.how,
            "explains": v.explains,
            "verdict": str(v),
            "remarks": list(v.remarks),
            "checks": [{"test": c.name, "p": c.p, "holds": c.holds, "found": c.words} for c in v.checks],
            "parameters": {p.name: p.to_json() for p in self.parameters},
            "figures": {f.name: f.to_json() for f in self.figures},
            "noise": {
                n: {"deviation": float(s), "unit": u, "estimated": bool(np.isnan(g))}
                for n, s, u, g in zip(self.measured.signals, self.noise, self.measured.units, self.measured.noise, strict=True)
            },
            "suspects": [
                {"name": s.name, "at": s.at, "change": s.value - s.at, "deviation": s.deviation, "gain": s.gain, "unit": s.unit}
                for s in v.suspects
            ],
            "observability": {
                "left": dict(zip(self.observability.names, self.observability.left.tolist(), strict=True)),
                "texts": list(self.observability.texts),
            },
            "log_likelihood": self.log_likelihood,
            "errors": self.errors,
        }
