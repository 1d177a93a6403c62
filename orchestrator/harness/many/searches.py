"""Searches that need runs: the next runs of all searches are computed together, so that no number depends on who computes.

A search is a function that is given `ask(points) -> rows` and calls it whenever it needs runs. Each is in a thread of its own, of
which one goes on at a time until it asks; the runs are computed where `run_searches` was called.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from queue import SimpleQueue
from threading import Lock
from typing import TypeVar

import numpy as np

from ....components.core.errors import BadInput
from .measures import Row

T = TypeVar("T")
Ask = Callable[[Sequence[np.ndarray]], list[Row]]
Request = tuple[Sequence[np.ndarray], Future[list[Row]]]


class _Abandoned(BaseException):
    """Ends a search that is not gone on with."""


def run_searches(searches: Sequence[Callable[[Ask], T]], compute: Ask) -> list[T]:
    """The results of searches, in their order. `compute`: runs points, together those that all searches have asked for."""
    turn = Lock()
    news: SimpleQueue[tuple[int, Request | None]] = SimpleQueue()  # a search has asked, or (None) has ended

    def run(place: int) -> T:
        def ask(points: Sequence[np.ndarray]) -> list[Row]:
            answer: Future[list[Row]] = Future()
            news.put((place, (points, answer)))
            turn.release()
            try:
                return answer.result()
            finally:
                turn.acquire()

        try:
            with turn:
                return searches[place](ask)
        finally:
            news.put((place, None))

    with ThreadPoolExecutor(len(searches)) as threads:
        results = [threads.submit(run, place) for place in range(len(searches))]
        asking: list[Request] = []
        going_on = len(searches)
        try:
            while going_on:
                latest = sorted([news.get() for _ in range(going_on)], key=lambda item: item[0])
                asking = [request for _, request in latest if request is not None]
                going_on = len(asking)
                for place, request in latest:
                    if request is None:
                        results[place].result()  # raises what has ended the search
                if asking:
                    rows = iter(compute([p for points, _ in asking for p in points]))
                    for points, answer in asking:
                        answer.set_result([next(rows) for _ in points])
        except BaseException:
            while going_on:  # those that wait, and those that have been answered and ask again
                for _, answer in asking:
                    if not answer.done():
                        answer.set_exception(_Abandoned())
                _, request = news.get()
                asking = [] if request is None else [request]
                going_on -= request is None
            raise
    return [result.result() for result in results]


def differences(
    values: Callable[[Sequence[np.ndarray]], Sequence[np.ndarray]], u: np.ndarray, step: float, names: Sequence[str]
) -> np.ndarray:
    """Derivatives (m, n) of values (m,) at a point u (n,) of the unit cube by differences to one side, of the size `step`.

    The n + 1 points are asked for together. Forward, but backward at the upper bound and where the run ahead has failed (its
    values are not finite). Raises `BadInput` where the runs on both sides fail.
    """
    shift = np.where(u + step <= 1.0, step, -step)
    first, *others = values([u, *(u + shift * e for e in np.eye(u.size))])
    failed = [k for k, v in enumerate(others) if not np.isfinite(v).all()]
    if failed:
        shift[failed] *= -1.0
        inside = (u + shift >= 0.0) & (u + shift <= 1.0)
        again = values([u + shift * e for k, e in enumerate(np.eye(u.size)) if k in failed and inside[k]])
        for k, v in zip([k for k in failed if inside[k]], again, strict=True):
            others[k] = v
    for name, v in zip(names, others, strict=True):
        if not np.isfinite(v).all():
            raise BadInput(
                f"search: {name}",
                "runs that fail on both sides of a point",
                "runs that come to their end",
                "Give narrower bounds.",
            )
    moved = (u + shift) - u
    return np.stack([(v - first) / h for v, h in zip(others, moved, strict=True)], axis=1)
