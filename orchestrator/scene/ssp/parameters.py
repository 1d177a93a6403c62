"""Parameter sets (.ssv), their mappings (.ssm) and transformations, as assignments of values to names.

Source: System Structure and Parameterization 1.0, chapters 5 (bindings), 6 (SSV) and 7 (SSM).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from itertools import product
from math import prod
from pathlib import Path

from lxml import etree

from ....components.core.errors import BadInput, counted
from ....components.core.measure import bare_number
from .package import LARGEST_TEXT, Package, find_all, number, parsed, required, truth
from .units_of_measure import Measure, definitions, named

REALS = ("Real", "Float64", "Float32")  # the first of each is of version 1.0, the others of 2.0
WHOLES = ("Integer", "Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32", "Int64", "UInt64")
OTHERS = ("Boolean", "String", "Enumeration", "Binary")
SHOWN = 5  # names in a remark
MAPPINGS = {
    "BooleanMappingTransformation": "Boolean",
    "IntegerMappingTransformation": "Integer",
    "EnumerationMappingTransformation": "Enumeration",
}


@dataclass(frozen=True)
class Transformation:
    """target = factor * source + offset, or the entry of a table for values of one type; `given`: the file has it."""

    factor: float = 1.0
    offset: float = 0.0
    table: Mapping[str, str] | None = None
    type: str = ""  # of the table
    given: bool = False

    def entries(self, where: str) -> dict[str, bool | int | float | str]:
        """Of the table, with the values of its targets."""
        return {source: plain(self.type, target, where) for source, target in (self.table or {}).items()}


@dataclass(frozen=True)
class Value:
    """A value as a file gives it: its type's name in SSP, and the unit of measure of a real one."""

    type: str
    value: bool | int | float | str
    measure: Measure | None = None

    def through(self, transformation: Transformation, where: str) -> Value:
        """The value after a transformation, which must be of its type."""
        t = transformation
        if t.table is not None:
            key = str(self.value).lower() if self.type == "Boolean" else str(self.value)
            if t.type != self.type or key not in t.table:
                raise BadInput(where, f"{self.type} {self.value!r}", f"a {t.type} among {', '.join(t.table)}, for this mapping")
            return replace(self, value=plain(self.type, t.table[key], where))
        if (t.factor, t.offset) == (1.0, 0.0):
            return self
        if self.type not in ("Real", "Integer"):
            raise BadInput(where, f"a linear transformation of a {self.type}", "one of a number")
        return replace(self, type="Real", value=t.factor * float(self.value) + t.offset)


@dataclass(frozen=True)
class Assignment:
    """A value for all variables of a name, seen from the element that the binding belongs to."""

    name: str
    value: Value
    transformation: Transformation
    suppress: bool  # no conversion of units of measure
    where: str


def transformation(node: etree._Element, where: str) -> Transformation:
    """The transformation of a connection or of an entry of a mapping; the one that changes nothing where there is none."""
    for child in node:
        name = etree.QName(child).localname
        if name == "LinearTransformation":
            return Transformation(number(child, "factor", 1.0, where), number(child, "offset", 0.0, where), given=True)
        if name in MAPPINGS:
            entries = child.findall("{*}MapEntry")
            if twice := _twice(_key(MAPPINGS[name], e.get("source", ""), where) for e in entries):
                raise BadInput(where, f"a second MapEntry of {twice[0]!r}", "one for each value")
            return Transformation(
                table={_key(MAPPINGS[name], e.get("source", ""), where): e.get("target", "") for e in entries},
                type=MAPPINGS[name],
                given=True,
            )
    return Transformation()


def _key(type_: str, text: str, where: str) -> str:
    return str(truth(text, "source", where)).lower() if type_ == "Boolean" else text


