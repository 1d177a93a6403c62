"""The one table of units in which a person reads numbers: terminal, report, notebook and live page.

Files for programs (CSV, JSON, Parquet) keep the unit that a component declares; so does everything with `--si`. A range of a
reference table keeps the unit of its source.
"""

from __future__ import annotations

from functools import cache
from math import isfinite

from ...components.core.measure import conversion
from ..delivery import DELIVERY

# Declared unit -> the unit for a reader with the least size, in the declared unit, from which it is taken; the largest first.
# The choices are conventions of drawings and data sheets, such as µm for shaft orbits and rpm for shafts.
PREFERRED: dict[str, tuple[tuple[str, float], ...]] = {
    "m": (("m", 1.0), ("mm", 1e-3), ("um", 0.0)),
    "m/s": (("km/h", 20.0), ("m/s", 0.1), ("mm/s", 0.0)),
    "rad": (("deg", 0.0),),
    "N": (("kN", 1e4), ("N", 0.1), ("mN", 0.0)),
    "N.m": (("kN.m", 1e4), ("N.m", 0.1), ("N.mm", 0.0)),
    "N/m": (("MN/m", 1e6), ("kN/m", 1e4), ("N/m", 0.0)),
    "N.s/m": (("kN.s/m", 1e4), ("N.s/m", 0.0)),
    "Pa": (("GPa", 1e9), ("MPa", 1e6), ("kPa", 1e3), ("Pa", 0.0)),
    "Pa.s": (("Pa.s", 1.0), ("mPa.s", 0.0)),
    "W": (("MW", 1e6), ("kW", 1e4), ("W", 0.1), ("mW", 0.0)),
    "J": (("MJ", 1e6), ("kJ", 1e4), ("J", 0.0)),
    "s": (("s", 0.1), ("ms", 1e-4), ("us", 0.0)),
    "kg.m": (("kg.m", 0.1), ("g.mm", 0.0)),
    "m3": (("m3", 0.1), ("l", 0.0)),
    "m3/s": (("m3/s", 0.1), ("l/s", 0.0)),
    "m/N": (("mm/N", 1e-4), ("um/N", 0.0)),
}
TURNING = {"speed": "rpm", "rate": "deg/s", "velocity": "deg/s"}  # of rad/s by the name: a shaft, a body; frequencies stay


def choices(unit: str, name: str = "") -> list[tuple[str, float, float]]:
    """(unit as it is written, factor, least size in the declared unit) for a reader of numbers in a declared unit, the largest first.

    name: that of the quantity.
    """
    units: tuple[tuple[str, float], ...] = PREFERRED.get(unit, ())
    if unit == "rad/s":
        units = tuple((other, 0.0) for word, other in TURNING.items() if word in name.rpartition(".")[2])[:1]
    if DELIVERY.get().si or not units:
        units = ((unit, 0.0),)
    return [(written(other), _factor(unit, other), least) for other, least in units]


def preferred(unit: str, size: float, name: str = "") -> tuple[str, float]:
    """(unit as it is written, factor): the choice for numbers of a size; that of 0 or of none is the declared unit, if it is one.

    size: the largest absolute number that is shown in the unit, in the declared unit.
    """
    known = choices(unit, name)
    if not (isfinite(size) and size):
        return next(((text, factor) for text, factor, _ in known if factor == 1.0), known[0][:2])
    return next((text, factor) for text, factor, least in known if size >= least * (1.0 - 1e-12))


@cache
def _factor(unit: str, other: str) -> float:
    return 1.0 if unit == other else conversion(unit, other)[0]


def written(unit: str) -> str:
    """A unit as a text shows it: "N·s/m", "m/s²", "µm"; "" for "1"."""
    if unit == "1":
        return ""
    text = unit
    for code, sign in (("um", "µm"), ("us", "µs"), ("deg", "°")):
        text = sign + text[len(code) :] if text == code or text.startswith((f"{code}/", f"{code}C", f"{code}F")) else text
    for digit, sign in (("2", "²"), ("3", "³")):
        text = text.replace(f"{digit}/", f"{sign}/").replace(f"{digit}.", f"{sign}.")
        text = text[:-1] + sign if text.endswith(digit) and text[-2:-1] not in ("-", "", "/") else text
    return text.replace(".", "·")
