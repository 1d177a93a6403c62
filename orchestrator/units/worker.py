"""The worker process of one unit: opens it, and answers requests until the run closes the pipe or ends.

Nothing the unit does can disturb the messages: its standard input is empty, and what it prints goes to the log.
"""

from __future__ import annotations

import contextlib
import ctypes
import importlib
import logging
import math
import os
import pickle
import signal
import sys
import traceback
import warnings
from collections.abc import Callable
from typing import Any

from ...components.core.errors import BadInput, StepFailed
from . import Simulator, open_unit
from .channel import (
    CALL,
    EVENT,
    FAILED,
    INDEX,
    OBJECT,
    READ,
    STEP,
    STOPPING,
    TIMES,
    UPDATE,
    VALUES,
    WARNED,
    Channel,
    packer,
    unpacker,
)
from .interface import PortValues, SimulationEnded
from .walls import put_up

DIE_WITH_PARENT, LINES = 1, 1  # PR_SET_PDEATHSIG, _IOLBF


class Worker:
    """One unit, and how the requests for it are answered."""

    def __init__(self, name: str, channel: Channel):
        self._name, self._channel = name, channel
        self._unit: Simulator
        self._readers: list[tuple[Callable[[], PortValues], Callable[[PortValues], bytes]]] = []
        self._text_readers: list[Callable[[], list[str]]] = []
        self._states: dict[int, Any] = {}  # states of `save` by the numbers the run gives them
        self._time = 0.0

    def open(self, settings: Any, in_process: bool, native: Any, folder: str) -> tuple[dict[str, Any], list[str]]:
        """Parameters of the unit, and the walls around it, which are put up where a `folder` is given that it may write."""
        walls = []
        if folder:
            importlib.import_module(f"{__package__}.fmu")  # what is loaded now need not be found behind the walls
            walls = put_up(folder)
        self._unit = open_unit(self._name, settings, in_process=in_process, native=native)
        return self._unit.parameters(), walls

    def wire(self, inputs: list[str], outputs: list[str]) -> None:
        self._unit.wire(inputs, outputs)
        self._n = len(inputs)
        self._take, self._give = unpacker(self._n), packer(len(outputs))

    def reader(self, names: list[str]) -> int:
        self._readers.append((self._unit.reader(names), packer(len(names))))
        return len(self._readers) - 1

    def text_reader(self, names: list[str]) -> int:
        self._text_readers.append(self._unit.text_reader(names))
        return len(self._text_readers) - 1

    def read_texts(self, index: int) -> list[str]:
        return self._text_readers[index]()

    def save(self, number: int) -> None:
        self._states[number] = self._unit.save(self._states.get(number))

    def restore(self, number: int) -> None:
        self._unit.restore(self._states[number])

    def release(self, number: int) -> None:
        self._unit.release(self._states.pop(number))

    def pack(self, number: int) -> bytes:
        return self._unit.pack(self._states[number])

    def unpack(self, number: int, packed: bytes) -> None:
        self._states[number] = self._unit.unpack(packed)

    def close(self) -> None:
        if hasattr(self, "_unit"):
            self._unit.close()

    def _step(self, content: memoryview) -> None:
        unit, n, take = self._unit, self._n, self._take
        self._time, h, driven = TIMES.unpack_from(content)
        if n and len(content) > TIMES.size:
            rows = [take(content, k) for k in range(TIMES.size, len(content), 8 * n)]
            unit.drive(rows[0], rows[1] if len(rows) > 1 else None, rows[2] if len(rows) > 2 else None, driven)
        unit.step(self._time, h)

    def _answer(self, code: int, content: memoryview) -> tuple[int, bytes]:
        if code == CALL:
            name, arguments = pickle.loads(content)
            method = getattr(self, name, None) or getattr(self._unit, name)
            return OBJECT, pickle.dumps(method(*arguments))
        if code == READ:
            read, give = self._readers[INDEX.unpack(content)[0]]
            return OBJECT, give(read())
        if code == STEP:
            self._step(content)
        elif code == UPDATE:
            self._unit.update(self._take(content, 0))
        values, event = self._unit.get(), self._unit.event  # in this order: an event is asked for after `get`
        return VALUES, EVENT.pack(math.nan if event is None else event) + self._give(values)

    def serve(self) -> None:
        """Answer requests until the pipe is closed; what fails is an answer, too."""
        messages: list[str] = []
        warnings.simplefilter("always", UserWarning)
        warnings.showwarning = lambda message, category, *_: (
            messages.append(str(message)) if issubclass(category, UserWarning) else None
        )
        while True:
            try:
                code, content = self._channel.receive()
            except EOFError:
                return
            try:
                code, answer = self._answer(code, content)
            except BadInput as error:
                code, answer = FAILED, pickle.dumps((BadInput, (error.where, error.actual, error.expected, error.remedy)))
            except SimulationEnded as error:
                code, answer = FAILED, pickle.dumps((SimulationEnded, (error.unit, error.time)))
            except StepFailed as error:
                code, answer = FAILED, pickle.dumps((StepFailed, (error.unit, error.time, error.reason, error.remedy)))
            except Exception as error:
                traceback.print_exc()
                reason = f"{type(error).__name__}: {error}"
                code, answer = FAILED, pickle.dumps((StepFailed, (self._name, self._time, reason)))
            if messages:
                code, answer = WARNED, pickle.dumps((messages, code, answer))
                messages.clear()
            self._channel.send(code, answer)


def main() -> None:
    """Serve the unit named on the command line over standard input and output."""
    channel = Channel(os.dup(0), os.dup(1))
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    os.dup2(2, 1)
    for one in STOPPING:  # they are for the run, which then closes its units
        signal.signal(one, signal.SIG_IGN)
    if sys.platform == "linux":
        libc = ctypes.CDLL(None)
        libc.prctl(DIE_WITH_PARENT, signal.SIGKILL)  # a unit that hangs would not see the pipe closed
        libc.setvbuf(ctypes.c_void_p.in_dll(libc, "stdout"), None, LINES, 0)  # a crash would lose what C code has printed
    logging.basicConfig(stream=sys.stderr, level=logging.INFO, format="%(message)s")
    worker = Worker(sys.argv[1], channel)
    with contextlib.suppress(BrokenPipeError):  # the run ended while the unit was at work
        worker.serve()
    worker.close()
    sys.stdout.flush()
    os._exit(0)  # libraries that crash while a process winds up have nothing left to spoil


if __name__ == "__main__":
    main()
