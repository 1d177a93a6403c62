"""Calls of the kernels on the records of a master. A status that a unit returns becomes the exception that says why."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from ctypes import c_double
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple, Protocol

import numpy as np

from ...units.call_table import Callback, polynomials, python_table
from ...units.interface import CallTable, SteppedFmu, port_values
from .memory import Records
from .network import RowRange
from .node import Node
from .records import BEYOND, GIVEN
from .texts import Texts


class Steps(NamedTuple):
    """Macro steps that were taken together, and why there are fewer, if there are."""

    rows: np.ndarray  # (n, S), the signals behind each
    given: np.ndarray = np.zeros(
        (0, 0, len(GIVEN))
    )  # (n, B, 5), of bonded inputs: value, slope, half of the second derivative, degree, jump behind
    inputs: np.ndarray = np.zeros((0, 2, 0))  # (m, 2, L), inputs behind the sampled steps, and the ends of their polynomials
    outputs: np.ndarray = np.zeros((0, 0))  # (n, W), what `watch` has asked for
    saved: Sequence[Any] = ()  # states of the master
    failure: BaseException | None = None


@dataclass
class Space:
    """A batch that is under way: memory for all of its steps, and the number of those that are done."""

    times: np.ndarray
    sampled: np.ndarray
    steps: Steps
    done: int = 0
    beyond: bool = False  # the signals behind the last one have left the limit

    def completed(self, saved: Sequence[Any], failure: BaseException | None) -> Steps:
        """What is done; inputs of all sampled steps."""
        n, steps = self.done, self.steps
        return Steps(steps.rows[:n], steps.given[:n], steps.inputs, steps.outputs[:n], saved, failure)


class Machine:
    """Calls the kernels for the nodes of a network. signals: the table that they share."""

    def __init__(self, nodes: Sequence[Node], records: Records, texts: Texts | None):
        self._nodes, self.records, self.signals = nodes, records, records.memory.signals
        self._begin = [Callback(partial(_begin, node, texts)) for node in nodes]
        for node, callback in zip(nodes, self._begin, strict=True):
            node.unit_record["initialize"] = callback.function
        self._noted: list[tuple[Callable[[float], None], int, int]] = []  # with the cells of the steps taken and of the time
        self.fmus: list[
            tuple[SteppedFmu, int, int, int]
        ] = []  # with the cells of whether a state will come back, of steps, of warnings
        self._tables: list[CallTable] = []  # which keep what addresses point to
        self._watched = np.zeros(0, dtype=np.int64)
        self._under_way: Space | None = None

    def initialize(self, t: float) -> None:
        """Initialize the groups; raises what a unit raises."""
        for node in self._nodes:
            node.of_called[0]["input_mode"] = 0  # memory is laid out anew: nothing has an address yet
        self.records.call("initialize_groups", t)
        if (unit := self.records.answer("unit")) >= 0:
            self._begin[unit].raise_error()

    def address(self) -> None:
        """Find the functions of the initialized units, and where their inputs and outputs lie in memory."""
        records, memory = self.records, self.records.memory
        self._noted.clear()
        self.fmus.clear()
        self._tables.clear()
        for node in self._nodes:
            row, links = node.of_called
            table = node.unit.call_table() or python_table(node.unit, links, memory.signals[node.place])
            row["input_mode"] = table.input_mode
            for name, address in table.calls.items():
                row[name] = address
            links["at"], memory.outputs_at[node.place] = table.inputs_at, table.outputs_at
            links["set_on_change"], row["n_set_on_change"] = table.set_on_change, sum(table.set_on_change)
            taken, time = (records.place("units", node.called, name) for name in ("taken", "time"))
            if table.stepped is not None:
                self._noted.append((table.stepped, taken, time))
            if (fmu := table.fmu) is not None:
                fmu.driven = partial(polynomials, links)
                fmu.time_of_step = partial(records.numbers.__getitem__, time)
                no_return, warned = (records.place("units", node.called, name) for name in ("no_return", "warned"))
                self.fmus.append((fmu, no_return, taken, warned))
            self._tables.append(table)

    def perform(self, rows: RowRange, t: float, h: float) -> None:
        """Take rows of the program, in the step from t to t + h; raises what a unit raises."""
        self.records.take_rows(rows, t, h)
        if self.records.answer("unit") >= 0:
            self._go_on(t, h)

    def step(self, rows: RowRange, t: float, h: float) -> bool:
        """Take the rows of a macro step, and tell the units; returns whether the signals have left the limit."""
        records = self.records
        records.take_rows(rows, t, h, 1)
        if records.integers[records.unit_place] >= 0:
            self._go_on(t, h)
        self.note()
        return records.integers[records.unit_place] == BEYOND

    def _go_on(self, t: float, h: float) -> None:
        """Where the call of a unit has failed, raises the reason; if its step is done all the same, the rest follows."""
        records = self.records
        while (unit := records.answer("unit")) >= 0:
            node = self._nodes[unit]
            begin, length = (float(node.unit_record[name][0]) for name in ("start", "length")) if node.own else (t, h)
            self.note()
            self._tables[unit].stopped(records.answer("status"), begin, length)
            records.ask(first=records.answer("row") + 1, steps=1, times=0, rows=0, sampled_count=0)
            records.call("run_steps", t, h)

    @property
    def in_python(self) -> tuple[str, ...]:
        """Units that are stepped through Python, by name."""
        return tuple(node.unit.name for node, table in zip(self._nodes, self._tables, strict=True) if table.in_python)

    def begin(self) -> None:
        """Before steps: FMUs tell whether a state will come back; raises `SimulationEnded` where one has ended it."""
        for fmu, place, _, _ in self.fmus:
            self.records.integers[place] = fmu.begin_steps()

    def note(self) -> None:
        """Tell the units how far they have come."""
        integers, numbers = self.records.integers, self.records.numbers
        for fmu, _, taken, warned in self.fmus:
            fmu.count(integers[taken], integers[warned])
            integers[warned] = 0
        for stepped, taken, time in self._noted:
            if integers[taken]:
                stepped(numbers[time])
                integers[taken] = 0

    def space(self, times: np.ndarray, sampled: np.ndarray) -> Space:
        """Room for macro steps from each of `times`, s; sampled: as of `Master.take_steps`."""
        n, memory = times.size, self.records.memory
        return Space(
            times,
            sampled,
            Steps(
                np.empty((n, memory.inverse.size)),
                np.empty((n, memory.bonded.size, len(GIVEN))),
                np.empty((sampled.size, 2, self.records.driven)),
                np.empty((n, self._watched.size)),
            ),
        )

    def take_batch(self, rows: RowRange, space: Space, h: float, last: int) -> BaseException | None:
        """The macro steps up to the `last`, in one call; returns why there are fewer."""
        records, steps, first = self.records, space.steps, space.done
        before = int(np.searchsorted(space.sampled, first))
        times, sampled = space.times[first:last], space.sampled[before:] - first
        into = {
            "rows": steps.rows[first:],
            "given": steps.given[first:],
            "inputs": steps.inputs[before:],
            "outputs": steps.outputs[first:],
            "times": times,
            "sampled": sampled,
            "watched": self._watched,
        }
        try:
            self.begin()
            records.ask(
                first=rows[0],
                last=rows[1],
                steps=times.size,
                whole=1,
                sampled_count=sampled.size,
                driven=records.driven,
                watches=self._watched.size,
                **{n: a.ctypes.data for n, a in into.items()},
            )
            self._under_way = space
            records.call("run_steps", 0.0, h)
            self._under_way = None
            records.ask(rows=0, sampled_count=0)  # nothing is wanted of single steps
            space.done += records.answer("done")
            if records.answer("unit") >= 0:
                self._go_on(float(space.times[space.done]), h)
                self._keep(space)
                space.done += 1
            self.note()
        except (Exception, SystemExit) as error:  # those of Python in a unit, too: the steps before it stand
            return error
        space.beyond = records.answer("unit") == BEYOND
        return None

    def so_far(self) -> Steps:
        """What has been completed of the batch that is under way, where one is."""
        if (space := self._under_way) is None:
            return self.space(np.zeros(0), np.zeros(0, dtype=np.int64)).steps
        space.done += self.records.answer("done")
        return space.completed((), None)

    def _keep(self, space: Space) -> None:
        """What a batch wants of the step that has just been completed otherwise."""
        steps, memory = space.steps, self.records.memory
        steps.rows[space.done] = memory.signals[: memory.inverse.size]
        steps.given[space.done] = self.given()
        steps.inputs[space.sampled == space.done] = self.inputs()
        steps.outputs[space.done] = [c_double.from_address(address).value for address in self._watched.tolist()]

    def watch(self, addresses: Sequence[int]) -> slice:
        """Columns of `Steps.outputs` in which the numbers at these addresses will stand."""
        first = self._watched.size
        self._watched = np.array([*self._watched, *addresses], dtype=np.int64)
        return slice(first, self._watched.size)

    def watch_nothing(self) -> None:
        """Forget what was watched."""
        self._watched = self._watched[:0]

    def given(self) -> np.ndarray:
        """What bonded inputs were given in the last step, (B, 5), as of `Steps`."""
        links = self.records.memory.links[self.records.memory.bonded]
        return np.stack([links[name] for name in GIVEN], axis=1)

    def inputs(self) -> np.ndarray:
        """All inputs behind the last step, in the order of the nodes' links, and the ends of their polynomials, (2, L)."""
        links = self.records.memory.links[: self.records.driven]
        return np.stack([links["now"], links["reached"]])


def _begin(node: Node, texts: Texts | None, t: float, _: float) -> None:
    """Initialize a unit with its present inputs, and read its outputs."""
    if texts is not None:
        texts.give(node.unit.name)
    node.unit.initialize(t, port_values(node.link_records["looked"]))
    node.read()
    if texts is not None:
        texts.read(node.unit.name)


class Signals(Protocol):
    """What has a table of signals."""

    positions: Any
    sample: Any


class Stepper(Protocol):
    """What takes single macro steps."""

    def step(self, t: float, h: float) -> None:
        """One macro step from t to t + h."""


def singly(stepper: Stepper, master: Signals, times: np.ndarray, h: float) -> Steps:
    """Macro steps one by one, with the master's signals behind each."""
    rows: list[list[float]] = []
    failure: BaseException | None = None
    try:
        for t in times.tolist():
            stepper.step(t, h)
            rows.append(master.sample())
    except (Exception, SystemExit) as error:
        failure = error
    return Steps(np.array(rows).reshape(len(rows), len(master.positions)), failure=failure)
