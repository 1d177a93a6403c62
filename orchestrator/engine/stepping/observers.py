"""What watches a run without taking part in it: recording, missed inputs, progress, signals to stop.

Each is called with the tick and the time.
"""

from __future__ import annotations

import math
import signal
import sys
import threading
from array import array
from collections.abc import Callable, Mapping, Sequence
from time import perf_counter
from typing import Any

import numpy as np

from ...units import Unit
from ...units.channel import STOPPING
from ...units.interface import PortValues
from ..algorithms.master import Node
from ..coupling import Endpoint

Sample = Callable[[], list[float]]
FOREVER = 1_000_000  # steps


class BatchObserver:
    """An observer that need not be called at every step, see `stretched`; as it stands, one that need be called at none."""

    def steps_not_needed(self, tick: int, length: int) -> int:
        """How many of the coming steps of `length` ticks it need not see."""
        return FOREVER

    def observe_ends(self, inputs: np.ndarray, outputs: np.ndarray) -> None:
        """Inputs behind steps it was not called at, and where they were led to, (n, 2, links), and what `Stepping.watch` was
        asked for, (n, columns); called before `observe_batch`."""

    def observe_batch(self, ticks: range, times: np.ndarray, rows: np.ndarray) -> None:
        """Steps it was not called at: the ticks and times (s) they have reached, and the master's sample there, (n, signals)."""


