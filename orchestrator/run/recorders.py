"""Rows of samples while a run goes on."""

from __future__ import annotations

import math
from array import array
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from typing import Any

import numpy as np

from ..engine.coupling import Endpoint
from ..engine.stepping.loop import FOREVER, BatchObserver
from ..units import Simulator

Sample = Callable[[], list[float]]


class Recorder(BatchObserver):
    """Rows of samples at the first macro step not before each multiple of `interval` ticks, and at the end.

    The ticks of a run do not depend on the interval, which therefore need not be a whole number of them.
    """

    def __init__(
        self, sample: Sample, width: int, interval: Fraction, end: int, *, of_master: bool = False, columns: slice | None = None
    ):
        """`of_master`: the sample is the master's own. `columns`: where in the outputs of batches it stands, if it does."""
        self._sample, self._width, self._end, self._of_master = sample, width, end, of_master
        self._interval: Fraction | int = int(interval) if interval == int(interval) else interval
        self._due, self._last, self._columns = 0, -math.inf, columns
        self._times, self._values = array("d"), array("d")

    def __call__(self, tick: int, t: float) -> None:
        if tick >= self._due or tick == self._end:
            self._due = self._next(tick)
            self._times.append(t)
            self._values.fromlist(self._sample())

    def _next(self, tick: int) -> int:
        """The first tick that is not before the next multiple of the interval."""
        return math.ceil((tick // self._interval + 1) * self._interval)

    def steps_not_needed(self, tick: int, length: int) -> int:
        """As in `BatchObserver`."""
        anywhere = self._of_master or self._columns is not None
        return FOREVER if anywhere else max(-(-(self._due - tick) // length) - 1, 0)

    def observe_inputs(self, at: np.ndarray, inputs: np.ndarray, outputs: np.ndarray) -> None:
        """As in `BatchObserver`."""
        self._outputs = outputs

    def observe_batch(self, ticks: range, times: np.ndarray, rows: np.ndarray) -> None:
        """As in `BatchObserver`."""
        if self._columns is not None:
            rows = self._outputs[:, self._columns]
        elif not self._of_master:
            return
        while (k := max(-(-(self._due - ticks.start) // ticks.step), 0)) < len(ticks):
            due = slice(k, None if self._interval <= ticks.step else k + 1)  # every step, or one
            self._times.frombytes(times[due].tobytes())
            self._values.frombytes(rows[due].tobytes())
            self._due = self._next(ticks[due][-1])

    def close(self, t: float, sample: Sample | None = None) -> None:
        """A last row where a unit has ended the run at t, s, between two steps; by `sample` where the own one is out of date."""
        if t > self.last:
            self._times.append(t)
            self._values.fromlist((sample or self._sample)())

    def go_back(self) -> None:
        """Behind a row that is taken back: the next one is that of the next step."""
        self._due, self._last = 0, -math.inf

    def drain(self, rows: int) -> tuple[np.ndarray, np.ndarray]:
        """Times (rows,) s and values (rows, width) of the first rows, which it keeps no longer."""
        time, values = self.time[:rows], self.values[:rows]
        if rows:
            self._last = float(time[-1])
            del self._times[:rows], self._values[: rows * self._width]
        return time, values

    @property
    def last(self) -> float:
        """Time of the last row, s; without one, minus infinity."""
        return self._times[self.rows - 1] if self.rows else self._last

    def state(self) -> dict[str, Any]:
        """What was recorded and not drained, for a checkpoint."""
        return {"due": self._due, "last": self._last, "times": self.time, "values": self.values}

    def take(self, state: Mapping[str, Any]) -> None:
        """Go on from a `state`."""
        self._due, self._last = state["due"], state["last"]
        self._times, self._values = array("d", state["times"].tolist()), array("d", state["values"].ravel().tolist())

    @property
    def pending(self) -> int:
        """About how many rows have not been drained."""
        return len(self._times)

    @property
    def rows(self) -> int:
        """How many there are; an interrupt may have left a time without its row, or a row that is not complete."""
        return min(len(self._times), len(self._values) // self._width) if self._width else len(self._times)

    @property
    def time(self) -> np.ndarray:
        """Times of the rows, (n,) s."""
        return np.array(self._times)[: self.rows]

    @property
    def values(self) -> np.ndarray:
        """The rows, (n, width)."""
        return np.array(self._values)[: self.rows * self._width].reshape(self.rows, self._width)


class TextRecorder(Recorder):
    """Rows of texts: what is kept of each is its place in the list of all different ones."""

    def __init__(self, sample: Callable[[], list[str]], width: int, interval: Fraction, end: int):
        self._places: dict[str, float] = {}
        places = self._places
        super().__init__(lambda: [places.setdefault(text, float(len(places))) for text in sample()], width, interval, end)

    def state(self) -> dict[str, Any]:
        """As in `Recorder`."""
        return super().state() | {"texts": list(self._places)}

    def take(self, state: Mapping[str, Any]) -> None:
        """As in `Recorder`."""
        super().take(state)
        self._places |= {text: float(k) for k, text in enumerate(state["texts"])}

    def drain(self, rows: int) -> tuple[np.ndarray, np.ndarray]:
        """As in `Recorder`; values (rows, width) of texts."""
        time, places = super().drain(rows)
        return time, np.array([*self._places, None], dtype=object)[places.astype(int)]


def reading(units: Mapping[str, Simulator], ends: Sequence[Endpoint], *, texts: bool = False) -> Callable[[], list[Any]]:
    """A function that asks the units for the present values of some outputs, in the order of `ends`; `texts`: they are texts."""
    by_unit = {u: [n for v, n in ends if v == u] for u, _ in ends}
    readers = [(units[u].text_reader if texts else units[u].reader)(names) for u, names in by_unit.items()]
    flat = [(u, n) for u, names in by_unit.items() for n in names]
    order = [flat.index(end) for end in ends]

    def sample() -> list[Any]:
        values = [v for read in readers for v in read()]
        return [values[k] for k in order]

    return sample
