"""Who runs batches of points: this process, a pool of processes, a Dask cluster. All take points and give back rows as futures."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
import warnings
from collections.abc import Callable, Sequence
from concurrent.futures import CancelledError, Future, ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from dataclasses import dataclass
from importlib.util import find_spec
from multiprocessing.connection import Connection
from signal import Signals
from time import perf_counter
from typing import Any

from ....components.core.errors import BadInput
from ...run.progress import Interrupt, Stop
from .measures import Row, Task
from .point_runs import runs_of
from .store import table_of

CONNECT = 15.0  # s to wait for a scheduler, and for its first worker: a nanny needs some to start a killed one again
Point = tuple[int, dict[str, Any]]  # digest, values
_stopping = threading.Event()  # in a worker: the sweep is being stopped, or its process is gone


@dataclass(frozen=True)
class BatchRows:
    """What a batch gave. table: of pyarrow, the rows of its points.  seconds: of real time in runs.

    stopped: the signal that has ended it before its last point.
    """

    table: Any
    seconds: float = 0.0
    stopped: Signals | None = None


def run_batch(
    task: Task, points: Sequence[Point], give_up: Callable[[], bool] = lambda: False, stop: Stop | None = None
) -> BatchRows:
    """Run points one after the other; a signal, or `give_up`, ends the batch early, `stop` also a run that is under way."""
    rows: list[tuple[int, Row]] = []
    seconds, stopped = 0.0, None
    with Interrupt(lambda: None) as interrupt:  # between two runs; a run has its own
        runs = runs_of(task, stop)
        for digest, values in points:
            if give_up():
                break
            since = perf_counter()
            row = runs.row(values)
            seconds += perf_counter() - since
            if row.stopped is None:
                rows.append((digest, row))
            stopped = row.stopped or interrupt.wanted
            if stopped is not None:
                break
    return BatchRows(table_of(rows), seconds, stopped)


class Executor:
    """count: of workers.  ahead: batches for each of them that are run or wait."""

    count = 1
    ahead = 3

    def submit(self, task: Task, points: Sequence[Point]) -> Future[BatchRows]:
        """Run a batch."""
        raise NotImplementedError

    def recover(self, error: BaseException) -> None:
        """After an error of a future: workers again where its process is gone; those that had begun have ended with errors, too.
        Other errors are raised, as `BadInput` where all processes are gone for good."""
        raise error

    def stop(self) -> None:
        """End the runs that are under way; batches that have begun end with the rows that they have."""
        self.close()

    def close(self) -> None:
        """End the workers."""


class Here(Executor):
    """This process."""

    ahead = 1

    def submit(self, task: Task, points: Sequence[Point]) -> Future[BatchRows]:
        future: Future[BatchRows] = Future()
        future.set_result(run_batch(task, points))
        return future


class Threads(Executor):
    """Threads of this process, for scenes of kernels alone, whose steps need no interpreter."""

    def __init__(self, count: int):
        self.count = count
        self._stop = Stop()
        # the list of warnings is one for all threads
        self._quiet = warnings.catch_warnings()
        self._quiet.__enter__()
        warnings.simplefilter("ignore", UserWarning)
        self._executor = ThreadPoolExecutor(count, "cosimo-point")

    def submit(self, task: Task, points: Sequence[Point]) -> Future[BatchRows]:
        return self._executor.submit(run_batch, task, points, lambda: self._stop.wanted, self._stop)

    def stop(self) -> None:
        self._stop.set()
        self.close()

    def close(self) -> None:
        self._executor.shutdown(wait=True, cancel_futures=True)
        self._quiet.__exit__(None, None, None)


class Pool(Executor):
    """Processes of this machine, started anew (spawn): nothing of this one's threads and handles is in them."""

    def __init__(self, count: int):
        self.count = count
        self._start()

    def _start(self) -> None:
        context = multiprocessing.get_context("spawn")
        until_closed, self._open = context.Pipe(duplex=False)
        self._executor = ProcessPoolExecutor(self.count, context, _start_worker, (until_closed,))
        self._first = self._executor.submit(os.getpid)  # a worker takes it before any batch

    def submit(self, task: Task, points: Sequence[Point]) -> Future[BatchRows]:
        return self._executor.submit(_in_worker, task, points)

    def recover(self, error: BaseException) -> None:
        if not isinstance(error, BrokenProcessPool):
            raise error
        if self._first.exception() is not None:
            raise BadInput(
                "worker processes",
                "none that came as far as its first point",
                "processes that start",
                'Each imports the script that is run: keep its calls behind if __name__ == "__main__": there, or use jobs=1.',
            )
        self.close()
        self._start()

    def stop(self) -> None:
        self._open.close()
        self.close()

    def close(self) -> None:
        self._executor.shutdown(wait=True, cancel_futures=True)


