"""An OspSystemStructure.xml of Open Simulation Platform as the tree of a system, as libcosim reads such a file.

Functions are between variables only: a linear transformation becomes that of a connection, a sum a unit of its own. libcosim hands
on numbers, whatever units of measure the FMUs name, and so does the scene, which says where they differ.

Source: libcosim (2025), data/xsd/OspSystemStructure.xsd 0.1 and src/cosim/osp_config_parser.cpp; groups of variables:
OspModelDescription.xml of OSP-IS.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from lxml import etree

from ....components.core.errors import BadInput, nearest
from ...units.description import read as read_description
from .package import LARGEST_TEXT, Package, number, parsed, required
from .parameters import Assignment, Transformation, Value, plain
from .sum_component import MOST, Sum
from .system import GIVES, TAKES, Connection, Connector, Element
from .units_of_measure import of_fmu

STEP = 0.1  # s: libcosim's, where the file has none
KNOWN = ("StartTime", "EndTime", "BaseStepSize", "Algorithm", "Simulators", "Functions", "Connections", "EccoConfiguration")
FUNCTIONS = ("LinearTransformation", "Sum", "VectorSum")
CONNECTIONS = tuple(f"{kind}Connection" for kind in ("Variable", "Signal", "VariableGroup", "SignalGroup"))
VALUES = ("Real", "Integer", "Boolean", "String", "Enumeration")


class End(NamedTuple):
    """A variable of a simulator, or of a function that became a unit."""

    element: str
    name: str


class Structure:
    """One OspSystemStructure.xml."""

    def __init__(self, package: Package, name: str):
        self.remarks: list[str] = package.remarks
        self.package = package.beside(name)
        self.where = package.label(name)
        self.title = Path(name).stem
        self.root = parsed(package.read(name, self.where, LARGEST_TEXT), self.where, self.remarks)
        if _kind(self.root) != "OspSystemStructure" or self.root.get("version") != "0.1":
            actual = f"{self.root.tag}, version {self.root.get('version', '')!r}"
            raise BadInput(self.where, actual, "an OspSystemStructure of version 0.1")
        self._known(self.root, *KNOWN)
        self._elements: dict[str, Element] = {}
        self._files: dict[str, etree._Element | None] = {}  # of the groups of a simulator's variables
        self._connections: list[Connection] = []
        self._signals: set[tuple[str, ...]] = set()
        self._reached: dict[tuple[str, ...], list[list[End]]] = {}  # variables, by the signal of a function

    def times(self) -> tuple[float | None, float | None]:
        """Start and end of the run, s; None for an end that is not given."""
        return self._number("StartTime", 0.0), self._number("EndTime", None)

    def step(self) -> float | None:
        """The base step, s."""
        step = self._number("BaseStepSize", None)
        if step is None:
            self.remarks.append(f"{self.where}: no BaseStepSize is given; {STEP:g} s is taken, as libcosim does")
        if (step := STEP if step is None else step) <= 0.0:
            raise BadInput(self.where, f"BaseStepSize {step:g}", "a step above 0 s")
        return step

    def system(self) -> Element:
        """The system with all simulators, and with what functions come to."""
        algorithm = (self._text("Algorithm") or "fixedStep").lower()
        if algorithm not in ("fixedstep", "ecco"):
            raise BadInput(self.where, f"Algorithm {algorithm!r}", "fixedStep or ecco")
        if algorithm == "ecco":
            self.remarks.append(f"{self.where}: the control of the step by ecco is not read; steps are those of BaseStepSize")
        for node in self._children("Simulators", "Simulator"):
            self._add(self._simulator(node), node)
        functions = self._children("Functions", *FUNCTIONS)
        self._signals = {name for node in functions for name in self._signals_of(node)}
        for node in self._children("Connections", *CONNECTIONS):
            kind = _kind(node).removesuffix("Connection")
            if kind.startswith("Variable"):
                if [_kind(end) for end in node] != [kind] * 2:
                    raise BadInput(self._at(node), f"{kind}Connection with {len(node)} ends", f"two of {kind}")
                first, second = (self._end(end) for end in node)
                for pair in self._pairs(first, second, node) if kind == "VariableGroup" else [(first, second)]:
                    self._connect(*pair, node)
            else:
                self._signal(node)
        for node in functions:
            self._function(node)
        return Element(self.title, self.where, {}, (), tuple(self._elements.values()), tuple(self._connections))

    # -- simulators ----------------------------------------------------------------------------------------------------
    def _simulator(self, node: etree._Element) -> Element:
        name, where = required(node, "name", self.where), self._at(node)
        path = self.package.fmu(required(node, "source", self.where), where)
        description = read_description(str(path), where)
        scalars = description.scalars
        connectors = {
            n: Connector(n, s.variable.causality, "", None)
            for n, s in scalars.items()
            if s.variable.causality in (*GIVES, *TAKES)
        }
        places = (path.parent, Path(self.package.name).parent)
        files = [f for f in (p / f"{description.model.modelName}_OspModelDescription.xml" for p in places) if f.is_file()]
        self._files[name] = (
            parsed(self.package.read(str(files[0].absolute()), where, LARGEST_TEXT), str(files[0]), self.remarks)
            if files
            else None
        )
        return Element(
            name,
            where,
            connectors,
            tuple(self._initial_values(node, name, list(scalars))),
            fmu=path,
            description=description,
            measures=of_fmu(description.model),
            step_hint=number(node, "stepSize", 0.0, self.where),
        )

    def _initial_values(self, node: etree._Element, name: str, variables: list[str]) -> Iterator[Assignment]:
        given = set[str]()
        for child in node.iterfind("{*}InitialValues/{*}InitialValue"):
            variable, where = required(child, "variable", self.where), self._at(child)
            values = [c for c in child if _kind(c) in VALUES and c.get("value") is not None]
            if not values:
                raise BadInput(where, f"no value of {variable!r}", f"one of {', '.join(VALUES)}, with value")
            if variable not in variables:
                raise BadInput(where, f"variable {variable!r}", f"a variable of {name!r}", nearest(variable, variables))
            if variable in given:
                raise BadInput(where, f"a second initial value of {variable!r}", "one of each variable")
            given.add(variable)
            value = Value(_kind(values[0]), plain(_kind(values[0]), values[0].get("value", ""), where))
            yield Assignment(variable, value, Transformation(), False, where)

    def _add(self, element: Element, node: etree._Element) -> None:
        if element.name in self._elements:
            raise BadInput(self._at(node), f"a second {element.name!r}", "names that are unique")
        self._elements[element.name] = element

    # -- connections ---------------------------------------------------------------------------------------------------
    def _connect(self, first: End, second: End, node: etree._Element, transformation: Transformation | None = None) -> None:
        """A connection of numbers, in whichever order the ends are given."""
        units = [self._elements[e].fmu_unit(n) if e in self._elements else "" for e, n in (first, second)]
        if all(units) and units[0] != units[1] and "1" not in units and transformation is None:
            self.remarks.append(
                f"{self._at(node)}: {first.element}.{first.name} is in {units[0]}, {second.element}.{second.name} in {units[1]}; "
                "numbers are handed on unchanged, as libcosim does"
            )
        self._connections.append(Connection((first, second), transformation or Transformation(), True, self._at(node)))

    def _pairs(self, first: End, second: End, node: etree._Element) -> Iterator[tuple[End, End]]:
        """Variables of two groups, one by one in their order, and those of groups in them."""
        groups = [(self._group(end, node), end.element) for end in (first, second)]

        def paired(a: etree._Element, b: etree._Element) -> Iterator[tuple[End, End]]:
            for kind in (True, False):
                parts = [[c for c in group if (_kind(c) == "Variable") is kind] for group in (a, b)]
                if len(parts[0]) != len(parts[1]):
                    names = [
                        f"{len(p)} {'variables' if kind else 'groups'} in {g.get('name')!r}"
                        for p, g in zip(parts, (a, b), strict=True)
                    ]
                    raise BadInput(self._at(node), " and ".join(names), "as many at both ends")
                for x, y in zip(*parts, strict=True):
                    if kind:
                        yield End(groups[0][1], _ref(x, self.where)), End(groups[1][1], _ref(y, self.where))
                    else:
                        yield from paired(x, y)

        return paired(groups[0][0], groups[1][0])

    def _group(self, end: End, node: etree._Element) -> etree._Element:
        root = self._files.get(end.element)
        if root is None:
            model = self._elements[end.element].description if end.element in self._elements else None
            name = f"{model.model.modelName}_OspModelDescription.xml" if model else "a simulator of this file"
            raise BadInput(self._at(node), f"a group {end.name!r} of {end.element!r}", name, "It names the variables of a group.")
        groups = [g for g in root.iterfind("{*}VariableGroups//*") if _kind(g) != "Variable"]
        named = [g for g in groups if g.get("name") == end.name]
        if not named:
            known = [g.get("name", "") for g in groups]
            raise BadInput(self._at(node), f"group {end.name!r}", f"a group of {end.element!r}", nearest(end.name, known))
        return named[0]

    # -- functions -----------------------------------------------------------------------------------------------------
    def _signals_of(self, node: etree._Element) -> list[tuple[str, str]]:
        """(function, signal) of all that a function has."""
        name, terms = required(node, "name", self.where), range(self._terms(node))
        return [(name, signal) for signal in (*(self._input(node, k) for k in terms), "out")]

    def _input(self, node: etree._Element, k: int) -> str:
        return "in" if _kind(node) == "LinearTransformation" else f"in[{k}]"

    def _terms(self, node: etree._Element) -> int:
        return 1 if _kind(node) == "LinearTransformation" else self._whole(node, "inputCount")

    def _signal(self, node: etree._Element) -> None:
        """Note which variables, of a group all of them, a signal of a function is connected with."""
        group = _kind(node).removeprefix("Signal").removesuffix("Connection")
        ends = {_kind(end): end for end in node}
        if ends.keys() != {f"Signal{group}", f"Variable{group}"} or len(node) != len(ends):
            raise BadInput(self._at(node), ", ".join(map(_kind, node)) or "no end", f"one Signal{group} and one Variable{group}")
        signal = tuple(required(ends[f"Signal{group}"], key, self.where) for key in ("function", "name"))
        if signal not in self._signals:
            raise BadInput(
                self._at(node), f"signal {signal[1]!r} of function {signal[0]!r}", "a signal of a function of this file"
            )
        end = self._end(ends[f"Variable{group}"])
        members = [End(end.element, _ref(v, self.where)) for v in self._group(end, node)] if group else [end]
        self._reached.setdefault(signal, []).append(members)

    def _function(self, node: etree._Element) -> None:
        """A transformation is that of its connections; a sum becomes a unit for each of its dimensions."""
        name, linear, terms = required(node, "name", self.where), _kind(node) == "LinearTransformation", self._terms(node)
        size = self._whole(node, "dimension") if _kind(node) == "VectorSum" else 1
        reached = [self._reached.get(signal, []) for signal in self._signals_of(node)]
        for k, ends in enumerate(reached):
            is_input = k < terms
            if not ends or (is_input and len(ends) > 1) or any(len(members) != size for members in ends):
                sizes = " and ".join(str(len(members)) for members in ends) or "no"
                raise BadInput(
                    self._at(node),
                    f"{self._input(node, k) if is_input else 'out'!r} of {name!r} connected with {sizes} variables",
                    f"{size}{'' if is_input else ', once or more often'}",
                )
        if linear:
            factors = Transformation(number(node, "factor", 1.0, self.where), number(node, "offset", 0.0, self.where), given=True)
            for target in reached[-1]:
                self._connect(reached[0][0][0], target[0], node, factors)
            return
        for j in range(size):
            unit = f"{name}_{j}" if _kind(node) == "VectorSum" else name
            ports = {f"term[{k + 1}]": "input" for k in range(terms)} | {"out": "output"}
            connectors = {n: Connector(n, kind, "", None) for n, kind in ports.items()}
            self._add(Element(unit, self._at(node), connectors, (), component=f"{Sum.__module__}:{Sum.__name__}"), node)
            for k in range(terms):
                self._connect(reached[k][0][j], End(unit, f"term[{k + 1}]"), node)
            for target in reached[-1]:
                self._connect(End(unit, "out"), target[j], node)

    def _whole(self, node: etree._Element, attribute: str) -> int:
        text = required(node, attribute, self.where)
        if not text.isascii() or not text.isdigit() or not 1 <= int(text[:9]) <= MOST:
            raise BadInput(self._at(node), f"{attribute} {text!r}", f"a whole number from 1 to {MOST}")
        return int(text)

    # -- the file ------------------------------------------------------------------------------------------------------
    def _children(self, group: str, *kinds: str) -> list[etree._Element]:
        """What one of the file's lists has; kinds: that it may have."""
        nodes = self.root.findall(f"{{*}}{group}")
        for node in nodes:
            self._known(node, *kinds)
        return [child for node in nodes for child in node]

    def _known(self, node: etree._Element, *kinds: str) -> None:
        for child in node:
            if _kind(child) not in kinds:
                raise BadInput(self._at(child), f"<{_kind(child)}>", f"one of {', '.join(kinds)}")

    def _text(self, kind: str) -> str:
        return (self.root.findtext(f"{{*}}{kind}") or "").strip()

    def _number(self, kind: str, default: float | None) -> float | None:
        node = self.root.find(f"{{*}}{kind}")
        if node is None or not self._text(kind):
            return default
        node.set(kind, self._text(kind))
        return number(node, kind, 0.0, self.where)

    def _end(self, node: etree._Element) -> End:
        return End(required(node, "simulator", self.where), required(node, "name", self.where))

    def _at(self, node: etree._Element) -> str:
        return f"{self.where}:{node.sourceline}"


def _kind(node: etree._Element) -> str:
    return etree.QName(node).localname


def _ref(node: etree._Element, where: str) -> str:
    return required(node, "ref", where)
