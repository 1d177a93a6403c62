"""The block of a master, and how Python calls the kernels on it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from ctypes import CFUNCTYPE, c_double, c_int32, c_void_p
from functools import cached_property
from typing import Any

import numpy as np

from ....components.core.block import CELL, Block, Entry
from ....components.core.kernels import COMPILED, RAISED
from .fault_kernels import begin_change, end_change
from .initial_kernels import ROWS, initialize_groups
from .kernels import run_steps
from .records import (
    ANSWER,
    FAULT,
    FAULT_END,
    FAULT_END_STATE,
    FAULT_STATE,
    GROUP,
    LINK,
    LINK_STATE,
    PAST,
    PAST_STATE,
    REQUEST,
    SECANTS,
    UNIT,
    UNIT_STATE,
    Memory,
)

HEAD = 5  # fields at the beginning of `REQUEST`, up to `whole`
KERNELS: dict[str, Any] = {"run_steps": run_steps, "initialize_groups": initialize_groups}
OF_FAULTS: dict[str, Any] = {"begin_change": begin_change, "end_change": end_change}
RAW = CFUNCTYPE(c_int32)  # an entry that is given its arguments as those of C
KERNEL_RAISED = "a kernel of the loop has raised an exception"
_ENTRIES: dict[tuple[Any, ...], Entry] = {}  # of the kernels, for each layout in this process


class Records:
    """The block of a master; `memory` has views of it, as kernels get them.

    integers, numbers: its cells, and `place` that of a field of a record among them.
    """

    def __init__(
        self,
        units: int,
        links: int,
        pasts: int,
        program: Sequence[tuple[int, int]],
        weights: Sequence[float],
        bonded: Sequence[int],
        signals: int,
        driven: int,
        groups: Sequence[tuple[Sequence[int], Sequence[tuple[int, bool, float]]]],
        faults: Sequence[int] = (),
    ):
        """units, links, pasts: numbers of records; program: rows of (act, unit);
        weights: 1 / nominal of every output; bonded: links; signals: cells of the table; driven: inputs of all units;
        groups: units of each in the order of their initialization, and its outputs, as of `records.ANSWER`; faults: inputs of
        each."""

        def whole(values: Sequence[Any], *shape: int) -> np.ndarray:
            return np.array(values, dtype=np.int64).reshape(*shape)

        zeros, inverse = np.zeros, np.array(weights, dtype=float)
        records = (zeros(n, dtype) for n, dtype in ((1, REQUEST), (units, UNIT), (links, LINK), (pasts, PAST)))
        begin = Memory(
            *records,
            whole(program, -1, 2),
            zeros(inverse.size, np.int64),
            inverse,
            whole(bonded, -1),
            zeros(signals),
            zeros(3 * links),
            zeros(len(groups), GROUP),
            whole([unit for members, _ in groups for unit in members], -1),
            np.array([answer for _, answers in groups for answer in answers], dtype=ANSWER),
            zeros((ROWS, max(SECANTS, *widths)) if (widths := [len(a) for g, a in groups if len(g) > 1]) else (0, 0)),
            zeros(SECANTS, np.int64),
            zeros(len(faults), FAULT),
            zeros(sum(faults), FAULT_END),
        )
        begin.faults["last"] = np.cumsum(faults, dtype=np.int64)
        begin.faults["first"] = begin.faults["last"] - np.array(faults, dtype=np.int64)
        members, answers = 0, 0
        for row, (units_of_group, answers_of_group) in zip(begin.groups, groups, strict=True):
            row["first"], row["last"] = members, members + len(units_of_group)
            row["first_answer"], row["answers"] = answers, len(answers_of_group)
            members, answers = members + len(units_of_group), answers + len(answers_of_group)
        times = ("double %t", "double %h")
        self.block, self.driven = Block(begin, (), (), dict.fromkeys(KERNELS | OF_FAULTS, times)), driven
        self.memory = self.block.s if COMPILED else Memory(*(a.view(np.recarray) if a.dtype.names else a for a in self.block.s))
        self.integers, self.numbers = _cells(self.block.memory.view(np.int64)), _cells(self.block.memory)
        first = self.place("request", 0, "first")
        self._head = slice(first, first + HEAD)
        self._heads: tuple[dict[tuple[int, int], Any], ...] = {}, {}  # the first fields of the request, for single steps
        self._requested = {name: self.place("request", 0, name) for name in REQUEST.names or ()}
        self.unit_place = self._requested["unit"]
        self._calls: dict[str, Callable[..., int]] = {}  # the kernels
        self._times = c_double(), c_double(), c_void_p(self.block.address)  # what they get; made once, half of the time of a call

    def place(self, array: str, k: int, field: str) -> int:
        """The cell of a field of the k-th record of an array."""
        offset: int = getattr(self.memory, array).dtype.fields[field][1]
        return self.block.cell("s", array) + (k * getattr(self.memory, array).dtype.itemsize + offset) // CELL

    @cached_property
    def changing(self) -> np.ndarray:
        """Cells that steps change: fields that `records` marks, and the table of signals, (n,)."""
        memory, states = self.memory, {"units": UNIT_STATE, "links": LINK_STATE, "pasts": PAST_STATE}
        states |= {"faults": FAULT_STATE, "fault_ends": FAULT_END_STATE}
        places = [
            self.place(array, 0, name) + np.arange(getattr(memory, array).size) * (getattr(memory, array).dtype.itemsize // CELL)
            for array, names in states.items()
            for name in names
            if getattr(memory, array).size
        ]
        return np.concatenate([*places, self.block.cell("s", "signals") + np.arange(memory.signals.size)])

    def ask(self, **fields: int) -> None:
        """Write into the request."""
        integers, places = self.integers, self._requested
        for name, value in fields.items():
            integers[places[name]] = value

    def take_rows(self, rows: tuple[int, int], t: float, h: float, whole: int = 0) -> None:
        """Call the kernel for some rows of the program, in the step from t to t + h; whole: whether they are a macro step."""
        if (head := self._heads[whole].get(rows)) is None:  # one write of all takes a fifth of the time
            head = self._heads[whole][rows] = _cells(np.array([*rows, 1, 0, whole], dtype=np.int64))
        self.integers[self._head] = head
        times = self._times  # from here as of `call`: this is in every step
        times[0].value, times[1].value = t, h
        if (self._calls.get("run_steps") or self._prepare("run_steps"))(*times) == RAISED:
            raise RuntimeError(KERNEL_RAISED)

    def answer(self, field: str) -> int:
        """A field of the request."""
        return self.integers[self._requested[field]]

    def call(self, name: str, t: float, h: float = 0.0) -> None:
        """Call a kernel of `KERNELS` or `OF_FAULTS`."""
        times = self._times
        times[0].value, times[1].value = t, h
        if (self._calls.get(name) or self._prepare(name))(*times) == RAISED:
            raise RuntimeError(KERNEL_RAISED)

    def _prepare(self, name: str) -> Callable[..., int]:
        """A kernel, compiled if need be, as a function of times and the block."""
        memory, kernel = self.memory, (KERNELS | OF_FAULTS)[name]
        if COMPILED:
            key = name, *(array.shape for array in memory)
            if key not in _ENTRIES:
                _ENTRIES[key] = self.block.entry(name, kernel, (memory,))
            self._calls[name] = RAW(self.block.take(name, _ENTRIES[key]))
        else:
            self._calls[name] = lambda t, h, _: kernel(t.value, h.value, memory)
        return self._calls[name]

    def wanted(self) -> list[tuple[Any, int, tuple[Any, ...]]]:
        """Of each kernel that every run calls, what its machine code is made for."""
        return [self.block.wanted(name, kernel, (self.memory,)) for name, kernel in KERNELS.items()]

    def with_changing(self, numbers: np.ndarray) -> np.ndarray:
        """The block with other numbers in the cells that are `changing`; raises `ValueError` for those of another scene."""
        if numbers.dtype != np.int64 or numbers.shape != self.changing.shape:
            raise ValueError(f"a master of {numbers.size} cells, not {self.changing.size}")
        cells = self.block.memory.copy()
        cells.view(np.int64)[self.changing] = numbers
        return cells


def _cells(array: Any) -> Any:
    """An array whose items Python reads and writes twice as fast."""
    return memoryview(array)
