"""Compute the points of a plan that its store has not: here, by threads where the scene is kernels alone, or by Dask's processes."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from contextlib import ExitStack, closing
from importlib.util import find_spec
from itertools import chain
from math import inf
from queue import SimpleQueue
from signal import Signals
from threading import Lock
from time import perf_counter
from typing import Any, TypedDict

import numpy as np

from ....components.core.errors import BadInput
from ...run.progress import Interrupt, Stop
from .measures import PointResult, Summarize, Task
from .point_runs import LOOK, Ended, Point, PointRuns, only_kernels
from .store import StoredPlan

ALONE = 4.0  # s of runs in this process before it starts others


class WorkerOptions(TypedDict, total=False):
    """Who computes the runs of a search or a sweep."""

    jobs: int | None
    cluster: str
    summarize: Summarize | None


def one_by_one(runs: PointRuns, points: Iterator[Point], until: float = inf) -> Ended:
    """Run points in this thread. until: of `perf_counter`, from which no further one begins."""
    for place, values in points:
        yield [(place, runs.row(values))]
        if perf_counter() > until:
            return


def by_threads(runs: Sequence[PointRuns], points: Iterator[Point]) -> Ended:
    """Run points of a scene whose steps need no interpreter, each `PointRuns` in a thread. Who leaves it early ends the runs."""
    lock, stop = Lock(), Stop()
    rows: SimpleQueue[tuple[int, PointResult]] = SimpleQueue()

    def work(one: PointRuns) -> None:
        one.stop = stop
        while not stop.wanted:
            with lock:
                point = next(points, None)
            if point is None:
                return
            row = one.row(point[1])
            if row.stopped is None:
                rows.put((point[0], row))

    with warnings.catch_warnings():  # the list of warnings is one for all threads
        warnings.simplefilter("ignore", UserWarning)
        with ThreadPoolExecutor(len(runs), "cosimo-point") as executor:
            working = [executor.submit(work, one) for one in runs]
            try:
                left = True
                while left:
                    left = bool(wait(working, timeout=LOOK).not_done)
                    yield [rows.get() for _ in range(rows.qsize())]
            finally:
                stop.set()
    for one, ended in zip(runs, working, strict=True):
        one.stop = None
        ended.result()


class Computing:
    """Who computes the runs of a sweep or of a search; a context that ends their processes.

    jobs: threads of this process for a scene of kernels alone, of the catalogue's components; else processes of this machine, 1:
    this one, None: others where it pays, after some seconds in this one.  cluster: address of a Dask scheduler, whose workers
    compute instead.  Neither changes a number.  observe: is told of the rows as they come.  computed: runs so far.  Raises `BadInput`.
    """

    def __init__(
        self,
        task: Task,
        jobs: int | None,
        cluster: str = "",
        observe: Callable[[Sequence[tuple[int, PointResult]]], None] = lambda rows: None,
    ):
        if jobs is not None and jobs < 1:
            raise BadInput("--jobs", str(jobs), "at least 1")
        self._task, self.jobs, self.cluster, self._observe = task, jobs, cluster, observe
        self._stack = ExitStack()
        self._threads = [self._opened_scene()]  # the first one for this thread, too
        self._workers: Any = None
        self._until: float | None = None  # of `perf_counter`: from when on other processes pay
        self.computed = 0

    def __enter__(self) -> Computing:
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    def __call__(self, points: StoredPlan, missing: np.ndarray) -> Signals | None:
        """Run the missing points of a plan; the signal that has ended it early."""
        store, digests = points.store, points.digests
        todo = ((int(i), points.plan.values(int(i))) for i in missing)
        try:
            with Interrupt() as interrupt, closing(self._rows(todo, missing.size)) as ended:
                for rows in ended:
                    stopped = next((row.stopped for _, row in rows if row.stopped is not None), None)
                    kept = [(int(digests[place]), row) for place, row in rows if row.stopped is None]
                    store.append(kept)
                    self.computed += len(kept)
                    self._observe(kept)
                    if stopped is not None or interrupt.wanted is not None:
                        return stopped or interrupt.wanted
        finally:
            store.flush()
        return None

    def _opened_scene(self) -> PointRuns:
        runs = PointRuns(self._task)
        self._stack.callback(runs.close)
        return runs

    def _rows(self, points: Iterator[Point], count: int) -> Ended:
        """The rows of so many points, as they end."""
        jobs = self.jobs or cores()
        if count == 1 or (jobs == 1 and not self.cluster):
            yield from one_by_one(self._threads[0], points)
        elif not self.cluster and only_kernels(self._task, self._threads[0]):
            while len(self._threads) < jobs:
                self._threads.append(self._opened_scene())
            yield from by_threads(self._threads[:count], points)
        else:
            if self.jobs is None and not self.cluster:
                # what is short is done before other processes have started, and compiled for them
                if self._until is None:
                    self._until = perf_counter() + ALONE if find_spec("distributed") else inf
                if perf_counter() <= self._until:
                    yield from one_by_one(self._threads[0], points, self._until)
            if (first := next(points, None)) is not None:
                from .cluster import Workers

                if self._workers is None:
                    self._workers = self._stack.enter_context(closing(Workers(jobs, self.cluster)))
                yield from self._workers.rows(self._task, chain([first], points))


def cores() -> int:
    """Of this process."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
