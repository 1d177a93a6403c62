"""What watches a run without taking part in it: it is called with the tick and the time, or sees steps in batches."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

FOREVER = 1_000_000  # steps


class BatchObserver:
    """An observer that need not be called at every step, see `steps_not_needed`; as it stands, one that is called at none."""

    alarms = False  # it looks for what may happen at any step: where steps can be taken back, batches need not end for it

    def steps_not_needed(self, tick: int, length: int) -> int:
        """How many of the coming steps of `length` ticks it need not see."""
        return FOREVER

    def alarm(self, at: np.ndarray, inputs: np.ndarray) -> int | None:
        """Which of the steps `at` it must be called at; arguments as of `observe_ends`. They are repeated up to it."""
        return None

    def looks(self, n: int) -> range:
        """Of the coming n steps, counted from 0, those behind which it wants all inputs."""
        return range(0)

    def keeps(self, n: int) -> Iterable[int]:
        """Of the coming n steps, counted from 0, those behind which it wants the master saved."""
        return ()

    def observe_saved(self, saved: Sequence[tuple[int, float, Any]]) -> None:
        """Ticks, times (s) and what the master has saved behind the `keeps` of all observers; before `observe_batch`."""

    def observe_ends(self, at: np.ndarray, inputs: np.ndarray, outputs: np.ndarray) -> None:
        """Of steps it was not called at: inputs behind those `at` (m,), the `looks` of all observers, and where they were led to,
        (m, 2, links); and what `Stepping.watch` was asked for, (n, columns). Called before `observe_batch`."""

    def observe_batch(self, ticks: range, times: np.ndarray, rows: np.ndarray) -> None:
        """Steps it was not called at: the ticks and times (s) they have reached, and the master's sample there, (n, signals)."""
