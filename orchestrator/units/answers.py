"""What a worker process has answered, checked against what was asked: its unit may be hostile, and write answers of its own.

Every function raises a `ValueError` for an answer that is none, which msgpack does, too. No answer holds a list in a list or
a table in a table, so that none grows when it is read.
"""

from __future__ import annotations

from collections.abc import Collection
from math import isfinite
from typing import Any

import msgpack

from ...components.core.errors import BadInput, StepFailed, visible
from .fmu_messages import LEVELS, LONGEST, MOST_MESSAGES
from .interface import SimulationEnded

REPORT = 1 << 20  # bytes of an answer about a failure, or of warnings
LONGEST_TEXT = 10_000  # characters of a failure or a warning
ENTRIES = 1_100_000  # of a table: an FMU has at most 1 000 000 elements
MOST_WARNINGS = 100
SCALARS = (bool, int, float, str)


def _flat(values: list[Any]) -> tuple[Any, ...]:
    """A list as a tuple, which no list may hold."""
    if any(type(value) not in (*SCALARS, bytes) for value in values):
        raise ValueError("a list with more than plain values")
    return tuple(values)


def _read_list(content: Any, most: int) -> tuple[Any, ...]:
    values = msgpack.unpackb(content, list_hook=_flat, max_array_len=most, max_map_len=0, max_ext_len=0)
    if type(values) is not tuple:
        raise ValueError("no list")
    return values


def _read_table(content: Any) -> dict[str, Any]:
    table = msgpack.unpackb(content, max_array_len=0, max_map_len=ENTRIES, max_ext_len=0)
    if type(table) is not dict or not all(type(name) is str and name.isprintable() for name in table):
        raise ValueError("no table of names")
    return table


def nothing(content: Any) -> None:
    """The answer to a request that asks for none."""
    if content != b"\xc0":
        raise ValueError("an answer that nobody asked for")


def read_texts(content: Any, n: int) -> list[str]:
    """n texts of outputs."""
    texts = _read_list(content, n)
    if len(texts) != n or not all(type(text) is str for text in texts):
        raise ValueError(f"expected {n} texts")
    return list(texts)


def read_parameters(content: Any, known: Collection[str] | None) -> dict[str, Any]:
    """Values of parameters by name; known: the names that the unit has, elements of arrays aside; None: any."""
    table = _read_table(content)
    names = table if known is None else known
    for name, value in table.items():
        if type(value) not in SCALARS or not (name in names or name.partition("[")[0] in names):
            raise ValueError(f"no parameter {name}")
    return table


def read_counters(content: Any) -> dict[str, float]:
    """A unit's counters by name, whole numbers but for the shortest step, s."""
    table = _read_table(content)
    sound = (type(n) in (int, float if name == "shortest" else int) and 0 <= n < 1 << 63 for name, n in table.items())
    if len(table) > MOST_WARNINGS or not all(sound):
        raise ValueError("no counters")
    return table


def read_messages(content: Any) -> list[tuple[float, str, str]]:
    """Messages of an FMU: time, level and text of each."""
    values = _read_list(content, 3 * MOST_MESSAGES * len(LEVELS))
    messages = list(zip(values[::3], values[1::3], values[2::3], strict=True))
    if not all(type(t) is float and isfinite(t) and level in LEVELS and type(text) is str for t, level, text in messages):
        raise ValueError("no messages")
    return [(t, level, visible(text[:LONGEST])) for t, level, text in messages]


def read_warnings(content: Any) -> tuple[int, bytes, list[str]]:
    """Code and content of the answer that the warnings came with, and the warnings."""
    code, answer, *texts = _read_list(content, MOST_WARNINGS + 2)
    if type(code) is not int or type(answer) is not bytes or not all(type(text) is str for text in texts):
        raise ValueError("no warnings")
    return code, answer, [visible(text[:LONGEST_TEXT]) for text in texts]


def read_failure(content: Any, unit: str, start: float, end: float) -> Exception:
    """The exception for a failure of this unit, which has been simulated from start to end, s."""
    kind, time, *texts = _read_list(content, 6)
    if not (type(time) is float and isfinite(time) and all(type(text) is str for text in texts)):
        raise ValueError("no failure")
    texts = [text[:LONGEST_TEXT] for text in texts]
    if kind == "BadInput" and len(texts) == 4:
        return BadInput(*texts)
    if kind == "SimulationEnded" and not texts and within(time, start, end):
        return SimulationEnded(unit, time)
    if kind == "StepFailed" and len(texts) == 2:
        return StepFailed(unit, time, *texts)
    raise ValueError("no failure that is known")


def within(time: float, start: float, end: float) -> bool:
    """Whether a time is in a step, but for the rounding of clocks."""
    tolerance = 1e-6 * (end - start) + 1e-12 * abs(end)
    return start - tolerance <= time <= end + tolerance
