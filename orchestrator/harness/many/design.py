"""Choose parameters so that quantities are small or large while others keep their limits: SciPy's searches over runs for one
quantity, a front for several."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Unpack

import numpy as np

from ....components.core.errors import BadInput, counted
from ...output import write_table
from ...scene.names import measure_of
from ...scene.scene import Scene
from ...settings.answers import DesignSettings, LimitSettings
from ...settings.messages import validated
from ..sweep import Sweep
from .columns import column_name, keep_for
from .evaluations import Evaluations, SearchOptions, evaluations
from .front import check_pymoo, search_front, still_growing, unbeaten
from .limits import check_limits, with_rows
from .measures import PointResult
from .plan import other_starts, read_settings
from .repetition import Repeated
from .searches import Ask, jacobian, run_searches

FEASIBLE = 1e-6  # of a limit's size: how far a constraint may be exceeded by rounding
EVALUATIONS = 200  # at most, each start
REPEATED = 5  # runs of a front, from end to end, that are made again with half of every step
BAD = 1e3  # a failed run is this many scales worse than the start


@dataclass(frozen=True)
class Step:
    """One run of the search."""

    parameters: tuple[float, ...]
    quantities: tuple[float, ...]
    constraints: tuple[float, ...]
    feasible: bool
    outcome: str

    @property
    def quantity(self) -> float:
        """That of the first aim."""
        return self.quantities[0]


@dataclass(frozen=True)
class Design:
    """The best runs that keep all limits, among all that were made.

    quantities, maximise: the aims, and which of them are made large.  names: of the parameters.  constraints: of the columns with
    limits.  units: of measure of all these.  front: places in `steps` that no other one beats in one aim without losing in
    another, in the order of the first aim; of one aim the best run, none where no run keeps the limits.  active: constraints of
    the best run of one aim that are at a limit.  repeated: what half of every step changes at the best run, or at some of a
    front.  starts: searches.  computed: runs of this call; the others were kept.  sweep:
    all of them.
    """

    quantities: tuple[str, ...]
    maximise: tuple[bool, ...]
    names: tuple[str, ...]
    units: Mapping[str, str]
    constraints: Mapping[str, LimitSettings]
    steps: tuple[Step, ...]
    front: tuple[int, ...]
    active: tuple[str, ...]
    messages: tuple[str, ...]
    repeated: Repeated | None
    starts: int
    computed: int
    sweep: Sweep | None = None

    @property
    def quantity(self) -> str:
        """The first aim."""
        return self.quantities[0]

    @property
    def best(self) -> int:
        """Place of the best run, of a front the first one; -1 without any."""
        return self.front[0] if self.front else -1

    @property
    def values(self) -> dict[str, float]:
        """The parameters of the best run; empty where there is none."""
        return dict(zip(self.names, self.steps[self.best].parameters, strict=True)) if self.best >= 0 else {}

    def __repr__(self) -> str:
        """The best run, or the ends of a front."""
        ends = [self.front[0], self.front[-1]] if len(self.front) > 1 else list(self.front)
        units = {n: u if u != "1" else "" for n, u in self.units.items()}
        lines = [f"<Design: {counted(len(self.steps), 'run')}, {len(self.front) or 'none'} best>"]
        for place in ends:
            step = self.steps[place]
            named = zip((*self.quantities, *self.names), (*step.quantities, *step.parameters), strict=True)
            lines.append(", ".join(f"{n} {v:.5g} {units.get(n, '')}".rstrip() for n, v in named))
        return "\n".join([*lines, *self.messages])

    def save(self, directory: str | Path) -> Path:
        """Write design.csv: a row a run, and which of them are on the front."""
        header = [
            *(f"{n}, {self.units[n]}" if self.units.get(n) else n for n in self.names),
            *self.quantities,
            *self.constraints,
            "feasible",
            "front",
            "outcome",
        ]
        front = set(self.front)
        rows = [
            (
                *s.parameters,
                *s.quantities,
                *s.constraints,
                "yes" if s.feasible else "no",
                "yes" if k in front else "no",
                s.outcome,
            )
            for k, s in enumerate(self.steps)
        ]
        return write_table(directory, "design.csv", header, rows)


def design(
    scene: Scene,
    settings: DesignSettings | Mapping[str, Any] | str | Path,
    directory: str | Path | None = None,
    *,
    limits: str = "",
    conditions: Sequence[str] = (),
    verify: bool = True,
    **how: Unpack[SearchOptions],
) -> Design:
    """Search for the least (or largest) quantity within bounds and limits: local searches, from one or several starts. Of several
    quantities a front, by NSGA-II.

    `directory`: where the runs are kept; those of an earlier call are not run again. `limits`, `conditions`: a validation table
    whose rows are constraints as well, and which of them. `verify`: whether the best run, of a front some of its runs, are made
    again with half of every step. `how`: who computes the runs of differences, of several starts and of a generation; no number
    depends on it. Raises `BadInput`, also where the start cannot be run, and `Stopped` where a signal has ended it.
    """
    data, name, folder = read_settings(settings, "design", scene)
    wanted = with_rows(validated(DesignSettings, data, name), folder, scene=scene)
    wanted = with_rows(wanted, table=limits, conditions=conditions, scene=scene)
    several = len(wanted.aims) > 1
    if several:
        check_pymoo()
    keep = keep_for([*wanted.aims, *wanted.constraints], wanted.keep)
    needed = {"design": wanted.aims, "design: constraints": wanted.constraints}
    with evaluations(scene, wanted.vary, keep, needed, directory, **how) as runs:
        start = runs.start()
        (first,) = runs([start])
        if first.outcome != "done":
            raise BadInput(
                "design: start", f"a run that is {first.outcome}: {first.reason}", "a start that runs", "Give another start."
            )
        aims = tuple(column_name(first.numbers, name, "design") for name in wanted.aims)
        columns = [column_name(first.numbers, n, "design: constraints") for n in wanted.constraints]
        limits_of = dict(zip(columns, wanted.constraints.values(), strict=True))
        check_limits(limits_of, first.units)
        begin = (start - runs.low) / (runs.high - runs.low)
        sign = np.array([1.0] * len(wanted.minimise) + [-1.0] * len(wanted.maximise))
        if several:
            search_front(wanted, runs, aims, sign, limits_of, begin)
            message = ""
        else:
            message = _one_aim(wanted, runs, aims[0], limits_of, first, begin)
        steps = tuple(_step(p, row, aims, limits_of) for p, row in runs.history)
        good = np.flatnonzero([s.feasible for s in steps])
        values = sign * np.array([steps[k].quantities for k in good]).reshape(good.size, len(aims))
        front = good[unbeaten(values)] if several else good[values[:, 0].argmin()][None] if good.size else good
        messages = [message] if message else []
        if several and (text := still_growing(values, good, len(steps))):
            messages.append(text)
        ended = list(runs.history)
        messages += dict.fromkeys(row.reason for k in front.tolist() if (row := ended[k][1]).reason)
        repeated = None
        if verify and front.size:
            some = dict.fromkeys(front[np.linspace(0, front.size - 1, min(REPEATED, front.size)).round().astype(int)].tolist())
            repeated = runs.repeated([np.array(steps[k].parameters) for k in some])[1]
            messages += [*repeated.messages(), *_undecided([steps[k] for k in some], limits_of, repeated)]
        ends = zip(limits_of.items(), steps[front[0]].constraints, strict=True) if front.size and not several else ()
        active = tuple(name for (name, limit), v in ends if _at_limit(v, limit))
        units = {n: measure_of(scene, n) for n in runs.names} | {n: first.units.get(n, "") for n in aims}
        units |= {n: first.units.get(n, "") or limit.unit for n, limit in limits_of.items()}
        return Design(
            aims,
            tuple((sign < 0.0).tolist()),
            tuple(runs.names),
            units,
            limits_of,
            steps,
            tuple(front.tolist()),
            active,
            tuple(messages),
            repeated,
            wanted.starts,
            runs.computed,
            runs.sweep(),
        )


def _one_aim(
    wanted: DesignSettings,
    runs: Evaluations,
    quantity: str,
    limits: Mapping[str, LimitSettings],
    first: PointResult,
    begin: np.ndarray,
) -> str:
    """Search from `begin` and from the other starts; what a user should know of it."""
    searching = _Searching(wanted, runs, quantity, limits, first.numbers[quantity])
    starts = [begin, *other_starts(wanted.starts, len(begin), wanted.seed)]
    solutions = run_searches([searching.search(u) for u in starts], runs)
    left = [s.message for s in solutions if not s.success]
    which = f"{len(left)} of {len(starts)} searches" if len(starts) > 1 else "the search"
    return f"{which} ended before it had converged: {left[0]}" if left else ""


class _Searching:
    """The aim and the limits over the unit cube, scaled, from the rows of runs. first: the quantity at the start."""

    def __init__(
        self, wanted: DesignSettings, runs: Evaluations, quantity: str, limits: Mapping[str, LimitSettings], first: float
    ):
        self.wanted, self.runs, self.quantity, self.limits = wanted, runs, quantity, limits
        self.sign = -1.0 if wanted.maximise else 1.0
        self.first, self.scale = self.sign * first, abs(first) or 1.0
        self.sizes = [limit.size for limit in limits.values()]

    def search(self, start: np.ndarray) -> Callable[[Ask], Any]:
        """SciPy's solution from a start in the unit cube."""
        wanted, most = self.wanted, self.wanted.evaluations or EVALUATIONS
        ends = [
            [
                (getattr(limit, end) / s if getattr(limit, end) is not None else other)
                for limit, s in zip(self.limits.values(), self.sizes, strict=True)
            ]
            for end, other in (("low", -np.inf), ("high", np.inf))
        ]

        def solve(ask: Ask) -> Any:
            from scipy.optimize import NonlinearConstraint, minimize

            def values(points: Sequence[np.ndarray]) -> list[np.ndarray]:
                inside = [self.runs.low + np.clip(u, 0.0, 1.0) * (self.runs.high - self.runs.low) for u in points]
                return [self._scaled(row) for row in ask(inside)]

            def whole(u: np.ndarray) -> np.ndarray:
                v = values([u])[0]
                return np.where(np.isfinite(v), v, self._bad())

            def slopes(u: np.ndarray) -> np.ndarray:
                u, width = np.clip(u, 0.0, 1.0), self.runs.high - self.runs.low
                return jacobian(
                    values, u, wanted.step, self.runs.names, self.runs.slopes(self.runs.low + u * width, self._scaled) * width
                )

            if (wanted.method or "COBYQA") == "COBYQA":
                options = {"maxfev": most, "final_tr_radius": wanted.accuracy, "initial_tr_radius": 0.1}
                constraints = [NonlinearConstraint(lambda u: whole(u)[1:], *ends)] if self.limits else []
                first = {}
            else:
                options = {"maxiter": most, "ftol": wanted.accuracy**2}
                constraints = (
                    [NonlinearConstraint(lambda u: whole(u)[1:], *ends, jac=lambda u: slopes(u)[1:])] if self.limits else []
                )
                first = {"jac": lambda u: slopes(u)[0]}
            return minimize(
                lambda u: whole(u)[0],
                start,
                method=wanted.method or "COBYQA",
                bounds=[(0.0, 1.0)] * len(start),
                constraints=constraints,
                options=options,
                **first,
            )

        return solve

    def _scaled(self, row: PointResult) -> np.ndarray:
        """Aim and limited columns, (1 + c,); NaN where the run failed."""
        return row.values([self.quantity, *self.limits]) / [self.sign * self.scale, *self.sizes]

    def _bad(self) -> np.ndarray:
        """What a failed run has in their places: worse than the start, and clearly out of the limits."""
        outside = [_outside(limit, s) for limit, s in zip(self.limits.values(), self.sizes, strict=True)]
        return np.array([self.first / self.scale + BAD, *outside])


