"""A component that runs in this process: the fastest kind of unit."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ...components.catalogue import component_class
from ...components.core.component import Component
from ...components.core.contract import KernelComponent
from ...components.core.errors import StepFailed
from ...components.core.kernels import COMPILED
from ..settings import UnitSettings
from .call_names import FAILED, IN_MEMORY
from .call_table import Callback
from .interface import ARRAY_THRESHOLD, CallTable, PortValues, Simulator


def make(name: str, settings: UnitSettings) -> Component:
    """The component of a scene's entry, with its parameters checked."""
    cls = component_class(settings.component, f"units.{name}")
    component = cls(settings.effects, settings.parameters, preset=settings.preset, name=name)
    component.refuse_unused(settings.parameters)
    return component


def _stretch(positions: np.ndarray) -> Any:
    """Positions (n,) as a slice if they follow one another."""
    first = int(positions[0]) if positions.size else 0
    return slice(first, first + positions.size) if (np.diff(positions) == 1).all() else positions


def _addresses(row: np.ndarray, positions: np.ndarray) -> tuple[int, ...]:
    return tuple(row.ctypes.data + row.itemsize * int(k) for k in positions)


def _write_items(row: Any, columns: list[int], values: list[float]) -> None:
    for i, value in zip(columns, values):  # noqa: B905 - strict would take more time than the loop
        row[i] = value


def _write_array(row: np.ndarray, at: Any, values: np.ndarray) -> None:
    row[at] = values


class ComponentSimulator(Simulator):
    """A component as a unit; inputs and outputs are views of the component's own arrays. It has no events and no texts."""

    kind = "in process"
    component: Component

    def __init__(self, name: str, component: Component):
        self.name, self.component = name, component
        self.kernels = component if isinstance(component, KernelComponent) else None
        self.starts = 0  # how often it was initialized; its arrays are others each time

    def wire(self, inputs: Sequence[str], outputs: Sequence[str]) -> None:
        u, y = self.component.u, self.component.y
        if len(inputs) > ARRAY_THRESHOLD:
            at = _stretch(self.component.input_positions(inputs))
            self._rows: Any = [(row, at) for row in u]
            self._write: Any = _write_array
        else:
            columns = self.component.input_positions(inputs).tolist()
            rows: list[Any] = list(u)
            self._rows = [(memoryview(row), columns) for row in rows]  # its items are written twice as fast as an array's
            self._write = _write_items
        places = _stretch(self.component.output_positions(outputs))
        self.get = (lambda: y[places]) if len(outputs) > ARRAY_THRESHOLD else self.reader(outputs)
        self.step = self.component.step
        self.addresses = _addresses(u[0], self.component.input_positions(inputs)), self.outputs_at(outputs)

    def outputs_at(self, names: Sequence[str]) -> tuple[int, ...]:
        return _addresses(self.component.y, self.component.output_positions(names))

    def call_table(self) -> CallTable:
        c = self.component
        self._callbacks: tuple[Callback, ...] = ()
        self.written = None
        if isinstance(c, KernelComponent) and COMPILED:
            assert c.block is not None
            alive: tuple[Any, ...] = (c.block,)
            self.written = [c.block.memory] if type(c).stepped is Component.stepped else None
            outputs, step, argument = c.entry("outputs"), c.entry("step"), c.block.address
        else:

            def refresh(t: float, _: float) -> None:
                c.t = t
                c.refresh()

            alive = self._callbacks = Callback(refresh), Callback(c.step)
            outputs, step, argument = *(callback.function for callback in self._callbacks), 0
        calls = {"step": step, "outputs": outputs, "argument": argument, "row": c.u.strides[0]}
        set_on_change, in_python = (False,) * len(self.addresses[0]), bool(self._callbacks)
        return CallTable(self._stopped, calls, IN_MEMORY, alive, *self.addresses, set_on_change, in_python, c.stepped)

    def _stopped(self, status: int, t: float, h: float) -> None:
        for callback in self._callbacks:
            callback.raise_error()
        self.component._check(status // FAILED)

    def reader(self, names: Sequence[str]) -> Callable[[], list[float]]:
        y, places = self.component.y, _stretch(self.component.output_positions(names))
        if isinstance(places, slice):
            view: Any = y[places]
            view = memoryview(view)
            return view.tolist  # a quarter of the time of picking elements
        return lambda: y[places].tolist()

    def initialize(self, t: float, values: PortValues) -> None:
        self._write(*self._rows[0], values)
        self.component.initialize(t)
        self.starts += 1

    def drive(self, values: PortValues, slopes: PortValues | None, quadratic: PortValues | None, h: float) -> None:
        write, rows = self._write, self._rows
        write(*rows[0], values)
        if slopes is not None:
            write(*rows[1], slopes)
        if quadratic is not None:
            write(*rows[2], quadratic)

    def update(self, values: PortValues) -> None:
        self._write(*self._rows[0], values)
        self.component.refresh()

    def put(self, name: str, value: float | str) -> None:
        self.component.set(name, value)
        if self.starts:
            self.component.refresh()

    def save(self, reuse: bytes | None = None) -> bytes:
        return self.component.save()

    def restore(self, state: bytes) -> None:
        self.component.restore(state)

    def check_step_repeatable(self, h: float) -> None:
        component = self.component
        state, counts, reached = component.save(), component.counts.copy(), []
        try:
            for _ in range(2):
                component.step(component.t, h)
                reached.append(component.save())
                component.restore(state)
        except StepFailed:  # not this step's fault that it is too long
            component.restore(state)
        component.counts[:] = counts
        if len(reached) == 2 and reached[0] != reached[1]:
            raise StepFailed(
                self.name,
                component.t,
                "a step that is repeated from the same state gives another result",
                "Keep everything that a step changes in the component's x",
            )

    def pack(self, state: bytes) -> bytes:
        return state

    def unpack(self, packed: bytes) -> bytes:
        return packed

    def parameters(self) -> dict[str, Any]:
        return dict(self.component.parameters)

    def work(self) -> dict[str, int]:
        return self.component.work
