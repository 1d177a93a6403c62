"""A unit in a worker process of its own: what crashes there is a failed step here, and several such units work at once.

A step is one message there and one back: inputs, time and length of the step go, outputs and the event come. The
answer is waited for in `get`, so units of which a master calls `step` one after the other compute side by side.
"""

from __future__ import annotations

import os
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
from time import monotonic
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ...components.core.errors import BadInput, StepFailed, visible
from ..verified_file import packed
from .answers import (
    REPORT,
    nothing,
    read_counters,
    read_failure,
    read_messages,
    read_parameters,
    read_texts,
    read_warnings,
    within,
)
from .channel import EVENT, INDEX, LARGEST, TIMES, Channel, Code, Late, NoMessage, packer, unpacker
from .fmu_messages import Messages
from .folders import process_folder
from .interface import PortValues, Simulator, Span
from .sandbox import ANSWER, environment, sandboxed, walls

if TYPE_CHECKING:
    from .kinds import UnitKind
    from .native import NativeFmu

START = 60.0  # s that a worker may take to start, whatever the limit for its answers is
GRACE = 3.0  # s that a worker has to end by itself
LOG_LINES = 5
LOG_BYTES = 10_000  # in which they are looked for
SIGNALLED = 128  # to which bubblewrap adds the number of a signal, for its exit code
LONGEST = 200  # characters of a unit's name that are shown


class Expected(NamedTuple):
    """What the next answer must be: its code, its length at most, and the function that checks and reads its content.

    The function raises `ValueError` or `TypeError` for what was not asked for.
    """

    code: int
    longest: int  # bytes
    read: Callable[[Any], Any]


NOTHING = Expected(Code.DATA, 1, nothing)


def _numbers(n: int) -> Expected:
    """n numbers and nothing else."""
    take, size = unpacker(n), 8 * n

    def read(content: Any) -> PortValues:
        if len(content) != size:
            raise ValueError(f"expected {n} numbers")
        return take(content, 0)

    return Expected(Code.NUMBERS, size, read)


