"""A line as a table: sections of one tension each, with their spans, droppers and supports; read from TOML text.

A table says what it knows; what it leaves out comes from the section, then from the parameters of `Catenary`. All lengths in m,
forces in N, masses in kg or kg/m, stiffnesses in N/m; heights above any level, which `reference_height` names.
"""

# ruff: noqa: RUF009 - calls of `field` by other names
from __future__ import annotations

import math
import sys
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from functools import cache
from typing import Any

from ...core.errors import BadInput, decimal_point, nearest, syntax_remedy

MOST_SPANS = 2000  # 130 km of 65 m
MOST_DROPPERS = 200  # of one span
Number = Any  # a float, or None where the table leaves it out


CONTACT_HEIGHTS = -1.0, 20.0  # m, of the heights that `HEIGHTS` says: lines of reference models give deviations
HEIGHTS = "height of the contact wire above the rail, or a small deviation from a level that all supports share"


def number(unit: str, text: str, low: float = -math.inf, high: float = math.inf) -> Any:
    """A number that may be left out."""
    return field(default=None, metadata={"kind": "number", "unit": unit, "text": text, "low": low, "high": high})


def numbers(unit: str, text: str) -> Any:
    """A list of numbers that may be left out."""
    return field(default=None, metadata={"kind": "numbers", "unit": unit, "text": text, "low": -math.inf, "high": math.inf})


def words(text: str) -> Any:
    """Free text."""
    return field(default="", metadata={"kind": "words", "text": text})


def truth(text: str) -> Any:
    """True or false, or left out."""
    return field(default=None, metadata={"kind": "truth", "text": text})


def table(kind: type, text: str) -> Any:
    """A table inside."""
    return field(default_factory=kind, metadata={"kind": "table", "of": kind, "text": text})


def tables(kind: type, text: str, short: str = "", default: Any = ()) -> Any:
    """A list of tables; short: the key that a bare number in the list stands for."""
    return field(default=default, metadata={"kind": "tables", "of": kind, "text": text, "short": short})


@dataclass(frozen=True)
class WireData:
    """One wire."""

    tension: Number = number("N", "tension", 1.0)
    mass: Number = number("kg/m", "mass per length, unworn", 1e-6)
    bending: Number = number("N.m2", "bending stiffness EI, unworn; takes part with the effect bending_stiffness", 0.0)
    fixed: bool | None = truth("anchored at both ends; left out, automatic tensioning keeps the tension at any temperature")
    axial_stiffness: Number = number("N", "EA of a fixed wire; takes part with the effect temperature", 1.0)
    expansion: Number = number("1/K", "coefficient of thermal expansion; left out, 1.7e-5 of copper", 0.0, 1e-3)


@dataclass(frozen=True)
class Auxiliary(WireData):
    """Auxiliary wire of a compound catenary: main droppers carry it, and it carries the contact wire's droppers. No `bending`: a string."""

    height: Number = number("m", "its height at its droppers above the straight line between the contact heights", 1e-3)


@dataclass(frozen=True)
class Stitch:
    """Stitch (Y) wire: clamped to the messenger on both sides of a support, which it passes below without touching."""

    half_length: Number = number("m", "distance of its clamps from the support; 0 for none", 0.0)
    tension: Number = number("N", "its tension H; the messenger between the clamps carries its own tension less H", 1.0)
    mass: Number = number("kg/m", "mass per length", 1e-6)


@dataclass(frozen=True)
class DropperData:
    """Droppers of a section or span. Positions follow from `first` and `gap` where no list is given."""

    first: Number = number("m", "distance of the first and the last one from the supports", 0.0)
    gap: Number = number("m", "longest distance of two, which are all equal", 0.01)
    stiffness: Number = number("N/m", "stiffness in tension", 1.0)
    axial_stiffness: Number = number("N", "EA, from which the stiffness follows by the length, instead", 1.0)
    mass: Number = number("kg", "mass of one", 0.0)
    mass_per_length: Number = number("kg/m", "mass per length, instead", 0.0)
    contact_clamp: Number = number("kg", "mass of the clamp at the contact wire", 0.0)
    messenger_clamp: Number = number("kg", "mass of the clamp at the messenger", 0.0)


@dataclass(frozen=True)
class Dropper:
    """One dropper: by the wanted height of the contact wire, by its cut length, or straight less sag where neither is given."""

    position: Number = number("m", "position from the left support; in a CSV table, along the line")
    contact_wire: Number = number("1", "1, or 2 for a second contact wire", 1.0, 2.0)
    hangs_from: str = words(
        "messenger, stitch or auxiliary: follows, and is compared; without a contact wire, messenger or stitch make it one of an "
        "auxiliary wire, second messenger or second stitch in a CSV table that of every second section"
    )
    height: Number = number("m", "wanted height of the wire at its lower clamp")
    length: Number = number("m", "length under load: follows, and is compared", 1e-3)
    cut_length: Number = number("m", "length without load; beside a height it is compared", 1e-3)
    preload: Number = number("N", "tension at rest: follows, and is compared")
    stiffness: Number = number("N/m", "stiffness in tension", 1.0)
    axial_stiffness: Number = number("N", "EA, from which the stiffness follows by the length, instead", 1.0)
    mass: Number = number("kg", "mass", 0.0)
    contact_clamp: Number = number("kg", "mass of the clamp at the contact wire", 0.0)
    messenger_clamp: Number = number("kg", "mass of the clamp at the messenger", 0.0)


