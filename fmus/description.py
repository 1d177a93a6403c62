"""The texts of an FMU that are written at build time.

modelDescription.xml and documentation/index.html: FMI for Model Exchange and Co-Simulation 2.0.4, sections 2.2 and 4.3, with
units (2.2.2: shown value = factor value + offset) and types of real variables (2.2.3).
terminalsAndIcons/terminalsAndIcons.xml has the ports of an FMU as terminals: FMI 3.0.2, section 2.4.9; FMI 2.0 takes the same
file, with the version that defines it. Own signals of no declared port are the terminal `signals`. Members match by what stands
behind the dot of a signal's name.
"""

from __future__ import annotations

import html
import inspect
import math
import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

from ..components.core.errors import BadInput
from ..components.core.measure import BASES, parse
from ..components.core.variables import Declared, gathered
from .interface import Scalar, interface
from .picture import icon
from .versions import version

RELEASED = "2026-11-22T00:00:00Z"  # of this version's source; the variable SOURCE_DATE_EPOCH gives another date
AUTHOR = "the cosimo developers"
LICENSE = Path(__file__).parent.parent / "LICENSE"
LOG_CATEGORIES = {
    "logStatusWarning": "Something was refused; the run goes on.",
    "logStatusDiscard": "A step was discarded.",
    "logStatusError": "A value cannot be used, or the unit has failed.",
    "logAll": "All messages.",
}


def identity(name: str, component: Any, tool: str, **token: str) -> dict[str, str]:
    """Attributes of the root that tell what an FMU is and where it comes from; `tool`: beside this project."""
    release = version("cosimo")
    epoch = os.environ.get("SOURCE_DATE_EPOCH", "")
    date = datetime.fromtimestamp(int(epoch), UTC).strftime("%Y-%m-%dT%H:%M:%SZ") if epoch.isdigit() else RELEASED
    return {
        "modelName": name,
        **token,
        "description": component.title,
        "author": AUTHOR,
        "version": release,
        "copyright": f"Copyright (c) {RELEASED[:4]} {AUTHOR}",
        "license": "MIT",
        "generationTool": f"cosimo {release}{tool}",
        "generationDateAndTime": date,
        "variableNamingConvention": "structured",
    }


def model_description(name: str, component: Any, guid: str, derivatives: bool = True) -> bytes:
    """modelDescription.xml of the FMU `name`; without `derivatives` of inputs their value references stay unused."""
    root = ET.Element(
        "fmiModelDescription",
        {"fmiVersion": "2.0", **identity(name, component, f" with PythonFMU {version('pythonfmu')}", guid=guid)},
    )
    ET.SubElement(
        root,
        "CoSimulation",
        {
            "modelIdentifier": name,
            "needsExecutionTool": "true",
            "canHandleVariableCommunicationStepSize": "true",
            "canInterpolateInputs": "false",
            "maxOutputDerivativeOrder": "0",
            "canBeInstantiatedOnlyOncePerProcess": "false",
            "canNotUseMemoryManagementFunctions": "true",
            "canGetAndSetFMUstate": "true",
            "canSerializeFMUstate": "true",
            "providesDirectionalDerivative": "false",
        },
    )
    listed = [(k, s) for k, s in enumerate(interface(component)) if derivatives or not s.order]
    scalars = tuple(s for _, s in listed)
    add_head(root, component, scalars)
    variables = ET.SubElement(root, "ModelVariables")
    for reference, scalar in listed:
        add_variable(variables, reference, scalar)
    add_structure(root, component, scalars)
    ET.indent(root)
    return ET.tostring(root, encoding="UTF-8", xml_declaration=True) + b"\n"


