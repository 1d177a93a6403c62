"""Rows of samples while a run goes on, and the table they go to."""

from __future__ import annotations

import math
from array import array
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from ..engine.coupling import Endpoint
from ..engine.stepping.loop import Batch, BatchObserver, Needs
from ..units import Simulator
from .rows import Rows, joined

Sample = Callable[[], list[Any]]


class Recorder(BatchObserver):
    """Rows of samples at the first macro step not before each multiple of `interval` ticks, and at the end.

    The ticks of a run do not depend on the interval, which therefore need not be a whole number of them. Takes part in checkpoints.
    """

    def __init__(
        self,
        table: Rows,
        sample: Sample,
        width: int,
        interval: Fraction,
        end: int,
        *,
        texts: Sample | None = None,
        of_master: bool = False,
        columns: slice | None = None,
        picked: Sequence[int] | None = None,
        beside: Path | None = None,
    ):
        """sample: `width` numbers; of the `picked` ones the table has columns, default all.  texts: those of the same rows.

        of_master: the sample is the master's own.  columns: where in the outputs of batches it stands, if it does.
        beside: folder of the checkpoint from which the run goes on.
        """
        self.table, self._picked, self._beside = table, picked, beside
        self._sample, self._width, self._end, self._of_master = sample, width, end, of_master and texts is None
        self._read_texts, self._columns = texts, columns
        self._known: dict[str, str] = {}
        self._interval: Fraction | int = int(interval) if interval == int(interval) else interval
        self._due, self._last = 0, -math.inf
        self._clear()

    def _clear(self) -> None:
        self._times, self._values = array("d"), array("d")
        self._texts: list[str] = []

    def __call__(self, tick: int, t: float) -> None:
        if tick >= self._due or tick == self._end:
            self._due = self._next(tick)
            self._add(t, self._sample())

    def _add(self, t: float, row: list[float]) -> None:
        self._times.append(t)
        self._values.fromlist(row)
        if self._read_texts is not None:
            self._texts += [self._known.setdefault(text, text) for text in self._read_texts()]  # each once in memory

    def _next(self, tick: int) -> int:
        """The first tick that is not before the next multiple of the interval."""
        return math.ceil((tick // self._interval + 1) * self._interval)

    def needs(self, tick: int, length: int) -> Needs:
        """See `BatchObserver.needs`: what batches have in their rows or outputs is read from there."""
        anywhere = self._of_master or self._columns is not None
        return Needs() if anywhere else Needs(unseen=max(-(-(self._due - tick) // length) - 1, 0))

    def see(self, batch: Batch) -> None:
        """See `BatchObserver.see`."""
        if self._columns is None and not self._of_master:
            return
        rows = batch.rows if self._columns is None else batch.outputs[:, self._columns]
        ticks, times = batch.ticks, batch.times
        while (k := max(-(-(self._due - ticks.start) // ticks.step), 0)) < len(ticks):
            due = slice(k, None if self._interval <= ticks.step else k + 1)  # every step, or one
            self._times.frombytes(times[due].tobytes())
            self._values.frombytes(rows[due].tobytes())
            self._due = self._next(ticks[due][-1])

    def close(self, t: float, sample: Sample | None = None) -> None:
        """A last row where a unit has ended the run at t, s, between two steps; by `sample` where the own one is out of date."""
        if t > self.last:
            self._add(t, (sample or self._sample)())

    def forget(self, t: float) -> None:
        """Drop the rows behind t, s: the run has been taken back to there. For rows in memory."""
        self.flush()
        self.table.copy_rows(self.table, int(np.searchsorted(joined(self.table)[0], t, side="right")))
        self._due, self._last = 0, -math.inf

    @property
    def rows(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Those that are not in the table: times (n,) s, values (n, numbers) and texts (n, texts).

        An interrupt may have left a time without its row, or a row that is not complete: it is none.
        """
        width, texts = self._width, len(self.table.texts)
        counts = [
            len(self._times),
            *([len(self._values) // width] if width else []),
            *([len(self._texts) // texts] if texts else []),
        ]
        n = min(counts)
        values = np.array(self._values)[: n * width].reshape(n, width)
        of_texts = np.array(self._texts[: n * texts], dtype=object).reshape(n, texts)
        return np.array(self._times)[:n], values if self._picked is None else values[:, self._picked], of_texts

    def flush(self) -> None:
        """Rows that are not in the table yet go there, or stay, where it raises `OSError`."""
        rows = self.rows
        self.table.append(*rows)
        self._last = float(rows[0][-1]) if rows[0].size else self._last
        self._clear()

    @property
    def last(self) -> float:
        """Time of the last row, s; without one, minus infinity."""
        times = self.rows[0]
        return float(times[-1]) if times.size else self._last

    @property
    def pending(self) -> int:
        """About how many rows are not in the table."""
        return len(self._times)

    def state(self) -> dict[str, Any]:
        """All rows, or where they are, for a checkpoint."""
        self.flush()
        return {"due": self._due, "last": self._last, "rows": self.table.state()}

    def set_state(self, state: Mapping[str, Any]) -> None:
        """Go on from a `state`; raises `BadInput` where the rows are not stored where they were any more."""
        self._clear()
        self._due, self._last = state["due"], state["last"]
        self.table.go_on(state["rows"], self._beside)


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
