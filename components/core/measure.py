"""Units of measure: unit strings in SI base units, and conversion from one to another.

A unit is written the way FMI tools write it: factors joined by ".", divided by "/" (each "/" divides only the
factor behind it), with integer exponents ("N.s/m", "kg.m2", "1/s", "m/s2"). In a number that a person writes, "250 km/h" or
"3 µm/N", signs such as "·", "²", "°" and "µ" are known as well.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from .errors import BadInput, decimal_point, nearest

BASES = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")
STANDARD_GRAVITY = 9.80665  # m/s², exact (third CGPM, 1901; ISO 80000-3)


@dataclass(frozen=True)
class Unit:
    """SI value = factor * value + offset, with the exponents of `BASES`."""

    factor: float
    offset: float
    exponents: tuple[int, ...]


def _unit(factor: float = 1.0, offset: float = 0.0, **powers: int) -> Unit:
    return Unit(factor, offset, tuple(powers.get(base, 0) for base in BASES))


PI = 3.141592653589793
SYMBOLS = {
    "1": _unit(),
    "kg": _unit(kg=1),
    "m": _unit(m=1),
    "s": _unit(s=1),
    "A": _unit(A=1),
    "K": _unit(K=1),
    "mol": _unit(mol=1),
    "cd": _unit(cd=1),
    "rad": _unit(rad=1),
    "Hz": _unit(s=-1),
    "N": _unit(kg=1, m=1, s=-2),
    "Pa": _unit(kg=1, m=-1, s=-2),
    "J": _unit(kg=1, m=2, s=-2),
    "W": _unit(kg=1, m=2, s=-3),
    "V": _unit(kg=1, m=2, s=-3, A=-1),
    "Ohm": _unit(kg=1, m=2, s=-3, A=-2),
    "H": _unit(kg=1, m=2, s=-2, A=-2),
    "F": _unit(kg=-1, m=-2, s=4, A=2),
    "C": _unit(s=1, A=1),
    "g": _unit(1e-3, kg=1),
    "t": _unit(1e3, kg=1),
    "mm": _unit(1e-3, m=1),
    "um": _unit(1e-6, m=1),
    "cm": _unit(1e-2, m=1),
    "km": _unit(1e3, m=1),
    "l": _unit(1e-3, m=3),
    "ms": _unit(1e-3, s=1),
    "us": _unit(1e-6, s=1),
    "min": _unit(60.0, s=1),
    "h": _unit(3600.0, s=1),
    "kN": _unit(1e3, kg=1, m=1, s=-2),
    "MN": _unit(1e6, kg=1, m=1, s=-2),
    "mN": _unit(1e-3, kg=1, m=1, s=-2),
    "mPa": _unit(1e-3, kg=1, m=-1, s=-2),
    "kPa": _unit(1e3, kg=1, m=-1, s=-2),
    "MPa": _unit(1e6, kg=1, m=-1, s=-2),
    "GPa": _unit(1e9, kg=1, m=-1, s=-2),
    "bar": _unit(1e5, kg=1, m=-1, s=-2),
    "kJ": _unit(1e3, kg=1, m=2, s=-2),
    "MJ": _unit(1e6, kg=1, m=2, s=-2),
    "kW": _unit(1e3, kg=1, m=2, s=-3),
    "MW": _unit(1e6, kg=1, m=2, s=-3),
    "kV": _unit(1e3, kg=1, m=2, s=-3, A=-1),
    "mA": _unit(1e-3, A=1),
    "mH": _unit(1e-3, kg=1, m=2, s=-2, A=-2),
    "mW": _unit(1e-3, kg=1, m=2, s=-3),
    "kHz": _unit(1e3, s=-1),
    "deg": _unit(PI / 180.0, rad=1),
    "rpm": _unit(2.0 * PI / 60.0, rad=1, s=-1),
    "%": _unit(1e-2),
    "degC": _unit(1.0, 273.15, K=1),
    "degF": _unit(5.0 / 9.0, 459.67 * 5.0 / 9.0, K=1),
    "ft": _unit(0.3048, m=1),
    "in": _unit(0.0254, m=1),
    "yd": _unit(0.9144, m=1),
    "mi": _unit(1609.344, m=1),
    "mph": _unit(0.44704, m=1, s=-1),
    "lb": _unit(0.45359237, kg=1),
    "lbf": _unit(4.4482216152605, kg=1, m=1, s=-2),
    "psi": _unit(4.4482216152605 / 0.0254**2, kg=1, m=-1, s=-2),
}
OTHERWISE = {
    "m/s": "km/h",
    "N": "kN",
    "N/m": "kN/m",
    "m": "mm",
    "rad": "deg",
}  # a unit in which a number of the field is as often written
ACCELERATION = _unit(m=1, s=-2).exponents
_FACTOR = re.compile(r"([./]?)([A-Za-z%]+|1(?![-\d]))(-?\d+)?", re.ASCII)  # a number such as 10 is no power of 1


def parse(text: str, where: str = "unit") -> Unit:
    """The meaning of a unit string; raises `BadInput` for an unknown symbol or form."""
    factor, exponents, position = 1.0, [0] * len(BASES), 0
    if text in SYMBOLS:
        return SYMBOLS[text]
    for match in _FACTOR.finditer(text):
        if match.start() != position or (position == 0) != (match[1] == ""):
            break
        symbol = SYMBOLS.get(match[2])
        if symbol is None:
            raise BadInput(
                where, f"unit {text!r}", "known units of measure", f"{match[2]!r} is not known. {nearest(match[2], SYMBOLS)}"
            )
        power = int(match[3] or 1) * (-1 if match[1] == "/" else 1)
        factor *= symbol.factor**power
        exponents = [e + power * s for e, s in zip(exponents, symbol.exponents, strict=True)]
        position = match.end()
    if position != len(text) or not text:
        remedy = "A unit has no number: multiply the values by it." if re.search(r"(^|[./])\d\d", text) else ""
        raise BadInput(where, f"unit {text!r}", 'factors joined by "." and "/", such as "N.s/m" or "kg.m2"', remedy)
    return Unit(factor, 0.0, tuple(exponents))


def conversion(
    source: str, target: str, where: str = "unit", defined: tuple[Unit | None, Unit | None] = (None, None), relative: bool = False
) -> tuple[float, float]:
    """(factor, offset) with target value = factor * source value + offset; raises `BadInput` if they do not fit.

    `defined`: what the two strings mean where they have a meaning of their own. `relative`: of differences, which have no offset.
    """
    if source == target and None in defined:
        return 1.0, 0.0
    a, b = (own or parse(text, where) for own, text in zip(defined, (source, target), strict=True))
    if source == "g" and b.exponents == ACCELERATION and defined[0] is None:  # no mass is meant
        a = Unit(STANDARD_GRAVITY, 0.0, ACCELERATION)
    if a.exponents != b.exponents:
        raise BadInput(where, f"{source!r} for {target!r}", "units of the same quantity")
    return a.factor / b.factor, 0.0 if relative else (a.offset - b.offset) / b.factor


def conversion_of(
    written: str, unit: str, where: str, shown: str, defined: Unit | None = None, relative: bool = False
) -> tuple[float, float]:
    """As `conversion`, of a unit that a person has written where one of this dimension is wanted; shown: what a message quotes."""
    try:
        return conversion(written, unit, where, (None, defined), relative)
    except BadInput as error:
        wanted = f"a unit of the dimension of {unit}" if unit != "1" else "a number without unit"
        remedy = ""
        if error.expected.startswith("factors"):  # it is written in no way that units are
            wanted, remedy = error.expected, error.remedy
        elif error.actual == f"unit {written!r}":
            exponents = (defined or parse(unit, where)).exponents
            alike = [symbol for symbol, known in SYMBOLS.items() if known.exponents == exponents and unit != "1"]
            remedy = error.remedy if "Did you mean" in error.remedy else f"Such as {', '.join(alike)}." if alike else ""
        elif unit == "rad/s" and parse(written).exponents == SYMBOLS["Hz"].exponents:
            remedy = "Turns in time are written as rpm: 1 Hz or 1 1/s is 60 rpm."
        raise BadInput(where, shown, wanted, remedy) from None


_WRITTEN = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)(?![eE.]?[+-]?\d)\s*([^\s\d_.,:+*/-].*?)\s*")
_SIGNS = {"°C": "degC", "°": "deg", "µ": "u", "μ": "u", "²": "2", "³": "3", "·": ".", "*": ".", "^": "", "Ω": "Ohm", " ": "."}


def plain(text: str) -> str:
    """A unit as a person writes it, "N / mm²", in the form that `parse` takes."""
    written = re.sub(r"\s*/\s*", "/", text.strip())
    for sign, other in _SIGNS.items():
        written = written.replace(sign, other)
    return re.sub(r"\(([^()]+)\)2(?!\d)", lambda match: squared(match[1]), written)


def squared(unit: str) -> str:
    """The square of a unit: "m2/s4" of "m/s2"."""
    return _FACTOR.sub(lambda f: f[0] if f[2] == "1" else f"{f[1]}{f[2]}{2 * int(f[3] or 1)}", unit)


def bare_number(text: str) -> float:
    """The number of a text as a person writes it; raises `ValueError`, also for "1_1", which Python takes for 11."""
    if "_" in text:
        raise ValueError(text)
    return float(text)


def is_quantity(text: object) -> bool:
    """Whether it is a text that begins with a number and goes on, as "250 km/h" does."""
    return isinstance(text, str) and _WRITTEN.fullmatch(text) is not None


def refuse_mixed(given: Sequence[object], numbers: Sequence[object], where: str) -> None:
    """Raise `BadInput` for a number alone beside one whose unit scales it, as in 200 and "250 km/h": 0 is 0 in both, and % is plain.

    given: texts and numbers as they are written; numbers: what they come to.
    """
    alone = ""
    for written, number in zip(given, numbers, strict=True):
        if not is_quantity(written) and isinstance(number, int | float) and not isinstance(number, bool) and number:
            alone = alone or f"{number:g}"
    for written, number in zip(given, numbers, strict=True):
        match = _WRITTEN.fullmatch(written) if isinstance(written, str) else None
        if alone and match is not None and "%" not in match[2] and number not in (written, float(match[1])):
            remedy = f'Write "{alone} {match[2]}".'
            raise BadInput(where, f"{alone} beside {written!r}", "a unit at each number, or at none", remedy)


def number_in(text: str, unit: str, where: str, defined: Unit | None = None, relative: bool = False) -> float:
    """The number of a text such as "250 km/h" in a unit; raises `BadInput` for another dimension. defined, relative: as of
    `conversion`.

    "20 degC" is refused where K is wanted, unless a difference is: a temperature and a difference of temperatures are different numbers.
    """
    match = _WRITTEN.fullmatch(text)
    if match is None:
        raise BadInput(where, repr(text), f"a number in {unit}, or a text with its unit", decimal_point(text))
    written = plain(match[2])
    factor, offset = conversion_of(written, unit, where, repr(text), defined, relative)
    if offset:
        raise BadInput(where, repr(text), f"a number in {unit}", "A temperature and a difference of temperatures would differ.")
    return float(match[1]) * factor
