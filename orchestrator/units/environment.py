"""The floating-point environment: a library that leaves another one changes every number that is computed after it.

Another rounding mode, or numbers below the normal range that become zero, show in four sums and comparisons, which cost less than to
ask for the environment. Where one fails, the environment of the start is set again. The values are read from memory each time, since
a compiler knows the sums of constants.
"""

from __future__ import annotations

import ctypes
import os
import struct
from collections.abc import Callable
from typing import Any

SIZE = 64  # numbers of eight bytes, more than any environment has
VALUES = ONE, LITTLE, LARGER, SMALLEST, BELOW = 1.0, 2.0**-60, 1.5 * 2.0**-1022, 2.0**-1022, 5e-324
_environment = (ctypes.c_uint64 * SIZE)()


def _setter() -> Any:
    """C's fesetenv, with the present environment noted; None where it is not found."""
    for name in ("ucrtbase",) if os.name == "nt" else (None, "libm.so.6"):
        try:
            library = ctypes.CDLL(name)
            return library.fesetenv if library.fegetenv(_environment) == 0 else None
        except (OSError, AttributeError):
            continue
    return None


_set = _setter()
_function = 0 if _set is None else ctypes.cast(_set, ctypes.c_void_p).value or 0
_cells = ctypes.create_string_buffer(struct.pack("=QQ5d", _function, ctypes.addressof(_environment), *VALUES))
CELLS = ctypes.addressof(_cells) if _function else 0  # fesetenv, its argument and the values, for kernels; 0: not there


def guarded(function: Callable[..., int]) -> Callable[..., int]:
    """The function, behind which the environment is that of the start."""

    def called(*arguments: Any) -> int:
        answer = function(*arguments)
        restore()
        return answer

    return called


def restore(one=ONE, little=LITTLE, larger=LARGER, smallest=SMALLEST, below=BELOW) -> None:  # type: ignore[no-untyped-def]
    """Set the environment of the start again where it is another one now."""
    if not (one + little == one == one - little and larger - smallest > 0.0 < below) and _set is not None:
        _set(_environment)