def add_head(root: ET.Element, component: Any, scalars: Iterable[Scalar], fmi: int = 2) -> None:
    """Units with those to show them in, types, categories of messages and default experiment."""
    units = {s.unit for s in scalars if s.type == "Real" and s.unit} | ({"s"} if fmi == 3 else set())
    definitions = ET.SubElement(root, "UnitDefinitions")
    for name in sorted(units):
        try:
            unit = parse(name)
        except BadInput:  # of a column of a table: what nobody defines has a name
            ET.SubElement(definitions, "Unit", {"name": name})
            continue
        base = {b: str(e) for b, e in zip(BASES, unit.exponents, strict=True) if e}
        if unit.factor != 1.0:
            base["factor"] = repr(unit.factor)
        if unit.offset:
            base["offset"] = repr(unit.offset)
        element = ET.SubElement(definitions, "Unit", {"name": name})
        ET.SubElement(element, "BaseUnit", base)
        for shown, (factor, offset) in SHOWN.get(name, {}).items():
            numbers = {"factor": repr(factor)} | ({"offset": repr(offset)} if offset else {})
            ET.SubElement(element, "DisplayUnit", {"name": shown, **numbers})
    _add_types(root, units, fmi, moving=any(s.moving for s in scalars))
    categories = ET.SubElement(root, "LogCategories")
    for category, text in LOG_CATEGORIES.items():
        ET.SubElement(categories, "Category", {"name": category, "description": text})
    ET.SubElement(
        root,
        "DefaultExperiment",
        {
            "startTime": repr(start) if (start := getattr(component, "default_start", 0.0)) else "0",
            "stopTime": repr(component.default_stop),
            "stepSize": repr(component.default_step),
            **_tolerance(component),
        },
    )


def _add_types(root: ET.Element, units: Iterable[str], fmi: int, *, moving: bool) -> None:
    types = [(TYPES[unit], unit) for unit in sorted(units) if unit in TYPES] + ([(MOVING, "m")] if moving else [])
    definitions = ET.SubElement(root, "TypeDefinitions") if types else root
    for name, unit in types:
        attributes = {"quantity": TYPES[unit], "unit": unit}
        if shown := [] if unit == "m" else list(SHOWN.get(unit, {})):  # lengths are of all sizes: each has its own
            attributes["displayUnit"] = shown[0]
        if fmi == 3:
            ET.SubElement(definitions, "Float64Type", {"name": name, **attributes})
        else:
            ET.SubElement(ET.SubElement(definitions, "SimpleType", {"name": name}), "Real", attributes)


def _tolerance(component: Any) -> dict[str, str]:
    """Of a component that has such a parameter: what its own accuracy is without a change."""
    declared = component.variables.get("tolerance")
    return {} if declared is None else {"tolerance": repr(float(declared.start))}


def real_attributes(scalar: Scalar) -> dict[str, str]:
    """Type, units and nominal value of a real variable."""
    of = quantity(scalar)
    return {
        **({"declaredType": of.type} if of.type else {}),
        **({"unit": scalar.unit} if scalar.unit else {}),
        **({"displayUnit": of.display} if of.display else {}),
        "nominal": repr(typical_size(scalar)),
        **({"relativeQuantity": "true"} if scalar.relative else {}),
    }


def shared_files(name: str, component: Any, scalars: Iterable[Scalar], fmi: int = 2) -> dict[str, bytes]:
    """Files beside the model description that hosts may show: icon, terminals, license. Path in the FMU -> content.

    `scalars`: what the FMU lists; in FMI 3 the elements of an array are one variable of the array's name.
    """
    listed = [s for s in scalars if s.causality in ("input", "output")]
    ends = [s for s in listed if not s.order]
    picture = icon(name, *(sum(s.causality == c for s in ends) for c in ("input", "output")))
    return {
        FILE: terminals_and_icons(
            (s.name for s in ends), component.ports, component.port_members, (s.name for s in listed if s.order)
        ),
        ICON: picture,
        **({"model.png": picture} if fmi == 2 else {}),
        "documentation/licenses/license.txt": LICENSE.read_bytes(),
    }


def variability_attributes(scalar: Scalar) -> dict[str, str]:
    """Variability, and how the value at the start comes about; of an input it follows."""
    initial = {"output": "calculated", "input": ""}.get(scalar.causality, "exact")
    return {"variability": scalar.variability, **({"initial": initial} if initial else {})}


def add_variable(parent: ET.Element, reference: int, scalar: Scalar) -> None:
    """One ScalarVariable; a local one is a constant."""
    attributes = {"name": scalar.name, "valueReference": str(reference), "description": scalar.text}
    attributes["causality"] = scalar.causality
    attributes |= variability_attributes(scalar)
    value: dict[str, str] = {}
    if scalar.type == "Real":
        value |= real_attributes(scalar)
    if scalar.type in ("Real", "Integer"):
        value |= {key: repr(limit) for key, limit in (("min", scalar.low), ("max", scalar.high)) if math.isfinite(limit)}
    if scalar.causality != "output":
        value["start"] = xml_value(scalar.start)
    ET.SubElement(ET.SubElement(parent, "ScalarVariable", attributes), scalar.type, value)