@dataclass(frozen=True)
class Arm:
    """Steady arm: a rod from a hinge to the contact wire, which pulls the wire sideways."""

    length: Number = number("m", "length", 1e-3)
    angle: Number = number("deg", "angle below the horizontal; left out, the arm carries its own weight only", 0.0, 80.0)
    mass: Number = number("kg", "mass of the rod; a third of it moves with the wire, half of its weight hangs there", 0.0)


@dataclass(frozen=True)
class Support:
    """One support. Both wires are anchored at the first and the last one of a section."""

    contact_height: Number = number("m", HEIGHTS, *CONTACT_HEIGHTS)
    system_height: Number = number("m", "height of the messenger above the contact wire", 0.0, 20.0)
    stiffness: Number = number("N/m", "vertical stiffness of the messenger's support", 0.0)
    damping: Number = number("N.s/m", "damping of the messenger's support", 0.0)
    held: bool | None = truth("the contact wire is at its height at rest; left out, it hangs free between the droppers")
    contact_stiffness: Number = number("N/m", "vertical stiffness that the contact wire meets there, beside that of an arm", 0.0)
    stagger: Number = number("m", "lateral position of the contact wire", -5.0, 5.0)
    arm: Arm = table(Arm, "steady arm; its vertical stiffness follows from stagger, tension and geometry")
    stitch: Stitch = table(Stitch, "stitch wire at this support")


@dataclass(frozen=True)
class Span:
    """One span, or several alike."""

    length: Number = number("m", "length", 1.0, 1000.0)
    repeat: Number = number("1", "number of spans like this", 1.0, MOST_SPANS)
    positions: tuple[float, ...] | None = numbers("m", "positions of the droppers from the left support; [] for none")
    heights: tuple[float, ...] | None = numbers("m", "heights of the contact wire at the droppers; left out, straight less sag")
    second_positions: tuple[float, ...] | None = numbers("m", "positions of the second contact wire's droppers")
    main_positions: tuple[float, ...] | None = numbers("m", "positions of the auxiliary wire's droppers")
    dropper_list: tuple[Dropper, ...] | None = tables(
        Dropper, "droppers one by one, from left to right; a number is a position", "position", None
    )
    sag: Number = number("m", "depth of the parabola of pre-sag between the first and the last dropper")
    relative_sag: Number = number("1", "the same over the length of the span, instead", 0.0, 0.1)
    wear: Number = number("1", "worn share of the contact wire's section; mass falls by it", 0.0, 0.5)
    droppers: DropperData = table(DropperData, "droppers of this span")


@dataclass(frozen=True)
class Section:
    """One tension length: its wires run from its first support to its last."""

    start: Number = number("m", "position of its first support; left out, the end of the section before")
    contact_wire: WireData = table(WireData, "contact wire")
    second_contact_wire: WireData = table(WireData, "second contact wire, beside the first; with its tension there is one")
    messenger: WireData = table(WireData, "messenger wire")
    auxiliary: Auxiliary = table(Auxiliary, "auxiliary wire of a compound catenary; with its tension there is one")
    stitch: Stitch = table(Stitch, "stitch wires at all supports but the anchors")
    droppers: DropperData = table(DropperData, "droppers of all spans")
    main_droppers: DropperData = table(DropperData, "droppers of the auxiliary wire, which hang from the messenger")
    span: Span = table(Span, "what all spans have that do not say otherwise")
    support: Support = table(Support, "what all supports have that do not say otherwise")
    spans: tuple[Span, ...] = tables(Span, "spans, one after the other; a number is a length", "length")
    supports: tuple[Support, ...] = tables(
        Support, "one more than spans; left out, all as `support`; a number is a contact height", "contact_height"
    )


@dataclass(frozen=True)
class Line:
    """A line of one or more sections; where two overlap, a pantograph passes from one contact wire to the other."""

    title: str = words("what it is")
    source: str = words("where its numbers come from")
    reference_height: Number = number("m", "level that heights of the model count from; left out, the first contact height")
    sections: tuple[Section, ...] = tables(Section, "tension lengths")


# keys of which one alone has an effect
ALTERNATIVES: dict[type, tuple[tuple[str, ...], ...]] = {
    DropperData: (("stiffness", "axial_stiffness"), ("mass", "mass_per_length")),
    Dropper: (("stiffness", "axial_stiffness"),),
    Span: (
        ("heights", "sag"),
        ("heights", "relative_sag"),
        ("sag", "relative_sag"),
        ("dropper_list", "positions"),
        ("dropper_list", "heights"),
        ("dropper_list", "second_positions"),
        ("dropper_list", "main_positions"),
    ),
}


