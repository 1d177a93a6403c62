"""Messages between a run and a unit's worker process: a head with number, length and code, then numbers or data in msgpack.

A pipe of the operating system carries them, one request and one answer at a time. Memory shared by both and watched in a
loop would answer ten times sooner, but it takes a whole core for each side, also while a unit computes.

`multiprocessing.connection` would do the same for a third more: the run's share of a round trip is 4.4 µs of CPU time here and
5.9 µs there for 40 bytes, 8.9 and 12.9 µs for 20 000 (its messages are read in two calls, these mostly in one).

Numbers travel as their float64 bytes, without type and shape: both ends know how many there are. All else is msgpack's plain data:
nothing that arrives is executed or imported.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from struct import Struct
from typing import Any

import msgpack
import numpy as np

from .interface import ARRAY_THRESHOLD, PortValues

HEAD = Struct("=IIQB")  # mark, number of the message in its direction, bytes that follow, code
MARK = 0xC051_F1E7  # a unit may write into any open file of its process: bytes that do not start so are no message
TIMES = Struct("ddd")  # start and length of a step, length the inputs are meant for
EVENT = Struct("d")  # time of the event in a step, NaN for none
INDEX = Struct("I")
ONCE = 1 << 16  # bytes asked for in one read: what a pipe holds on Linux
LARGEST = 1 << 30  # bytes of the longest message of all, a saved state


class Code:
    """What a message is: requests, then answers."""

    STEP, UPDATE, GET, READ, CALL, JACOBIAN, STATE = range(7)
    VALUES, NUMBERS, DATA, BYTES, FAILED, WARNED = range(7, 13)


class NoMessage(EOFError):
    """The bytes that have arrived are no message, or a longer one than asked for."""


class Channel:
    """One end of a pair of pipes; `EOFError` and `BrokenPipeError` where the other end has gone."""

    def __init__(self, read: int, write: int):
        self._from, self._to = read, write
        self._sent = self._received = 0

    def send(self, code: int, content: bytes) -> None:
        """Hand over one message, whole."""
        self._sent += 1
        message: bytes | memoryview = HEAD.pack(MARK, self._sent & 0xFFFFFFFF, len(content), code) + content
        while (written := os.write(self._to, message)) < len(message):
            message = memoryview(message)[written:]

    def receive(self, longest: int = LARGEST) -> tuple[int, memoryview]:
        """Wait for one message of at most so many bytes: code and content."""
        message: bytes | bytearray = self._read(ONCE)
        while len(message) < HEAD.size:
            message += self._read(HEAD.size - len(message))
        mark, number, length, code = HEAD.unpack_from(message)
        self._received += 1
        if mark != MARK or number != self._received & 0xFFFFFFFF or length > longest:
            raise NoMessage
        if (missing := HEAD.size + length - len(message)) > 0:
            message = bytearray(message)
            while missing > 0:
                message += self._read(min(missing, ONCE))
                missing = HEAD.size + length - len(message)
        if missing < 0:  # each answer is waited for before there is another request
            raise NoMessage
        return code, memoryview(message)[HEAD.size :]

    def _read(self, most: int) -> bytes:
        content = os.read(self._from, most)
        if not content:
            raise EOFError
        return content


def packed(data: Any) -> bytes:
    """Plain data as msgpack; numbers of NumPy as Python's. Raises `TypeError` for all else, such as arrays of objects."""
    return msgpack.packb(data, default=_plain)


def _plain(value: Any) -> Any:
    if isinstance(value, np.generic):
        return value.item()
    raise TypeError(f"a {type(value).__name__} cannot be sent to or from a worker process")


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
