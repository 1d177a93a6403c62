"""Searches that need runs: what all of them need next is computed together, so that no number depends on who computes.

A search is a function that is given `ask(points) -> rows` and calls it whenever it needs runs. Each goes on in a thread of its
own until it asks, one at a time; the runs are computed where `run_searches` was called.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from threading import Semaphore, Thread
from typing import Generic, TypeVar

import numpy as np

from ....components.core.errors import BadInput
from .measures import Row

T = TypeVar("T")
Ask = Callable[[Sequence[np.ndarray]], list[Row]]


class _Abandoned(BaseException):
    """Ends the thread of a search that is not gone on with."""


class _Search(Thread, Generic[T]):
    """A search up to its next request. request: the points it needs, None where it has ended with `result` or `error`."""

    result: T

    def __init__(self, search: Callable[[Ask], T]):
        super().__init__(daemon=True)
        self._search = search
        self._its_turn, self._our_turn = Semaphore(0), Semaphore(0)
        self._answer: list[Row] | None = []
        self.request: Sequence[np.ndarray] | None = None
        self.error: BaseException | None = None
        self.start()

    def run(self) -> None:
        """In the thread."""
        self._its_turn.acquire()
        try:
            if self._answer is not None:
                self.result = self._search(self._ask)
        except BaseException as error:  # raised where the searches are run
            self.error = error
        self.request = None
        self._our_turn.release()

    def _ask(self, points: Sequence[np.ndarray]) -> list[Row]:
        self.request = points
        self._our_turn.release()
        self._its_turn.acquire()
        if self._answer is None:
            raise _Abandoned
        return self._answer

    def resume(self, answer: list[Row] | None) -> None:
        """Go on with the rows that were asked for, up to the next request; None: end."""
        self._answer = answer
        self._its_turn.release()
        self._our_turn.acquire()
        if self.error is not None and answer is not None:
            raise self.error


def run_searches(searches: Sequence[Callable[[Ask], T]], compute: Ask) -> list[T]:
    """The results of searches, in their order. `compute`: runs points, together those that all searches have asked for."""
    threads = [_Search(search) for search in searches]
    try:
        for thread in threads:
            thread.resume([])
        while asking := [t for t in threads if t.request is not None]:
            requests = [list(t.request or ()) for t in asking]
            rows = iter(compute([p for points in requests for p in points]))
            for thread, points in zip(asking, requests, strict=True):
                thread.resume([next(rows) for _ in points])
    finally:
        for thread in threads:
            if thread.is_alive():
                thread.resume(None)
            thread.join()
    return [t.result for t in threads]


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
