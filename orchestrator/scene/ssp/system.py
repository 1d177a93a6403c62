"""The tree of a system as its files say it: systems in systems, components with their FMU, connectors, connections.

Arrays of version 2.0 become their elements, "name[1]" or "name[1,2]", as those of FMUs do.

Source: System Structure and Parameterization 1.0 and 2.0, chapter 5 (SSD); ssp-standard.org.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import count, product
from math import prod
from pathlib import Path
from urllib.parse import unquote

from lxml import etree

from ....components.core.errors import BadInput, nearest
from ...units.description import Description
from ...units.description import read as read_description
from .package import DEFAULT, LARGEST_TEXT, NAMESPACES, Package, find_all, number, parsed, required, truth
from .parameters import REALS, WHOLES, Assignment, Transformation, assignments, content, transformation
from .units_of_measure import Measure, definitions, named, of_fmu

FMU, DEFINITION, ARCHIVE = "application/x-fmu-sharedlibrary", "application/x-ssp-definition", "application/x-ssp-package"
GIVES = ("output", "calculatedParameter", "constant")  # kinds of connectors, as their element is seen
TAKES = ("input", "parameter", "structuralParameter")
EITHER = "inout"  # of entries of signal dictionaries
DICTIONARY = "signal dictionary:"  # before the name of a dictionary among the elements of a system
INSIDE = ("local",)  # no connection reaches it
TYPES = {
    "Boolean": "boolean",
    "String": "string",
    "Enumeration": "enumeration",
    "Binary": "binary",
    **dict.fromkeys(REALS, "real"),
    **dict.fromkeys(WHOLES, "integer"),
}
UNREAD = ("Clock",)
STEPS = {"FixedStepAlgorithm": "baseStepSize", "FixedStepMaster": "stepSize"}  # of libcosim and of OMSimulator
DEEPEST = 32  # systems in systems; more of them is a file that contains itself
MOST = 10_000  # elements; files that each name the next one twice would make millions


@dataclass(frozen=True)
class Connector:
    """One connector; `type` is "" and `measure` None where the file says nothing of them."""

    name: str
    kind: str
    type: str
    measure: Measure | None


@dataclass(frozen=True)
class Connection:
    """One connection between connectors of the elements of a system, or of the system itself (element "")."""

    ends: tuple[tuple[str, str], tuple[str, str]]  # (element, connector); which of them gives follows from their kinds
    transformation: Transformation
    suppress: bool  # no conversion of units of measure
    where: str


@dataclass
class Element:
    """A component with its FMU, or a system with its elements."""

    name: str
    where: str
    connectors: Mapping[str, Connector]
    parameters: tuple[Assignment, ...]  # in rising priority
    elements: tuple[Element, ...] = ()
    connections: tuple[Connection, ...] = ()
    fmu: Path | None = None
    component: str = ""  # "module:Class" of a function of the system itself, which no FMU has
    refers: str = ""  # the element of a signal dictionary that a reference stands for, here or in a system around
    description: Description | None = None
    measures: Mapping[str, Measure] = field(default_factory=dict)  # that the FMU defines
    arrays: dict[str, list[str]] = field(default_factory=dict)  # elements of connectors that are arrays
    implementation: str = "any"
    step_hint: float | None = None  # s, of Open Simulation Platform's annotation

    def unit_of(self, variable: str) -> Measure | None:
        """The unit of measure of a component's variable: of its connector, or else of the FMU's variable."""
        connector = self.connectors.get(variable)
        if connector is not None and connector.measure is not None:
            return connector.measure
        return named(self.fmu_unit(variable), self.measures)

    def fmu_unit(self, variable: str) -> str:
        """The name of the unit of measure that the FMU itself gives a variable, or ""; numbers are what a function has."""
        if self.component:
            return "1"
        scalar = self.description.scalars.get(variable) if self.description else None
        return scalar.unit if scalar is not None else ""

    def is_relative(self, variable: str) -> bool:
        """Whether a variable of the FMU is a difference."""
        scalar = self.description.scalars.get(variable) if self.description else None
        return scalar is not None and scalar.relative


class Document:
    """One .ssd file of a package."""

    def __init__(self, package: Package, name: str, first: Document | None = None):
        """`first`: the document of the root system, with which this one shares remarks and the count of elements."""
        self._numbers: Iterator[int] = count(1) if first is None else first._numbers
        self.remarks: list[str] = package.remarks if first is None else first.remarks  # what was accepted and is not used
        self.package, self.name = package.beside(name), name
        self.where = package.label(name)
        self.root = parsed(package.read(name, self.where, LARGEST_TEXT), self.where, self.remarks)
        version = self.root.get("version", "")
        if self.root.tag != f"{{{NAMESPACES['ssd']}}}SystemStructureDescription" or version[:2] not in ("1.", "2."):
            raise BadInput(self.where, f"{self.root.tag}, version {version!r}", "a SystemStructureDescription of SSP 1.0 or 2.0")
        self.measures = definitions(self.root, "ssd", self.where)

    @property
    def title(self) -> str:
        """What the file says of the system, or its name."""
        return self.root.get("description") or self.root.get("name", "")

    def times(self) -> tuple[float | None, float | None]:
        """Start and end of the default experiment, s; None for what is not given."""
        given: list[float | None] = [None, None]
        for node, (k, key) in product(find_all(self.root, "ssd:DefaultExperiment"), enumerate(("startTime", "stopTime"))):
            if node.get(key) is not None:
                given[k] = number(node, key, 0.0, self.where)
        return given[0], given[1]

    def step(self) -> float | None:
        """The macro step of an annotation of other tools, s."""
        for node in self.root.iter(*(f"{{*}}{name}" for name in STEPS)):
            return number(node, STEPS[etree.QName(node).localname], 0.0, self.where)
        return None

    def system(self, depth: int = 0, of: str = "") -> Element:
        """The root system, or the one with the id `of`, with all that is in it. `depth`: systems around it."""
        systems = [n for n in self.root.iter("{*}System") if n.get("id") == of] if of else find_all(self.root, "ssd:System")
        if not systems:
            raise BadInput(self.where, f"no System with the id {of!r}" if of else "no System", "one")
        if len(systems) > 1:
            names = ", ".join(repr(n.get("name", "")) for n in systems)
            raise BadInput(self.where, f"{len(systems)} systems, {names}", "one", "Put them into one system as its elements.")
        return self._system(systems[0], required(systems[0], "name", self.where), depth)

    def _at(self, element: etree._Element) -> str:
        return f"{self.where}:{element.sourceline}"

    def _system(self, node: etree._Element, name: str, depth: int) -> Element:
        if depth > DEEPEST:
            raise BadInput(self._at(node), f"systems nested more than {DEEPEST} deep", "fewer", "Does a file contain itself?")
        elements = [self._dictionary(n) for n in find_all(node, "ssd:SignalDictionaries", "ssd:SignalDictionary")]
        for child in (c for group in find_all(node, "ssd:Elements") for c in group):
            label = required(child, "name", self.where)
            if label in {e.name for e in elements}:
                raise BadInput(self._at(child), f"a second element {label!r}", "names that are unique within a system")
            if next(self._numbers) > MOST:
                raise BadInput(
                    self._at(child),
                    f"a system of more than {MOST} elements",
                    "fewer",
                    "Do its files name one another many times?",
                )
            kinds = {"System": self._system, "SignalDictionaryReference": self._reference}
            elements.append(kinds.get(etree.QName(child).localname, self._component)(child, label, depth + 1))
        system = Element(
            name,
            self._at(node),
            self._connectors(node),
            self._parameters(node, None),
            tuple(elements),
            tuple(self._connection(c) for c in find_all(node, "ssd:Connections", "ssd:Connection")),
        )
        system.arrays = self._arrays(node)
        system.connectors = {e: replace(c, name=e) for n, c in system.connectors.items() for e in system.arrays.get(n, [n])}
        return system

    def _dictionary(self, node: etree._Element) -> Element:
        """A signal dictionary as an element whose connectors are its entries, which take and give."""
        where, name = self._at(node), required(node, "name", self.where)
        root, place = content(node, "", "ssb:SignalDictionary", self.package, None, where)
        if root is None:
            raise BadInput(where, f"signal dictionary {name!r} without content", "a source, or a SignalDictionary inside")
        measures, connectors = definitions(root, "ssb", place), {}
        for entry in find_all(root, "ssb:DictionaryEntry"):
            if any(etree.QName(t).localname == "Dimension" for t in entry):
                raise BadInput(place, f"entry {entry.get('name')!r} that is an array", "entries of one value")
            types = [t for t in entry if etree.QName(t).localname in TYPES]
            unit, label = types[0].get("unit") if types else None, required(entry, "name", place)
            connectors[label] = Connector(label, EITHER, "", named(unit, measures))
        return Element(DICTIONARY + name, where, connectors, ())

    def _reference(self, node: etree._Element, name: str, depth: int) -> Element:
        """What stands for a signal dictionary of this system or of one around it."""
        return Element(name, self._at(node), {}, (), refers=DICTIONARY + required(node, "dictionary", self.where))

    def _component(self, node: etree._Element, name: str, depth: int) -> Element:
        where, kind, source = self._at(node), node.get("type") or FMU, required(node, "source", self.where)
        if node.get("implementation") == "ScheduledExecution":
            self.remarks.append(f"{where}: {name!r} is to be run by scheduled execution; its interface for co-simulation is used")
        if kind in (DEFINITION, ARCHIVE) or source.startswith("#"):
            referenced = self._referenced(source, kind, name, depth, where)
            referenced.parameters = (*referenced.parameters, *self._parameters(node, None))
            return referenced
        if kind != FMU:
            raise BadInput(where, f"a component of type {kind!r}", f"one of {FMU}, {DEFINITION}, {ARCHIVE}")
        path = self.package.fmu(source, where)
        description = read_description(str(path), where)
        measures = of_fmu(description.model)
        hints = [number(h, "value", 0.0, self.where) for h in node.iter("{*}StepSizeHint")]
        element = Element(
            name,
            where,
            self._connectors(node),
            self._parameters(node, path),
            fmu=path,
            description=description,
            measures=measures,
            implementation=node.get("implementation", "any"),
            step_hint=hints[0] if hints else None,
        )
        self._check(element)
        return element

    def _referenced(self, source: str, kind: str, name: str, depth: int, where: str) -> Element:
        """A system in another place: of this file by its id, in another .ssd file, or in an archive of its own."""
        place, _, fragment = source.partition("#")
        fragment, of = unquote(fragment), ""
        if not place:
            nodes = [n for n in self.root.iter("{*}System") if n.get("id") == fragment]
            if not nodes:
                raise BadInput(where, f"source {source!r}", "the id of a system of this file")
            return self._system(nodes[0], name, depth)
        if kind == ARCHIVE:
            path = self.package.inside(place, where)
            package = Package.zipped(self.package.label(path), self.package.read(path, where))
            package.remarks = self.remarks
            document = Document(package, fragment or DEFAULT, self)
        else:
            document, of = Document(self.package, self.package.inside(place, where), self), fragment
        element = document.system(depth, of)
        element.name = name
        return element

    def _connectors(self, node: etree._Element) -> dict[str, Connector]:
        connectors = {}
        for child in find_all(node, "ssd:Connectors", "ssd:Connector"):
            name, kind = required(child, "name", self.where), required(child, "kind", self.where)
            if kind not in GIVES + TAKES + INSIDE:
                raise BadInput(self._at(child), f"connector {name!r} of kind {kind!r}", f"one of {', '.join(TAKES + GIVES)}")
            types = [t for t in child if etree.QName(t).localname in (*TYPES, *UNREAD)]
            unit = types[0].get("unit") if types else None
            connectors[name] = Connector(name, kind, etree.QName(types[0]).localname if types else "", named(unit, self.measures))
        return connectors

    def _arrays(self, node: etree._Element) -> dict[str, list[str]]:
        """Elements of a system's connectors that are arrays of version 2.0."""
        arrays = {}
        for child in find_all(node, "ssd:Connectors", "ssd:Connector"):
            name = child.get("name", "")
            if dimensions := child.findall("{*}Dimension"):
                sizes = [int(number(d, "size", 0.0, self.where)) for d in dimensions]
                if not 0 < prod(sizes) <= MOST:
                    raise BadInput(
                        self._at(child),
                        f"connector {name!r} of sizes {sizes}",
                        f"at most {MOST} elements",
                        "Give sizes as numbers: that of a system's connector cannot follow from another connector.",
                    )
                arrays[name] = [f"{name}[{','.join(map(str, i))}]" for i in product(*(range(1, n + 1) for n in sizes))]
        return arrays

    def _connection(self, node: etree._Element) -> Connection:
        where = self._at(node)
        ends = tuple((node.get(f"{end}Element", ""), required(node, f"{end}Connector", self.where)) for end in ("start", "end"))
        suppress = truth(node.get("suppressUnitConversion", "false"), "suppressUnitConversion", where)
        return Connection((ends[0], ends[1]), transformation(node, where), suppress, where)

    def _parameters(self, node: etree._Element, fmu: Path | None) -> tuple[Assignment, ...]:
        return tuple(
            a
            for binding in find_all(node, "ssd:ParameterBindings", "ssd:ParameterBinding")
            for a in assignments(binding, self.package, fmu, self._at(binding))
        )

    def _check(self, element: Element) -> None:
        """Connectors of a component against the variables of its FMU."""
        assert element.description is not None
        scalars = element.description.scalars
        for n, s in scalars.items():
            if s.variable.dimensions:
                element.arrays.setdefault(s.variable.name, []).append(n)
        connectors = {e: replace(c, name=e) for n, c in element.connectors.items() for e in element.arrays.get(n, [n])}
        for name in [n for n, c in connectors.items() if n not in scalars or c.type in UNREAD]:
            kind = connectors[name].type
            reason = f"its type is {kind}" if kind in UNREAD else f"the FMU has no such variable. {nearest(name, scalars)}"
            self.remarks.append(f"{element.where}: connector {element.name}.{name} left out: {reason}")
        element.connectors = {n: c for n, c in connectors.items() if n in scalars and c.type not in UNREAD}
        for connector in element.connectors.values():
            scalar = scalars[connector.name]
            label = f"connector {element.name}.{connector.name}"
            causality, kind = scalar.variable.causality, TYPES.get(connector.type, scalar.kind)
            alike = {"structuralParameter": "parameter", "constant": "output"}  # constants are outputs or locals of an FMU
            if alike.get(causality, causality) != alike.get(connector.kind, connector.kind) and (causality, connector.kind) != (
                "local",
                "constant",
            ):
                raise BadInput(element.where, f"{label} of kind {connector.kind!r}", f"{causality!r}, as the FMU says")
            if kind != scalar.kind:
                raise BadInput(element.where, f"{label} of type {connector.type}", f"{scalar.variable.type}, as the FMU says")
            own, declared = connector.measure, named(element.fmu_unit(connector.name), element.measures)
            if own and declared and own.meaning and declared.meaning and own.meaning != declared.meaning:
                raise BadInput(element.where, f"{label} in {own.name!r}", f"{declared.name!r}, as the FMU says")
