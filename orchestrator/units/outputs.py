"""The outputs of an FMU: buffers made once, one call of the library for all outputs of a type; and their derivatives."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from .description import Scalar
from .inputs import WARNING, Functions
from .interface import PortValues
from .values import EXACT, Block, blocks, signature


def reader(
    names: Sequence[str],
    arrays: bool,
    inexact: Callable[[str, int], None],
    scalars: Mapping[str, Scalar],
    fmi3: bool,
    instance: Any,
    functions: Functions,
    failed: Callable[[int], None],
) -> Callable[[], PortValues]:
    """A function that gives the present values of some outputs, as a list or with `arrays` as an array.

    `failed` gets a bad status, `inexact` the name and value of a whole number that no float can stand for.
    """
    if not names:
        return list
    by_type = blocks([scalars[n] for n in names], fmi3)
    calls = [(functions("Get" + b.type.suffix, *signature(fmi3)), (instance, *b.arguments), b.buffer) for b in by_type]
    if len(by_type) == 1 and by_type[0].straight and by_type[0].type.c is ctypes.c_double:
        return _of_reals(*calls[0], by_type[0], arrays, failed)
    picks, long, offset = [0] * len(names), {}, 0
    for block in by_type:
        for row, at in zip(block.rows, block.at, strict=True):
            picks[row] = offset + at
            if block.type.high > EXACT:
                long[names[row]] = offset + at
        offset += block.size

    def read(_alive: list[Block] = by_type) -> PortValues:  # the arguments are addresses in them
        raw: list[Any] = []
        for call, arguments, buffer in calls:
            status = call(*arguments)
            if status > WARNING:
                failed(status)
            raw += buffer[:]
        for name, k in long.items():
            if abs(raw[k]) > EXACT:
                inexact(name, raw[k])
        values = [float(raw[k]) for k in picks]
        return np.array(values) if arrays else values

    return read


def _of_reals(
    call: Callable[..., int], arguments: tuple[Any, ...], buffer: Any, block: Block, arrays: bool, failed: Callable[[int], None]
) -> Callable[[], PortValues]:
    """Reals of 64 bits in the order of the buffer: nothing is to be picked or converted."""
    values = np.ctypeslib.as_array(buffer) if arrays else None

    def read(_alive: Block = block) -> PortValues:  # the arguments are addresses in it
        status = call(*arguments)
        if status > WARNING:
            failed(status)
        return buffer[:] if values is None else values

    return read


def derivatives(
    outputs: Sequence[str],
    inputs: Sequence[str],
    scalars: Mapping[str, Scalar],
    fmi3: bool,
    instance: Any,
    functions: Functions,
    failed: Callable[[int], None],
) -> np.ndarray:
    """Of outputs with respect to inputs at this instant, (outputs, inputs), one directional derivative for each real input.

    What changes at instants only has none, which is 0 here.
    """
    result = np.zeros((len(outputs), len(inputs)))
    rows, columns = ([k for k, n in enumerate(names) if not scalars[n].discrete] for names in (outputs, inputs))
    if not (rows and columns):
        return result
    unknowns, knowns = (
        Block.of_derivatives([scalars[names[k]] for k in places], fmi3) for names, places in ((outputs, rows), (inputs, columns))
    )
    pointer, size = ctypes.c_void_p, ctypes.c_size_t
    extra = (size,) if fmi3 else ()
    derive = functions("GetDirectionalDerivative", pointer, size, pointer, size, pointer, *extra, pointer, *extra)
    arguments = (instance, *unknowns.arguments[:2], *knowns.arguments, *unknowns.arguments[2:])
    for column, at in zip(columns, knowns.at, strict=True):
        knowns.buffer[at] = 1.0
        status = derive(*arguments)
        if status > WARNING:
            failed(status)
        knowns.buffer[at] = 0.0
        result[rows, column] = [unknowns.buffer[k] for k in unknowns.at]
    return result
