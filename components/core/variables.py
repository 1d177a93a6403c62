"""Declared variables: one line on the class gives name, start, unit, description and limits.

The component's interface, the FMU's model description, the checks of a scene and the tests all derive from that line.

Ports are signals that go to one partner together, as FMUs have them as terminals and drawings as one line. A component declares
them on its class, own signals by name and all those of an effect as "effect.*":

    ports = {"shaft": ("displacement_x", "displacement_y", "linearisation.*")}

What no declared port takes is a port of its effect; own signals that are left over are the port "". Where a partner calls a
signal otherwise, the component says what it is called within its ports: `port_members = {"wire_compliance": "contact_compliance"}`.
"""

from __future__ import annotations

import enum
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from numbers import Real
from typing import Any

import numpy as np

from .errors import BadInput, decimal_point
from .measure import OTHERWISE, is_quantity, number_in, parse

Declared = Mapping[str, tuple[str, ...]]  # port -> own signals, and effects as "effect.*"


class Causality(enum.Enum):
    """Who sets a variable: the user before the run, a partner during it, or the component itself."""

    PARAMETER = "parameter"
    INPUT = "input"
    OUTPUT = "output"


class Kind(enum.Enum):
    """The kind of values of a variable."""

    REAL = "real"
    INTEGER = "integer"
    BOOLEAN = "boolean"
    CHOICE = "choice"
    TEXT = "text"


MESHES = {
    "shorter": "the length of elements",
    "more": "the number of elements",
    "random": "the number of random parts, of which each number has others",
}
SEED = "a seed"  # selects one of many equally likely histories
PARTS = "parts of the machine"
NUMBERED = "one of several parts"  # by its number
STRUCTURAL = {Kind.INTEGER: "a count", Kind.CHOICE: "a choice between models", Kind.TEXT: "a table as long as its text"}


USUAL = {"rad": (-4.0 * math.pi, 4.0 * math.pi)}  # where a variable does not say it


@dataclass(frozen=True)
class Variable:
    """One declared variable; `name` carries the effect it belongs to ("bump_stops.stiffness")."""

    causality: Causality
    kind: Kind
    start: float | int | str | tuple[float, ...]
    unit: str
    text: str
    low: float = -math.inf
    high: float = math.inf
    # of a real parameter: what is met in practice; a number beyond is probably in another unit, of which `doubt` tells
    usual: tuple[float, float] | None = None
    nominal: float = 1.0
    size: int = 0  # 0: a scalar; n: an array that appears as name[1] ... name[n]
    choices: tuple[str, ...] = ()
    feedthrough: tuple[str, ...] = ()  # of an output: the inputs it depends on directly, without a step between, whatever is on
    moving: bool = False  # of an input: a place that moves on, which is wrong where it is held over a step
    held: bool = False  # of an output: it keeps its value between samples, as its component says of all of them
    # of a parameter that decides how large the component's memory is, or which of several models it is: why; a native FMU has the
    # value of its build. Whole numbers, choices and texts always are such parameters.
    structural: str = ""
    # of a real parameter: it may change during a run, and acts from the next step on; only where a change has a meaning, and where
    # nothing that initialization computes follows from it but the state
    tunable: bool = False
    # of a structural parameter that is a discretisation: which way it gets finer, `MESHES`
    mesh: str = ""
    name: str = ""

    def __set_name__(self, owner: type, name: str) -> None:
        object.__setattr__(self, "name", name)
        parse(self.unit, f"{owner.__name__}.{name}")

    def __get__(self, component: Any, owner: type | None = None) -> Any:
        """Of a class the declaration; of a component the present value, of an array all of them, (n,)."""
        if component is None:
            return self
        if self.name in vars(component):  # what the component itself calls so
            return vars(component)[self.name]
        values = [component.get(scalar.name) for scalar in self.scalars]
        return np.array(values) if self.size else values[0]

    def __set__(self, component: Any, value: Any) -> None:
        """An output gets a value; with the name of any other variable a component may call something of its own."""
        if self.causality is not Causality.OUTPUT or not hasattr(component, "_used") or self.name in vars(component):
            vars(component)[self.name] = value
            return
        first = component.output_positions([self.scalars[0].name])[0]
        component.y[first : first + max(self.size, 1)] = value

    def __post_init__(self) -> None:
        if self.kind is Kind.REAL:
            start = tuple(map(float, self.start)) if isinstance(self.start, tuple) else float(self.start)
            object.__setattr__(self, "start", start)
        if self.causality is Causality.PARAMETER and not self.structural and (self.mesh or self.kind is not Kind.REAL):
            object.__setattr__(self, "structural", MESHES.get(self.mesh) or STRUCTURAL[self.kind])

    @property
    def discrete(self) -> bool:
        """Of an input or an output: whether it changes at instants only."""
        return self.held or self.kind is not Kind.REAL

    @cached_property
    def scalars(self) -> tuple[Variable, ...]:
        """The variable itself, or the elements of an array as variables of their own (counted from 1)."""
        if not self.size:
            return (self,)
        starts = self.start if isinstance(self.start, tuple) else (self.start,) * self.size
        return tuple(replace(self, name=f"{self.name}[{i + 1}]", start=s, size=0) for i, s in enumerate(starts))

    def number_of(self, value, where: str):
        """The value; of a text such as "250 km/h" for a real variable the number in the variable's unit, or `BadInput`."""
        return number_in(value, self.unit, where) if self.kind is Kind.REAL and is_quantity(value) else value

    def doubt(self, value) -> str:
        """The question which unit was meant, of a value beyond what is met in practice; "" of others."""
        low, high = self.usual or USUAL.get(self.unit, (-math.inf, math.inf))
        if self.kind is not Kind.REAL or not isinstance(value, Real) or low <= float(value) <= high:
            return ""
        other = OTHERWISE[self.unit]
        return f"{value:g} {other} or {value:g} {self.unit}? {low:g} to {high:g} {self.unit} are usual"

    def checked(self, value, where: str):
        """`value` in this variable's type and within its limits, or `BadInput`."""
        actual = f"{self.name} = {value!r}"
        if self.kind is Kind.CHOICE:
            if value not in self.choices:
                raise BadInput(where, actual, "one of " + ", ".join(self.choices))
            return value
        if self.kind is Kind.TEXT:
            if not isinstance(value, str):
                raise BadInput(where, actual, "a text", self.text[:1].upper() + self.text[1:] + ".")
            return value
        value = self.number_of(value, f"{where}.{self.name}")
        number = isinstance(value, Real) and not isinstance(value, bool)
        if not number or (self.kind is Kind.INTEGER and not float(value).is_integer()):
            expected = "a whole number" if self.kind is Kind.INTEGER else f"a number in {self.unit}"
            raise BadInput(where, actual, expected, decimal_point(value))
        if not self.low <= value <= self.high or not math.isfinite(value):
            unit = "" if self.unit == "1" else f" {self.unit}"
            limited = math.isfinite(self.low) or math.isfinite(self.high)
            expected = f"a value in [{self.low:g}, {self.high:g}]{unit}" if limited else "a finite number"
            raise BadInput(where, actual, expected, self.text[:1].upper() + self.text[1:] + ".")
        return int(value) if self.kind is Kind.INTEGER else float(value)


