"""How compiled code calls a unit: addresses as plain numbers, of machine code or of callbacks into Python."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ...components.core.block import ENTRY
from ...components.core.kernels import DONE, RAISED
from . import environment
from .call_names import COMPANIONS, DERIVATIVES, FUNCTIONS, HELD, IN_PYTHON, MEAN, OF_FMU
from .description import Scalar, has_companions
from .interface import CallTable, PortValues, Simulator, port_values
from .values import Block, blocks


class Callback:
    """A function of t and h as function and argument of an entry. Keeps what it has raised."""

    argument = 0
    error: BaseException | None = None

    def __init__(self, python: Callable[[float, float], None]):
        def call(t: float, h: float, _: int | None) -> int:
            try:
                python(t, h)
            except BaseException as error:  # none may pass through compiled code
                self.error = error
                return RAISED
            finally:
                environment.restore()
            return DONE

        self._call = ENTRY(call)
        self.function = ctypes.cast(self._call, ctypes.c_void_p).value or 0

    def raise_error(self) -> None:
        """What it has kept, once."""
        if (error := self.error) is not None:
            self.error = None
            raise error


class Held(NamedTuple):
    """Driven inputs of an FMU that change at instants only."""

    places: Sequence[int]  # among all driven inputs
    values: np.ndarray  # that the FMU has
    hand_over: Callback  # to be called where these have changed


def fmu_table(
    stopped: Callable[[int, float, float], None],
    library: Any,
    instance: int,
    inputs: Sequence[str],
    outputs: Sequence[str],
    interpolates: bool,
    scalars: Mapping[str, Scalar],
    held: Held,
    state: int,
    foreign: bool,
) -> CallTable | None:
    """The call table of an FMU with these driven inputs and read outputs; None where two moving inputs are one variable.

    state: address of the state to be saved before each step; 0: none.  foreign: whether the FMU may leave another
    floating-point environment.
    """

    def address(name: str) -> int:
        return ctypes.cast(library["fmi2" + name], ctypes.c_void_p).value or 0

    moving = [name for k, name in enumerate(inputs) if k not in held.places]
    companions = has_companions(scalars, moving)
    names = [*moving, *(f"der({n})" for n in moving), *(f"der({n},2)" for n in moving)] if companions else moving
    into, out_of = (blocks([scalars[n] for n in part], fmi3=False) for part in (names, outputs))
    if into and not into[0].straight:
        return None
    plain = not out_of or (len(out_of) == 1 and out_of[0].type.suffix == "Real" and out_of[0].straight)
    parts = np.array([] if plain else output_parts(out_of, address), dtype=np.int64)
    orders = (ctypes.c_int * (2 * len(moving)))(*[1] * len(moving), *[2] * len(moving))
    references = [ctypes.addressof(part[0].references) if part else 0 for part in (into, out_of)]
    calls = (
        *map(address, FUNCTIONS.values()),
        instance,
        *references,
        ctypes.addressof(orders),
        held.hand_over.function,
        held.values.ctypes.data,
        0 if plain else len(out_of),
        parts.ctypes.data,
        address("GetFMUstate") if state else 0,
        state,
        environment.CELLS if foreign else 0,
    )
    input_mode = COMPANIONS if companions else DERIVATIVES if interpolates else MEAN
    return CallTable(
        stopped,
        dict(zip(OF_FMU, calls, strict=True)),
        input_mode if moving else HELD,
        (into, out_of, orders, parts, held),
        (0,) * len(inputs),
        (0,) * len(outputs),
        tuple(k in held.places for k in range(len(inputs))),
    )


def output_parts(by_type: Sequence[Block], address: Callable[[str], int]) -> list[int]:
    """Of each block: function, references, their number, buffer, whether it has whole numbers, and the number n of outputs;
    then n times the place among the outputs and the address of the value."""
    cells: list[int] = []
    for block in by_type:
        references, size, buffer = block.arguments
        width = ctypes.sizeof(block.type.c)
        cells += [address("Get" + block.type.suffix), references, size, buffer, block.type.suffix != "Real", len(block.rows)]
        for row, at in zip(block.rows, block.at, strict=True):
            cells += [row, buffer + width * at]
    return cells


def polynomials(links: np.ndarray) -> tuple[PortValues, PortValues | None, PortValues | None]:
    """What inputs are over the step that has begun, as of `Simulator.drive`, of their records."""
    rows = ["value", "slope", "quadratic"][: int(links["degree"][0]) + 1]
    return (*(port_values(links[name]) for name in rows), None, None)[:3]


def python_table(unit: Simulator, links: np.ndarray, outputs: np.ndarray) -> CallTable:
    """Of a unit whose calls are Python's: an FMU of FMI 3.0, for model exchange or in a worker process, a contact.

    The step of a unit in a process of its own begins in `step` and is waited for in `read`. links: the records of its inputs; outputs:
    its part of the table of signals.
    """

    def step(t: float, h: float) -> None:
        if links.size:
            unit.drive(*polynomials(links), h)
        unit.step(t, h)

    def update(t: float, h: float) -> None:
        unit.update(port_values(links["known"]))

    def read(t: float, h: float) -> None:
        outputs[:] = unit.get()

    callbacks = {"step": Callback(step), "outputs": Callback(update), "read": Callback(read)}

    def stopped(status: int, t: float, h: float) -> None:
        for callback in callbacks.values():
            callback.raise_error()

    n, m, calls = links.size, outputs.size, {name: callback.function for name, callback in callbacks.items()}
    return CallTable(stopped, calls, IN_PYTHON, (callbacks,), (0,) * n, (0,) * m, (False,) * n, in_python=True)
