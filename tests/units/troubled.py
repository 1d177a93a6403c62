"""Components that crash, hang, print, warn or meet each other, for tests of worker processes."""

from __future__ import annotations

import ctypes
import os
import signal
import sys
import time
import warnings
from pathlib import Path

import numpy as np
from cosimo.components.core.component import Component
from cosimo.components.core.kernels import DONE, NOT_FINITE
from cosimo.components.core.variables import choice, input_, output, parameter

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


def _fill() -> None:
    machine = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    kept = [np.empty(machine // 4, dtype=np.uint8) for _ in range(6)]  # reserved, not filled
    kept.clear()


TROUBLES = {
    "none": lambda: None,
    "segfault": _crash,
    "exit": lambda: os._exit(7),
    "sys exit": lambda: sys.exit(0),
    "kill": lambda: os.kill(os.getpid(), signal.SIGKILL),
    "fork": _fork,
    "memory": _fill,
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
