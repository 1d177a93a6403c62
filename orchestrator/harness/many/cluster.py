"""Points by processes of Dask: a cluster on this machine, or a running one. Its scheduler deals them out, starts killed workers
again, ends those that take too much memory, and shows all of it on its dashboard."""

from __future__ import annotations

import logging
from asyncio import CancelledError
from collections import deque
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, closing, suppress
from importlib.util import find_spec
from queue import Empty, SimpleQueue
from typing import Any

from ....components.core.errors import BadInput
from .measures import PointResult, Task
from .point_runs import LOOK, Ended, Point, PointRuns

CONNECT = 15.0  # s to wait for a scheduler, its first worker, a row: a nanny needs some to start a killed one again
AHEAD = 1000  # points that the scheduler has at a time
KILLED = "the process that ran this point ended without an answer: it crashed, or was killed, such as for want of memory"
LOCAL = {
    "distributed.scheduler.allowed-failures": 1,  # see `rows`
    "distributed.scheduler.worker-ttl": None,  # a run may keep the interpreter, and so its worker silent, as long as it takes
}
_open_scenes: dict[str, PointRuns] = {}  # in a worker, by task


def run_point(task: Task, values: Mapping[str, Any]) -> PointResult:
    """In a worker of one thread: the row of a point. The scene stays open for the next one of its task."""
    if task.base not in _open_scenes:
        for runs in _open_scenes.values():
            runs.close()
        _open_scenes.clear()
        _open_scenes[task.base] = PointRuns(task)
    return _open_scenes[task.base].row(values)


class Workers:
    """Processes that run points; `jobs` of this machine, or those of the scheduler at an address. Raises `BadInput`."""

    def __init__(self, jobs: int, address: str = ""):
        where, actual = ("--cluster", repr(address)) if address else ("--jobs", str(jobs))
        if find_spec("distributed") is None:
            expected = "an installed dask.distributed, which runs what threads cannot"
            raise BadInput(where, actual, expected, "pip install cosimo[cluster], or use one job.")
        import dask
        from distributed import Client, LocalCluster

        with ExitStack() as stack:
            try:
                if not address:
                    with dask.config.set(LOCAL):
                        local = LocalCluster(
                            n_workers=jobs, threads_per_worker=1, silence_logs=logging.CRITICAL, dashboard_address="127.0.0.1:0"
                        )
                    stack.enter_context(closing(local))
                self._client = stack.enter_context(closing(Client(address or local, timeout=CONNECT, set_as_default=False)))
            except (OSError, ValueError, TimeoutError, RuntimeError) as error:
                expected = (
                    "the address of a running scheduler, tcp://host:port"
                    if address
                    else 'processes that start: keep the calls of a script behind if __name__ == "__main__":, or use jobs=1'
                )
                raise BadInput(where, actual, expected, f"{type(error).__name__}: {error}".rstrip(": ")) from None
            with suppress(TimeoutError):  # said below
                self._client.wait_for_workers(1, timeout=CONNECT)
            threads = self._client.nthreads().values()
            if not threads or max(threads) > 1:
                actual = f"a worker of {max(threads)} threads" if threads else f"no worker for {CONNECT:g} s"
                raise BadInput(where, actual, "workers of one thread each", "dask worker ADDRESS --nthreads 1 --nworkers N")
            self.close = stack.pop_all().close

    def rows(self, task: Task, points: Iterator[Point]) -> Ended:
        """Run points. The scheduler runs a point again whose worker has died. Where that is too often, others may have done it: such
        points run once more at the end, each alone.

        Raises `BadInput` where the scheduler is gone.
        """
        from distributed import KilledWorker

        ended: SimpleQueue[Any] = SimpleQueue()
        flying: dict[Any, tuple[Any, Point]] = {}  # futures by key
        lost: deque[Point] = deque()
        suspect: Point | None = None

        def submit(point: Point) -> None:
            future = self._client.submit(run_point, task, point[1], pure=False)
            flying[future.key] = future, point
            future.add_done_callback(ended.put)

        try:
            while True:
                while len(flying) < AHEAD and (point := next(points, None)) is not None:
                    submit(point)
                if not flying:
                    if not lost:
                        return
                    submit(suspect := lost.popleft())
                rows: list[tuple[int, PointResult]] = []
                with suppress(Empty):
                    future, point = flying.pop(ended.get(timeout=LOOK).key)
                    try:
                        rows.append((point[0], future.result(timeout=CONNECT)))
                    except (Exception, CancelledError) as error:  # also of a row that was with its worker when that died
                        future.cancel()
                        if point is not suspect:
                            lost.append(point)
                        elif isinstance(error, KilledWorker):
                            rows.append((point[0], PointResult("killed", KILLED)))
                        else:
                            raise
                yield rows
        except (Exception, CancelledError) as error:
            expected = "a scheduler and workers that answer"
            text = "What was computed is kept; the same command computes the rest."
            raise BadInput("workers", f"{type(error).__name__}: {error}", expected, text) from None
        finally:
            with suppress(Exception):
                self._client.cancel([future for future, _ in flying.values()])
