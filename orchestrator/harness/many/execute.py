"""Compute the points of a plan that its store has not: batches go to an executor, their rows come back into the store."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, wait
from dataclasses import dataclass
from math import inf
from signal import Signals
from time import perf_counter
from typing import TypedDict

import numpy as np

from ....components.core.errors import BadInput
from ...run.progress import Interrupt
from .executors import BatchRows, Cluster, Executor, Here, Pool, Threads, cores
from .measures import Row, Summarize
from .point_runs import in_threads
from .store import StoredPlan, table_of

BATCH_SECONDS = 1.0  # of work, at least: three orders above what a scheduler needs for a batch
TASKS_A_SECOND = 650.0 / 5.0  # a fifth of what a Dask scheduler was measured to handle: batches of many workers are longer
MOST_IN_BATCH = 1000
LOOK = 0.2  # s between two looks at signals
ALONE = 4.0  # s of runs in this process before it starts others
KILLED = "the process that ran this point ended without an answer: it crashed, or was killed, such as for want of memory"
Observe = Callable[[BatchRows, int], None]  # what is told of every batch that has ended, and how many processes there are


class WorkerOptions(TypedDict, total=False):
    """Who computes the runs of a search or a sweep."""

    jobs: int | None
    scheduler: str
    summarize: Summarize | None


@dataclass(frozen=True)
class Batch:
    """places: of points in the plan.  alone: nothing else runs, so that this point did it where its process crashes."""

    places: np.ndarray
    alone: bool = False


class Schedule:
    """Which of the missing points come next, as places in a plan.

    compiled: groups of points for which there is machine code, which grows: of each other group one point is run before the others
    start, and compiles for them.
    """

    def __init__(self, points: StoredPlan, missing: np.ndarray, compiled: set[int] | None = None):
        self._kernels = points.plan.kernels
        self._compiled = set() if compiled is None else compiled
        self._per_point = 0.0  # s, of recent batches; 0: not known
        self._suspects: deque[int] = deque()  # of batches whose process crashed
        self._waiting: dict[int, np.ndarray] = {}  # by group, for its first point
        self._ready: deque[np.ndarray] = deque()
        groups = self._kernels[missing]
        for group in np.unique(groups).tolist():
            members = missing[groups == group]
            if group in self._compiled:
                self._ready.append(members)
            else:
                self._ready.insert(len(self._waiting), members[:1])  # before those that there is code for
                self._waiting[group] = members[1:]

    @property
    def left(self) -> int:
        """How many points have not been given to workers, or to none that came back."""
        return len(self._suspects) + sum(members.size for members in (*self._ready, *self._waiting.values()))

    def next(self, flying: list[Batch], workers: int, most: int) -> Batch | None:
        """A batch; None where `most` are on their way, or others must end first."""
        if self._suspects:
            return Batch(np.array([self._suspects.popleft()]), alone=True) if not flying else None
        if len(flying) >= most or any(batch.alone for batch in flying) or not self._ready:
            return None
        seconds = max(BATCH_SECONDS, workers / TASKS_A_SECOND)
        size = 1 if not self._per_point else int(np.clip(seconds / self._per_point, 1, MOST_IN_BATCH))
        size = min(size, max(1, self.left // (2 * workers)))  # none waits long for the last one
        members = self._ready.popleft()
        if members.size > size:
            self._ready.appendleft(members[size:])
        return Batch(members[:size])

    def ended(self, batch: Batch, seconds: float) -> None:
        """A batch has ended after so many s of runs: where it was the first of its group, the others of the group may start."""
        group = int(self._kernels[batch.places[0]])
        if (rest := self._waiting.pop(group, None)) is not None:
            self._compiled.add(group)
            if rest.size:
                self._ready.append(rest)
        elif not batch.alone:
            now = max(seconds / batch.places.size, 1e-6)
            self._per_point = now if not self._per_point else 0.5 * (self._per_point + now)

    def lost(self, batch: Batch) -> None:
        """The process of a batch is gone. Which of its points did it shows when each runs alone."""
        self._suspects.extend(batch.places.tolist())
        self.ended(batch, 0.0)


def compute(
    executor: Executor,
    points: StoredPlan,
    schedule: Schedule,
    observe: Observe = lambda rows, workers: None,
    seconds: float = inf,
) -> Signals | None:
    """Run what a schedule has left; the signal that has ended the runs early, and with them the executor.

    seconds: after which no further batch begins, but one in any case.  Raises `BadInput` where the executor is gone, or the rows
    cannot be written.
    """
    workers = min(executor.count, schedule.left)
    flying: dict[Future[BatchRows], Batch] = {}
    since, stopped = perf_counter(), None
    started = False

    def take(rows: BatchRows) -> None:
        points.store.append(rows.table)
        observe(rows, workers)

    try:
        with Interrupt(lambda: None) as interrupt:
            while stopped is None:
                while interrupt.wanted is None and (not started or perf_counter() - since < seconds):
                    if (batch := schedule.next(list(flying.values()), workers, executor.ahead * executor.count)) is None:
                        break
                    values = [(int(points.digests[i]), points.plan.values(int(i))) for i in batch.places]
                    flying[executor.submit(points.task, values)], started = batch, True
                if not flying:
                    return interrupt.wanted
                if (stopped := interrupt.wanted) is not None:
                    executor.stop()
                    ended = {f for f in flying if f.done()}
                else:
                    ended = wait(flying, timeout=LOOK, return_when=FIRST_COMPLETED).done
                    if errors := [error for f in ended if (error := _error(f)) is not None]:
                        executor.recover(errors[0])
                        ended = {f for f in flying if f.done()}  # with those that were lost with it
                for future in ended:
                    batch = flying.pop(future)
                    if _error(future) is None:
                        rows = future.result()
                        take(rows)
                        schedule.ended(batch, rows.seconds)
                        stopped = stopped or rows.stopped
                    elif batch.alone and stopped is None:
                        take(BatchRows(table_of([(int(points.digests[batch.places[0]]), Row("killed", KILLED))])))
                    else:
                        schedule.lost(batch)
            return stopped
    finally:
        points.store.flush()


def _error(future: Future[BatchRows]) -> BaseException | None:
    return CancelledError() if future.cancelled() else future.exception()


class Computing:
    """Who computes the runs of a sweep or of a search, from when they are needed; a context that ends their processes.

    jobs: threads of this process for a scene of kernels alone, of the catalogue's components; else processes of this machine, 1:
    this one, None: others where it pays, after some seconds in this one.  scheduler: address of a Dask cluster instead.  Neither
    changes a number.  computed: runs so far.  Raises `BadInput`.
    """

    def __init__(self, jobs: int | None, scheduler: str = "", observe: Observe = lambda rows, workers: None):
        if jobs is not None and jobs < 1:
            raise BadInput("--jobs", str(jobs), "at least 1")
        self._jobs, self._scheduler, self._observe = jobs, scheduler, observe
        self._others: Executor | None = None
        self._compiled: set[int] = set()
        self._seconds = 0.0  # of runs in this process
        self.computed = 0

    def __enter__(self) -> Computing:
        return self

    def __exit__(self, kind: object, *_: object) -> None:
        if self._others is not None:
            (self._others.close if kind is None else self._others.stop)()

    def __call__(self, points: StoredPlan, missing: np.ndarray) -> Signals | None:
        """Run the missing points of a plan; the signal that has ended it early, and with it the processes."""
        schedule = Schedule(points, missing, self._compiled)
        if missing.size == 1 or (not self._scheduler and (self._jobs or cores()) == 1):
            return compute(Here(), points, schedule, self._count)
        threads = not self._scheduler and in_threads(points.task)
        if not self._scheduler and self._jobs is None and self._seconds < ALONE and not threads:
            # what is short is done before other processes have started, and compiled for them
            stopped = compute(Here(), points, schedule, self._count, ALONE - self._seconds)
            if stopped is not None or not schedule.left:
                return stopped
        if self._others is None:
            local = Threads if threads else Pool
            self._others = Cluster(self._scheduler) if self._scheduler else local(self._jobs or cores())
        if (stopped := compute(self._others, points, schedule, self._count)) is not None:
            self._others = None
        return stopped

    def _count(self, rows: BatchRows, workers: int) -> None:
        if workers == 1:
            self._seconds += rows.seconds
        self.computed += rows.table.num_rows
        self._observe(rows, workers)