def xml_value(value: Any) -> str:
    """A value as XML writes it."""
    if isinstance(value, bool):
        return str(value).lower()
    return ("INF" if value > 0 else "-INF") if isinstance(value, float) and math.isinf(value) else str(value)


def fed_by(names: Iterable[str], scalar: Scalar) -> bool:
    """Whether an input, or the array of which it is an element, is among declared names."""
    return scalar.name in names or scalar.name.partition("[")[0] in names


def add_structure(root: ET.Element, component: Any, scalars: tuple[Scalar, ...]) -> None:
    """Outputs with the inputs they depend on within an instant.

    At the start they also depend on the inputs from which the initial state follows, and on parameters; on which of these is not
    declared, so that all are listed. Where the inputs are not declared, the list is left out, which means all variables.
    """
    structure = ET.SubElement(root, "ModelStructure")
    outputs = [(i, s) for i, s in enumerate(scalars, 1) if s.causality == "output"]
    if not outputs:
        return
    inputs = {i: s for i, s in enumerate(scalars, 1) if s.causality == "input"}
    start = component.start_inputs
    always = {
        *(i for i, s in enumerate(scalars, 1) if s.causality == "parameter"),
        *(i for i, s in inputs.items() if fed_by(start or (), s)),
    }
    unknowns, initial = ET.SubElement(structure, "Outputs"), ET.SubElement(structure, "InitialUnknowns")
    for index, scalar in outputs:
        known = [i for i, s in inputs.items() if fed_by(scalar.feedthrough, s)]
        ET.SubElement(unknowns, "Unknown", {"index": str(index), "dependencies": _listed(known)})
        ET.SubElement(initial, "Unknown", {"index": str(index)} | initial_dependencies(component, always, known))


def initial_dependencies(component: Any, always: set[int], known: Iterable[int]) -> dict[str, str]:
    """The attribute of an initial unknown, from what all outputs and what this one depends on."""
    return {} if component.start_inputs is None else {"dependencies": _listed(sorted({*always, *known}))}


def _listed(numbers: Iterable[int]) -> str:
    return " ".join(map(str, numbers))


DERIVATIVES = """ For each input <code>v</code> the inputs
<code>der(v)</code> and <code>der(v,2)</code> let a master extrapolate: they hold for the next step, then they are 0 again."""
HOST = (
    """The host needs Python 3.11 or newer with NumPy{scipy}; Numba makes the FMU fast.</p>
<p>Effects are off unless the parameter <code>effects.&lt;name&gt;</code> is true."""
    + DERIVATIVES
)


def documentation(name: str, component: Any, scalars: tuple[Scalar, ...] = (), host: str = HOST, section: str = "") -> bytes:
    """documentation/index.html: the equations as they stand in the source, a section of HTML, and the variables."""
    host = host.format(scipy=" and SciPy" if component.needs_scipy else "")
    rows = "\n".join(
        "<tr>" + "".join(f"<td>{html.escape(c)}</td>" for c in (s.name, s.causality, _shown(s), s.unit, s.text)) + "</tr>"
        for s in scalars or interface(component)
        if s.order == 0
    )
    drawing = getattr(component, "drawing", "")
    return f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>{name}</title></head><body>
