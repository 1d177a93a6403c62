"""The texts of an FMU that are written at build time: modelDescription.xml and documentation/index.html.

Source: FMI for Model Exchange and Co-Simulation 2.0.4, sections 2.2 and 4.3.
"""

from __future__ import annotations

import html
import inspect
import math
from collections.abc import Iterable
from importlib.metadata import version
from typing import Any
from xml.etree import ElementTree as ET

from ..components.core.measure import BASES, parse
from .interface import Scalar, interface

LOG_CATEGORIES = {
    "logStatusWarning": "Something was refused; the run goes on.",
    "logStatusDiscard": "A step was discarded.",
    "logStatusError": "A value cannot be used, or the unit has failed.",
    "logAll": "All messages.",
}


def model_description(name: str, component: Any, guid: str) -> bytes:
    """modelDescription.xml of the FMU `name`."""
    release = version("cosimo")
    root = ET.Element("fmiModelDescription", {
        "fmiVersion": "2.0", "modelName": name, "guid": guid, "description": component.title, "version": release,
        "license": "MIT", "generationTool": f"cosimo {release} with PythonFMU {version('pythonfmu')}",
        "variableNamingConvention": "structured",
    })
    ET.SubElement(root, "CoSimulation", {
        "modelIdentifier": name, "needsExecutionTool": "true", "canHandleVariableCommunicationStepSize": "true",
        "canInterpolateInputs": "false", "maxOutputDerivativeOrder": "0", "canBeInstantiatedOnlyOncePerProcess": "false",
        "canNotUseMemoryManagementFunctions": "true", "canGetAndSetFMUstate": "true", "canSerializeFMUstate": "true",
        "providesDirectionalDerivative": "false",
    })
    scalars = interface(component)
    add_head(root, component, {s.unit for s in scalars if s.type == "Real"})
    variables = ET.SubElement(root, "ModelVariables")
    for reference, scalar in enumerate(scalars):
        add_variable(variables, reference, scalar)
    add_structure(root, scalars)
    ET.indent(root)
    return ET.tostring(root, encoding="UTF-8", xml_declaration=True) + b"\n"


def add_head(root: ET.Element, component: Any, units: Iterable[str]) -> None:
    """Units, categories of messages and default experiment."""
    definitions = ET.SubElement(root, "UnitDefinitions")
    for name in sorted(units):
        unit = parse(name)
        base = {b: str(e) for b, e in zip(BASES, unit.exponents, strict=True) if e}
        if unit.factor != 1.0:
            base["factor"] = repr(unit.factor)
        if unit.offset:
            base["offset"] = repr(unit.offset)
        ET.SubElement(ET.SubElement(definitions, "Unit", {"name": name}), "BaseUnit", base)
    categories = ET.SubElement(root, "LogCategories")
    for category, text in LOG_CATEGORIES.items():
        ET.SubElement(categories, "Category", {"name": category, "description": text})
    ET.SubElement(root, "DefaultExperiment", {
        "startTime": "0", "stopTime": repr(component.default_stop), "stepSize": repr(component.default_step)})


def add_variable(parent: ET.Element, reference: int, scalar: Scalar) -> None:
    """One ScalarVariable; a local one is a constant."""
    attributes = {"name": scalar.name, "valueReference": str(reference), "description": scalar.text}
    attributes["causality"] = scalar.causality
    if scalar.causality == "parameter":
        attributes |= {"variability": "fixed", "initial": "exact"}
    elif scalar.causality == "local":
        attributes |= {"variability": "constant", "initial": "exact"}
    elif scalar.causality == "output":
        attributes |= {"variability": "continuous", "initial": "calculated"}
    else:
        attributes |= {"variability": "continuous"}
    value: dict[str, str] = {}
    if scalar.type == "Real":
        value["unit"] = scalar.unit
    if scalar.type in ("Real", "Integer"):
        value |= {key: repr(limit) for key, limit in (("min", scalar.low), ("max", scalar.high)) if math.isfinite(limit)}
    if scalar.nominal != 1.0:
        value["nominal"] = repr(scalar.nominal)
    if scalar.causality != "output":
        value["start"] = str(scalar.start).lower() if scalar.type == "Boolean" else str(scalar.start)
    ET.SubElement(ET.SubElement(parent, "ScalarVariable", attributes), scalar.type, value)


def add_structure(root: ET.Element, scalars: tuple[Scalar, ...]) -> None:
    """Outputs with the inputs they depend on within an instant; at the start they may depend on everything."""
    structure = ET.SubElement(root, "ModelStructure")
    outputs = [(i, s) for i, s in enumerate(scalars, 1) if s.causality == "output"]
    if not outputs:
        return
    inputs = {s.name: i for i, s in enumerate(scalars, 1) if s.causality == "input"}
    unknowns, initial = ET.SubElement(structure, "Outputs"), ET.SubElement(structure, "InitialUnknowns")
    for index, scalar in outputs:
        known = [i for n, i in inputs.items() if n in scalar.feedthrough or n.partition("[")[0] in scalar.feedthrough]
        ET.SubElement(unknowns, "Unknown", {"index": str(index), "dependencies": " ".join(map(str, known))})
        ET.SubElement(initial, "Unknown", {"index": str(index)})


HOST = """The host needs Python 3.11 or newer with NumPy{scipy}; Numba makes the FMU fast.</p>
<p>Effects are off unless the parameter <code>effects.&lt;name&gt;</code> is true."""


def documentation(name: str, component: Any, scalars: tuple[Scalar, ...] = (), host: str = HOST) -> bytes:
    """documentation/index.html: the equations as they stand in the source, and the variables."""
    host = host.format(scipy=" and SciPy" if component.needs_scipy else "")
    rows = "\n".join(
        "<tr>" + "".join(f"<td>{html.escape(c)}</td>" for c in (s.name, s.causality, _shown(s), s.unit, s.text)) + "</tr>"
        for s in scalars or interface(component) if s.order == 0
    )
    return f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>{name}</title></head><body>
<h1>{name}: {html.escape(component.title)}</h1>
<pre>{html.escape(inspect.getdoc(component) or "")}</pre>
<p>{host} For each input <code>v</code> the inputs
<code>der(v)</code> and <code>der(v,2)</code> let a master extrapolate: they hold for the next step, then they are 0 again.</p>
<table><tr><th>name</th><th>causality</th><th>start</th><th>unit</th><th>meaning</th></tr>
{rows}
</table></body></html>
""".encode()


def _shown(scalar: Scalar) -> str:
    return "" if scalar.causality == "output" else str(scalar.start)
