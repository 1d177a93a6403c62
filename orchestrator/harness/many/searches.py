"""Searches that need runs: the next runs of all searches are computed together, so that no number depends on who computes.

A search is a function that is given `ask(points) -> rows` and calls it whenever it needs runs. Each is in a thread of its own, and
goes on alone until it asks again; the runs are computed where `run_searches` was called.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from queue import SimpleQueue
from typing import Any, TypeVar

import numpy as np

from ....components.core.errors import BadInput

T = TypeVar("T")
Ask = Callable[[Sequence[np.ndarray]], list[Any]]  # rows: what the runs of a point give


class _Abandoned(BaseException):
    """Ends a search that is not gone on with."""


def run_searches(searches: Sequence[Callable[[Ask], T]], compute: Ask) -> list[T]:
    """The results of searches, in their order. `compute`: runs points, together those that all searches have asked for."""
    questions: list[SimpleQueue[Sequence[np.ndarray] | None]] = [SimpleQueue() for _ in searches]  # None: the search has ended
    answers: list[SimpleQueue[list[Any] | None]] = [SimpleQueue() for _ in searches]  # None: it is not gone on with

    def run(place: int) -> T:
        def ask(points: Sequence[np.ndarray]) -> list[Any]:
            questions[place].put(points)
            if (rows := answers[place].get()) is None:
                answers[place].put(None)
                raise _Abandoned
            return rows

        try:
            return searches[place](ask)
        finally:
            questions[place].put(None)

    with ThreadPoolExecutor(len(searches)) as threads:
        results: list[Future[T]] = []
        asked: dict[int, Sequence[np.ndarray]] = {}
        try:
            for place in range(len(searches)):
                results.append(threads.submit(run, place))
                asked |= _question(place, questions[place], results[place])
            while asked:
                rows = iter(compute([p for points in asked.values() for p in points]))
                given = {place: [next(rows) for _ in points] for place, points in asked.items()}
                asked = {}
                for place, some in given.items():
                    answers[place].put(some)
                    asked |= _question(place, questions[place], results[place])
        except BaseException:
            for queue in answers:
                queue.put(None)
            raise
    return [result.result() for result in results]


def _question(place: int, questions: SimpleQueue[Any], result: Future[Any]) -> dict[int, Sequence[np.ndarray]]:
    """What a search asks for next, by its place; nothing where it has ended. Raises what has ended it."""
    if (points := questions.get()) is not None:
        return {place: points}
    result.result()
    return {}


def jacobian(
    values: Callable[[Sequence[np.ndarray]], Sequence[np.ndarray]],
    u: np.ndarray,
    step: float,
    names: Sequence[str],
    exact: np.ndarray,
) -> np.ndarray:
    """Derivatives (m, n) of values (m,) at a point u (n,) of the unit cube.

    exact: (m, n), NaN in columns that are not known, which follow from differences to one side, of the size `step`. Their points are
    asked for together. Forward, but backward at the upper bound and where the run ahead has failed (its values are not finite).
    Raises `BadInput` where the runs on both sides fail.
    """
    missing = [k for k in range(u.size) if not (exact.shape[0] and np.isfinite(exact[:, k]).all())]
    if not missing:
        return exact
    shift = np.where(u + step <= 1.0, step, -step)
    unit = np.eye(u.size)
    first, *some = values([u, *(u + shift[k] * unit[k] for k in missing)])
    others = dict(zip(missing, some, strict=True))
    failed = [k for k, v in others.items() if not np.isfinite(v).all()]
    shift[failed] *= -1.0
    inside = [k for k in failed if 0.0 <= u[k] + shift[k] <= 1.0]
    if inside:
        others |= zip(inside, values([u + shift[k] * unit[k] for k in inside]), strict=True)
    for k, v in others.items():
        if not np.isfinite(v).all():
            raise BadInput(
                f"search: {names[k]}",
                "runs that fail on both sides of a point",
                "runs that come to their end",
                "Give narrower bounds.",
            )
    moved = (u + shift) - u
    return np.stack([(others[k] - first) / moved[k] if k in others else exact[:, k] for k in range(u.size)], axis=1)
