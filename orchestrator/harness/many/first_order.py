"""First order before samples: what derivatives say of all points of a plan, and whether some runs agree.

    f(p) = f(m) + g (p - m)        g: exact derivatives at the means m of the parameters

The runs that judge it are those where a quantity is predicted to be least and largest, and some at random. First order is taken if
what it leaves out there is less than what n samples leave open anyway: their standard deviation s is known to s / sqrt(2 n).
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from math import ceil, sqrt
from pathlib import Path
from typing import Unpack

import numpy as np

from ...derivatives.along import PointDerivatives
from ...judgement.parameter_errors import FIRST_ORDER
from ...run.results import Result
from ...scene.scene import Scene
from ...settings.plan import Distribution, PlanSettings
from ..sweep import AnswerOptions, Sweep, sweep
from .columns import as_column
from .measures import Task, row_of_result
from .plan import plan_of, unit_points
from .repetition import AT_RANDOM, SEED


@dataclass(frozen=True)
class FirstOrder:
    """runs: those that judge it.  values: of all points of the plan, (n,) by column.  rest: what it leaves out, as a share of the
    standard deviation; holds: whether that is little enough."""

    runs: Sweep
    values: dict[str, np.ndarray]
    rest: float
    holds: bool


def first_order(
    scene: Scene, settings: PlanSettings, names: Sequence[str], directory: str | Path | None, **how: Unpack[AnswerOptions]
) -> FirstOrder | None:
    """Of columns over a plan of samples; None where it has no derivatives, or takes more than half of the runs of the samples.

    Raises `BadInput` as a sweep.
    """
    columns = [as_column(name) for name in names]
    n, d = settings.points or 0, len(settings.vary)
    work = FIRST_ORDER * ceil(d / 8) + 2 * len(columns) + AT_RANDOM
    kept = settings.keep.signals or settings.keep.functions
    if 2.0 * work > n or kept or not all(isinstance(axis, Distribution) for axis in settings.vary.values()):
        return None
    plan, cube = plan_of(scene, settings), unit_points(settings.method, n, d, settings.seed)
    points = np.stack([column.numbers for column in plan.columns.values()], axis=1)
    center = points.mean(axis=0)
    task, seen = Task.of(scene, settings.keep, how.get("summarize")), list[np.ndarray]()

    def numbers(result: Result) -> np.ndarray:
        seen.append(row_of_result(result, task).values(columns))  # first those of the run itself
        return seen[-1]

    with ExitStack() as stack:
        derivatives = PointDerivatives(task.scene(), [*plan.columns], stack)
        if derivatives.reasons:
            return None
        slopes = derivatives(dict(zip(plan.columns, center.tolist(), strict=True)), numbers)
    if not seen or not np.isfinite(slopes).all():
        return None
    values = seen[0] + (points - center) @ slopes.T
    ends = [*values.argmin(axis=0), *values.argmax(axis=0)]
    some = np.random.default_rng(SEED).permutation(n)[:AT_RANDOM]
    places = list(dict.fromkeys(map(int, [*ends, *some])))
    runs = sweep(scene, settings, directory, columns=names, cube=cube[places], **how)
    actual = np.stack([runs.measures.get(name, np.full(len(places), np.nan)) for name in columns], axis=1)
    beside = np.sqrt(np.mean((actual - values[places]) ** 2, axis=0))
    deviation = values.std(axis=0)
    shares = np.where(beside > 1e-9 * np.abs(seen[0]), beside / np.maximum(deviation, 1e-300), 0.0)
    shares[~np.isfinite(actual).all(axis=0)] = np.inf
    rest = float(shares.max())
    return FirstOrder(runs, dict(zip(columns, values.T, strict=True)), rest, rest <= 1.0 / sqrt(2.0 * n))