def _outside(limit: LimitSettings, size: float) -> float:
    """What a failed run has in the place of a column: clearly out of its limits."""
    return limit.high / size + 1.0 if limit.high is not None else limit.low / size - 1.0  # type: ignore[operator]


def _step(p: np.ndarray, row: PointResult, aims: Sequence[str], limits: Mapping[str, LimitSettings]) -> Step:
    values, sizes = row.values(limits).tolist(), row.values(aims)
    inside = all(limit.keeps(v, FEASIBLE * limit.size) for v, limit in zip(values, limits.values(), strict=True))
    good = bool(np.isfinite(sizes).all()) and inside
    outcome = row.outcome if row.outcome == "done" else f"{row.outcome}: {row.reason}"
    return Step(tuple(p.tolist()), tuple(sizes.tolist()), tuple(values), good, outcome)


def _undecided(steps: Sequence[Step], limits: Mapping[str, LimitSettings], repeated: Repeated) -> list[str]:
    """Limits that are kept by less than the numerical error."""
    texts = []
    for i, (name, limit) in enumerate(limits.items()):
        error = repeated.errors.get(name, 0.0)
        near = [s for s in steps if s.feasible and not limit.keeps(s.constraints[i], -error)]
        if near and error > FEASIBLE * limit.size:
            texts.append(f"{name} is kept by less than its numerical error of ±{error:.2g}: with exact steps it may be exceeded")
    return texts


def _at_limit(value: float, limit: LimitSettings) -> bool:
    return any(end is not None and abs(value - end) <= 1e-3 * limit.size for end in (limit.low, limit.high))
