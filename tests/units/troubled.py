"""Components that crash, hang, print, warn or meet each other, for tests of worker processes."""

from __future__ import annotations

import contextlib
import ctypes
import os
import pickle
import signal
import socket
import sys
import tempfile
import time
import warnings
from pathlib import Path

import numpy as np
from cosimo.components.core.component import Component
from cosimo.components.core.kernels import DONE, NOT_FINITE
from cosimo.components.core.variables import choice, input_, output, parameter
from cosimo.orchestrator.units.channel import FAILED, HEAD, MARK

LONG = 30.0  # s: a test that waits for it has failed
PATIENCE = 60.0  # s, for what takes a moment where the machine is not busy


def _crash() -> None:
    ctypes.string_at(0)


def _print() -> None:
    print("a line of the unit")
    os.write(1, b"and one of its library\n")
    os._exit(7)


def _fork() -> None:
    if not os.fork():
        time.sleep(LONG)
        os._exit(0)


TROUBLES = {
    "none": lambda: None,
    "segfault": _crash,
    "exit": lambda: os._exit(7),
    "sys exit": lambda: sys.exit(0),
    "kill": lambda: os.kill(os.getpid(), signal.SIGKILL),
    "fork": _fork,
    "hang": lambda: time.sleep(LONG),
    "exception": lambda: 1 / 0,
    "warning": lambda: warnings.warn("the oil is old", stacklevel=1),
    "print": _print,
}


class Troubled(Component):
    """Counts its steps, tells its process, and gets into trouble at a time."""

    trouble = choice("none", tuple(TROUBLES), "what happens")
    when = parameter(0.25, "s", "start of the step in which it happens; before 0: in the initialization")
    driven = input_(0.0, "1", "any number")
    steps = output("1", "steps made")
    process = output("1", "number of its process")

    def _initialize(self, t: float) -> int:
        if self.parameters["when"] < 0.0:
            TROUBLES[self.parameters["trouble"]]()
        self.x = np.zeros(1)
        return DONE

    def _step(self, t: float, h: float) -> int:
        if t <= self.parameters["when"] < t + h:
            TROUBLES[self.parameters["trouble"]]()
        self.x[0] += 1.0
        self.refresh()
        return DONE

    def _outputs(self, t: float) -> None:
        self.y[:] = self.x[0], os.getpid()


class Meeting(Component):
    """Fails unless a second one is inside its own step with the same number at the same time.

    They meet in the folder COSIMO_TEST_MEETING: each leaves a file and waits for that of the other.
    """

    me = parameter(1.0, "1", "1 or 2")
    driven = input_(0.0, "1", "any number")
    met = output("1", "steps in which both were at work")

    def _initialize(self, t: float) -> int:
        self.x = np.zeros(1)
        return DONE

    def _step(self, t: float, h: float) -> int:
        folder, me = Path(os.environ["COSIMO_TEST_MEETING"]), self.parameters["me"]
        (folder / f"{me:g} {t:g}").touch()
        other, end = folder / f"{3.0 - me:g} {t:g}", time.monotonic() + PATIENCE
        while not other.exists():
            if time.monotonic() > end:
                return NOT_FINITE
            time.sleep(1e-4)
        self.x[0] += 1.0
        self.refresh()
        return DONE

    def _outputs(self, t: float) -> None:
        self.y[0] = self.x[0]


def _answers(attempt) -> float:
    """1 where an attempt succeeds, 0 where the system refuses it."""
    try:
        attempt()
    except OSError:
        return 0.0
    return 1.0


def _connect() -> None:
    with socket.socket() as one, socket.socket() as other:
        one.bind(("127.0.0.1", 0))
        one.listen()
        other.connect(one.getsockname())


class Curious(Component):
    """Tries what foreign code must not do, and gives out what worked."""

    driven = input_(0.0, "1", "any number")
    network = output("1", "1: it could open a connection")
    writes = output("1", "1: it could write into the home of the user, or beside the scene")
    own = output("1", "1: it could write into the folder for temporary files")
    secret = output("1", "1: it has read a secret of the environment")
    kills = output("1", "1: it could send a signal to the process that runs the scene")
    memory = output("1", "1: it got 6 GB")

    def _initialize(self, t: float) -> int:
        self.x = np.zeros(1)
        return DONE

    def _step(self, t: float, h: float) -> int:
        self.refresh()
        return DONE

    def _outputs(self, t: float) -> None:
        target = Path(os.environ.get("COSIMO_TEST_TARGET") or Path(__file__).parent) / "written-by-a-unit"
        got = 1.0
        try:
            np.empty(6 << 30, dtype=np.uint8)  # reserved, not filled
        except MemoryError:
            got = 0.0
        self.y[:] = (
            _answers(_connect),
            _answers(lambda: target.write_text("x")),
            _answers(lambda: Path(tempfile.gettempdir(), "own").write_text("x")),
            float("COSIMO_TEST_SECRET" in os.environ),
            _answers(lambda: os.kill(os.getppid(), 0)),
            got,
        )


class Forger(Component):
    """Writes an object of its own into the pipe to the run, which must not be brought to life there."""

    driven = input_(0.0, "1", "any number")
    y_out = output("1", "0")

    def _initialize(self, t: float) -> int:
        self.x = np.zeros(1)
        return DONE

    def _step(self, t: float, h: float) -> int:
        content = pickle.dumps(_Evil())
        for number in range(3, 12):
            with contextlib.suppress(OSError):
                os.write(number, HEAD.pack(MARK, len(content), FAILED) + content)
        return DONE

    def _outputs(self, t: float) -> None:
        self.y[:] = 0.0


class _Evil:
    def __reduce__(self):
        return os._exit, (66,)
