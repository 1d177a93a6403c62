"""modelDescription.xml of native FMUs, for FMI 2.0 and 3.0; variables, units and texts are those of the pythonfmu FMU.

Sources: FMI 2.0.4, sections 2.2 and 4.3; FMI 3.0.2, sections 2.4 and 4.3.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import Any
from xml.etree import ElementTree as ET

from ..description import (
    DERIVATIVES,
    add_head,
    add_structure,
    add_variable,
    fed_by,
    identity,
    initial_dependencies,
    real_attributes,
    variability_attributes,
    xml_value,
)
from .variables import NativeVariable

ABILITIES = {
    2: {
        "canHandleVariableCommunicationStepSize": "true",
        "canInterpolateInputs": "true",
        "maxOutputDerivativeOrder": "0",
        "canBeInstantiatedOnlyOncePerProcess": "false",
        "canNotUseMemoryManagementFunctions": "true",
        "canGetAndSetFMUstate": "true",
        "canSerializeFMUstate": "true",
        "providesDirectionalDerivative": "true",
    },
    3: {
        "canBeInstantiatedOnlyOncePerProcess": "false",
        "canGetAndSetFMUState": "true",
        "canSerializeFMUState": "true",
        "providesDirectionalDerivatives": "true",
        "canHandleVariableCommunicationStepSize": "true",
        "maxOutputDerivativeOrder": "0",
    },
}
ELEMENTS = {"Real": "Float64", "Integer": "Int32", "Boolean": "Boolean", "String": "String"}
HOST = (
    "This FMU needs no Python. Effects are constants, fixed when it was built, and so are the parameters that are marked; "
    "the others can be set before the run, tunable ones during it." + DERIVATIVES
)


def listed(variables: Iterable[NativeVariable], derivatives: bool) -> list[tuple[int, NativeVariable]]:
    """The variables that an FMU lists, with their value references; `derivatives`: those of inputs as well."""
    return [(k, v) for k, v in enumerate(variables) if v.role != "ABSENT" and (derivatives or not v.scalar.order)]


def description(
    fmi: int,
    name: str,
    component: Any,
    variables: tuple[NativeVariable, ...],
    token: str,
    derivatives: bool = True,
    *,
    abilities: Mapping[str, str] = MappingProxyType({}),
) -> bytes:
    """modelDescription.xml for FMI 2.0 or 3.0; abilities: attributes of the co-simulation beside those of components, or in their
    place.  In FMI 3.0 elements that follow one another are an array."""
    known = identity(name, component, "", **{"guid" if fmi == 2 else "instantiationToken": token})
    root = ET.Element("fmiModelDescription", {"fmiVersion": f"{fmi}.0", **known})
    attributes = {"modelIdentifier": name, "needsExecutionTool": "false", **ABILITIES[fmi], **abilities}
    ET.SubElement(root, "CoSimulation", attributes)
    present = listed(variables, derivatives)
    if fmi == 2:
        _add_variables2(root, component, present)
    else:
        _add_variables3(root, component, present, variables)
    ET.indent(root)
    return ET.tostring(root, encoding="UTF-8", xml_declaration=True) + b"\n"


def _add_variables2(root: ET.Element, component: Any, present: list[tuple[int, NativeVariable]]) -> None:
    """Units of measure, variables and structure as FMI 2.0 has them."""
    scalars = tuple(v.scalar for _, v in present)
    add_head(root, component, scalars)
    parent = ET.SubElement(root, "ModelVariables")
    for reference, variable in present:
        add_variable(parent, reference, variable.scalar)
    add_structure(root, component, scalars)


def _add_variables3(
    root: ET.Element, component: Any, present: list[tuple[int, NativeVariable]], variables: tuple[NativeVariable, ...]
) -> None:
    """Units of measure, variables and structure as FMI 3.0 has them, the time among the variables."""
    present = [(k, v) for k, v in present if v.size]
    add_head(root, component, [v.scalar for _, v in present], 3)
    parent = ET.SubElement(root, "ModelVariables")
    ET.SubElement(
        parent,
        "Float64",
        {
            "name": "time",
            "valueReference": str(len(variables)),
            "description": "simulated time",
            "causality": "independent",
            "variability": "continuous",
            "unit": "s",
        },
    )
    for reference, variable in present:
        _add_variable3(parent, reference, variable, variables[reference : reference + variable.size])
    structure = ET.SubElement(root, "ModelStructure")
    outputs = [(k, v) for k, v in present if v.role == "OUTPUT"]
    inputs = {k: variables[k : k + v.size] for k, v in present if v.role == "INPUT"}

    def fed(names: Iterable[str]) -> list[int]:
        return [k for k, elements in inputs.items() if any(fed_by(names, e.scalar) for e in elements)]

    known = {k: fed([n for e in variables[k : k + v.size] for n in e.scalar.feedthrough]) for k, v in outputs}
    for reference, dependencies in known.items():
        ET.SubElement(structure, "Output", {"valueReference": str(reference), "dependencies": " ".join(map(str, dependencies))})
    # the time is a variable, and a start may follow from it
    always = {len(variables), *(k for k, v in present if v.role == "PARAMETER"), *fed(component.start_inputs or ())}
    for reference, dependencies in known.items():
        ET.SubElement(
            structure,
            "InitialUnknown",
            {"valueReference": str(reference), **initial_dependencies(component, always, dependencies)},
        )


def name_of(variable: NativeVariable) -> str:
    """What FMI 3 calls a variable: an array by its name, without the indices of elements."""
    return variable.scalar.name if variable.size == 1 else variable.scalar.name.partition("[")[0]


def _add_variable3(parent: ET.Element, reference: int, variable: NativeVariable, elements: tuple[NativeVariable, ...]) -> None:
    scalar = variable.scalar
    name = name_of(variable)
    attributes = {"name": name, "valueReference": str(reference), "description": scalar.text, "causality": scalar.causality}
    attributes |= variability_attributes(scalar)
    if scalar.type == "Real":
        attributes |= real_attributes(scalar)
    if scalar.type in ("Real", "Integer"):
        attributes |= {key: repr(limit) for key, limit in (("min", scalar.low), ("max", scalar.high)) if math.isfinite(limit)}
    starts = [xml_value(e.scalar.start) for e in elements]
    if scalar.causality != "output" and scalar.type != "String":
        attributes["start"] = " ".join(starts)
    element = ET.SubElement(parent, ELEMENTS[scalar.type], attributes)
    if len(elements) > 1:
        ET.SubElement(element, "Dimension", {"start": str(len(elements))})
    if scalar.type == "String":
        for text in starts:
            ET.SubElement(element, "Start", {"value": text})