class WorkerSimulator(Simulator):
    """Stands for a unit that runs in a worker process; see `Simulator` for the order of calls.

    The process starts at once and is not waited for, so several of them start at the same time; what is wrong with the unit
    shows in `wire`.
    """

    def __init__(self, name: str, kind: UnitKind, *, in_process: bool, native: NativeFmu | None = None, span: Span):
        self.name = name
        settings = kind.settings
        self.kind = f"{'native FMU' if native else kind.opened_as(in_process)} in a worker process"
        self._begin = self._time = span.start
        self._length = 0.0  # s: start of the simulation and of the step, and the step's length
        self._requests, self._numbers = 0, 0
        self._expected: Expected | None = None  # of the answer that is still to come
        self._started = self._lost = self._late = self._gone = False
        self._stale = True  # the outputs that were handed over last hold no more
        self._values: PortValues = []
        self._readers, self._text_readers = 0, 0
        self._restricted = kind.sandboxed
        self._limit = settings.time_limit or (ANSWER if self._restricted else None)  # s
        self._since: float | None = None  # when the wait for the present answer began
        self._rows, self._driven = b"", 0.0
        start = sandboxed(f"{kind.where}.isolation", kind.file) if self._restricted else []
        self._folder = Path(tempfile.mkdtemp(dir=process_folder()))  # of the worker's log and of all its temporary files
        temporary = "/tmp" if self._restricted else str(self._folder)
        try:
            with open(self._folder / "log", "wb") as log:
                self._process = subprocess.Popen(
                    [*start, sys.executable, "-P", "-m", f"{__package__}.worker", name],
                    stdin=subprocess.PIPE,
                    stdout=subprocess.PIPE,
                    stderr=log,
                    bufsize=0,
                    env={
                        **(environment() if self._restricted else os.environ),
                        "PYTHONPATH": os.pathsep.join(os.path.abspath(p) for p in sys.path),
                        "PYTHONUNBUFFERED": "1",
                        **dict.fromkeys(("TMPDIR", "TEMP", "TMP"), temporary),
                    },
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
        starting = None if self._limit is None else max(self._limit, START)
        self._channel = Channel(self._pipes[1].fileno(), self._pipes[0].fileno(), starting)
        self._closed = threading.Event()
        if self._limit is not None and os.name == "nt":  # elsewhere the channel has the limit
            threading.Thread(target=self._watch, daemon=True).start()
        parameters = Expected(Code.DATA, LARGEST // 16, lambda content: read_parameters(content, kind.parameter_names()))
        given = settings.model_dump(exclude={"isolation", "time_limit"})
        fmu = native and [native.path, dict(native.starts)]
        with suppress(StepFailed):  # it has ended already; `wire` says so
            self._call("open", given, in_process, fmu, self._restricted, [*span], expected=parameters)

    # -- messages ----------------------------------------------------------------------------------------------------
    def _send(self, code: int, content: bytes, expected: Expected) -> None:
        """One request; its answer is left for `_receive`. An earlier answer that nobody has asked for is taken first."""
        if self._expected is not None:
            self._receive()
        if self._lost:
            raise StepFailed(self.name, self._time, "its worker process has ended")
        self._requests += 1
        self._through(self._channel.send, code, content)
        self._expected = expected

    def _receive(self) -> Any:
        """The answer to the last request; raises what the unit raised, or `StepFailed` where its process has ended."""
        expected = self._expected
        if expected is None:  # the process had ended before the request was sent
            raise self._end()
        code, content = self._through(self._channel.receive, max(expected.longest, REPORT))
        self._expected = answer = None
        texts: list[str] = []
        failure: Exception | None = None
        try:
            if code == Code.WARNED:
                code, content, texts = read_warnings(content)
            if code == Code.FAILED:
                failure = read_failure(content, self.name, self._begin, self._time + self._length)
            elif code == expected.code:
                answer = expected.read(content)
            else:
                raise ValueError("an answer of another kind")
        except Exception:  # foreign code may write into the pipe what it likes
            failure = self._no_answer()
        for text in texts:
            warnings.warn(text, stacklevel=2)
        if failure is not None:
            self._stale = True
            raise failure
        return answer

    def _through(self, transfer: Callable[..., Any], *message: Any) -> Any:
        """Send or receive; raises `StepFailed` with what has become of the process where that fails."""
        self._since = monotonic()
        try:
            transferred = transfer(*message)
        except NoMessage:
            raise self._no_answer() from None
        except Late:
            raise self._too_late() from None
        except (EOFError, BrokenPipeError):
            raise self._end() from None
        except KeyboardInterrupt:
            self._lost = True  # part of a message may be left in the pipe
            raise
        self._since = None
        return transferred

    def _read_values(self, content: Any) -> None:
        """Event and outputs of the unit."""
        if len(content) != EVENT.size + 8 * len(self._outputs):
            raise ValueError("expected an event and outputs")
        (event,) = EVENT.unpack_from(content)
        if event != event:
            self.event = None
        elif within(event, self._time, self._time + self._length):
            self.event = event
        else:
            raise ValueError("an event outside the step")
        self._values, self._stale = self._take(content, EVENT.size), False

    def _call(self, method: str, *arguments: Any, expected: Expected = NOTHING) -> None:
        """Call a method there without waiting for it."""
        self._send(Code.CALL, packed([method, *arguments]), expected)

    def _move(self, method: str, *arguments: Any) -> None:
        """The same for one that may change the outputs."""
        self._call(method, *arguments)
        self._stale = True

    def _ask(self, method: str, *arguments: Any, expected: Expected = NOTHING) -> Any:
        """Call a method there and wait for what it returns."""
        self._call(method, *arguments, expected=expected)
        return self._receive()

    def _no_answer(self) -> StepFailed:
        self._kill()
        return self._end("something else than answers came from its worker process, which was ended")

    def _too_late(self) -> StepFailed:
        self._late = True
        self._kill()
        return self._end()

    def _end(self, reason: str = "") -> StepFailed:
        """The process has ended, or is to; the failure to raise, with what its end says where no reason is known."""
        self._lost = self._stale = True
        self._expected = self._since = None
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
        elif (code := code if not self._restricted or code <= SIGNALLED else SIGNALLED - code) < 0:
            reason = f"its worker process was ended by signal {-code} ({signal.strsignal(-code)})"
        else:
            reason = f"its worker process ended itself with code {code}"
        return StepFailed(self.name, self._time, reason + self._log_tail())

    def _log_tail(self) -> str:
        with open(self._folder / "log", "rb") as log:
            log.seek(max(log.seek(0, os.SEEK_END) - LOG_BYTES, 0))
            lines = log.read().decode(errors="replace").splitlines()
        return "".join(f"\n  log: {visible(line)}" for line in lines[-LOG_LINES:])

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
        """End the process when an answer, or that a request is read, is waited for longer than the limit."""
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
        self._n_inputs, self._row = len(inputs), Expected(Code.VALUES, EVENT.size + 8 * len(outputs), self._read_values)
        try:
            self._parameters: dict[str, Any] = self._receive()
            self._ask("wire", [*inputs], [*outputs])
        except StepFailed as error:
            raise BadInput(f"units.{self.name}", f"the unit cannot be started in a worker process: {error.reason}", "") from None
        self._started, self.walls = True, walls() if self._restricted else ()
        self._channel.limit = self._limit

    def put(self, name: str, value: float | str) -> None:
        self._move("put", name, value)

    def wire_texts(self, inputs: Sequence[str]) -> None:
        self._ask("wire_texts", [*inputs])

    def set_texts(self, values: Sequence[str]) -> None:
        self._move("set_texts", [*values])

    def text_reader(self, names: Sequence[str]) -> Callable[[], list[str]]:
        self._ask("text_reader", [*names])
        index, n = self._text_readers, len(names)
        self._text_readers += 1
        expected = Expected(Code.DATA, LARGEST // 16, lambda content: read_texts(content, n))
        return lambda: self._ask("read_texts", index, expected=expected)

    def reader(self, names: Sequence[str]) -> Callable[[], list[float]]:
        if set(names) <= set(self._outputs):  # these come with every answer
            at = [self._outputs.index(n) for n in names]
            return lambda: [float(values[k]) for values in [self.get()] for k in at]
        self._ask("reader", [*names])
        index, expected = INDEX.pack(self._readers), _numbers(len(names))
        self._readers += 1

        def read() -> list[float]:
            self._send(Code.READ, index, expected)
            return [*map(float, self._receive())]

        return read

    def initialize(self, t: float, values: PortValues) -> None:
        self._begin, self._time, self._length = t, t, 0.0
        self._move("initialize", t, [*values])

    def start(self) -> None:
        self._move("start")

    def drive(self, values: PortValues, slopes: PortValues | None, quadratic: PortValues | None, h: float) -> None:
        given = (values, slopes, quadratic)
        self._rows, self._driven = b"".join([self._give(row) for row in given if row is not None]), h

    def step(self, t: float, h: float) -> None:
        self._time, self._length = t, h
        self._send(Code.STEP, TIMES.pack(t, h, self._driven) + self._rows, self._row)
        self._rows = b""

    def update(self, values: PortValues) -> None:
        self._send(Code.UPDATE, self._give(values), self._row)

    def get(self) -> PortValues:
        if self._expected is not None:
            self._receive()
        if self._stale:
            self._send(Code.GET, b"", self._row)
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
        self._send(Code.STATE, INDEX.pack(state), Expected(Code.BYTES, LARGEST, bytes))
        return self._receive()

    def unpack(self, packed: bytes) -> int:
        self._numbers += 1
        self._call("unpack", self._numbers - 1, packed)
        return self._numbers - 1

    def jacobian(self) -> np.ndarray:
        shape = len(self._outputs), self._n_inputs
        self._send(Code.JACOBIAN, b"", _numbers(shape[0] * shape[1]))
        return np.array(self._receive()).reshape(shape)

    def parameters(self) -> dict[str, Any]:
        return self._parameters

    def work(self) -> dict[str, float]:
        """The unit's counters, as far as its process can still be asked, and the number of requests to it."""
        counted: dict[str, float] = {}
        if not self._lost and self._expected is None:
            with suppress(StepFailed):  # it has ended since its last answer, when nothing was wanted of it any more
                counted = self._ask("work", expected=Expected(Code.DATA, REPORT, read_counters))
        return {**counted, "requests": self._requests}

    def log_messages(self) -> Messages:
        """What the FMU has said, as far as its process can still be asked."""
        messages = Messages()
        if not self._lost and self._expected is None and self.kind.startswith("FMU"):
            with suppress(StepFailed):
                messages.counts = self._ask("counted", expected=Expected(Code.DATA, REPORT, read_counters))
                messages.kept = self._ask("kept", expected=Expected(Code.DATA, REPORT, read_messages))
        return messages

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
