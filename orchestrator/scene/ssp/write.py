"""A scene as an .ssp file with its FMUs inside, valid against SSP 1.0.

Written so that the importers that exist can read it: libcosim matches prefixes letter by letter and wants all namespaces
declared at the root, one parameter set for each component, no nested systems, no conversion of units but by a linear
transformation; OMSimulator wants identifiers as names of elements, its own annotation as the first one of its place, and
none at components; FMPy wants no inputs without connection.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from lxml import etree

from ....components.core.errors import BadInput
from ....components.core.measure import BASES, Unit, parse
from ....fmus.build import write as write_zip
from ....fmus.versions import version
from ...engine.coupling import Coupling
from ...engine.coupling.graph import Link
from ...units.description import Description
from ...units.description import read as read_description
from ...units.interface import Signal
from ...units.kinds import UnitKind
from ...units.values import members
from ..scene import Scene
from .package import DEFAULT, NAMESPACES
from .read import ANNOTATION, NAMESPACE
from .units_of_measure import Measure, of_fmu

PREFIXES = {
    **{letters: space for letters, space in NAMESPACES.items() if letters != "ssb"},  # signal dictionaries are read alone
    "osp": "http://opensimulationplatform.com/SSP/OSPAnnotations",
    "cosimo": NAMESPACE,
    "oms": "https://raw.githubusercontent.com/OpenModelica/OMSimulator/master/schema/oms.xsd",
}
TYPES = {"real": "Real", "integer": "Integer", "boolean": "Boolean", "string": "String", "enumeration": "Enumeration"}
IN_THE_SYSTEM = ("units", "connections", "start_time", "stop_time")  # what the standard's own elements say
PARAMETER_SET = "initialValues"  # the name that Ecos applies by default
TOLERANCE = "0.0001"  # of OMSimulator's master; it has no effect with a fixed step, but must be there


def check(scene: Scene, path: Path) -> None:
    """Raises `BadInput` for contacts, whose laws are the master's, so that no other tool could run them; and for a path that
    names no package.
    """
    if scene.contacts:
        raise BadInput(
            f"{scene.name}: contacts",
            "a contact law that the master integrates",
            "connections between units",
            "A package holds FMUs and connections only.",
        )
    if path.suffix != ".ssp":
        raise BadInput("output", repr(str(path)), "a file name that ends in .ssp")


def write(scene: Scene, path: Path, starts: Mapping[str, Mapping[str, float]] | None = None) -> Path:
    """Write the scene to an .ssp file and return its path; the same scene gives the same bytes. Raises `BadInput` as `check`.

    `starts`: by unit, what its connected inputs are when the scene has been initialized. Other masters do not look for values
    that fit together: with these the units begin as they do in the scene.
    """
    check(scene, path)
    system = _System(scene, starts or {})
    try:
        text = system.text()
    except ValueError as error:
        if isinstance(error, BadInput):
            raise
        raise BadInput(scene.name, "a text that XML cannot hold", "texts without control characters", f"{error}.") from None
    try:
        return write_zip({DEFAULT: text, **{place: file.read_bytes() for place, file in system.files.items()}}, path)
    except OSError as error:
        raise BadInput("output", repr(str(path)), "a file that can be written", f"{error.strerror}.") from None


class _System:
    """The description of a scene, and the FMUs that it names."""

    def __init__(self, scene: Scene, starts: Mapping[str, Mapping[str, float]]):
        self.scene, self.coupling, self.starts = scene, scene.coupling, starts
        self.files: dict[str, Path] = {}  # place in the package -> FMU
        self.names = _identifiers(scene.units)
        self.sources = {name: self._packed(kind) for name, kind in scene.kinds.items()}
        self.descriptions = {name: read_description(str(self.files[s]), f"units.{name}") for name, s in self.sources.items()}
        self.measures: dict[str, Unit] = {}
        self.enumerations: dict[str, Mapping[str, int]] = {}

    def _packed(self, kind: UnitKind) -> str:
        """The place of a unit's FMU in the package; units with the same FMU share it.

        Places of two FMUs differ in more than capitals, which not every file system tells where the package is unpacked.
        """
        file = kind.fmu_file()
        stem = re.sub(r"\W", "_", file.stem, flags=re.ASCII)
        there = {place.casefold(): place for place in self.files}
        for k in range(1, len(self.files) + 2):
            place = f"resources/{stem}{'' if k == 1 else f'_{k}'}.fmu"
            place = there.get(place.casefold(), place)
            if self.files.setdefault(place, file) == file:
                return place
        raise AssertionError  # one of the numbers is free

    def text(self) -> bytes:
        """SystemStructure.ssd."""
        scene = self.scene
        root = etree.Element(
            _tag("ssd:SystemStructureDescription"), {"version": "1.0", "name": _identifier(scene.name)}, nsmap=PREFIXES
        )
        if scene.title:
            root.set("description", scene.title)
        root.set("generationTool", f"cosimo {version('cosimo')}")
        system = _add(root, "ssd:System", name="system")
        elements = _add(system, "ssd:Elements")
        for name in scene.units:
            self._component(elements, name)
        links = [*self.coupling.links, *self.coupling.texts]
        if links:
            connections = _add(system, "ssd:Connections")
            for link in links:
                self._connection(connections, link)
        _add(_add(_annotation(system, "org.openmodelica"), "oms:Annotations"), "oms:SimulationInformation").append(
            etree.Element(
                _tag("oms:FixedStepMaster"),
                {
                    "description": "oms-ma",
                    "stepSize": repr(scene.master.step),
                    "absoluteTolerance": TOLERANCE,
                    "relativeTolerance": TOLERANCE,
                },
            )
        )
        self._definitions(root)
        self._experiment(root)
        etree.indent(root)
        return etree.tostring(root, encoding="UTF-8", xml_declaration=True) + b"\n"

    def _component(self, parent: etree._Element, name: str) -> None:
        component = _add(
            parent, "ssd:Component", name=self.names[name], type="application/x-fmu-sharedlibrary", source=self.sources[name]
        )
        interface = self.scene.units[name].interface
        if interface is not None:
            component.set("implementation", {"co-simulation": "CoSimulation", "model-exchange": "ModelExchange"}[interface])
        connectors = list(_used(name, self.coupling))
        if connectors:
            group = _add(component, "ssd:Connectors")
            for variable, kind in connectors:
                self._type(_add(group, "ssd:Connector", name=variable, kind=kind), name, variable)
        scalars = self.descriptions[name].scalars
        driven = {link.target[1] for link in self.coupling.links if link.target[0] == name}
        values = self.scene.kinds[name].fmu_values(name) | {
            n: v for n, v in self.starts.get(name, {}).items() if n in driven and v != scalars[n].start
        }
        if values:
            binding = _add(_add(component, "ssd:ParameterBindings"), "ssd:ParameterBinding")
            inline = _add(_add(binding, "ssd:ParameterValues"), "ssv:ParameterSet", version="1.0", name=PARAMETER_SET)
            group = _add(inline, "ssv:Parameters")
            for variable, value in values.items():
                self._value(_add(group, "ssv:Parameter", name=variable), name, variable, value)

    def _type(self, connector: etree._Element, name: str, variable: str) -> None:
        """The type of a connector, with its unit of measure or enumeration."""
        scalar = self.descriptions[name].scalars[variable]
        type_ = _add(connector, f"ssc:{TYPES[scalar.kind]}")
        declared = scalar.variable.declaredType
        if scalar.kind == "enumeration" and declared is not None:
            label, items, k = declared.name, members(scalar), 2
            while self.enumerations.setdefault(label, items) != items:  # another FMU has something else of this name
                label, k = f"{declared.name}_{k}", k + 1
            type_.set("name", label)
        unit = scalar.unit
        if (
            scalar.kind == "real"
            and unit
            and (meaning := _meaning(unit, self.descriptions[name])) is not None
            and self.measures.setdefault(unit, meaning) == meaning
        ):  # else another FMU means something else by this name
            type_.set("unit", unit)

    def _value(self, parameter: etree._Element, name: str, variable: str, value: Any) -> None:
        scalar = self.descriptions[name].scalars[variable]
        if scalar.kind == "enumeration" and not isinstance(value, str):
            value = next((n for n, v in members(scalar).items() if v == value), value)
        if scalar.kind == "integer" and not -(2**31) <= value < 2**31:
            raise BadInput(
                f"{self.scene.name}: units.{name}.parameters",
                f"{variable} = {value}",
                "a whole number of 32 bits",
                "SSP 1.0 has no others.",
            )
        text = str(value).lower() if isinstance(value, bool) else repr(float(value)) if scalar.kind == "real" else str(value)
        _add(parameter, f"ssv:{TYPES[scalar.kind]}", value=text)

    def _connection(self, parent: etree._Element, link: Link) -> None:
        """Units of measure that differ are converted by the transformation, which every importer understands."""
        connection = _add(
            parent,
            "ssd:Connection",
            startElement=self.names[link.source[0]],
            startConnector=link.source[1],
            endElement=self.names[link.target[0]],
            endConnector=link.target[1],
        )
        interfaces = self.coupling.interfaces
        units = {interfaces[link.source[0]].outputs[link.source[1]].unit, interfaces[link.target[0]].inputs[link.target[1]].unit}
        if len(units - {""}) == 2:
            connection.set("suppressUnitConversion", "true")
        if link.map:
            self._map(connection, link)
        elif (link.factor, link.offset) != (1.0, 0.0):
            _add(connection, "ssc:LinearTransformation", factor=repr(link.factor), offset=repr(link.offset))

    def _map(self, connection: etree._Element, link: Link) -> None:
        """The entries of a map by the names that their values have at either end."""
        source = self.coupling.interfaces[link.source[0]].outputs[link.source[1]]
        target = self.coupling.interfaces[link.target[0]].inputs[link.target[1]]
        transformation = _add(connection, f"ssc:{TYPES[source.kind]}MappingTransformation")
        for pair in link.map:
            texts = [_text_of(signal, int(value)) for signal, value in zip((source, target), pair, strict=True)]
            _add(transformation, "ssc:MapEntry", source=texts[0], target=texts[1])

    def _definitions(self, root: etree._Element) -> None:
        if self.enumerations:
            group = _add(root, "ssd:Enumerations")
            for name, items in self.enumerations.items():
                enumeration = _add(group, "ssc:Enumeration", name=name)
                for item, number in items.items():
                    _add(enumeration, "ssc:Item", name=item, value=str(number))
        if self.measures:
            group = _add(root, "ssd:Units")
            for name, unit in sorted(self.measures.items()):
                base = {b: str(e) for b, e in zip(BASES, unit.exponents, strict=True) if e}
                base |= {"factor": repr(unit.factor)} if unit.factor != 1.0 else {}
                base |= {"offset": repr(unit.offset)} if unit.offset else {}
                _add(_add(group, "ssc:Unit", name=name), "ssc:BaseUnit", **base)

    def _experiment(self, root: etree._Element) -> None:
        """Start and stop time, libcosim's step, and all of the scene that has no other place."""
        scene = self.scene
        experiment = _add(root, "ssd:DefaultExperiment", startTime=repr(scene.start_time), stopTime=repr(scene.stop_time))
        _add(
            _add(_annotation(experiment, "com.opensimulationplatform"), "osp:Algorithm"),
            "osp:FixedStepAlgorithm",
            baseStepSize=repr(scene.master.step),
        )
        settings = scene.model_dump(mode="json", exclude_unset=True)
        in_the_set = ("fmu", "component", "signals", "preset", "effects", "parameters", "interface")
        units = {n: {k: v for k, v in u.items() if k not in in_the_set} for n, u in settings["units"].items()}
        own = {
            "scene": {k: v for k, v in settings.items() if k not in IN_THE_SYSTEM},
            "units": {n: u for n, u in units.items() if u},
            "elements": {element: name for name, element in self.names.items()},
        }
        _add(_annotation(experiment, ANNOTATION), "cosimo:Scene").text = json.dumps(own, indent=1)


