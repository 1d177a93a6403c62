"""A tree of systems as the units and connections of a scene.

A chain of connectors through systems becomes one connection between two components, with all conversions and transformations of the
chain. Parameters of systems become parameters of the variables that they are connected with.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from ....components.core.errors import BadInput, nearest
from ...engine.coupling.arrays import shape_of
from ...settings.names import connection
from .parameters import SHOWN, Assignment, Transformation, Value
from .system import DICTIONARY, GIVES, TAKES, Connection, Connector, Element
from .units_of_measure import between

Path = tuple[str, ...]  # names of elements from the root system down, which has ()
Place = tuple[Path, str]  # a connector or variable of an element


@dataclass(frozen=True)
class Edge:
    """What feeds a connector."""

    source: Place
    connection: Connection


class Flat:
    """Units and connections of a scene, from a root system.

    `units`: settings by unit, `connections` as a scene gives them, `remarks`: what was left out.
    """

    def __init__(self, root: Element, names: Mapping[str, str], starts: bool = False):
        """`names`: of units by the names of elements of the root system, where they are to have others.

        `starts`: values of inputs that a connection drives are start values for other masters, which need no remark.
        """
        self._starts = starts
        self.elements: dict[Path, Element] = dict(_walk(root, ()))
        self.remarks: list[str] = []
        self._edges: dict[Place, Edge] = {}
        self._dictionaries = {id(e): path for path, e in self.elements.items() if e.name.startswith(DICTIONARY)}
        for path, element in self.elements.items():
            if element.refers:
                self._referred(path, element)
            for each in element.connections:
                self._connect(path, element, each)
        self.components = {path: e for path, e in self.elements.items() if e.fmu is not None or e.component}
        self.names = _unit_names(list(self.components), names)
        self.connections = list(self._links())
        self._values = self._assigned(root, ())
        self.units = {self.names[path]: self._settings(path, e) for path, e in self.components.items()}

    def _connect(self, path: Path, system: Element, connection: Connection) -> None:
        """Note which end feeds which: an element's outputs and the system's own inputs are sources, in whichever order the file has them.

        Arrays are connected element by element.
        """
        inner_of = [self._element(path, system, element, connection) for element, _ in connection.ends]
        elements = [inner.arrays.get(name, [name]) for inner, (_, name) in zip(inner_of, connection.ends, strict=True)]
        shapes = [
            shape_of(name, inner.arrays.get(name, [name])) for inner, (_, name) in zip(inner_of, connection.ends, strict=True)
        ]
        if shapes[0] != shapes[1]:
            raise BadInput(connection.where, f"ends of shape {' and '.join(shapes)}", "the same shape at both")
        for names in zip(*elements, strict=True):
            self._connect_scalars(path, connection, inner_of, names)

    def _element(self, path: Path, system: Element, element: str, connection: Connection) -> Element:
        inner = self.elements.get((*path, element)) if element else system
        if inner is not None and inner.refers:
            return self._referred((*path, element), inner)
        if inner is None:
            raise BadInput(
                connection.where,
                f"element {element!r}",
                f"an element of {system.name!r}",
                nearest(element, [e.name for e in system.elements]),
            )
        return inner

    def _referred(self, path: Path, reference: Element) -> Element:
        """The signal dictionary of a reference: the nearest around it."""
        around = (self.elements.get((*path[:k], reference.refers)) for k in range(len(path) - 1, -1, -1))
        if (dictionary := next(filter(None, around), None)) is None:
            raise BadInput(
                reference.where,
                f"a reference to the {reference.refers.replace(':', ' ')}",
                "a signal dictionary of this system or of one around it",
            )
        return dictionary

    def _connect_scalars(self, path: Path, connection: Connection, inner_of: list[Element], names: tuple[str, ...]) -> None:
        gives: list[Place] = []
        takes: list[Place] = []
        either: list[Place] = []
        for (element, _), inner, name in zip(connection.ends, inner_of, names, strict=True):
            if inner.name.startswith(DICTIONARY) and name in inner.connectors:
                either.append((self._dictionaries[id(inner)], name))
                continue
            if name not in inner.connectors and not self._taken_from_fmu(inner, name):
                raise BadInput(
                    connection.where, f"connector {name!r}", f"a connector of {inner.name!r}", nearest(name, inner.connectors)
                )
            outward = inner.connectors[name].kind in GIVES
            (gives if outward == bool(element) else takes).append(((*path, element) if element else path, name))
        if len(either) == 1:
            (takes if gives else gives).extend(either)
        if len(gives) != 1:
            ends = " and ".join(".".join(filter(None, end)) for end in connection.ends)
            raise BadInput(
                connection.where,
                f"{ends}, which both {'give' if gives else 'take'} a value",
                "one that gives and one that takes",
                "As their kinds say.",
            )
        if takes[0] in self._edges:
            raise BadInput(
                connection.where,
                f"connector {_text(takes[0])} driven a second time",
                f"one source; {_text(self._edges[takes[0]].source)} drives it already",
            )
        self._edges[takes[0]] = Edge(gives[0], connection)

    def _taken_from_fmu(self, element: Element, name: str) -> bool:
        """Whether a connector that the file leaves out is a variable of the component's FMU, which then replaces it."""
        scalar = element.description.scalars.get(name) if element.description is not None else None
        if scalar is None or scalar.variable.causality not in GIVES + TAKES:
            return False
        element.connectors = {**element.connectors, name: Connector(name, scalar.variable.causality, "", None)}
        self.remarks.append(f"{element.where}: connector {element.name}.{name} is not listed; the FMU's variable is taken")
        return True

    def _chain(self, target: Place) -> list[tuple[Place, Edge]]:
        """The parts of the way to a connector, from its far end; each with the connector it leads to."""
        chain: list[tuple[Place, Edge]] = []
        while (edge := self._edges.get(target)) is not None:
            if any(edge is e for _, e in chain):
                raise BadInput(edge.connection.where, f"connector {_text(target)} fed by itself", "an output that feeds it")
            chain.insert(0, (target, edge))
            target = edge.source
        return chain

    def _links(self) -> Iterator[str | dict[str, Any]]:
        """Connections of the scene, in the order of the files."""
        for target, edge in list(self._edges.items()):
            if target[0] not in self.components:
                continue
            chain = self._chain(target)
            source = chain[0][1].source
            if source[0] not in self.components:
                continue  # a connector of the root system, or one that nothing feeds: it may still carry a parameter
            kinds = [self._connector(end).kind for end in (source, target)]
            if kinds != ["output", "input"]:
                raise BadInput(
                    edge.connection.where,
                    f"a {kinds[0]} that feeds a {kinds[1]}",
                    "an output that feeds an input",
                    "Give the parameter its value in a parameter set.",
                )
            yield self._link(source, target, chain)

    def _link(self, source: Place, target: Place, chain: list[tuple[Place, Edge]]) -> str | dict[str, Any]:
        measure, factor, offset, entries = self._measure(source), 1.0, 0.0, dict[str, Any]()
        differences = [self.elements[path].is_relative(name) for path, name in (source, target)]
        scaled = any(edge.connection.transformation.given for _, edge in chain)
        relative = all(differences) or (any(differences) and scaled)
        for place, edge in chain:
            own, c = self._measure(place), edge.connection
            t = c.transformation
            a, b = (1.0, 0.0) if c.suppress or t.table is not None else between(measure, own, c.where, relative, t.given)
            if b and any(differences):
                names = [f"a {'difference' if d else 'value'}" for d in differences]
                raise BadInput(c.where, " for ".join(names), "two differences, or none", "Or give a LinearTransformation.")
            if t.table is not None:
                entries = self._mapped(entries, t, c.where)
            factor, offset = t.factor * (a * factor), t.factor * (a * offset + b) + t.offset
            measure = own or (None if c.suppress else measure)
        ends = [f"{self.names[path]}.{name}" for path, name in (source, target)]
        plain, table = connection(ends[0], ends[1], self.names.values()), {"source": ends[0], "target": ends[1]}
        if entries:
            if (factor, offset) != (1.0, 0.0):
                where = chain[-1][1].connection.where
                raise BadInput(where, "a mapping of values and a linear transformation on one way", "one of them")
            return {**table, "map": entries}
        given = [self.components[end[0]].fmu_unit(end[1]) for end in (source, target)]
        more: dict[str, Any] = {"factor": factor, "offset": offset} if (factor, offset) != (1.0, 0.0) else {}
        if all(given) and given[0] != given[1]:
            more["convert_units"] = False  # the conversion is in the factor, or not wanted
        return {**table, **more} if more else plain

    def _mapped(self, entries: Mapping[str, Any], transformation: Transformation, where: str) -> dict[str, Any]:
        """Entries of a mapping behind those before it on the same way, as a scene has them."""
        own = transformation.entries(where)
        if not entries:
            return own
        texts = {key: str(value).lower() if isinstance(value, bool) else str(value) for key, value in entries.items()}
        if missing := [text for text in texts.values() if text not in own]:
            raise BadInput(where, f"no entry for {missing[0]!r}", "one for each value of the mapping before it")
        return {key: own[text] for key, text in texts.items()}

    def _connector(self, place: Place) -> Connector:
        return self.elements[place[0]].connectors[place[1]]

    def _measure(self, place: Place) -> Any:
        element = self.elements[place[0]]
        return element.unit_of(place[1]) if element.fmu is not None else self._connector(place).measure

    # -- parameters --------------------------------------------------------------------------------------------------
    def _assigned(self, element: Element, path: Path) -> dict[Place, Assignment]:
        """Values by what they are assigned to; those of a system stand above those of its elements."""
        by_place: dict[Place, Assignment] = {}
        for inner in element.elements:
            by_place |= self._assigned(inner, (*path, inner.name))
        vain = []
        for assignment in element.parameters:
            places = list(self._meant(element, path, assignment.name))
            by_place |= dict.fromkeys(places, assignment)
            vain += [] if places else [assignment.name]
        self._remark(element, vain, "fit no variable")
        return by_place

    def _remark(self, element: Element, names: list[str], why: str) -> None:
        """Say once for an element which parameters were left out; sets shared by many elements have hundreds of them."""
        if names:
            shown = ", ".join(map(repr, names[:SHOWN])) + (", ..." if len(names) > SHOWN else "")
            self.remarks.append(f"{element.where}: values left out at {element.name!r} because they {why}: {shown}")

    def _meant(self, element: Element, path: Path, name: str) -> Iterator[Place]:
        """All that a hierarchical name means, seen from an element; names of elements may hold dots themselves."""
        if element.description is not None:
            if name in element.description.scalars:
                yield path, name
            return
        if name in element.connectors:
            yield path, name
        for inner in element.elements:
            if name.startswith(inner.name + "."):
                yield from self._meant(inner, (*path, inner.name), name.removeprefix(inner.name + "."))

    def _settings(self, path: Path, element: Element) -> dict[str, Any]:
        """The settings of a unit."""
        if element.component:
            return {"component": element.component}
        assert element.description is not None
        scalars, effects, parameters = element.description.scalars, [], {}
        driven: list[str] = []
        for name, value, where in self._of_component(path, element, driven):
            if not name.startswith("effects."):
                parameters[name] = value
            elif value is True:
                effects.append(name.removeprefix("effects."))
            elif value is not False or scalars[name].start:
                raise BadInput(where, f"{name} = {value!r}", "true; a scene switches effects on")
        self._remark(element, [] if self._starts else driven, "are of inputs that a connection drives")
        interfaces = {"CoSimulation": "co-simulation", "ModelExchange": "model-exchange"}
        interface = {"interface": interfaces[element.implementation]} if element.implementation in interfaces else {}
        return {
            "fmu": str(element.fmu),
            **({"effects": effects} if effects else {}),
            **({"parameters": parameters} if parameters else {}),
            **interface,
        }

    def _of_component(self, path: Path, element: Element, driven: list[str]) -> Iterator[tuple[str, Any, str]]:
        """Values of a component's variables: assigned to them, or to what they are connected with; the farthest end wins.

        Values of inputs that another component feeds have no effect; their names are appended to `driven`.
        """
        assert element.description is not None
        for name in element.description.scalars:
            chain = self._chain((path, name))
            steps = [edge.source for _, edge in chain] + [(path, name)]
            at = next((k for k, place in enumerate(steps) if place in self._values), None)
            if at is None:
                continue
            assignment = self._values[steps[at]]
            if chain and steps[0][0] in self.components:
                driven.append(name)
                continue
            relative, a = element.is_relative(name), assignment
            value = self._converted(a.value, steps[at], a.suppress, a.transformation, a.where, relative)
            for target, edge in chain[at:]:
                c = edge.connection
                value = self._converted(value, target, c.suppress, c.transformation, c.where, relative)
            yield name, value.value, assignment.where

    def _converted(
        self, value: Value, place: Place, suppress: bool, transformation: Transformation, where: str, relative: bool
    ) -> Value:
        """A value in the unit of measure of the place it reaches, then transformed. `relative`: it is a difference."""
        measure = self._measure(place)
        if value.type == "Real" and not suppress:
            factor, offset = between(value.measure, measure, where, relative, transformation.given)
            if (factor, offset) != (1.0, 0.0):
                value = Value("Real", factor * float(value.value) + offset)
        value = value.through(transformation, where)
        return Value(value.type, value.value, measure or (None if suppress else value.measure))


def _walk(element: Element, path: Path) -> Iterator[tuple[Path, Element]]:
    yield path, element
    for inner in element.elements:
        yield from _walk(inner, (*path, inner.name))


def _text(place: Place) -> str:
    return ".".join((*place[0], place[1]))


def _unit_names(paths: list[Path], wished: Mapping[str, str]) -> dict[Path, str]:
    """Names of units as scenes may have them: letters, digits and _, with dots between systems and what is in them."""
    names: dict[Path, str] = {}
    for path in paths:
        parts = re.sub(r"[^\w.]", "_", ".".join(path), flags=re.ASCII).split(".")
        name = ".".join(p if re.match("[A-Za-z]", p) else f"u{p}" for p in parts)
        name = wished.get(path[0], name) if len(path) == 1 else name
        taken, k, first = set(names.values()), 2, name
        while name in taken:
            name, k = f"{first}_{k}", k + 1
        names[path] = name
    return names