def _start_worker(until_closed: Connection) -> None:
    """In a new process: end the run that is under way when the sweep closes its end of the pipe, or is gone, however it ended."""
    threading.Thread(target=_watch, args=(until_closed,), daemon=True).start()
    signal.signal(signal.SIGTERM, lambda *_: None if _stopping.is_set() else os._exit(128 + signal.SIGTERM))
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _watch(until_closed: Connection) -> None:
    with suppress(EOFError, OSError):
        until_closed.recv()
    _stopping.set()
    signal.raise_signal(signal.SIGTERM)
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
    os._exit(1)


def _in_worker(task: Task, points: Sequence[Point]) -> BatchRows:
    rows = run_batch(task, points, _stopping.is_set)
    if rows.stopped is not None and not _stopping.is_set():  # a signal for this process alone: it is gone, its points are not
        os._exit(128 + rows.stopped)
    return rows


class Cluster(Executor):
    """The workers of a running Dask scheduler, which have cosimo installed."""

    def __init__(self, address: str):
        if find_spec("distributed") is None:
            raise BadInput("--scheduler", repr(address), "an installed dask.distributed", "pip install cosimo[cluster]")
        from distributed import Client

        try:
            self._client = Client(address, timeout=CONNECT, set_as_default=False)
        except (OSError, ValueError, TimeoutError) as error:
            text = f"{type(error).__name__}: {error}".rstrip(": ")
            expected = "the address of a running scheduler, tcp://host:port"
            raise BadInput("--scheduler", repr(address), expected, text) from None
        with suppress(TimeoutError):  # said below
            self._client.wait_for_workers(1, timeout=CONNECT)
        threads = [w["nthreads"] for w in self._client.scheduler_info(n_workers=-1)["workers"].values()]
        if not threads or max(threads) > 1:
            actual = f"a worker of {max(threads)} threads" if threads else f"a scheduler without workers for {CONNECT:g} s"
            self._client.close()
            raise BadInput("--scheduler", actual, "workers of one thread each", "dask worker ADDRESS --nthreads 1 --nworkers N")
        self.count = len(threads)
        self._executor = self._client.get_executor(pure=False, retries=0)

    def submit(self, task: Task, points: Sequence[Point]) -> Future[BatchRows]:
        return self._executor.submit(run_batch, task, points)

    def recover(self, error: BaseException) -> None:
        from distributed import KilledWorker

        if isinstance(error, CancelledError | TimeoutError) or "Comm" in type(error).__name__:
            raise BadInput(
                "--scheduler",
                f"no answer any more ({type(error).__name__}: {error})",
                "a running scheduler",
                "What was computed is written; the same command computes the rest.",
            ) from None
        if not isinstance(error, KilledWorker):
            raise error  # of a killed worker: the scheduler's nannies start it again

    def stop(self) -> None:
        self._executor.shutdown(wait=False)
        self.close()

    def close(self) -> None:
        self._client.close()


def cores() -> int:
    """Of this process."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
