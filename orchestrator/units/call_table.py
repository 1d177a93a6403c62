"""What compiled code needs of a unit to call it without Python: addresses, as plain numbers."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from .call_names import COMPANIONS, DERIVATIVES, FUNCTIONS, HELD, MEAN, OF_FMU
from .callback import Callback
from .description import Scalar, has_companions
from .values import Block, blocks


@dataclass(frozen=True)
class CallTable:
    """Addresses by name; where the driven inputs and the read outputs of a component lie; which inputs of an FMU are held."""

    calls: Mapping[str, int]
    way: int
    alive: tuple[Any, ...]  # the memory that addresses point to
    inputs_at: tuple[int, ...]
    outputs_at: tuple[int, ...]
    apart: tuple[bool, ...]
    in_python: bool = False  # whether a step goes through it


class Held(NamedTuple):
    """Driven inputs of an FMU that change at instants only."""

    places: Sequence[int]  # among all driven inputs
    values: np.ndarray  # that the FMU has
    hand_over: Callback  # to be called where these have changed


def call_table(
    library: Any,
    instance: int,
    inputs: Sequence[str],
    outputs: Sequence[str],
    interpolates: bool,
    scalars: Mapping[str, Scalar],
    held: Held,
) -> CallTable | None:
    """The call table of an FMU with these driven inputs and read outputs; None where two moving inputs are one variable."""

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
    )
    way = COMPANIONS if companions else DERIVATIVES if interpolates else MEAN
    return CallTable(
        dict(zip(OF_FMU, calls, strict=True)),
        way if moving else HELD,
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