def read_line(text: str, where: str = "line") -> Line:
    """The line of a TOML text; anything that it cannot be is one `BadInput` with its place."""
    try:
        data = tomllib.loads(text)
    except ValueError as error:  # of syntax, or of an integer of thousands of digits
        raise BadInput(where, f"a syntax error: {error}", "a line's table as TOML", syntax_remedy(text, error)) from None
    line = _read(Line, data, where)
    if not line.sections:
        raise BadInput(where, "no section", "at least one", "Write [[sections]] with spans = [length, ...].")
    return line


def _read(kind: type, data: Any, where: str) -> Any:
    if not isinstance(data, Mapping):
        raise BadInput(where, repr(data), "a table")
    for group in ALTERNATIVES.get(kind, ()):
        if len(both := [key for key in data if key in group]) > 1:
            raise BadInput(where, f"{both[0]} and {both[1]}", "one of the two: only one would have an effect")
    known = {f.name: f for f in fields(kind)}
    if unknown := [key for key in data if key not in known]:
        raise BadInput(where, f"key {unknown[0]!r}", f"a key of a {kind.__name__.lower()}", nearest(unknown[0], known))
    return kind(**{key: _value(known[key].metadata, value, f"{where}.{key}") for key, value in data.items()})


def _value(meta: Mapping[str, Any], value: Any, where: str) -> Any:
    match meta["kind"]:
        case "number":
            return checked_number(meta, value, where)
        case "numbers":
            if not isinstance(value, list):
                raise BadInput(where, repr(value), "a list of numbers")
            return tuple(checked_number(meta, v, f"{where}[{i}]") for i, v in enumerate(value, 1))
        case "words":
            if not isinstance(value, str):
                raise BadInput(where, repr(value), "a text")
            return value
        case "truth":
            if not isinstance(value, bool):
                raise BadInput(where, repr(value), "true or false")
            return value
        case "table":
            return _read(meta["of"], value, where)
    if not isinstance(value, list):
        raise BadInput(where, repr(value), "a list")
    short = meta["short"]
    rows = [{short: v} if short and isinstance(v, int | float) and not isinstance(v, bool) else v for v in value]
    return tuple(_read(meta["of"], row, f"{where}[{i}]") for i, row in enumerate(rows, 1))


def checked_number(meta: Mapping[str, Any], value: Any, where: str) -> float:
    """A value as the number that a key wants, or `BadInput`; meta: as of `number`."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) <= sys.float_info.max:
        raise BadInput(where, repr(value)[:80], f"a number in {meta['unit']}", decimal_point(value))
    if not meta["low"] <= value <= meta["high"]:
        limits = f"[{meta['low']:g}, {meta['high']:g}] {meta['unit']}"
        raise BadInput(where, f"{value:g}", f"a value in {limits}", meta["text"][:1].upper() + meta["text"][1:] + ".")
    return float(value)


def over(first: Any, *others: Any) -> Any:
    """One table from several of a kind: of each key the first that says something, whole tables inside likewise.

    Of keys of which one alone has an effect, the first table that says one of them decides for all.
    """
    tables, values = (first, *others), {}
    kind: Any = type(first)
    for name, is_table, rivals in _keys(kind):
        if is_table:
            values[name] = over(*(getattr(t, name) for t in tables))
            continue
        values[name] = None
        for t in tables:
            value = getattr(t, name)
            if value is not None or any(getattr(t, rival) is not None for rival in rivals):
                values[name] = value
                break
    return kind(**values)


@cache
def _keys(kind: type) -> tuple[tuple[str, bool, tuple[str, ...]], ...]:
    """Of each key of a table its name, whether it is a table itself, and the keys beside which it has no effect."""
    groups = ALTERNATIVES.get(kind, ())
    rivals = {key: tuple({other: None for group in groups if key in group for other in group}) for g in groups for key in g}
    return tuple((f.name, f.metadata["kind"] == "table", rivals.get(f.name, ())) for f in fields(kind))


def schema(kind: type = Line) -> dict[str, Any]:
    """JSON schema of a table, for editors."""

    def of(meta: Mapping[str, Any]) -> dict[str, Any]:
        text = meta["text"] + (f", {meta['unit']}" if meta.get("unit", "1") != "1" else "")
        match meta["kind"]:
            case "number":
                limits = {key: meta[low] for key, low in (("minimum", "low"), ("maximum", "high")) if math.isfinite(meta[low])}
                return {"type": "number", "description": text, **limits}
            case "numbers":
                return {"type": "array", "items": {"type": "number"}, "description": text}
            case "words":
                return {"type": "string", "description": text}
            case "truth":
                return {"type": "boolean", "description": text}
            case "table":
                return {**schema(meta["of"]), "description": text}
        row: dict[str, Any] = schema(meta["of"])
        return {"type": "array", "description": text, "items": {"anyOf": [{"type": "number"}, row]} if meta["short"] else row}

    return {"type": "object", "additionalProperties": False, "properties": {f.name: of(f.metadata) for f in fields(kind)}}