<h1>{name}: {html.escape(component.title)}</h1>
{drawing}<pre>{html.escape(inspect.getdoc(component) or "")}</pre>
<p>{host}</p>
{section}<table><tr><th>name</th><th>causality</th><th>start</th><th>unit</th><th>meaning</th></tr>
{rows}
</table></body></html>
""".encode()


def _shown(scalar: Scalar) -> str:
    return "" if scalar.causality == "output" else str(scalar.start)


OTHERS = "signals"
FILE, ICON = "terminalsAndIcons/terminalsAndIcons.xml", "terminalsAndIcons/icon.png"


def terminals(
    names: Iterable[str], declared: Declared, members: Mapping[str, str], companions: Iterable[str] = ()
) -> dict[str, dict[str, str]]:
    """Names of terminals -> member -> variable; only what has two members and more.

    declared, members: ports of the component, and what signals are called in them.  companions: derivatives of inputs.
    """
    groups = {port or OTHERS: signals for port, signals in gathered(names, declared, members).items()}
    if listed := list(companions):
        groups["derivatives"] = {name: name for name in listed}
    return {group: signals for group, signals in groups.items() if len(signals) > 1}


def terminals_and_icons(
    names: Iterable[str], declared: Declared, members: Mapping[str, str], companions: Iterable[str] = ()
) -> bytes:
    """The file, for an icon as wide as high."""
    root = ET.Element("fmiTerminalsAndIcons", {"fmiVersion": "3.0"})
    graphics = ET.SubElement(root, "GraphicalRepresentation")
    corners = {"x1": "-100", "y1": "-100", "x2": "100", "y2": "100"}
    ET.SubElement(graphics, "CoordinateSystem", {**corners, "suggestedScalingFactorTo_mm": "0.1"})
    ET.SubElement(graphics, "Icon", corners)
    if groups := terminals(names, declared, members, companions):
        parent = ET.SubElement(root, "Terminals")
        for group, signals in groups.items():
            terminal = ET.SubElement(parent, "Terminal", {"name": group, "matchingRule": "bus"})
            for member, variable in signals.items():
                ET.SubElement(
                    terminal, "TerminalMemberVariable", {"variableName": variable, "memberName": member, "variableKind": "signal"}
                )
    ET.indent(root)
    return ET.tostring(root, encoding="UTF-8", xml_declaration=True) + b"\n"


# unit of measure -> units to show it in, (factor, offset); the first one is the type's
SHOWN = {
    "rad": {"deg": (180.0 / math.pi, 0.0)},
    "rad/s": {"rpm": (30.0 / math.pi, 0.0), "deg/s": (180.0 / math.pi, 0.0)},
    "K": {"degC": (1.0, -273.15)},
    "m": {"mm": (1e3, 0.0)},
}
TYPES = {
    "m": "Length",
    "m/s": "Velocity",
    "m/s2": "Acceleration",
    "m2": "Area",
    "m3": "Volume",
    "rad": "Angle",
    "rad/s": "AngularVelocity",
    "rad/s2": "AngularAcceleration",
    "s": "Time",
    "Hz": "Frequency",
    "kg": "Mass",
    "kg.m2": "MomentOfInertia",
    "N": "Force",
    "N.m": "Torque",
    "N/m": "Stiffness",
    "N.s/m": "Damping",
    "N.m/rad": "AngularStiffness",
    "N.m.s/rad": "AngularDamping",
    "m/N": "Compliance",
    "Pa": "Pressure",
    "J": "Energy",
    "W": "Power",
    "K": "Temperature",
    "W/K": "ThermalConductance",
    "J/K": "HeatCapacity",
    "V": "Voltage",
    "A": "Current",
    "Ohm": "Resistance",
    "H": "Inductance",
    "kg/m3": "Density",
    "m3/s": "VolumeFlowRate",
}
MOVING = "MovingPosition"  # type of inputs that a master is not to hold over a step
SHORT = 0.1  # m: lengths of this size and below are shown in mm
SPINS = ("speed",)  # parts of the names of angular velocities that are shown in rpm


@dataclass(frozen=True)
class Quantity:
    """What a real variable's declaration adds to its unit; "" where it has no such."""

    type: str
    display: str


def quantity(scalar: Scalar) -> Quantity:
    """The type and the display unit of a real variable."""
    return Quantity(MOVING if scalar.moving else TYPES.get(scalar.unit, ""), _display(scalar))


def _display(scalar: Scalar) -> str:
    if scalar.unit == "m":
        return "mm" if 0.0 < typical_size(scalar) <= SHORT else ""
    if scalar.unit == "rad/s":
        return "rpm" if any(part in scalar.name for part in SPINS) else "deg/s"
    return next(iter(SHOWN.get(scalar.unit, {})), "")


def typical_size(scalar: Scalar) -> float:
    """The nominal value: as declared, or of a parameter the size of its start value."""
    start = scalar.start
    if scalar.nominal == 1.0 and scalar.causality in ("parameter", "local") and isinstance(start, float) and math.isfinite(start):
        return abs(start) or 1.0
    return scalar.nominal