def _text_of(signal: Signal, value: int) -> str:
    """A truth value, a whole number or a member of an enumeration as a mapping has it."""
    if signal.kind == "boolean":
        return "true" if value else "false"
    return next((name for name, number in signal.members.items() if number == value), str(value))


def _tag(name: str) -> str:
    prefix, _, local = name.partition(":")
    return f"{{{PREFIXES[prefix]}}}{local}"


def _add(parent: etree._Element, tag: str, /, **attributes: str) -> etree._Element:
    return etree.SubElement(parent, _tag(tag), attributes)


def _annotation(parent: etree._Element, type_: str) -> etree._Element:
    group = parent.find(_tag("ssd:Annotations"))
    return _add(_add(parent, "ssd:Annotations") if group is None else group, "ssc:Annotation", type=type_)


def _identifier(name: str) -> str:
    text = re.sub(r"\W", "_", name, flags=re.ASCII)
    return text if re.match("[A-Za-z]", text) else f"s_{text}"


def _identifiers(units: Iterable[str]) -> dict[str, str]:
    """Names of elements for the names of units, which may hold dots."""
    identifiers: dict[str, str] = {}
    for name in units:
        element = first = _identifier(name)
        k = 2
        while element in identifiers.values():
            element, k = f"{first}_{k}", k + 1
        identifiers[name] = element
    return identifiers


def _used(name: str, coupling: Coupling) -> Iterator[tuple[str, str]]:
    """Connectors of a unit, (variable, kind): connected inputs, connected and recorded outputs."""
    links = [*coupling.links, *coupling.texts]
    inputs = {link.target[1] for link in links if link.target[0] == name}
    outputs = {link.source[1] for link in links if link.source[0] == name} | {v for u, v in coupling.signals if u == name}
    interface = coupling.interfaces[name]
    yield from ((v, "input") for v in interface.inputs if v in inputs)
    yield from ((v, "output") for v in interface.outputs if v in outputs)


def _meaning(unit: str, description: Description) -> Unit | None:
    """What an FMU means by the name of a unit: by its own definition, or as it is commonly written."""
    measure: Measure | None = of_fmu(description.model).get(unit)
    if measure is not None:
        return measure.meaning
    try:
        return parse(unit)
    except BadInput:
        return None
