"""The reason why Numba cannot compile a kernel, in one message: file, line, and the near name."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Any

from .errors import BadInput, nearest

_PLACE = re.compile(r" at (\S[^\n]*?) \((\d+)\)|File \"([^\"\n]+)\", line (\d+)")
_NAME = re.compile(r"attribute '(\w+)'|name '(\w+)'")


def typing_fault(error: Exception, arguments: Iterable[Any]) -> BadInput:
    """Numba's error of a kernel in one message: file, line, what it does not know there, and the near names.

    arguments: types of the kernel's arguments; the fields of NamedTuples, such as the parameters `p`, are what may be meant.
    """
    lines = [line.strip() for line in str(error).splitlines()]
    reason = next((line for line in lines if line and not line.startswith(("Failed in", "During"))), type(error).__name__)
    place = _PLACE.search(str(error))
    where = "kernel" if place is None else f"{place[1] or place[3]}:{place[2] or place[4]}"
    reason = re.sub(r" of type \S+\(.*\)$", "", reason)  # of the tuple that has all parameters
    unknown = _NAME.search(reason)
    known = sorted({field for kind in arguments for field in getattr(kind, "fields", ())})
    remedy = nearest(unknown[1] or unknown[2], known) if unknown and known else ""
    return BadInput(where, f"Numba cannot compile this kernel: {reason.rstrip('.')}", "", remedy)
