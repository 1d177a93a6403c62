"""Compute the missing points of a plan, here or by workers; what they compute, they write themselves."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, wait
from dataclasses import dataclass, field
from math import inf
from pathlib import Path
from signal import Signals
from time import perf_counter
from typing import Any, Protocol

import numpy as np

from ....components.core.errors import BadInput
from ...progress import Interrupt
from .batches import BatchReport, Point, run_batch, signal_of, write_outcome
from .measures import Task
from .plan import Points
from .store import locate_points
from .workers import Workers

BATCH_SECONDS = 1.0  # of work, at least: three orders above what a scheduler needs for a batch
TASKS_A_SECOND = 650.0 / 5.0  # a fifth of what a Dask scheduler was measured to handle: batches of many workers are longer
MOST_IN_BATCH = 1000
IN_FLIGHT = 3  # batches a worker
LOOK = 0.2  # s between two looks at signals
KILLED = "the process that ran this point ended without an answer: it crashed, or was killed, such as for want of memory"


class Observer(Protocol):
    """Who is told of batches that have ended."""

    def count(self, report: BatchReport) -> None: ...


@dataclass
class _Batch:
    places: np.ndarray  # of points in the plan
    group: int = -1  # whose first point it is, alone: its machine code is compiled once, before the others of its group start
    alone: bool = False  # nothing else runs: where it crashes, this point did it


@dataclass
class Schedule:
    """Which points come next. missing: places in the plan.  compiled: there is machine code for all of them."""

    plan: Points
    missing: np.ndarray
    workers: int
    compiled: bool = False
    per_point: float = 0.0  # s, of the fastest recent batch; 0: not known
    _ready: deque[np.ndarray] = field(default_factory=deque)
    _first: deque[_Batch] = field(default_factory=deque)
    _waiting: dict[int, np.ndarray] = field(default_factory=dict)
    suspects: deque[int] = field(default_factory=deque)
    left: int = 0

    def __post_init__(self) -> None:
        groups = self.plan.kernels[self.missing]
        if np.ptp(groups) > 0:
            order = np.argsort(groups, kind="stable")
            split = np.split(self.missing[order], np.flatnonzero(np.diff(groups[order])) + 1)
        else:
            split = [self.missing]
        for members in split:
            if members.size and self.compiled:
                self._ready.append(members)
            elif members.size:
                group = int(self.plan.kernels[members[0]])
                self._first.append(_Batch(members[:1], group))
                self._waiting[group] = members[1:]
        self.left = self.missing.size

    @property
    def seconds(self) -> float:
        """Of work in a batch."""
        return max(BATCH_SECONDS, self.workers / TASKS_A_SECOND)

    def next(self, in_flight: int) -> _Batch | None:
        """A batch; None where the workers have enough, or others must end first."""
        if self.suspects:
            return _Batch(np.array([self.suspects.popleft()]), alone=True) if not in_flight else None
        if in_flight >= IN_FLIGHT * self.workers:
            return None
        if self._first:
            return self._first.popleft()
        if not self._ready:
            return None
        size = 1 if not self.per_point else int(np.clip(self.seconds / self.per_point, 1, MOST_IN_BATCH))
        size = min(size, max(1, self.left // (2 * self.workers)))  # none waits long for the last one
        ahead = self._ready.popleft()
        if ahead.size > size:
            self._ready.appendleft(ahead[size:])
        self.left -= min(size, ahead.size)
        return _Batch(ahead[:size])

    def ended(self, batch: _Batch, seconds: float) -> None:
        """A batch has come back after so many s of runs."""
        if batch.group < 0 and not batch.alone:
            now = max(seconds / batch.places.size, 1e-6)
            self.per_point = now if not self.per_point else 0.5 * (self.per_point + now)
        self.release(batch)

    def release(self, batch: _Batch) -> None:
        """The others of its group may start."""
        rest = self._waiting.pop(batch.group, None) if batch.group >= 0 else None
        if rest is not None and rest.size:
            self._ready.append(rest)


def compute_here(
    task: Task, plan: Points, digests: np.ndarray, missing: np.ndarray, folder: Path, live: Observer, seconds: float = inf
) -> Signals | None:
    """In this process, one after the other, a batch at least, for about so many s; the signal that has ended it early."""
    schedule, since = Schedule(plan, missing, 1), perf_counter()
    while (batch := schedule.next(0)) is not None:
        report = run_batch(task, list(_points(plan, digests, batch)), str(folder))
        live.count(report)
        if report.stopped is not None:
            return signal_of(report)
        schedule.ended(batch, report.seconds)
        if perf_counter() - since >= seconds:
            break
    return None


def compute_with(
    workers: Workers,
    task: Task,
    plan: Points,
    digests: np.ndarray,
    missing: np.ndarray,
    folder: Path,
    live: Observer,
    compiled: bool = False,
) -> Signals | None:
    """By workers; the signal that has ended it, and them, early. A point that ends its process is a row "killed"; the others go
    on.

    Raises `BadInput` where the scheduler is gone, or the directory cannot be written.
    """
    schedule = Schedule(plan, missing, workers.count, compiled)
    flying: dict[Future[BatchReport], _Batch] = {}
    with Interrupt(lambda: None) as interrupt:
        while True:
            while interrupt.wanted is None and (batch := schedule.next(len(flying))) is not None:
                flying[workers.submit(task, list(_points(plan, digests, batch)), str(folder))] = batch
            if interrupt.wanted is not None:
                workers.stop()
                return interrupt.wanted
            if not flying:
                return None
            ended = wait(flying, timeout=LOOK, return_when=FIRST_COMPLETED).done
            lost = [b for f in ended if (b := _come_back(f, flying.pop(f), schedule, live, workers))]
            if lost:
                _crashed(lost, flying, schedule, live, workers, digests, folder)


def _come_back(future: Future[BatchReport], batch: _Batch, schedule: Schedule, live: Observer, workers: Workers) -> _Batch | None:
    """Count an ended batch; returns it where its process is gone."""
    try:
        report = future.result()
    except (Exception, CancelledError) as error:
        if workers.crashed(error):
            return batch
        if isinstance(error, BadInput | OSError):
            raise
        if "Comm" in type(error).__name__ or isinstance(error, CancelledError | TimeoutError):
            raise BadInput(
                "--scheduler",
                f"no answer any more ({type(error).__name__}: {error})",
                "a running scheduler",
                "What was computed is written; the same command computes the rest.",
            ) from None
        raise
    live.count(report)
    schedule.ended(batch, report.seconds)
    return None


def _crashed(
    lost: list[_Batch],
    flying: dict[Any, _Batch],
    schedule: Schedule,
    live: Observer,
    workers: Workers,
    digests: np.ndarray,
    folder: Path,
) -> None:
    """A process is gone, and with those of this machine all batches that were on their way. Which point did it shows when each
    of those that have not been written runs alone."""
    if len(lost) == 1 and lost[0].alone and not flying:
        write_outcome(folder, int(digests[lost[0].places[0]]), "killed", KILLED)
        live.count(BatchReport(failed=1, reasons={KILLED: 1}))
    else:
        for future in [f for f in flying if f.done() and (e := f.exception()) is not None and workers.crashed(e)]:
            lost.append(flying.pop(future))
        places = np.concatenate([b.places for b in lost])
        written = locate_points(folder, digests[places]).part >= 0
        live.count(BatchReport(done=int(written.sum())))
        schedule.suspects.extend(int(k) for k in places[~written])
    for batch in lost:
        schedule.release(batch)
    workers.restart()


def _points(plan: Points, digests: np.ndarray, batch: _Batch) -> Iterator[Point]:
    return ((int(digests[i]), plan.values(int(i))) for i in batch.places)
