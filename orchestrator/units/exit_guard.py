"""What ends this process from inside a unit: a library that calls `exit` would end a run with code 0 and without a result.

C's `exit` calls what was registered with `__cxa_atexit` before it ends the process. While units made of FMUs of others are
open, a function of ours is registered there: it says what has happened, saves what can be saved, and ends the process with the
code of a failed run. It is taken out again by `__cxa_finalize`, which calls it one last time: behind the end of the
interpreter nothing of Python may be called. `_exit` and signals pass by all this: isolation = "process" is for them.
"""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Callable, Sequence
from types import TracebackType

FAILED_RUN = 3
HANDLER = ctypes.CFUNCTYPE(None, ctypes.c_void_p)


class ExitGuard:
    """A context in which `exit` inside one of some units is reported; `rescue` is called then, and may save a result."""

    def __init__(self, units: Sequence[str], rescue: Callable[[str], None] | None = None):
        self._units, self._rescue, self._armed = list(units), rescue, False
        self._handler = HANDLER(self._at_exit)
        self._token = ctypes.c_char()  # its address tells this registration from others

    def __enter__(self) -> ExitGuard:
        if sys.platform == "linux" and self._units:
            register = ctypes.CDLL(None)["__cxa_atexit"]
            register.argtypes = (HANDLER, ctypes.c_void_p, ctypes.c_void_p)
            register(self._handler, None, ctypes.addressof(self._token))
            self._armed = True
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if self._armed:
            self._armed = False
            finalize = ctypes.CDLL(None)["__cxa_finalize"]
            finalize.argtypes = (ctypes.c_void_p,)
            finalize(ctypes.addressof(self._token))

    def _at_exit(self, _: int | None) -> None:
        if not self._armed:
            return
        self._armed = False
        names = f"unit {self._units[0]}" if len(self._units) == 1 else f"one of the units {', '.join(self._units)}"
        message = f'{names} has ended this process from inside. Write isolation = "process" for it'
        try:
            print(f"cosimo: {message}", file=sys.stderr)
            if self._rescue is not None:
                self._rescue(message)
            sys.stdout.flush()
            sys.stderr.flush()
        finally:
            os._exit(FAILED_RUN)
