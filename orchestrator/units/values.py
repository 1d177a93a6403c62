"""Values on their way into an FMU and out of it: C types, blocks of one type, and checks of what a scene gives."""

from __future__ import annotations

import ctypes
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import inf, isfinite
from typing import TYPE_CHECKING, Any

from ...components.core.errors import BadInput, nearest
from .description import Description, Scalar, is_companion

if TYPE_CHECKING:
    from ..settings import UnitSettings

EXACT = 2**53  # whole numbers up to it travel as floats without loss
SINGLE = 2.0**-24  # relative rounding to single precision
FLOAT32 = 3.4028234663852886e38


@dataclass(frozen=True)
class CType:
    """How values of some FMI types are handed over: "fmi2Get" + suffix ... with arrays of a C type."""

    suffix: str
    c: Any
    low: int = 0  # of whole numbers
    high: int = 0


def _whole(suffix: str, c: Any) -> CType:
    bits, signed = 8 * ctypes.sizeof(c), c(-1).value < 0
    return CType(suffix, c, -(2 ** (bits - 1)) if signed else 0, 2 ** (bits - signed) - 1)


FMI2 = {
    "Real": CType("Real", ctypes.c_double),
    "Integer": _whole("Integer", ctypes.c_int),
    "Enumeration": _whole("Integer", ctypes.c_int),
    "Boolean": CType("Boolean", ctypes.c_int),
    "String": CType("String", ctypes.c_char_p),
}
FMI3 = {
    "Float64": CType("Float64", ctypes.c_double),
    "Float32": CType("Float32", ctypes.c_float),
    "Boolean": CType("Boolean", ctypes.c_bool),
    "String": CType("String", ctypes.c_char_p),
    "Binary": CType("Binary", ctypes.c_void_p),
    "Enumeration": _whole("Int64", ctypes.c_int64),
}
FMI3 |= {
    name: _whole(name, getattr(ctypes, "c_" + name.lower()))
    for name in ("Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32", "Int64", "UInt64")
}


class Block:
    """The variables of one C type among some scalars, with a buffer for all their values.

    `rows` are the places of its scalars in the list they came from, `at` their places in the buffer: an array of FMI 3
    is read and written as a whole, whichever of its elements are asked for.
    """

    def __init__(self, type_: CType, scalars: Sequence[tuple[int, Scalar]], fmi3: bool):
        offsets: dict[int, int] = {}
        size = 0
        for _, scalar in scalars:
            if scalar.variable.valueReference not in offsets:
                offsets[scalar.variable.valueReference] = size
                size += scalar.size
        self.type, self.size = type_, size
        self.rows = [k for k, _ in scalars]
        self.at = [offsets[s.variable.valueReference] + s.position for _, s in scalars]
        self.references = (ctypes.c_uint32 * len(offsets))(*offsets)
        self.buffer: Any = (type_.c * size)()
        self.whole = sorted(self.at) == list(range(size))  # every value of the buffer is one of the scalars'
        self.straight = self.at == list(range(size))  # and in their order
        # addresses cost ctypes less than arrays; the attributes above keep the memory alive
        references, buffer = ctypes.addressof(self.references), ctypes.addressof(self.buffer)
        self.arguments: tuple[int, ...] = (references, len(offsets), buffer, size) if fmi3 else (references, size, buffer)
        self.argument_types = signature(fmi3)
        if type_.suffix == "Binary":
            self.lengths, self.octets = (ctypes.c_size_t * size)(), [b""] * size  # of the values, and what the buffer points to
            self.arguments = (references, len(offsets), ctypes.addressof(self.lengths), buffer, size)
            self.argument_types = (*signature(fmi3)[:2], ctypes.c_void_p, *signature(fmi3)[2:])

    def put(self, at: int, value: Any) -> None:
        """Write a value into the buffer."""
        if self.type.suffix == "Binary":
            self.octets[at] = octets = bytes.fromhex(value)
            self.lengths[at], value = len(octets), ctypes.cast(ctypes.c_char_p(octets), ctypes.c_void_p)
        self.buffer[at] = value

    def first(self, n: int) -> tuple[int, ...]:
        """Arguments for the first n variables only, all of them scalars."""
        references, _, buffer, *rest = self.arguments
        return (references, n, buffer, n) if rest else (references, n, buffer)

    @classmethod
    def of_derivatives(cls, scalars: Sequence[Scalar], fmi3: bool) -> Block:
        """For derivatives of reals, which are of 64 bits whatever the reals are."""
        return cls(FMI3["Float64"], list(enumerate(scalars)), fmi3)


def decoded(block: Block) -> list[Any]:
    """Values of a block's scalars after a call that has filled its buffer; texts are copied out of the FMU's memory."""
    values = [block.buffer[k] for k in block.at]
    if block.type.suffix == "String":
        return [(text or b"").decode(errors="replace") for text in values]
    if block.type.suffix == "Binary":
        return [ctypes.string_at(block.buffer[k], block.lengths[k]).hex() if block.lengths[k] else "" for k in block.at]
    return values


def blocks(scalars: Iterable[Scalar], fmi3: bool) -> list[Block]:
    """Scalars by C type, in the order in which the types come."""
    types = FMI3 if fmi3 else FMI2
    by_type: dict[str, tuple[CType, list[tuple[int, Scalar]]]] = {}
    for k, scalar in enumerate(scalars):
        type_ = types[scalar.variable.type]
        by_type.setdefault(type_.suffix, (type_, []))[1].append((k, scalar))
    return [Block(type_, members, fmi3) for type_, members in by_type.values()]


