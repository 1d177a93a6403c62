"""Messages between a run and a unit's worker process: a length, a code, and numbers or pickled objects.

A pipe of the operating system carries them, one request and one answer at a time. Memory shared by both and watched in a
loop would answer ten times sooner, but it takes a whole core for each side, also while a unit computes.

`multiprocessing.connection` would do the same for a third more: the run's share of a round trip is 4.4 µs of CPU time here and
5.9 µs there for 40 bytes, 8.9 and 12.9 µs for 20 000 (its messages are read in two calls, these mostly in one).
"""

from __future__ import annotations

import os
import signal
from collections.abc import Callable
from struct import Struct
from typing import Any

import numpy as np

from .interface import ARRAY_THRESHOLD, PortValues

HEAD = Struct("=QIB")  # mark of a message, bytes that follow, code
MARK = 0x6F6D69736F63_F1E7  # a unit may write into any open file of its process: what does not begin so is no message
STEP, UPDATE, GET, READ, CALL, VALUES, OBJECT, FAILED, WARNED = range(9)
TIMES = Struct("ddd")  # start and length of a step, length the inputs are meant for
EVENT = Struct("d")  # time of the event in a step, NaN for none
INDEX = Struct("I")
# signals that end a run, which then ends its workers; Windows has the first two
STOPPING = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))
ONCE = 1 << 16  # bytes asked for in one read: what a pipe holds on Linux


class NoMessage(EOFError):
    """What came is no message."""


class Channel:
    """One end of a pair of pipes; `EOFError` and `BrokenPipeError` where the other end has gone."""

    def __init__(self, read: int, write: int):
        self._from, self._to = read, write

    def send(self, code: int, content: bytes) -> None:
        """Hand over one message, whole."""
        message: bytes | memoryview = HEAD.pack(MARK, len(content), code) + content
        while (written := os.write(self._to, message)) < len(message):
            message = memoryview(message)[written:]

    def receive(self) -> tuple[int, memoryview]:
        """Wait for one message: code and content."""
        message = self._read(ONCE)
        while len(message) < HEAD.size:
            message += self._read(HEAD.size - len(message))
        mark, length, code = HEAD.unpack_from(message)
        if mark != MARK:
            raise NoMessage
        while (missing := HEAD.size + length - len(message)) > 0:
            message += self._read(missing)
        if missing < 0:  # each answer is waited for before there is another request
            raise NoMessage
        return code, memoryview(message)[HEAD.size :]

    def _read(self, most: int) -> bytes:
        content = os.read(self._from, most)
        if not content:
            raise EOFError
        return content


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
