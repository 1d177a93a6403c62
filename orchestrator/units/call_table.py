"""What compiled code needs of a unit to call it without Python: addresses, as plain numbers."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from .description import Scalar, has_companions
from .values import blocks

HELD, COMPANIONS, DERIVATIVES, MEAN = range(4)  # ways to give an FMU inputs that change over a step, see `inputs`
IN_MEMORY = 4  # a component's inputs are written where they lie
FUNCTIONS = {"get": "GetReal", "set": "SetReal", "set_derivatives": "SetRealInputDerivatives", "do_step": "DoStep"}
# what `CallTable.calls` has: of an FMU addresses of functions, the instance, the references of inputs and outputs, and the orders
# 1 ... 1, 2 ... 2 of inputs; of a component functions with their arguments, and the distance of two rows of inputs, bytes
OF_FMU = (*FUNCTIONS, "instance", "input_references", "output_references", "orders")
OF_COMPONENT = ("outputs", "outputs_argument", "step", "step_argument", "row")


@dataclass(frozen=True)
class CallTable:
    """Addresses by name, and where the driven inputs and the read outputs of a component lie."""

    calls: Mapping[str, int]
    way: int
    alive: tuple[Any, ...]  # the memory that addresses point to
    inputs_at: tuple[int, ...]
    outputs_at: tuple[int, ...]


def call_table(library: Any, instance: int, inputs: Sequence[str], outputs: Sequence[str], interpolates: bool,
               scalars: Mapping[str, Scalar]) -> CallTable | None:
    """The call table of an FMU with these driven inputs and read outputs; None where they are not all reals of their own."""
    companions = has_companions(scalars, inputs)
    names = [*inputs, *(f"der({n})" for n in inputs), *(f"der({n},2)" for n in inputs)] if companions else inputs
    parts = [blocks([scalars[n] for n in part], fmi3=False) for part in (names, outputs)]
    if any(len(part) > 1 or (part and not (part[0].type.suffix == "Real" and part[0].straight)) for part in parts):
        return None
    orders = (ctypes.c_int * (2 * len(inputs)))(*[1] * len(inputs), *[2] * len(inputs))
    references = [ctypes.addressof(part[0].references) if part else 0 for part in parts]
    calls = [ctypes.cast(library["fmi2" + name], ctypes.c_void_p).value or 0 for name in FUNCTIONS.values()]
    way = COMPANIONS if companions else DERIVATIVES if interpolates else MEAN
    addresses = dict(zip(OF_FMU, (*calls, instance, *references, ctypes.addressof(orders)), strict=True))
    return CallTable(addresses, way if inputs else HELD, (parts, orders), (0,) * len(inputs), (0,) * len(outputs))
