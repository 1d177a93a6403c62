"""Macro steps at the pace of the clock, and how punctual they were: what a test rig needs.

A step that ends at the simulated time t is due at t on the clock, and late by what it ends behind that. One that is early waits.
One that is late moves nothing: the steps behind it follow without waiting until they are on time again.
"""

from __future__ import annotations

import gc
from array import array
from time import perf_counter, sleep
from types import TracebackType

import numpy as np

from ..engine.stepping.loop import BatchObserver, Needs
from .run_record import Pace

PERCENTILES = (50.0, 90.0, 99.0, 99.9, 100.0)
BINS = np.geomspace(1e-6, 1.0, 61)  # s, ten in a decade


class Pacing(BatchObserver):
    """Observer that lets a run reach no instant before the clock does. It stands last: what the others do belongs to the step.

    The clock starts behind the first step, which loads what has to be loaded. Meanwhile the interpreter collects no garbage.
    """

    def __init__(self) -> None:
        self._durations, self._lateness, self._waking = array("d"), array("d"), array("d")
        self._origin: float | None = None
        self._calls, self._released, self._step = 0, 0.0, 0.0
        self._collected = False

    def __enter__(self) -> Pacing:
        self._collected = gc.isenabled()
        gc.collect()
        gc.disable()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, where: TracebackType | None) -> None:
        if self._collected:
            gc.enable()

    def needs(self, tick: int, length: int) -> Needs:
        """See `BatchObserver.needs`: every step."""
        return Needs(unseen=0)

    def __call__(self, tick: int, t: float) -> None:
        now = perf_counter()
        self._calls += 1
        if self._calls < 3 or self._origin is None:  # the start, and the first step
            self._origin = now - t
        else:
            due = self._origin + t
            self._durations.append(now - self._released)
            self._lateness.append(now - due)
            if now < due:
                sleep(due - now)
                self._waking.append(perf_counter() - due)
        self._released = perf_counter()

    def report(self) -> Pace | None:
        """Durations and lateness in s, as percentiles and counts; None before the third instant."""
        if not self._durations:
            return None
        durations, lateness = np.array(self._durations), np.array(self._lateness)
        behind = np.maximum(lateness, 0.0)

        def percentiles(values: np.ndarray) -> dict[str, float]:
            return {f"{p:g} %": float(v) for p, v in zip(PERCENTILES, np.percentile(values, PERCENTILES), strict=True)}

        def counts(values: np.ndarray) -> tuple[int, ...]:
            return tuple(np.histogram(np.clip(values, BINS[0], BINS[-1]), BINS)[0].tolist())

        return Pace(
            steps=durations.size,
            late=int(np.count_nonzero(lateness > 0.0)),
            duration=percentiles(durations),
            lateness=percentiles(behind),
            waking=percentiles(np.array(self._waking)) if self._waking else {},
            bins=tuple(BINS.tolist()),
            duration_counts=counts(durations),
            lateness_counts=counts(behind[lateness > 0.0]),
        )