def assignments(binding: etree._Element, package: Package, fmu: Path | None, where: str) -> Iterator[Assignment]:
    """What one ParameterBinding assigns, names with its prefix and through its mapping. `fmu`: of the component it is at."""
    if binding.get("type", "application/x-ssp-parameter-set") != "application/x-ssp-parameter-set":
        raise BadInput(where, f"a parameter source of type {binding.get('type')!r}", "application/x-ssp-parameter-set")
    root, place = content(binding, "ssd:ParameterValues", "ssv:ParameterSet", package, fmu, where)
    if root is None:
        raise BadInput(where, "a ParameterBinding without values", "a source, or a ParameterSet inside")
    measures, prefix = definitions(root, "ssv", place), binding.get("prefix", "")
    given = [
        (prefix + name, value)
        for p in find_all(root, "ssv:Parameters", "ssv:Parameter")
        for name, value in _values(p, required(p, "name", place), measures, f"{place}:{p.sourceline}")
    ]
    values = dict(given)
    _remark(package, place, _twice(name for name, _ in given), "stand there twice; the last value is taken")
    mappings = find_all(binding, "ssd:ParameterMapping")
    if not mappings:
        for name, value in values.items():
            yield Assignment(name, value, Transformation(), False, place)
        return
    root, place = content(mappings[0], "", "ssm:ParameterMapping", package, fmu, where)
    if root is None:
        raise BadInput(where, "a ParameterMapping without content", "a source, or a ParameterMapping inside")
    entries = find_all(root, "ssm:MappingEntry")
    named_entries = [e for e in entries if e.get("source") != ""]  # some tools list every parameter, those without a value so
    if len(named_entries) < len(entries):
        package.remarks.append(f"{place}: {len(entries) - len(named_entries)} entries with an empty source are left out")
    _remark(
        package,
        place,
        [s for e in named_entries if (s := e.get("source", "")) not in values],
        "are mapped and in no set; left out",
    )
    if twice := _twice(t for s, t in {(e.get("source"), e.get("target", "")) for e in named_entries} if s in values):
        raise BadInput(place, f"target {twice[0]!r} of two entries", "one source for each target")
    for entry in named_entries:
        source, target, at = required(entry, "source", place), required(entry, "target", place), f"{place}:{entry.sourceline}"
        if source in values:
            suppress = truth(entry.get("suppressUnitConversion", "false"), "suppressUnitConversion", at)
            yield Assignment(target, values[source], transformation(entry, at), suppress, at)


def _twice(names: Iterable[str]) -> list[str]:
    """Names that come more than once."""
    return [name for name, times in Counter(names).items() if times > 1]


def _remark(package: Package, place: str, names: Sequence[str], what: str) -> None:
    if names:
        shown = ", ".join(map(repr, names[:SHOWN])) + (", ..." if len(names) > SHOWN else "")
        package.remarks.append(f"{place}: parameters that {what}: {shown}")


def content(
    node: etree._Element, holder: str, wanted: str, package: Package, fmu: Path | None, where: str
) -> tuple[etree._Element | None, str]:
    """The root of a set or mapping, from another file or inline, and its file and line."""
    source = node.get("source")
    if not source:  # some tools write an empty one beside what is inline
        nodes = find_all(node, *filter(None, (holder, wanted)))
        return (nodes[0] if nodes else None), where.rpartition(":")[0]
    if node.get("sourceBase", "SSD") == "component":
        if fmu is None:
            raise BadInput(where, 'sourceBase="component"', "SSD; only a component with an FMU has files of its own")
        with closing(Package.zipped(str(fmu), fmu)) as inner:
            path = inner.inside(source, where)
            place, text = inner.label(path), inner.read(path, where, LARGEST_TEXT)
    else:
        path = package.inside(source, where)
        place, text = package.label(path), package.read(path, where, LARGEST_TEXT)
    root = parsed(text, place, package.remarks)
    if etree.QName(root).localname != wanted.partition(":")[2]:
        raise BadInput(place, f"<{etree.QName(root).localname}>", f"<{wanted}>")
    return root, place


def _values(node: etree._Element, name: str, measures: Mapping[str, Measure], where: str) -> Iterator[tuple[str, Value]]:
    """The value of a parameter by its name; of an array of version 2.0 all elements, "name[1]" ..., by theirs."""
    sizes = [int(number(d, "size", 0.0, where)) for d in node.findall("{*}Dimension")]
    for child in node:
        written = etree.QName(child).localname
        if written not in (*REALS, *WHOLES, *OTHERS):
            continue
        type_ = "Real" if written in REALS else "Integer" if written in WHOLES else written
        texts = [v.get("value") for v in child.findall("{*}Value")] or [child.get("value")]
        if texts[0] is None:
            raise BadInput(where, f"{written} without value", 'value="..."')
        measure = named(child.get("unit"), measures)
        if sizes and type_ != "String" and len(texts) == 1:
            texts = texts[0].split()
        if len(texts) != prod(sizes):
            raise BadInput(where, f"{counted(len(texts), 'value')} of {name!r}", f"{prod(sizes)}, as its dimensions say")
        indices = [f"[{','.join(map(str, i))}]" for i in product(*(range(1, n + 1) for n in sizes))] if sizes else [""]
        yield from ((name + i, Value(type_, plain(type_, t, where), measure)) for i, t in zip(indices, texts, strict=True))
        return
    raise BadInput(where, f"parameter {node.get('name')!r} of no known type", "a Real, Integer, Boolean, String or Enumeration")


def plain(type_: str, text: str, where: str) -> bool | int | float | str:
    """The text of a value as Python's kind of it."""
    if type_ == "Boolean":
        return truth(text, "value", where)
    if type_ in ("String", "Enumeration", "Binary"):
        return text
    try:
        return bare_number(text) if type_ == "Real" else int(text.replace("_", "?"))
    except ValueError:
        raise BadInput(where, f"value {text!r}", "a number" if type_ == "Real" else "a whole number") from None
