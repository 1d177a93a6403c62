"""Fronts of several aims under limits: NSGA-II of pymoo over runs, a generation at a time.

Deb, Pratap, Agarwal, Meyarivan, IEEE Transactions on Evolutionary Computation 6 (2002) 182-197 (from memory): of two points that
keep their limits the one that dominates is better, of two that do not the one that violates them less.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from typing import Any

import numpy as np

from ....components.core.errors import BadInput
from ...settings.answers import DesignSettings
from ...settings.plan import LimitSettings
from .evaluations import Evaluations
from .measures import PointResult
from .plan import unit_points

EVALUATIONS = 1000  # runs at most
FAILED = 1e6  # of a limit's size: how far a failed run is out of its limits
GROWTH = 0.01  # of its hypervolume: what the last quarter of the runs may add to a front that has converged


def check_pymoo() -> None:
    """Refuse a front without the library."""
    if find_spec("pymoo") is None:
        raise BadInput("design", "several aims without pymoo", "an installed pymoo", "pip install cosimo[design]")


def search_front(
    wanted: DesignSettings,
    runs: Evaluations,
    aims: Sequence[str],
    sign: np.ndarray,
    limits: Mapping[str, LimitSettings],
    begin: np.ndarray,
) -> None:
    """Run generations; all of their runs are then in `runs.history`.

    sign: (m,) 1 of aims to be small, -1 of those to be large.  begin: (n,) in the unit cube, the first point; the others of the
    first generation are a Latin hypercube.  What the generations are depends on the seed and on the runs' numbers alone.
    """
    from pymoo.algorithms.moo.nsga2 import NSGA2
    from pymoo.core.evaluator import Evaluator
    from pymoo.core.problem import Problem
    from pymoo.problems.static import StaticProblem

    n, size = len(begin), wanted.population
    first = np.vstack([begin, unit_points("latin-hypercube", size - 1, n, wanted.seed)])
    problem = Problem(n_var=n, n_obj=len(aims), n_ieq_constr=1 + 2 * len(limits), xl=0.0, xu=1.0)
    algorithm: Any = NSGA2(pop_size=size, sampling=first)
    generations = max(1, (wanted.evaluations or EVALUATIONS) // size)
    algorithm.setup(problem, termination=("n_gen", generations), seed=wanted.seed, verbose=False)
    while algorithm.has_next():
        generation = algorithm.ask()
        rows = runs([runs.low + u * (runs.high - runs.low) for u in np.clip(generation.get("X"), 0.0, 1.0)])
        answers = [_judged(row, aims, sign, limits) for row in rows]
        values, outside = (np.array(part) for part in zip(*answers, strict=True))
        Evaluator().eval(StaticProblem(problem, F=values, G=outside), generation)
        algorithm.tell(infills=generation)


def _judged(
    row: PointResult, aims: Sequence[str], sign: np.ndarray, limits: Mapping[str, LimitSettings]
) -> tuple[np.ndarray, np.ndarray]:
    """Aims (m,), all to be small, and how far the run is out of its limits (1 + 2 c,), negative inside; the first: it failed."""
    values = sign * row.values(aims)
    if not np.isfinite(values).all():
        return np.zeros(len(aims)), np.full(1 + 2 * len(limits), FAILED)
    outside = [0.0]
    for x, limit in zip(row.values(limits), limits.values(), strict=True):
        for end, way in ((limit.low, -1.0), (limit.high, 1.0)):
            outside.append(-1.0 if end is None else way * (x - end) / limit.size if np.isfinite(x) else FAILED)
    return values, np.array(outside)


def unbeaten(values: np.ndarray) -> np.ndarray:
    """Places of the points (k, m), all to be small, that none beats: no other is as small in every aim and smaller in one. Of
    equal points the first; in the order of the first aim."""
    kept: list[int] = []
    for k in np.lexsort(values.T[::-1]):  # who comes later beats none that came before
        if not any((values[other] <= values[k]).all() for other in kept):
            kept.append(int(k))
    return np.array(kept, dtype=int)


def still_growing(values: np.ndarray, places: np.ndarray, count: int) -> str:
    """What a user should know where the last quarter of `count` runs has added to the front of points (k, m), at `places` of
    them; measured by the hypervolume below the worst of each aim."""
    if not values.size:
        return ""
    from pymoo.indicators.hv import HV

    worst, best = values.max(axis=0), values.min(axis=0)
    scaled = (values - best) / np.where(worst > best, worst - best, 1.0)
    volume = HV(ref_point=np.ones(values.shape[1]))
    early = scaled[places < 0.75 * count]
    whole, before = (float(volume(part[unbeaten(part)])) if len(part) else 0.0 for part in (scaled, early))
    if whole <= 0.0 or (whole - before) / whole <= GROWTH:
        return ""
    return (
        f"the front was still growing: the last quarter of the runs added {100.0 * (whole - before) / whole:.2g} % of its "
        "hypervolume; give more evaluations"
    )
