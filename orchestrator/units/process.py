"""A unit in a worker process of its own: what crashes there is a failed step here, and several such units work at once.

A step is one message there and one back: inputs, time and length of the step go, outputs and the event come. The
answer is waited for in `get`, so units of which a master calls `step` one after the other compute side by side.
"""

from __future__ import annotations

import os
import pickle
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import warnings
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from struct import Struct
from time import monotonic
from typing import TYPE_CHECKING, Any

import numpy as np

from ...components.core.errors import BadInput, StepFailed
from .channel import (
    CALL,
    EVENT,
    FAILED,
    GET,
    INDEX,
    READ,
    STEP,
    TIMES,
    UPDATE,
    VALUES,
    WARNED,
    Channel,
    NoMessage,
    packer,
    unpacker,
)
from .folders import process_folder
from .interface import PortValues
from .walls import ANSWER, clean_environment, read_answer

if TYPE_CHECKING:
    from ..settings import UnitSettings
    from .native import NativeFmu

START = 60.0  # s that a worker may take to start, whatever the limit for its answers is
GRACE = 3.0  # s that a worker has to end by itself
LOG_LINES = 5
LOG_BYTES = 10_000  # in which they are looked for
LONGEST = 200  # characters of a unit's name that are shown


class WorkerSimulator:
    """Stands for a unit that runs in a worker process; see `Simulator` for the order of calls.

    The process starts at once and is not waited for, so several of them start at the same time; what is wrong with the unit
    shows in `wire`.
    """

    event: float | None = None

    def __init__(self, name: str, settings: UnitSettings, *, in_process: bool, native: NativeFmu | None = None):
        self.name = name
        kind = "native FMU" if native else "component" if in_process or ":" in settings.component else "FMU"
        self.kind = f"{kind} in a worker process"
        self._time, self._requests, self._numbers = 0.0, 0, 0
        self._started = self._waiting = self._lost = self._late = self._gone = False
        self._stale = True  # the outputs that were handed over last hold no more
        self._values: PortValues = []
        self.walls: list[str] = []  # that stand around it
        self._limit = settings.time_limit or (ANSWER if settings.isolation == "restricted" else None)  # s
        self._since: float | None = None  # when the wait for the present answer began
        self._rows, self._driven = b"", 0.0
        self._folder = Path(tempfile.mkdtemp(dir=process_folder()))  # of the worker's log and of all its temporary files
        paths = os.pathsep.join(os.path.abspath(p) for p in sys.path)
        folder, walled = str(self._folder), settings.isolation == "restricted"
        inherited = clean_environment(folder) if walled else os.environ
        environment = inherited | {"PYTHONPATH": paths, "PYTHONUNBUFFERED": "1", "TMPDIR": folder, "TEMP": folder, "TMP": folder}
        try:
            with open(self._folder / "log", "wb") as log:
                self._process = subprocess.Popen(
                    [sys.executable, "-P", "-m", f"{__package__}.worker", name],
                    stdin=subprocess.PIPE,
                    stdout=subprocess.PIPE,
                    stderr=log,
                    bufsize=0,
                    env=environment,
                    start_new_session=True,
                )  # a terminal's Ctrl-C does not reach it
        except OSError as error:  # too many processes or open files, a name longer than a command line ...
            shutil.rmtree(self._folder, ignore_errors=True)
            raise BadInput(
                f"units.{name[:LONGEST]}",
                "a worker process that the system does not start",
                "one that starts",
                f"{error.strerror}.",
            ) from None
        self._pipes = [pipe for pipe in (self._process.stdin, self._process.stdout) if pipe is not None]
        self._channel = Channel(self._pipes[1].fileno(), self._pipes[0].fileno())
        self._closed = threading.Event()
        if self._limit is not None:
            threading.Thread(target=self._watch, daemon=True).start()
        with suppress(StepFailed):  # it has ended already; `wire` says so
            self._call(
                "open",
                settings.model_copy(update={"isolation": "none", "time_limit": None}),
                in_process,
                native,
                folder if walled else "",
            )

    # -- messages ----------------------------------------------------------------------------------------------------
    def _send(self, code: int, content: bytes) -> None:
        """One request; its answer is left for `_receive`. An earlier answer that nobody has asked for is taken first."""
        if self._waiting:
            self._receive()
        if self._lost:
            raise StepFailed(self.name, self._time, "its worker process has ended")
        self._requests += 1
        try:
            self._channel.send(code, content)
        except BrokenPipeError:
            raise self._end() from None
        except KeyboardInterrupt:
            self._lost = True  # part of a message may be left in the pipe
            raise
        self._waiting = True

    def _receive(self) -> memoryview:
        """The answer to the last request; raises what the unit raised, or `StepFailed` where its process has ended."""
        self._since = monotonic()
        try:
            code, content = self._channel.receive()
        except NoMessage:
            raise self._no_answer() from None
        except EOFError:
            raise self._end() from None
        except KeyboardInterrupt:
            self._lost = True  # part of a message may be left in the pipe
            raise
        self._waiting, self._since = False, None
        if code == WARNED:
            texts, code, content = self._read(content)
            for text in texts:
                warnings.warn(text, stacklevel=2)
        if code == VALUES:
            (event,) = EVENT.unpack_from(content)
            self.event = event if event == event else None
            self._values, self._stale = self._take(content, EVENT.size), False
        elif code == FAILED:
            kind, arguments = self._read(content)
            self._stale = True
            raise kind(*arguments)
        return content

    def _call(self, method: str, *arguments: Any) -> None:
        """Call a method there without waiting for it."""
        self._send(CALL, pickle.dumps((method, arguments)))

    def _move(self, method: str, *arguments: Any) -> None:
        """The same for one that may change the outputs."""
        self._call(method, *arguments)
        self._stale = True

    def _ask(self, method: str, *arguments: Any) -> Any:
        """Call a method there and wait for what it returns."""
        self._call(method, *arguments)
        return self._read(self._receive())

    def _read(self, content: Any) -> Any:
        """The object in an answer."""
        try:
            return read_answer(content)
        except Exception:  # foreign code may write into the pipe what it likes
            raise self._no_answer() from None

    def _no_answer(self) -> StepFailed:
        self._kill()
        return self._end("something else than answers came from its worker process, which was ended")

    def _end(self, reason: str = "") -> StepFailed:
        """The process has ended, or is to; the failure to raise, with what its end says where no reason is known."""
        self._lost = self._stale = True
        self._waiting, self._since = False, None
        try:
            code = self._process.wait(GRACE)
        except subprocess.TimeoutExpired:  # it has closed the pipe and lives on
            self._kill()
            code = self._process.wait()
        self._kill()
        self._gone = True
        if reason:
            pass
        elif self._late:
            reason = f"no answer within {self._limit:g} s; its worker process was ended"
        elif code < 0:
            reason = f"its worker process was ended by signal {-code} ({signal.strsignal(-code)})"
        else:
            reason = f"its worker process ended itself with code {code}"
        return StepFailed(self.name, self._time, reason + self._log_tail())

    def _log_tail(self) -> str:
        with open(self._folder / "log", "rb") as log:
            log.seek(max(log.seek(0, os.SEEK_END) - LOG_BYTES, 0))
            lines = log.read().decode(errors="replace").splitlines()
        return "".join(f"\n  log: {line}" for line in lines[-LOG_LINES:])

    def _kill(self) -> None:
        """End the process, and with it those that its unit has started: they are of its process group."""
        if self._gone:  # and another group may have its number
            return
        if os.name == "nt":
            self._process.kill()
        else:
            with suppress(ProcessLookupError, PermissionError):
                os.killpg(self._process.pid, signal.SIGKILL)

    def _watch(self) -> None:
        """End the process when an answer is waited for longer than the limit."""
        assert self._limit is not None
        while not self._closed.wait(self._limit / 4.0):
            since, limit = self._since, self._limit if self._started else max(self._limit, START)
            if since is not None and monotonic() - since > limit:
                self._late = True
                self._kill()
                return

    # -- the unit ----------------------------------------------------------------------------------------------------
    def wire(self, inputs: Sequence[str], outputs: Sequence[str]) -> None:
        self._outputs, self._take, self._give = tuple(outputs), unpacker(len(outputs)), packer(len(inputs))
        try:
            self._parameters: dict[str, Any]
            self._parameters, self.walls = self._read(self._receive())
            self._ask("wire", [*inputs], [*outputs])
        except StepFailed as error:
            raise BadInput(
                f"units.{self.name}", f"it cannot be started: {error.reason}", "a unit that starts in a worker process"
            ) from None
        self._started = True

    def wire_texts(self, inputs: Sequence[str]) -> None:
        self._ask("wire_texts", [*inputs])

    def set_texts(self, values: Sequence[str]) -> None:
        self._move("set_texts", [*values])

    def text_reader(self, names: Sequence[str]) -> Callable[[], list[str]]:
        index = self._ask("text_reader", [*names])
        return lambda: self._ask("read_texts", index)

    def reader(self, names: Sequence[str]) -> Callable[[], list[float]]:
        if set(names) <= set(self._outputs):  # these come with every answer
            at = [self._outputs.index(n) for n in names]
            return lambda: [float(values[k]) for values in [self.get()] for k in at]
        index, unpack = INDEX.pack(self._ask("reader", [*names])), Struct(f"{len(names)}d").unpack

        def read() -> list[float]:
            self._send(READ, index)
            return list(unpack(self._receive()))

        return read

    def initialize(self, t: float, values: PortValues) -> None:
        self._time = t
        self._move("initialize", t, [*values])

    def start(self) -> None:
        self._move("start")

    def drive(self, values: PortValues, slopes: PortValues | None, halves: PortValues | None, h: float) -> None:
        given = (values, slopes, halves)
        self._rows, self._driven = b"".join([self._give(row) for row in given if row is not None]), h

    def step(self, t: float, h: float) -> None:
        self._time = t
        self._send(STEP, TIMES.pack(t, h, self._driven) + self._rows)
        self._rows = b""

    def update(self, values: PortValues) -> None:
        self._send(UPDATE, self._give(values))

    def get(self) -> PortValues:
        if self._waiting:
            self._receive()
        if self._stale:
            self._send(GET, b"")
            self._receive()
        return self._values

    def save(self, reuse: int | None = None) -> int:
        if reuse is None:
            reuse = self._numbers
            self._numbers += 1
        self._call("save", reuse)
        return reuse

    def restore(self, state: int) -> None:
        self._move("restore", state)

    def release(self, state: int) -> None:
        self._call("release", state)

    def pack(self, state: int) -> bytes:
        return self._ask("pack", state)

    def unpack(self, packed: bytes) -> int:
        self._numbers += 1
        self._call("unpack", self._numbers - 1, packed)
        return self._numbers - 1

    def jacobian(self) -> np.ndarray:
        return self._ask("jacobian")

    def parameters(self) -> dict[str, Any]:
        return self._parameters

    def work(self) -> dict[str, int]:
        """The unit's counters, as far as its process can still be asked, and the number of requests to it."""
        counted: dict[str, int] = {}
        if not (self._lost or self._waiting):
            with suppress(StepFailed):  # it has ended since its last answer, when nothing was wanted of it any more
                counted = self._ask("work")
        return {**counted, "requests": self._requests}

    def close(self) -> None:
        self._closed.set()
        try:
            self._pipes[0].close()  # the worker closes its unit and ends
            with suppress(subprocess.TimeoutExpired):
                self._process.wait(GRACE)
        finally:
            self._kill()
            self._process.wait()
            self._gone = True
            self._pipes[1].close()
            shutil.rmtree(self._folder, ignore_errors=True)