class Recorder(BatchObserver):
    """Rows of samples at the first macro step not before each multiple of `interval` ticks, and at the end."""

    def __init__(self, sample: Sample, width: int, interval: int, end: int, *, of_master: bool = False,
                 columns: slice | None = None):
        """`of_master`: the sample is the master's own. `columns`: where in the outputs of batches it stands, if it does."""
        self._sample, self._width, self._interval, self._end, self._of_master = sample, width, interval, end, of_master
        self._due, self._last, self._columns = 0, -math.inf, columns
        self._times, self._values = array("d"), array("d")

    def __call__(self, tick: int, t: float) -> None:
        if tick >= self._due or tick == self._end:
            self._due = tick - tick % self._interval + self._interval
            self._times.append(t)
            self._values.fromlist(self._sample())

    def steps_not_needed(self, tick: int, length: int) -> int:
        """As in `BatchObserver`."""
        anywhere = self._of_master or self._columns is not None
        return FOREVER if anywhere else max(-(-(self._due - tick) // length) - 1, 0)

    def observe_ends(self, inputs: np.ndarray, outputs: np.ndarray) -> None:
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
            last = ticks[due][-1]
            self._due = last - last % self._interval + self._interval

    def close(self, t: float, sample: Sample | None = None) -> None:
        """A last row where a unit has ended the run at t, s, between two steps; by `sample` where the own one is out of date."""
        if t > self.last:
            self._times.append(t)
            self._values.fromlist((sample or self._sample)())

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

    def __init__(self, sample: Callable[[], list[str]], width: int, interval: int, end: int):
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


def reading(units: Mapping[str, Unit], ends: Sequence[Endpoint], *, texts: bool = False) -> Callable[[], list[Any]]:
    """A function that asks the units for the present values of some outputs, in the order of `ends`; `texts`: they are texts."""
    by_unit = {u: [n for v, n in ends if v == u] for u, _ in ends}
    readers = [(units[u].text_reader if texts else units[u].reader)(names) for u, names in by_unit.items()]
    flat = [(u, n) for u, names in by_unit.items() for n in names]
    order = [flat.index(end) for end in ends]

    def sample() -> list[Any]:
        values = [v for read in readers for v in read()]
        return [values[k] for k in order]

    return sample


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
        self._sums = [np.zeros((3, len(n.links))) for n in self._nodes]  # of missed², value, value²

    def __call__(self, tick: int, t: float) -> None:
        self._calls += 1
        if self._calls % self.EVERY:
            return
        self._samples += 1
        for node, sums in zip(self._nodes, self._sums, strict=True):
            if node.reached is not None:
                _add(sums, np.array(node.history.present), node.reached)

    def observe_ends(self, inputs: np.ndarray, outputs: np.ndarray) -> None:
        """As in `BatchObserver`."""
        for present, reached in inputs[self.EVERY - 1 - self._calls % self.EVERY :: self.EVERY]:
            self._samples += 1
            first = 0
            for node, sums in zip(self._nodes, self._sums, strict=True):
                mine = slice(first, first := first + len(node.links))
                if node.reached is not None:
                    _add(sums, present[mine], reached[mine])

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
        result = {}
        for node, (missed2, total, total2) in zip(self._nodes, self._sums, strict=True):
            n = max(self._samples, 1)
            variance = np.maximum(total2 / n - (total / n) ** 2, 0.0)
            for k, (link, m, v, square) in enumerate(zip(node.links, missed2 / n, variance, total2 / n, strict=True)):
                if v > 1e-20 * square and k not in node.held:  # below it the variance is rounding; what is held is not led
                    result[".".join(link.target)] = float(np.sqrt(m / v))
        return result


def _add(sums: np.ndarray, values: np.ndarray, reached: PortValues) -> None:
    """To the sums of missed², value and value²."""
    sums[0] += (values - reached) ** 2
    sums[1] += values
    sums[2] += values**2


class Interrupt(BatchObserver):
    """Lets Ctrl-C, SIGTERM and SIGHUP end a run between two macro steps.

    Inside one they would hit an FMU's own Python and look like its failure. A second one takes effect at once. A SIGHUP that
    this process ignores stays ignored, as nohup wants it.
    """

    taken: signal.Signals | None = None  # what has ended the run between two steps

    def __init__(self, halt: Callable[[], None]):
        """`halt`: makes the stepping call its observers at the next step."""
        self._halt = halt
        self._wanted: signal.Signals | None = None
        self._previous: dict[signal.Signals, Any] = {}

    def __enter__(self) -> Interrupt:
        if threading.current_thread() is threading.main_thread():  # only there handlers can be set
            for one in STOPPING:
                if one == signal.SIGINT or signal.getsignal(one) is not signal.SIG_IGN:
                    self._previous[one] = signal.signal(one, self._note)
        return self

    def __exit__(self, *_: object) -> None:
        for one, handler in self._previous.items():
            signal.signal(one, handler)

    def _note(self, number: int, frame: object) -> None:
        self._wanted = signal.Signals(number)
        self._halt()
        for one in self._previous:
            signal.signal(one, signal.default_int_handler if one == signal.SIGINT else signal.SIG_DFL)

    @property
    def wanted(self) -> signal.Signals | None:
        """The signal that has come, if any."""
        return self._wanted

    def __call__(self, tick: int, t: float) -> None:
        if self._wanted is not None:
            self.taken = self._wanted
            raise KeyboardInterrupt


class Progress(BatchObserver):
    """Simulated time, speed against real time and time left; silent when stderr is no terminal."""

    REFRESH = 0.1  # s

    def __init__(self, title: str, stop: float, start: float = 0.0):
        """`start`: s, where a run that is resumed goes on."""
        self._title, self._stop, self._start, self._next = title, stop, start, 0.0
        self._bar: Any = None

    def __enter__(self) -> Progress:
        self._begin = perf_counter()
        if sys.stderr.isatty():
            from rich.console import Console
            from rich.progress import BarColumn, TextColumn, TimeRemainingColumn
            from rich.progress import Progress as Bar

            self._bar = Bar(TextColumn("{task.description}"), BarColumn(),
                            TextColumn("{task.completed:.2f} of {task.total:g} s, {task.fields[speed]:.2g} x real time, left"),
                            TimeRemainingColumn(), console=Console(stderr=True), transient=True)
            self._task = self._bar.add_task(self._title, total=self._stop, completed=self._start, speed=0.0)
            self._bar.start()
        return self

    def __exit__(self, *_: object) -> None:
        if self._bar is not None:
            self._bar.stop()

    def __call__(self, tick: int, t: float) -> None:
        if self._bar is not None and (now := perf_counter()) >= self._next:
            self._next = now + self.REFRESH
            self._bar.update(self._task, completed=t, speed=(t - self._start) / (now - self._begin))
