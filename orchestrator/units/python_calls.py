"""Units that compiled code steps through Python."""

from __future__ import annotations

from typing import Any

import numpy as np

from .call_names import IN_PYTHON
from .call_table import CallTable
from .callback import Callback
from .interface import Simulator, port_values


class PythonCalls:
    """Entries of a unit whose calls are Python's: an FMU of FMI 3.0, for model exchange or in a worker process, a contact.

    The step of a unit in a process of its own begins in `step` and is waited for in `read`.
    """

    def __init__(self, unit: Simulator, links: np.ndarray, outputs: np.ndarray):
        """links: the records of its inputs; outputs: its part of the table of signals."""

        def step(t: float, h: float) -> None:
            if links.size:
                degree = links["degree"][0]
                rows = ["value", "slope", "half"][: int(degree) + 1]
                values, slopes, halves = (*(port_values(links[name]) for name in rows), None, None)[:3]
                unit.drive(values, slopes, halves, h)
            unit.step(t, h)

        def update(t: float, h: float) -> None:
            unit.update(port_values(links["known"]))

        def read(t: float, h: float) -> None:
            outputs[:] = unit.get()

        self._callbacks = {"step": Callback(step), "outputs": Callback(update), "read": Callback(read)}
        self._n, self._m = links.size, outputs.size

    def call_table(self) -> CallTable:
        """For the master."""
        calls = {name: callback.function for name, callback in self._callbacks.items()}
        return CallTable(calls, IN_PYTHON, (self,), (0,) * self._n, (0,) * self._m, (False,) * self._n, True)

    def stepped(self, steps: int, t: float) -> None:
        """The unit knows."""

    def stopped(self, status: int, t: float, h: float) -> None:
        """A callback has failed; raises what it has raised."""
        for callback in self._callbacks.values():
            callback.raise_error()


def calls_of(unit: Any, links: np.ndarray, outputs: np.ndarray) -> tuple[Any, CallTable]:
    """What has `stepped` and `stopped` of a unit, and its call table; links, outputs: as of `PythonCalls`."""
    table = unit.call_table() if hasattr(unit, "call_table") else None
    if table is not None:
        return unit, table
    python = PythonCalls(unit, links, outputs)
    return python, python.call_table()