def parameter(start: float | tuple[float, ...], unit: str, text: str, **limits) -> Variable:
    """A real parameter, fixed before the run."""
    return Variable(Causality.PARAMETER, Kind.REAL, start, unit, text, **limits)


def integer(start: int | tuple[int, ...], text: str, **limits) -> Variable:
    """A whole number, fixed before the run."""
    return Variable(Causality.PARAMETER, Kind.INTEGER, start, "1", text, **limits)


def choice(start: str, choices: tuple[str, ...], text: str) -> Variable:
    """One of a few names, fixed before the run."""
    return Variable(Causality.PARAMETER, Kind.CHOICE, start, "1", text, choices=choices)


def text(start: str, what: str) -> Variable:
    """A table as text, fixed before the run; kernels do not get it. A scene may name the file that holds it."""
    return Variable(Causality.PARAMETER, Kind.TEXT, start, "1", what)


def input_(start: float, unit: str, text: str, **more) -> Variable:
    """A continuous input; within a step it follows a polynomial of degree 0 to 2 in time."""
    return Variable(Causality.INPUT, Kind.REAL, start, unit, text, **more)


def output(unit: str, text: str, **more) -> Variable:
    """An output, continuous unless its component holds all of its own between samples."""
    return Variable(Causality.OUTPUT, Kind.REAL, 0.0, unit, text, **more)


def count(text: str, **more) -> Variable:
    """A whole number as an output, which changes at instants only."""
    return Variable(Causality.OUTPUT, Kind.INTEGER, 0, "1", text, **more)


def flag(text: str, **more) -> Variable:
    """A truth value as an output, 1 or 0, which changes at instants only."""
    return Variable(Causality.OUTPUT, Kind.BOOLEAN, 0, "1", text, **more)


def port_of(signal: str, declared: Declared) -> str:
    """The port of an input or output, which may be an element of an array."""
    effect = signal.rpartition(".")[0]
    whole = signal.partition("[")[0]
    for port, signals in declared.items():
        if whole in signals or (effect and f"{effect}.*" in signals):
            return port
    return effect


def member_of(signal: str, members: Mapping[str, str]) -> str:
    """The name of a signal within its port. members: own names that are others there."""
    name, bracket, index = signal.rpartition(".")[2].partition("[")
    return members.get(name, name) + bracket + index


def gathered(signals: Iterable[str], declared: Declared, members: Mapping[str, str]) -> dict[str, dict[str, str]]:
    """Port -> member -> signal, each in the order of the signals; declared, members: of the component."""
    ports: dict[str, dict[str, str]] = {}
    for signal in signals:
        ports.setdefault(port_of(signal, declared), {})[member_of(signal, members)] = signal
    return ports
