"""What a user at a terminal sees of a run, and how it is stopped from there."""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from time import perf_counter
from typing import Any, TypeVar

from ..engine.stepping.loop import BatchObserver
from ..interrupts import Interrupted, at_once, handled

T = TypeVar("T")


class Interrupt(BatchObserver):
    """Lets Ctrl-C, SIGTERM and SIGHUP end a run between two macro steps.

    Inside one they would hit an FMU's own Python and look like its failure. A second one takes effect at once.
    """

    taken: signal.Signals | None = None  # what has ended the run between two steps

    def __init__(self, halt: Callable[[], None] = lambda: None, *, at_once: bool = False):
        """`halt`: makes the stepping call its observers at the next step. `at_once`: a signal raises `Interrupted` where it comes,
        as long as this is true: no foreign code is running then."""
        self.halt, self.at_once = halt, at_once
        self._wanted: signal.Signals | None = None
        self._handling = handled(self._note)

    def __enter__(self) -> Interrupt:
        self._handling.__enter__()
        return self

    def __exit__(self, *_: object) -> None:
        self._handling.__exit__(None, None, None)

    def _note(self, number: int, frame: object) -> None:
        self._wanted = signal.Signals(number)
        self.halt()
        at_once()
        if self.at_once:
            raise Interrupted(self._wanted)

    @property
    def wanted(self) -> signal.Signals | None:
        """The signal that has come, if any."""
        return self._wanted

    def __call__(self, tick: int, t: float) -> None:
        if self._wanted is not None:
            self.taken = self._wanted
            raise KeyboardInterrupt


class Stop(BatchObserver):
    """Ends runs between two batches of macro steps, when a thread calls `set`."""

    at_once = False  # as of an `Interrupt`

    taken: signal.Signals | None = None  # what has ended a run

    def __init__(self) -> None:
        self._event = threading.Event()

    def set(self) -> None:
        """End the runs that are under way, and all that begin later."""
        self._event.set()

    @property
    def wanted(self) -> bool:
        """Whether runs are to end."""
        return self._event.is_set()

    def __call__(self, tick: int, t: float) -> None:
        if self._event.is_set():
            self.taken = signal.SIGINT
            raise KeyboardInterrupt


class Progress(BatchObserver):
    """Simulated time, speed against real time and time left, where stderr is a terminal; and one warning of a run of hours."""

    REFRESH = 0.1  # s
    MEASURED = 5.0  # s of the run, whose speed tells how long the rest takes
    LONG = 3600.0  # s left, from which a user is warned

    def __init__(self, title: str, stop: float, start: float = 0.0):
        """`start`: s, where a run that is resumed goes on."""
        self._title, self._stop, self._start, self._next = title, stop, start, 0.0
        self._first: tuple[float, float] | None = None  # (clock, simulated time): before, kernels were compiled or loaded
        self._bar: Any = None
        self._warned = False

    def __enter__(self) -> Progress:
        if sys.stderr.isatty():
            self._bar = terminal_bar("{task.completed:.2f} of {task.total:g} s, {task.fields[speed]:.2g} x real time, left")
            self._task = self._bar.add_task(self._title, total=self._stop, completed=self._start, speed=0.0)
            self._bar.start()
        return self

    def __exit__(self, *_: object) -> None:
        if self._bar is not None:
            self._bar.stop()

    def __call__(self, tick: int, t: float) -> None:
        now = perf_counter()
        if now < self._next or t <= self._start:
            return
        if self._first is None:
            self._first = (now, t)
            return
        begin, reached = self._first
        self._next, speed = now + self.REFRESH, (t - reached) / (now - begin)
        if self._bar is not None:
            self._bar.update(self._task, completed=t, speed=speed)
        left = (self._stop - t) / speed
        if not self._warned and now - begin >= self.MEASURED and left > self.LONG:
            self._warned = True
            show = self._bar.console.print if self._bar is not None else partial(print, file=sys.stderr)
            show(
                f"cosimo: warning: at this speed the run takes {left / 3600.0:.2g} h more. An interrupt keeps what is computed; "
                "cosimo run --dry-run counts what a macro step costs"
            )


def terminal_bar(numbers: str) -> Any:
    """A progress bar of rich on standard error, which disappears when it stops; numbers: the text before the time left."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    columns = TextColumn("{task.description}"), BarColumn(), TextColumn(numbers), TimeRemainingColumn()
    return Progress(*columns, console=Console(stderr=True), transient=True)


def tracked(items: Sequence[T], title: str, progress: bool) -> Iterable[T]:
    """The items one by one, with a progress bar on a terminal."""
    if not (progress and sys.stderr.isatty()):
        return items
    from rich.console import Console
    from rich.progress import track

    return iter(track(items, description=title, console=Console(stderr=True), transient=True))
