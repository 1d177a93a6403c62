"""How far the numbers of many runs can be trusted: some of the points are run again, with half of every step.

The runs are kept beside those of the points, in points/<base>/half, and are not made again.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ....components.core.errors import BadInput
from ...run import work
from ...run.key_results import STATISTICS
from ...run.thresholds import WARN
from ..summary import with_error
from .execute import Computing
from .measures import PointResult
from .plan import Points
from .point_runs import PointRuns
from .store import Store, StoredPlan

AT_RANDOM = 3  # points besides those at the ends
SEED = 0
OF_DEVIATION = 0.1  # of a column over the points, from which a numerical error changes its distribution
SHOWN = 3  # columns that a message names
NONE_REPEATED = "no point was repeated: the errors of these numbers are not known"


@dataclass(frozen=True)
class Repeated:
    """What half of every step changes at some points.

    chosen: places of the points that were to be repeated; points: of those that were, within the work for it.  errors: by column,
    twice the largest difference of any point.  shares: the same over the column's scale, its largest size at any point, or that
    of its signal's other statistics.  at: by column, the place of that point.  failed: by place, why the run with half the step
    has not come to its end.
    """

    chosen: tuple[int, ...]
    points: tuple[int, ...]
    errors: Mapping[str, float]
    shares: Mapping[str, float]
    at: Mapping[str, int]
    failed: Mapping[int, str]

    def summary(self, total: int) -> str:
        """Which points were repeated, and how large the errors are, in one sentence."""
        if not self.points:
            return NONE_REPEATED
        over = "" if len(self.points) == len(self.chosen) else f"; {len(self.chosen)} were to be, which is too much work"
        worst = max(self.shares, key=self.shares.__getitem__, default="")
        largest = f"errors up to {100.0 * self.shares[worst]:.2g} % ({worst})" if worst else "no number to compare"
        return (
            f"{len(self.points)} of {total} points, at the ends and at random, repeated with half of every step: {largest}{over}"
        )

    def messages(self) -> list[str]:
        """What a user must know of the errors: those that are too large, and runs that only come to their end with long steps."""
        large = sorted((n for n, share in self.shares.items() if share > WARN), key=lambda n: -self.shares[n])
        texts = []
        if large:
            named = "; ".join(f"{n} by up to ±{self.errors[n]:.2g}, {100.0 * self.shares[n]:.2g} %" for n in large[:SHOWN])
            more = f", and {len(large) - SHOWN} more" if len(large) > SHOWN else ""
            texts.append(f"half of every step changes {named}{more}: shorten master.step and the substeps")
        return texts + self.not_confirmed()

    def not_confirmed(self) -> list[str]:
        """Points that only come to their end with long steps, one sentence each."""
        return [f"point {k} does not come to its end with half of every step: {why}" for k, why in self.failed.items()]

    def to_json(self) -> dict[str, Any]:
        """What sweep.json says of it."""
        return {
            "chosen": list(self.chosen),
            "points": list(self.points),
            "seed": SEED,
            "macro step": 0.5,
            "errors": {n: {"error": self.errors[n], "share": self.shares[n], "point": self.at[n]} for n in self.errors},
            "failed": {str(k): why for k, why in self.failed.items()},
        }


def ends_and_some(plan: Points, done: np.ndarray) -> list[int]:
    """Places of the points at the ends of what varies, then of some at random; done: (n,) truth values of those that count."""
    able = np.flatnonzero(done)
    if not able.size:
        return []
    chosen = [able[0], able[-1]] if plan.settings.method == "grid" else []
    for column in plan.columns.values():
        if column.labels.dtype.kind == "f":
            values = column.labels[able]
            chosen += [able[values.argmin()], able[values.size - 1 - values[::-1].argmax()]]
    some = np.random.default_rng(SEED).permutation(able)
    return list(dict.fromkeys(map(int, [*chosen, *some[:AT_RANDOM]])))


def repeat(points: StoredPlan, places: Sequence[int], jobs: int | None = 1, cluster: str = "") -> dict[int, PointResult]:
    """Rows with half of every step by place, of as many as their counted work allows; of one in any case. jobs, cluster: who
    computes them, as of `Computing`."""
    places = _allowed(points, places)
    halved = replace(points.task, alterations=points.task.alterations._replace(parts=2 * points.task.alterations.parts))
    half = StoredPlan(halved, points.plan.at(places), Store(points.store.folder / "half"))
    if (missing := half.missing()).size:
        with Computing(halved, jobs, cluster) as computing:
            computing(half, missing)
    return {places[k]: row for k, row in half.rows(range(len(places))).items()}


def _allowed(points: StoredPlan, places: Sequence[int]) -> Sequence[int]:
    """The first places, as far as the work of their runs with half of every step is within the budget; counted anew each time,
    so that what is kept of an earlier sweep changes no choice."""
    scene, total = points.task.scene(), 0.0
    runs = PointRuns(replace(points.task, data=work.to_count(scene).settings()))
    try:
        for k, place in enumerate(places):
            values = points.plan.values(place)
            stop = values.get("stop_time", scene.stop_time)
            with suppress(BadInput):  # a point that cannot start takes no work
                total += work.from_part(runs.result(values), stop - scene.start_time)
            if k and not work.allows(total, 2.0):
                return places[:k]
    finally:
        runs.close()
    return places


def compared(places: Sequence[int], rows: Mapping[int, PointResult], numbers: Mapping[str, np.ndarray]) -> Repeated:
    """The rows with half of every step against the numbers (n,) of all points by column."""
    done = [k for k in places if k in rows and rows[k].outcome == "done"]
    scales = _scales(numbers)
    errors, shares, at = {}, {}, {}
    gaps = {k: np.abs(rows[k].numbers.at(numbers) - [values[k] for values in numbers.values()]) for k in done}
    for i, name in enumerate(numbers):
        known = {k: float(gap[i]) for k, gap in gaps.items() if np.isfinite(gap[i])}
        if known:
            at[name] = max(known, key=known.__getitem__)
            errors[name] = 2.0 * known[at[name]]
            shares[name] = errors[name] / scales[name] if errors[name] else 0.0
    failed = {k: rows[k].reason for k in places if k in rows and rows[k].outcome != "done"}
    return Repeated(tuple(places), tuple(k for k in places if k in rows), errors, shares, at, failed)


def _scales(numbers: Mapping[str, np.ndarray]) -> dict[str, float]:
    """By column its largest size, or that of the largest statistic of the same signal: a mean may be near zero."""
    sizes = {n: float(np.abs(x[np.isfinite(x)]).max(initial=0.0)) for n, x in numbers.items()}
    signals: dict[str, float] = {}
    for name, size in sizes.items():
        signal, _, kind = name.rpartition(", ")
        if kind in STATISTICS:
            signals[signal] = max(signals.get(signal, 0.0), size)
    return {n: max(size, signals.get(n.rpartition(", ")[0], 0.0), np.finfo(float).tiny) for n, size in sizes.items()}


def shown(value: float, repeated: Repeated | None, name: str) -> str:
    """A number of a column with its error, "116.0 ± 0.3", where points were repeated."""
    return with_error(value, repeated.errors.get(name, float("nan")) if repeated is not None else float("nan"))


def blurred(repeated: Repeated | None, deviations: Mapping[str, float]) -> list[str]:
    """What a user must know of columns whose numerical error is not small beside their standard deviation over the points."""
    if repeated is None:
        return []
    shares = {n: repeated.errors[n] / d for n, d in deviations.items() if repeated.errors.get(n, 0.0) > OF_DEVIATION * d > 0.0}
    return [
        f"{name}: the numerical error of a run, up to ±{repeated.errors[name]:.2g}, is {100.0 * share:.2g} % of the standard "
        "deviation over the points: shorten master.step and the substeps"
        for name, share in shares.items()
    ]
