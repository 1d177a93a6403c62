"""Messages between a run and a unit's worker process: a head with number, length and code, then numbers or data in msgpack.

A pipe of the operating system carries them, one request and one answer at a time. Memory shared by both and watched in a
loop would answer ten times sooner, but it takes a whole core for each side, also while a unit computes.

`multiprocessing.connection` would do the same for a third more: the run's share of a round trip is 4.4 µs of CPU time here and
5.9 µs there for 40 bytes, 8.9 and 12.9 µs for 20 000 (its messages are read in two calls, these mostly in one).

Numbers travel as their float64 bytes, without type and shape: both ends know how many there are. All else is plain data (`packed`):
nothing that arrives is executed or imported.
"""

from __future__ import annotations

import os
import select
from collections.abc import Callable
from struct import Struct
from time import monotonic
from typing import Any

import numpy as np

from .interface import ARRAY_THRESHOLD, PortValues

HEAD = Struct("=IIQB")  # mark, number of the message in its direction, bytes that follow, code
MARK = 0xC051_F1E7  # a unit may write into any open file of its process: bytes that do not start so are no message
TIMES = Struct("ddd")  # start and length of a step, length the inputs are meant for
EVENT = Struct("d")  # time of the event in a step, NaN for none
INDEX = Struct("I")
ONCE = 1 << 16  # bytes asked for in one read: what a pipe holds on Linux
LARGEST = 1 << 30  # bytes of the longest message of all, a saved state
LONGEST_WAIT = 1e6  # s that poll(2) can be given, in ms of 32 bits


class Code:
    """What a message is: requests, then answers."""

    STEP, UPDATE, GET, READ, CALL, JACOBIAN, STATE = range(7)
    VALUES, NUMBERS, DATA, BYTES, FAILED, WARNED = range(7, 13)


class NoMessage(EOFError):
    """The bytes that have arrived are no message, or a longer one than asked for."""


class Late(EOFError):
    """The other end has not taken, or not given, a whole message within the limit."""


class Channel:
    """One end of a pair of pipes; `EOFError` and `BrokenPipeError` where the other end has gone.

    limit: s that the other end may take to read a message whole, and to write one, then `Late`; None: any time. A process that
    the other end has started, and that outlives it, may hold the pipe open: so the wait itself ends, whatever was ended.
    """

    def __init__(self, read: int, write: int, limit: float | None = None):
        self._from, self._to, self.limit = read, write, limit
        self._sent = self._received = 0
        self._readable, self._writable = None, None
        if limit is not None and hasattr(select, "poll"):  # Windows cannot ask a pipe: there `WorkerSimulator` watches
            os.set_blocking(read, False)
            os.set_blocking(write, False)
            self._readable, self._writable = select.poll(), select.poll()
            self._readable.register(read, select.POLLIN)
            self._writable.register(write, select.POLLOUT)

    def send(self, code: int, content: bytes) -> None:
        """Hand over one message, whole."""
        self._sent += 1
        message: bytes | memoryview = HEAD.pack(MARK, self._sent & 0xFFFFFFFF, len(content), code) + content
        end = self._end()
        while (written := self._write(message, end)) < len(message):
            message = memoryview(message)[written:]

    def _end(self) -> float:
        """When the present message must be over."""
        return 0.0 if self._readable is None or self.limit is None else monotonic() + self.limit

    def _write(self, message: bytes | memoryview, end: float) -> int:
        while True:
            try:
                return os.write(self._to, message)
            except BlockingIOError:
                _wait(self._writable, end)

    def receive(self, longest: int = LARGEST) -> tuple[int, memoryview]:
        """Wait for one message of at most so many bytes: code and content."""
        end = self._end()
        message: bytes | bytearray = self._read(ONCE, end)
        while len(message) < HEAD.size:
            message += self._read(HEAD.size - len(message), end)
        mark, number, length, code = HEAD.unpack_from(message)
        self._received += 1
        if mark != MARK or number != self._received & 0xFFFFFFFF or length > longest:
            raise NoMessage
        if (missing := HEAD.size + length - len(message)) > 0:
            message = bytearray(message)
            while missing > 0:
                message += self._read(min(missing, ONCE), end)
                missing = HEAD.size + length - len(message)
        if missing < 0:  # each answer is waited for before there is another request
            raise NoMessage
        return code, memoryview(message)[HEAD.size :]

    def _read(self, most: int, end: float) -> bytes:
        if self._readable is not None:
            _wait(self._readable, end)  # first, because an answer is seldom there already
        content = os.read(self._from, most)
        if not content:
            raise EOFError
        return content


def _wait(ready: Any, end: float) -> None:
    """Until a pipe can be read or written; a message that comes in drops has no more time than one that comes at once."""
    if (left := end - monotonic()) <= 0.0 or not ready.poll(1e3 * min(left, LONGEST_WAIT)):
        raise Late


def packer(n: int) -> Callable[[PortValues], bytes]:
    """A function that turns n numbers into bytes."""
    if n > ARRAY_THRESHOLD:
        return lambda row: np.asarray(row, dtype=float).tobytes()
    pack = Struct(f"{n}d").pack
    return lambda row: pack(*row)


def unpacker(n: int) -> Callable[[Any, int], PortValues]:
    """A function of bytes and an offset that gives n numbers, as a list or, where they are many, as an array."""
    if n > ARRAY_THRESHOLD:
        return lambda content, offset: np.frombuffer(content, dtype=float, count=n, offset=offset)
    unpack = Struct(f"{n}d").unpack_from
    return lambda content, offset: list(unpack(content, offset))
