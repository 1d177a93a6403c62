"""What watches a run without taking part in it: it is called with the tick and the time, or sees steps in batches."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..algorithms.master import Node

FOREVER = 1_000_000  # steps


class BatchObserver:
    """An observer that need not be called at every step, see `stretched`; as it stands, one that need be called at none."""

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

    def keeps(self, n: int) -> range:
        """Of the coming n steps, counted from 0, those behind which it wants the master saved."""
        return range(0)

    def observe_saved(self, saved: Sequence[tuple[int, float, Any]]) -> None:
        """Ticks, times (s) and what the master has saved behind the `keeps` of all observers; before `observe_batch`."""

    def observe_ends(self, at: np.ndarray, inputs: np.ndarray, outputs: np.ndarray) -> None:
        """Of steps it was not called at: inputs behind those `at` (m,), the `looks` of all observers, and where they were led to,
        (m, 2, links); and what `Stepping.watch` was asked for, (n, columns). Called before `observe_batch`."""

    def observe_batch(self, ticks: range, times: np.ndarray, rows: np.ndarray) -> None:
        """Steps it was not called at: the ticks and times (s) they have reached, and the master's sample there, (n, signals)."""


class ExtrapolationError(BatchObserver):
    """How far the inputs that units were led to missed those that the other units then gave.

    rms of the miss over the standard deviation of the input, sampled now and then. It counts every ripple, also such as a
    unit's own inertia smooths out: no measure of the results' error. But at 1 and beyond, the extrapolation foretells
    nothing, and where the coupled system limits itself (a contact that opens) nothing else would tell that.
    """

    EVERY = 29  # macro steps from one sample to the next; a prime, so as not to keep step with the system

    def __init__(self, nodes: Sequence[Node]):
        self._nodes = [n for n in nodes if n.links]
        self._calls = self._samples = 0
        self._sums = np.zeros((3, sum(len(n.links) for n in self._nodes)))  # of missed², value, value²

    def __call__(self, tick: int, t: float) -> None:
        self._calls += 1
        if self._calls % self.EVERY == 0:
            present = [v for node in self._nodes for v in node.history.present]
            reached = [v for node in self._nodes for v in (node.history.present if node.reached is None else node.reached)]
            self._add(np.array([[present, reached]]))

    def looks(self, n: int) -> range:
        """As in `BatchObserver`."""
        return range(self.EVERY - 1 - self._calls % self.EVERY, n, self.EVERY)

    def observe_ends(self, at: np.ndarray, inputs: np.ndarray, outputs: np.ndarray) -> None:
        """As in `BatchObserver`."""
        self._add(inputs[(self._calls + at + 1) % self.EVERY == 0])

    def _add(self, looks: np.ndarray) -> None:
        """Inputs and where they were led to, (m, 2, links), to the sums: one after the other, as their order counts."""
        self._samples += len(looks)
        extrapolated = [node.reached is not None for node in self._nodes for _ in node.links]
        values, reached = looks[:, 0], looks[:, 1]
        terms = np.where(extrapolated, np.stack(((values - reached) ** 2, values, values**2), axis=1), 0.0)
        self._sums = np.add.accumulate(np.concatenate((self._sums[None], terms)))[-1]

    def observe_batch(self, ticks: range, times: np.ndarray, rows: np.ndarray) -> None:
        """As in `BatchObserver`."""
        self._calls += len(ticks)

    def state(self) -> dict[str, Any]:
        """The sums so far, for a checkpoint."""
        return {"calls": self._calls, "samples": self._samples, "sums": self._sums}

    def take(self, state: Mapping[str, Any]) -> None:
        """Go on from a `state`."""
        self._calls, self._samples, self._sums = state["calls"], state["samples"], state["sums"]

    @property
    def relative(self) -> dict[str, float]:
        """Relative miss by "unit.input", for the inputs that vary at all."""
        result, n = {}, max(self._samples, 1)
        missed2, total, total2 = self._sums / n
        variance = np.maximum(total2 - total**2, 0.0)
        inputs = [(link, k in node.held) for node in self._nodes for k, link in enumerate(node.links)]
        for (link, held), m, v, square in zip(inputs, missed2, variance, total2, strict=True):
            if v > 1e-20 * square and not held:  # below it the variance is rounding; what is held is not led
                result[".".join(link.target)] = float(np.sqrt(m / v))
        return result
