"""The reason why Numba cannot compile a kernel, in one message: file, line, and the near name."""

from __future__ import annotations

import re
from collections.abc import Iterable

from .errors import BadInput, nearest

_PLACE = re.compile(r" at (\S[^\n]*?) \((\d+)\)|File \"([^\"\n]+)\", line (\d+)")
_NAME = re.compile(r"attribute '(\w+)'|name '(\w+)'")


def is_typing_fault(error: BaseException) -> bool:
    """Whether Numba could not compile a kernel, which is a fault of its text. Without an import of Numba."""
    return any(cls.__module__ == "numba.core.errors" for cls in type(error).__mro__)


def typing_fault(error: BaseException, names: Iterable[str] = ()) -> BadInput:
    """Numba's error of a kernel in one message: file, line, what it does not know there, and the near names.

    names: parameters, inputs and outputs of the component.
    """
    lines = [line.strip() for line in str(error).splitlines()]
    reason = next((line for line in lines if line and not line.startswith(("Failed in", "During"))), type(error).__name__)
    place = _PLACE.search(str(error))
    where = "kernel" if place is None else f"{place[1] or place[3]}:{place[2] or place[4]}"
    reason = re.sub(r" of type \S+\(.*\)$", "", reason)  # of the tuple that has all parameters
    unknown = _NAME.search(reason)
    remedy = nearest(unknown[1] or unknown[2], {n.rpartition(".")[2] for n in names}) if unknown and names else ""
    return BadInput(where, reason.rstrip("."), "a kernel that Numba compiles", remedy)
