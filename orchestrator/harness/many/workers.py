"""Who computes batches: a pool of processes on this machine, or a Dask cluster; both as executors of `concurrent.futures`."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from importlib.util import find_spec
from multiprocessing.synchronize import Event
from typing import Any, Protocol

from ....components.core.errors import BadInput
from .batches import BatchReport, Point, run_batch
from .measures import Task

CONNECT = 15.0  # s to wait for a scheduler, and for its first worker: a nanny needs some to start a killed one again
_stop: Event | None = None  # in a worker: set where the sweep is being stopped
_orphaned = threading.Event()  # in a worker: its parent is gone
_busy = threading.Lock()


class Workers(Protocol):
    """count: of processes. crashed: whether an error of a future means that the process of its batch is gone."""

    count: int

    def submit(self, task: Task, points: Sequence[Point], folder: str) -> Future[BatchReport]: ...

    def crashed(self, error: BaseException) -> bool: ...

    def restart(self) -> None:
        """After a crash: workers again."""

    def stop(self) -> None:
        """Batches end after their present point, or within it, and write what they have."""

    def close(self) -> None: ...


class Pool:
    """Processes of this machine, started anew (spawn): nothing of this one's threads and handles is in them."""

    def __init__(self, count: int):
        self.count = count
        self._start()

    def _start(self) -> None:
        context = multiprocessing.get_context("spawn")
        before = set(multiprocessing.active_children())
        self._event = context.Event()
        self._executor = ProcessPoolExecutor(self.count, context, _start_worker, (self._event,))
        self._up = [self._executor.submit(os.getpid) for _ in range(self.count)]  # all start now, not with their first batch
        self._processes = [p for p in multiprocessing.active_children() if p not in before]

    def submit(self, task: Task, points: Sequence[Point], folder: str) -> Future[BatchReport]:
        return self._executor.submit(_in_worker, task, points, folder)

    def crashed(self, error: BaseException) -> bool:
        if not isinstance(error, BrokenProcessPool):
            return False
        if not any(f.done() and not f.cancelled() and f.exception() is None for f in self._up):
            raise BadInput(
                "worker processes",
                "none that came as far as its first point",
                "processes that start",
                'Each imports the script that is run: keep its calls behind if __name__ == "__main__": there, or use jobs=1.',
            )
        return True

    def restart(self) -> None:
        self._executor.shutdown(wait=True, cancel_futures=True)
        self._start()

    def stop(self) -> None:
        self._event.set()
        for process in self._processes:
            with suppress(ValueError, OSError):  # gone already
                process.terminate()
        self.close()

    def close(self) -> None:
        self._executor.shutdown(wait=True, cancel_futures=True)


class Cluster:
    """The workers of a running Dask scheduler, which see the same directory and have cosimo installed."""

    def __init__(self, address: str):
        if find_spec("distributed") is None:
            raise BadInput("--scheduler", repr(address), "an installed dask.distributed", "pip install cosimo[cluster]")
        from distributed import Client

        try:
            self._client = Client(address, timeout=CONNECT, set_as_default=False)
        except (OSError, ValueError, TimeoutError) as error:
            raise BadInput(
                "--scheduler",
                repr(address),
                "the address of a running scheduler, tcp://host:port",
                f"{type(error).__name__}: {error}".rstrip(": "),
            ) from None
        with suppress(TimeoutError):  # said below
            self._client.wait_for_workers(1, timeout=CONNECT)
        threads = [w["nthreads"] for w in self._client.scheduler_info(n_workers=-1)["workers"].values()]
        if not threads or max(threads) > 1:
            actual = f"a worker of {max(threads)} threads" if threads else f"a scheduler without workers for {CONNECT:g} s"
            self._client.close()
            raise BadInput("--scheduler", actual, "workers of one thread each", "dask worker ADDRESS --nthreads 1 --nworkers N")
        self.count = len(threads)
        self._executor = self._client.get_executor(pure=False, retries=0)

    def submit(self, task: Task, points: Sequence[Point], folder: str) -> Future[BatchReport]:
        return self._executor.submit(run_batch, task, points, folder)

    def crashed(self, error: BaseException) -> bool:
        from distributed import KilledWorker

        return isinstance(error, KilledWorker)

    def restart(self) -> None:
        """The scheduler's nannies do."""

    def stop(self) -> None:
        self._executor.shutdown(wait=False)
        self.close()

    def close(self) -> None:
        self._client.close()


def _start_worker(stop: Event) -> None:
    """In a new process: end with the parent, however that ends, after the present batch has been written."""
    global _stop
    _stop = stop
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_end_with, args=(parent,), daemon=True).start()
    signal.signal(signal.SIGTERM, lambda *_: None if stop.is_set() else os._exit(128 + signal.SIGTERM))
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _end_with(parent: Any) -> None:
    parent.join()
    _orphaned.set()
    with _busy:
        os._exit(1)


def _give_up() -> bool:
    return _orphaned.is_set() or (_stop is not None and _stop.is_set())


def _in_worker(task: Task, points: Sequence[Point], folder: str, run: Callable[..., BatchReport] = run_batch) -> BatchReport:
    with _busy:
        report = BatchReport() if _give_up() else run(task, points, folder, _give_up)
    if report.stopped is not None and not _give_up():  # a signal for this process alone: it is gone, its points are not
        os._exit(128 + report.stopped)
    return report


def cores() -> int:
    """Of this process."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