def same(given: Any, actual: Any) -> bool:
    """Whether a value that was set is the one that is read back; reals may have been rounded to single precision."""
    if isinstance(given, str) or isinstance(actual, str):
        return given == actual
    return abs(float(given) - float(actual)) <= SINGLE * abs(float(given)) if isinstance(actual, float) else given == actual


def signature(fmi3: bool) -> tuple[Any, ...]:
    """Argument types of the functions that read and write values, after the instance."""
    pointer, size = ctypes.c_void_p, ctypes.c_size_t
    return (pointer, size, pointer, size) if fmi3 else (pointer, size, pointer)


def checked_values(description: Description, settings: UnitSettings, where: str, off: Sequence[str] = ()) -> dict[str, Any]:
    """A scene's values as the FMU takes them: checked, members of enumerations as their number. `off`: effects not chosen.

    A list sets an array of FMI 3 as a whole: `BadInput` with both shapes where it has another one.
    """
    where = f"{where}.parameters"
    for array, shape in settings.shapes.items():
        elements = [n for n, s in description.scalars.items() if s.variable.dimensions and s.variable.name == array]
        if elements and shape != tuple(map(int, _sizes(elements))):
            given = "with rows of different lengths" if shape is None else f"of shape ({', '.join(map(str, shape))})"
            raise _wrong_shape(where, array, f"a list {given}", elements)
    return {n: _checked_value(where, n, v, description.scalars, off) for n, v in settings.parameters.items()}


def _checked_value(where: str, name: str, value: Any, scalars: Mapping[str, Scalar], off: Sequence[str]) -> Any:
    scalar, effect = scalars.get(name), name.partition(".")[0]
    if (
        scalar is None
        or name.startswith("effects.")
        or is_companion(name, scalars)
        or scalar.variable.causality not in ("parameter", "structuralParameter", "input")
    ):
        settable = [
            n
            for n, s in scalars.items()
            if s.variable.causality in ("parameter", "structuralParameter", "input")
            and not n.startswith("effects.")
            and not is_companion(n, scalars)
        ]
        if elements := [n for n in settable if n.partition("[")[0] == name.partition("[")[0] and scalars[n].size > 1]:
            raise _wrong_shape(where, name, repr(value), elements)
        remedy = "List effects under effects = [...]." if name.startswith("effects.") else nearest(name, settable)
        raise BadInput(where, repr(name), "a parameter or an input of the FMU", remedy)
    if effect in off:
        raise BadInput(where, repr(name), "a parameter of an effect that is on", f"Switch on the effect {effect!r}.")
    kind, variable = scalar.kind, scalar.variable
    if kind == "enumeration" and isinstance(value, str):
        return _member(where, scalar, value)
    wanted: Any = {"real": (int, float), "boolean": bool, "string": str, "binary": str}.get(kind, int)
    if not isinstance(value, wanted) or (isinstance(value, bool) and kind != "boolean"):
        raise BadInput(where, f"{name} = {value!r}", f"a value of type {variable.type}")
    if kind in ("boolean", "string"):
        return value
    if kind == "binary":
        return _octets(where, name, value)
    if kind == "real" and not (isfinite(value) and (variable.type != "Float32" or abs(value) <= FLOAT32)):
        raise BadInput(where, f"{name} = {value!r}", "a finite number")
    if kind == "enumeration" and (items := members(scalar)) and value not in items.values():
        raise BadInput(where, f"{name} = {value!r}", f"one of {', '.join(f'{n} ({v})' for n, v in items.items())}")
    low, high = (_bound(scalar, end) for end in ("min", "max"))
    if not low <= value <= high:
        span = ", ".join(f"{bound:.9g}" if isinstance(bound, float) else str(bound) for bound in (low, high))
        raise BadInput(where, f"{name} = {value!r}", f"a value in [{span}]")
    return value


def _octets(where: str, name: str, text: str) -> str:
    try:
        return bytes.fromhex(text).hex()
    except ValueError:
        raise BadInput(where, f"{name} = {text!r}", 'octets in hexadecimal digits, such as "666f6f"') from None


def _wrong_shape(where: str, name: str, actual: str, elements: Sequence[str]) -> BadInput:
    """A value for an array as a whole, one for an element that it does not have, or a list of another shape."""
    array, sizes = elements[0].partition("[")[0], _sizes(elements)
    nested = " of lists" * (len(sizes) - 1)
    return BadInput(
        where,
        f"{name} = {actual}",
        f"values of an array of shape ({', '.join(sizes)})",
        f"Write {array} = [...], a list{nested}, or single elements such as {elements[0]!r}.",
    )


def _sizes(elements: Sequence[str]) -> list[str]:
    """Of an array, from the indices of its last element."""
    return elements[-1].rpartition("[")[2][:-1].split(",")


def _bound(scalar: Scalar, end: str) -> float:
    """Lowest or highest value of a number: of the variable, of its declared type, or of its C type."""
    variable, whole = scalar.variable, scalar.kind != "real"
    text = getattr(variable, end) or (getattr(variable.declaredType, end) if variable.declaredType else None)
    if text is not None:
        return int(text) if whole else float(text)
    type_ = FMI2.get(variable.type) or FMI3[variable.type]
    lowest, highest = (type_.low, type_.high) if whole else (-inf, inf)
    return lowest if end == "min" else highest


def members(scalar: Scalar) -> dict[str, int]:
    """Members of an enumeration by name."""
    declared = scalar.variable.declaredType
    return {item.name: int(item.value) for item in declared.items} if declared else {}


def _member(where: str, scalar: Scalar, name: str) -> int:
    items = members(scalar)
    if name not in items:
        raise BadInput(where, f"{scalar.name} = {name!r}", "a member of the enumeration", nearest(name, items))
    return items[name]
