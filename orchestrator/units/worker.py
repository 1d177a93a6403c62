"""The worker process of one unit: opens it, and answers requests until the run closes the pipe or ends.

Nothing the unit does can disturb the messages: its standard input is empty, and what it prints goes to the log.
"""

from __future__ import annotations

import contextlib
import ctypes
import logging
import math
import os
import signal
import sys
import traceback
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np

from ...components.core.errors import BadInput, StepFailed
from ..interrupts import STOPPING
from ..settings import UnitSettings
from ..verified_file import packed, unpacked
from . import Simulator, environment, open_unit
from .answers import LONGEST_TEXT, MOST_WARNINGS, REPORT
from .channel import EVENT, INDEX, TIMES, Channel, Code, packer, unpacker
from .interface import PortValues, SimulationEnded, Span
from .sandbox import limit_resources

DIE_WITH_PARENT, LINES = 1, 1  # PR_SET_PDEATHSIG, _IOLBF


class Worker:
    """One unit, and how the requests for it are answered."""

    def __init__(self, name: str, channel: Channel):
        self._name, self._channel = name, channel
        self._unit: Simulator
        self._close: Callable[[], None] = lambda: None  # before there is a unit
        self._calls: dict[str, Callable[..., Any]] = {"open": self.open}  # what a message may ask for, by name
        self._readers: list[tuple[Callable[[], PortValues], Callable[[PortValues], bytes]]] = []
        self._text_readers: list[Callable[[], list[str]]] = []
        self._states: dict[int, Any] = {}  # states of `save` by the numbers the run gives them
        self._time = 0.0

    def open(
        self, settings: dict[str, Any], in_process: bool, native: list[Any] | None, restricted: bool, span: list[Any]
    ) -> dict[str, Any]:
        """Open the unit with the fields of its settings, of its native FMU and of the span of the run; its parameters."""
        limit_resources(restricted)
        fmu = None
        if native is not None:
            from .native import NativeFmu  # which loads FMPy

            fmu = NativeFmu(*native)
        self._unit = open_unit(
            self._name, UnitSettings.model_validate(settings), in_process=in_process, native=fmu, span=Span(*span)
        )
        unit, self._close = self._unit, self._unit.close
        self._calls = {
            "wire": self.wire,
            "reader": self.reader,
            "text_reader": self.text_reader,
            "read_texts": self.read_texts,
            "counted": lambda: unit.log_messages().counts,
            "kept": self.kept,
            "save": self.save,
            "restore": self.restore,
            "release": self.release,
            "unpack": self.unpack,
            "put": unit.put,
            "wire_texts": unit.wire_texts,
            "set_texts": unit.set_texts,
            "initialize": unit.initialize,
            "start": unit.start,
            "work": unit.work,
        }
        return unit.parameters()

    def wire(self, inputs: list[str], outputs: list[str]) -> None:
        self._unit.wire(inputs, outputs)
        self._n = len(inputs)
        self._take, self._give = unpacker(self._n), packer(len(outputs))

    def reader(self, names: list[str]) -> None:
        self._readers.append((self._unit.reader(names), packer(len(names))))

    def text_reader(self, names: list[str]) -> None:
        self._text_readers.append(self._unit.text_reader(names))

    def read_texts(self, index: int) -> list[str]:
        return self._text_readers[index]()

    def kept(self) -> list[Any]:
        """Messages of the FMU, each as three values, as many as fit into a report."""
        kept: list[Any] = []
        room = REPORT // 2
        for t, level, text in self._unit.log_messages().kept:
            room -= 50 + len(text.encode())
            if room > 0:
                kept += t, level, text
        return kept

    def save(self, number: int) -> None:
        self._states[number] = self._unit.save(self._states.get(number))

    def restore(self, number: int) -> None:
        self._unit.restore(self._states[number])

    def release(self, number: int) -> None:
        self._unit.release(self._states.pop(number))

    def unpack(self, number: int, packed: bytes) -> None:
        self._states[number] = self._unit.unpack(packed)

    def close(self) -> None:
        self._close()

    def _step(self, content: memoryview) -> None:
        unit, n, take = self._unit, self._n, self._take
        self._time, h, driven = TIMES.unpack_from(content)
        if n and len(content) > TIMES.size:
            rows = [take(content, k) for k in range(TIMES.size, len(content), 8 * n)]
            unit.drive(rows[0], rows[1] if len(rows) > 1 else None, rows[2] if len(rows) > 2 else None, driven)
        unit.step(self._time, h)

    def _answer(self, code: int, content: memoryview) -> tuple[int, bytes]:
        if code == Code.CALL:
            name, *arguments = unpacked(content)
            return Code.DATA, packed(self._calls[name](*arguments))
        if code == Code.READ:
            read, give = self._readers[INDEX.unpack(content)[0]]
            return Code.NUMBERS, give(read())
        if code == Code.JACOBIAN:
            return Code.NUMBERS, np.asarray(self._unit.jacobian(), dtype=float).tobytes()
        if code == Code.STATE:
            return Code.BYTES, self._unit.pack(self._states[INDEX.unpack(content)[0]])
        if code == Code.STEP:
            self._step(content)
        elif code == Code.UPDATE:
            self._unit.update(self._take(content, 0))
        values, event = self._unit.get(), self._unit.event  # in this order: an event is asked for after `get`
        return Code.VALUES, EVENT.pack(math.nan if event is None else event) + self._give(values)

    def _failure(self, error: BadInput | StepFailed) -> tuple[int, bytes]:
        if isinstance(error, BadInput):
            failure = ["BadInput", self._time, error.where, error.actual, error.expected, error.remedy]
        elif isinstance(error, SimulationEnded):
            failure = ["SimulationEnded", float(error.time)]
        else:
            failure = ["StepFailed", float(error.time), error.reason, error.remedy]
        return Code.FAILED, packed([text[:LONGEST_TEXT] if isinstance(text, str) else text for text in failure])

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
            except (BadInput, StepFailed) as error:
                code, answer = self._failure(error)
            except Exception as error:
                traceback.print_exc()
                code, answer = self._failure(StepFailed(self._name, self._time, f"{type(error).__name__}: {error}"))
            environment.restore()  # as it is between the calls where the unit is in the process of the run
            if messages:
                texts = [text[:LONGEST_TEXT] for text in messages[:MOST_WARNINGS]]
                code, answer = Code.WARNED, packed([code, answer, *texts])
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
