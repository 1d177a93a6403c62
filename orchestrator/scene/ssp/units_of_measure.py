"""Units of measure of a system: defined in its files by their exponents, referenced by name."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from fmpy.model_description import ModelDescription
from lxml import etree

from ....components.core.errors import BadInput
from ....components.core.measure import BASES, Unit, parse
from .package import find_all, number, required


@dataclass(frozen=True)
class Measure:
    """A unit by the name that a file gives it; `meaning` is None where no file defines it."""

    name: str
    meaning: Unit | None


def definitions(root: etree._Element, namespace: str, where: str) -> dict[str, Measure]:
    """The units that a file defines: `Units` below the root of an .ssd or .ssv file."""
    measures = {}
    for unit in find_all(root, f"{namespace}:Units", "ssc:Unit"):
        name = required(unit, "name", where)
        for base in find_all(unit, "ssc:BaseUnit"):
            exponents = tuple(int(number(base, b, 0.0, where)) for b in BASES)
            factor, offset = number(base, "factor", 1.0, where), number(base, "offset", 0.0, where)
            if not factor:
                raise BadInput(f"{where}:{base.sourceline}", f"unit {name!r} with factor 0", "a factor that is not 0")
            measures[name] = Measure(name, Unit(factor, offset, exponents))
    return measures


def of_fmu(description: ModelDescription) -> dict[str, Measure]:
    """The units that an FMU defines."""
    measures = {}
    for unit in description.unitDefinitions:
        if (base := unit.baseUnit) is not None:
            exponents = tuple(int(getattr(base, b) or 0) for b in BASES)
            measures[unit.name] = Measure(unit.name, Unit(float(base.factor or 1.0) or 1.0, float(base.offset or 0.0), exponents))
    return measures


def named(name: str | None, defined: Mapping[str, Measure]) -> Measure | None:
    """A unit by its name: as the file defines it, or else as it is commonly written. None: none is given."""
    if not name:
        return None
    if name in defined:
        return defined[name]
    bare = name[1:-1] if name.startswith("[") and name.endswith("]") else name  # "[m]", as some tools write it
    try:
        return Measure(name, parse(bare))
    except (BadInput, ArithmeticError, ValueError):  # a power beyond the range of numbers
        return Measure(name, None)


def between(
    source: Measure | None, target: Measure | None, where: str, relative: bool = False, scaled: bool = False
) -> tuple[float, float]:
    """(factor, offset) from a number in one unit to that in another; 1 and 0 where one is not given.

    `relative`: of differences, which have no offset. `scaled`: a transformation is given, which is the whole of the conversion
    between units that nothing converts; else raises `BadInput` for units of different quantities, and for different ones of
    unknown meaning.
    """
    if source is None or target is None or source.name == target.name:
        return 1.0, 0.0
    a, b = source.meaning, target.meaning
    if scaled and (a is None or b is None or a.exponents != b.exponents):
        return 1.0, 0.0
    if a is None or b is None:
        unknown = source if a is None else target
        raise BadInput(
            where,
            f"{source.name!r} to {target.name!r}",
            "units that are defined",
            f"{unknown.name!r} has no definition among the units of its file. Or give a LinearTransformation.",
        )
    if a.exponents != b.exponents:
        raise BadInput(where, f"{source.name!r} for {target.name!r}", "units of the same quantity")
    return a.factor / b.factor, 0.0 if relative else (a.offset - b.offset) / b.factor
