"""The driven inputs of an FMU: buffers made once, one call of the library for all inputs of a type.

Inputs that change over a step are given by the best of four methods: by companion inputs "der(x)" and "der(x,2)" (our own
FMUs have them); by fmi2SetRealInputDerivatives where the FMU says canInterpolateInputs; whenever the FMU asks for them by
the intermediate update of FMI 3; else the mean of the polynomial over the step is held: the unit then receives the right
impulse, and the second order of the coupling survives.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from ...components.core.errors import StepFailed
from .description import Scalar, has_companions
from .interface import ARRAY_THRESHOLD, PortValues
from .values import Block, blocks, signature

Call = Callable[..., int]
Functions = Callable[..., Call]  # of a library: name without its prefix, types of the arguments behind the instance
WARNING = 1  # the highest status with which a call has done its work


class Reals:
    """Inputs of 64 bits that may change over a step. `given`: the polynomials of the last `drive`."""

    given: Sequence[Any] = (None, None, None)

    def __init__(
        self,
        names: Sequence[str],
        interpolates: bool,
        scalars: Mapping[str, Scalar],
        fmi3: bool,
        instance: Any,
        functions: Functions,
        failed: Callable[[int], None],
    ):
        n, pointer = len(names), ctypes.c_void_p
        self._n, self._failed, self._interpolates = n, failed, interpolates
        self._companions = has_companions(scalars, names)
        all_names = [*names, *(f"der({i})" for i in names), *(f"der({i},2)" for i in names)] if self._companions else names
        self.block = block = blocks([scalars[i] for i in all_names], fmi3)[0]
        self._set = functions("Set" + block.type.suffix, *signature(fmi3))
        listed = n <= ARRAY_THRESHOLD and block.straight  # a list is stored in the buffer faster than in an array over it
        self._target: Any = block.buffer if listed else np.ctypeslib.as_array(block.buffer)
        at = np.array(block.at)
        self._places = [slice(k * n, k * n + n) if block.straight else at[k * n : k * n + n] for k in range(3)]
        self._arguments = [
            (instance, *block.first(k * n)) if self._companions else (instance, *block.arguments) for k in (1, 2, 3)
        ]
        if interpolates:
            self._orders = [(ctypes.c_int * n)(*[k] * n) for k in (1, 2)]
            references, size, buffer = block.arguments[:3]
            self._set_derivatives = functions("SetRealInputDerivatives", pointer, ctypes.c_size_t, pointer, pointer)
            self._derivatives = [(instance, references, size, ctypes.addressof(o), buffer) for o in self._orders]

    def write(self, values: PortValues) -> None:
        """The inputs have these values now."""
        self._target[self._places[0]] = values
        status = self._set(*self._arguments[0])
        if status > WARNING:
            self._failed(status)

    def drive(self, values: PortValues, slopes: PortValues | None, quadratic: PortValues | None, h: float) -> None:
        """As `Simulator.drive`."""
        self.given = values, slopes, quadratic
        target, places, arguments = self._target, self._places, self._arguments[0]
        if slopes is None:
            target[places[0]] = values
        elif self._companions:
            target[places[0]], target[places[1]], arguments = values, slopes, self._arguments[1]
            if quadratic is not None:
                target[places[2]], arguments = [2.0 * c for c in quadratic], self._arguments[2]
        elif self._interpolates:
            self.write(values)
            second = None if quadratic is None else [2.0 * c for c in quadratic]
            for call, derivatives in zip(self._derivatives, (slopes, second), strict=True):
                if derivatives is not None:
                    target[places[0]] = derivatives
                    status = self._set_derivatives(*call)
                    if status > WARNING:
                        self._failed(status)
            return
        else:
            target[places[0]] = means(values, slopes, quadratic, h)
        status = self._set(*arguments)
        if status > WARNING:
            self._failed(status)

    def drive_part(self, s: float, h: float) -> None:
        """The polynomials over h, from s behind the beginning of the step on; nothing where the inputs are held."""
        values, slopes, quadratic = given = self.given
        if slopes is not None:
            second = [0.0] * self._n if quadratic is None else quadratic
            terms = list(zip(values, slopes, second, strict=True))
            self.drive([v + s * (a + s * b) for v, a, b in terms], [a + 2.0 * s * b for _, a, b in terms], quadratic, h)
            self.given = given


class Requested(Reals):
    """Reals of FMI 3 that the FMU asks for inside a step, wherever it needs them: they follow their polynomials there."""

    def __init__(self, names: Sequence[str], *common: Any):
        super().__init__(names, False, *common)
        self._terms: list[tuple[float, float, float]] = []
        self._worst = 0

    def drive(self, values: PortValues, slopes: PortValues | None, quadratic: PortValues | None, h: float) -> None:
        self.write(values)
        second = quadratic if quadratic is not None else [0.0] * self._n
        self._terms = [] if slopes is None else list(zip(values, slopes, second, strict=True))

    def move(self, s: float) -> None:
        """The inputs at s after the beginning of the step; a bad status waits for `stepped`, an exception would be lost here."""
        if self._terms:
            self._target[self._places[0]] = [v + s * (a + s * b) for v, a, b in self._terms]
            self._worst = max(self._worst, self._set(*self._arguments[0]))

    def stepped(self) -> None:
        """The step is over: the inputs stay where they are."""
        self._terms = []
        if self._worst > WARNING:
            self._failed(self._worst)


def means(values: PortValues, slopes: PortValues, quadratic: PortValues | None, h: float) -> list[float]:
    """Of the polynomials over a step."""
    if quadratic is None:
        return [v + h * (s / 2.0) for v, s in zip(values, slopes, strict=True)]
    return [v + h * (s / 2.0 + h * c / 3.0) for v, s, c in zip(values, slopes, quadratic, strict=True)]


class Others:
    """Inputs of all other types, and reals that change at instants only: values are held over a step."""

    def __init__(
        self,
        name: str,
        names: Sequence[str],
        scalars: Mapping[str, Scalar],
        fmi3: bool,
        instance: Any,
        functions: Functions,
        failed: Callable[[int], None],
    ):
        self._name, self._names, self._failed = name, names, failed
        self.blocks = blocks([scalars[n] for n in names], fmi3)
        self._calls = [(functions("Set" + b.type.suffix, *b.argument_types), (instance, *b.arguments)) for b in self.blocks]

    def write(self, values: Sequence[Any], t: float) -> None:
        """The inputs have these values from t on; raises `StepFailed` for a number that the type cannot hold."""
        for block, (call, arguments) in zip(self.blocks, self._calls, strict=True):
            for row, at in zip(block.rows, block.at, strict=True):
                block.put(at, self._fitting(block, row, values[row], t))
            status = call(*arguments)
            if status > WARNING:
                self._failed(status)

    def _fitting(self, block: Block, row: int, value: Any, t: float) -> Any:
        type_ = block.type
        if type_.high:
            if not type_.low <= value <= type_.high or value != int(value):  # the first holds for no NaN
                raise StepFailed(
                    self._name,
                    t,
                    f"input {self._names[row]} cannot be {value:.9g}: it holds whole numbers from {type_.low} to {type_.high}",
                    "" if value == value else "Where its connection has a map, give it an entry for every value.",
                )
            return int(value)
        if type_.suffix == "Binary":
            return value
        return value.encode() if isinstance(value, str) else bool(value) if type_.suffix == "Boolean" else value
