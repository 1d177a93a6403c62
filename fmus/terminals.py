"""terminalsAndIcons/terminalsAndIcons.xml: the ports of an FMU as terminals.

Own signals of no declared port are the terminal `signals`. Members match by what stands behind the dot of a signal's name.

Source: FMI 3.0.2, section 2.4.9; FMI 2.0 takes the same file, with the version that defines it.
"""

from __future__ import annotations

from collections.abc import Iterable
from xml.etree import ElementTree as ET

from ..components.core.variables import Declared, gathered

OTHERS = "signals"
FILE, ICON = "terminalsAndIcons/terminalsAndIcons.xml", "terminalsAndIcons/icon.png"


def terminals(names: Iterable[str], declared: Declared, companions: Iterable[str] = ()) -> dict[str, dict[str, str]]:
    """Names of terminals -> member -> variable; only what has two members and more.

    declared: ports of the component.  companions: derivatives of inputs.
    """
    groups = {port or OTHERS: members for port, members in gathered(names, declared).items()}
    if listed := list(companions):
        groups["derivatives"] = {name: name for name in listed}
    return {group: members for group, members in groups.items() if len(members) > 1}


def terminals_and_icons(names: Iterable[str], declared: Declared, companions: Iterable[str] = ()) -> bytes:
    """The file, for an icon as wide as high."""
    root = ET.Element("fmiTerminalsAndIcons", {"fmiVersion": "3.0"})
    graphics = ET.SubElement(root, "GraphicalRepresentation")
    corners = {"x1": "-100", "y1": "-100", "x2": "100", "y2": "100"}
    ET.SubElement(graphics, "CoordinateSystem", {**corners, "suggestedScalingFactorTo_mm": "0.1"})
    ET.SubElement(graphics, "Icon", corners)
    if groups := terminals(names, declared, companions):
        parent = ET.SubElement(root, "Terminals")
        for group, members in groups.items():
            terminal = ET.SubElement(parent, "Terminal", {"name": group, "matchingRule": "bus"})
            for member, variable in members.items():
                ET.SubElement(
                    terminal, "TerminalMemberVariable", {"variableName": variable, "memberName": member, "variableKind": "signal"}
                )
    ET.indent(root)
    return ET.tostring(root, encoding="UTF-8", xml_declaration=True) + b"\n"
