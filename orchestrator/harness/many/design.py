"""Choose parameters so that a quantity is small or large while others keep their limits: SciPy's searches over runs."""

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
from ...settings.answers import DesignSettings, LimitSettings
from ...settings.messages import one_message
from .evaluations import Evaluations, Summarize, column_name, keep_for
from .measures import Row
from .plan import unit_of

FEASIBLE = 1e-6  # of a limit's size: how far a constraint may be exceeded by rounding
BAD = 1e3  # a failed run is this many scales worse than the start


@dataclass(frozen=True)
class Step:
    """One run of the search."""

    parameters: tuple[float, ...]
    quantity: float
    constraints: tuple[float, ...]
    feasible: bool
    outcome: str


@dataclass(frozen=True)
class Design:
    """The best run that keeps all limits, among all that were made. best: its place in `steps`, -1 where none does.

    names: of the parameters; constraints: of the columns with limits; active: those at a limit.
    """

    quantity: str
    maximise: bool
    names: tuple[str, ...]
    units: Mapping[str, str]
    constraints: Mapping[str, LimitSettings]
    steps: tuple[Step, ...]
    best: int
    active: tuple[str, ...]
    message: str

    @property
    def values(self) -> dict[str, float]:
        """The parameters of the best run; empty where there is none."""
        return dict(zip(self.names, self.steps[self.best].parameters, strict=True)) if self.best >= 0 else {}

    def save(self, directory: str | Path) -> Path:
        """Write design.csv: a row a run."""
        header = [*(f"{n}, {self.units[n]}" if self.units.get(n) else n for n in self.names), self.quantity, *self.constraints,
                  "feasible", "outcome"]
        rows = [(*s.parameters, s.quantity, *s.constraints, "yes" if s.feasible else "no", s.outcome) for s in self.steps]
        return write_table(directory, "design.csv", header, rows)


def design_settings(data: DesignSettings | Mapping[str, Any] | str | Path) -> DesignSettings:
    """A design from its file or plain data, checked."""
    if isinstance(data, DesignSettings):
        return data
    name, table = (Path(data).name, read_toml(Path(data))) if isinstance(data, str | Path) else ("design", dict(data))
    try:
        return DesignSettings.model_validate(table)
    except ValidationError as error:
        raise one_message(error, DesignSettings, name) from None


def design(scene: Scene, settings: DesignSettings | Mapping[str, Any] | str | Path, *, summarize: Summarize | None = None,
           observe: Callable[[int], None] = lambda n: None) -> Design:
    """Search for the least (or largest) quantity within bounds and limits; a local search, from the start that is given.

    Raises `BadInput`, also where the start cannot be run.
    """
    from scipy.optimize import NonlinearConstraint, minimize

    wanted = design_settings(settings)
    aim = wanted.minimise or wanted.maximise
    runs = Evaluations(scene, wanted.vary, keep_for([aim, *wanted.constraints], wanted.keep), summarize, observe)
    low, width = runs.low, runs.high - runs.low
    start = runs.start(wanted.vary)
    first = runs(start)
    if first.outcome != "done":
        raise BadInput("design: start", f"a run that is {first.outcome}: {first.reason}", "a start that runs",
                       "Give another start.")
    quantity = column_name(first.numbers, aim, "design")
    columns = [column_name(first.numbers, n, "design: constraints") for n in wanted.constraints]
    limits = dict(zip(columns, wanted.constraints.values(), strict=True))
    sign = -1.0 if wanted.maximise else 1.0
    scale = abs(first.numbers[quantity]) or 1.0
    sizes = [_size(limits[c]) for c in columns]

    def objective(u: np.ndarray) -> float:
        row = runs(low + np.clip(u, 0.0, 1.0) * width)
        value = row.numbers.get(quantity, np.nan) if row.outcome == "done" else np.nan
        return sign * value / scale if np.isfinite(value) else sign * first.numbers[quantity] / scale + BAD

    def constrained(u: np.ndarray) -> np.ndarray:
        row = runs(low + np.clip(u, 0.0, 1.0) * width)
        values = [row.numbers.get(c, np.nan) / s for c, s in zip(columns, sizes, strict=True)]
        return np.array([v if np.isfinite(v) else _outside(limits[c], s) for v, c, s in zip(values, columns, sizes, strict=True)])

    ends = [[(getattr(limits[c], end) / s if getattr(limits[c], end) is not None else other)
             for c, s in zip(columns, sizes, strict=True)] for end, other in (("low", -np.inf), ("high", np.inf))]
    constraints = [NonlinearConstraint(constrained, *ends)] if columns else []
    options = ({"maxfev": wanted.evaluations, "final_tr_radius": wanted.accuracy, "initial_tr_radius": 0.1}
               if wanted.method == "COBYQA" else
               {"maxiter": wanted.evaluations, "ftol": wanted.accuracy**2, "eps": wanted.step})
    solution = minimize(objective, (start - low) / width, method=wanted.method, bounds=[(0.0, 1.0)] * len(low),
                        constraints=constraints, options=options)
    steps = tuple(_step(p, row, quantity, limits) for p, row in runs.history)
    good = [k for k, s in enumerate(steps) if s.feasible]
    best = min(good, key=lambda k: sign * steps[k].quantity, default=-1)
    message = "" if solution.success else f"the search ended before it had converged: {solution.message}"
    active = tuple(c for c, v in zip(columns, steps[best].constraints, strict=True) if _at_limit(v, limits[c])) if good else ()
    return Design(quantity, bool(wanted.maximise), tuple(runs.names), {n: unit_of(scene, n) for n in runs.names}, limits, steps,
                  best, active, message)


def _size(limit: LimitSettings) -> float:
    return max(abs(e) for e in (limit.low, limit.high) if e is not None) or 1.0


def _outside(limit: LimitSettings, size: float) -> float:
    """What a failed run has in the place of a column: clearly out of its limits."""
    return limit.high / size + 1.0 if limit.high is not None else limit.low / size - 1.0  # type: ignore[operator]


def _step(p: np.ndarray, row: Row, quantity: str, limits: Mapping[str, LimitSettings]) -> Step:
    values = tuple(row.numbers.get(c, float("nan")) for c in limits)
    value = row.numbers.get(quantity, float("nan"))
    inside = all(_keeps(v, limit) for v, limit in zip(values, limits.values(), strict=True))
    good = row.outcome == "done" and bool(np.isfinite(value)) and inside
    return Step(tuple(p.tolist()), value, values, good, row.outcome if row.outcome == "done" else f"{row.outcome}: {row.reason}")


def _keeps(value: float, limit: LimitSettings) -> bool:
    slack = FEASIBLE * _size(limit)
    return (limit.low is None or value >= limit.low - slack) and (limit.high is None or value <= limit.high + slack)


def _at_limit(value: float, limit: LimitSettings) -> bool:
    return any(end is not None and abs(value - end) <= 1e-3 * _size(limit) for end in (limit.low, limit.high))
