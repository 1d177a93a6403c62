"""Signals that end what is under way: Ctrl-C, SIGTERM and SIGHUP."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

# they end a run, which then ends its workers; Windows has the first two
STOPPING = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))


class Interrupted(KeyboardInterrupt):
    """A signal has ended what was under way."""

    def __init__(self, one: signal.Signals):
        super().__init__(one.name)
        self.signal = one


@contextmanager
def handled(handler: Callable[[int, object], None]) -> Iterator[None]:
    """Signals that end a process call this instead; a SIGHUP that is ignored stays ignored, as nohup wants it."""
    previous = {}
    if threading.current_thread() is threading.main_thread():  # only there handlers can be set
        for one in STOPPING:
            if one == signal.SIGINT or signal.getsignal(one) is not signal.SIG_IGN:
                previous[one] = signal.signal(one, handler)
    try:
        yield
    finally:
        for one, handler_before in previous.items():
            signal.signal(one, handler_before)


@contextmanager
def interruptible() -> Iterator[None]:
    """A signal raises `Interrupted` in here at any moment; a second one ends the process at once.

    A library whose code is under way may make an exception of its own of it: that becomes `Interrupted` on its way out.
    """
    received: list[signal.Signals] = []

    def interrupt(number: int, frame: object) -> None:
        received.append(signal.Signals(number))
        at_once()
        raise Interrupted(received[0])

    with handled(interrupt):
        try:
            yield
        except (Exception, SystemExit):
            if received:
                raise Interrupted(received[0]) from None
            raise


def at_once() -> None:
    """From now on such signals do what they do to any process."""
    for one in STOPPING:
        if signal.getsignal(one) is not signal.SIG_IGN:
            signal.signal(one, signal.default_int_handler if one == signal.SIGINT else signal.SIG_DFL)
