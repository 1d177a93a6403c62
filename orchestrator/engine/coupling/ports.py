"""Ports that are joined: "pantograph.contact <-> catenary.contact" stands for a connection of each pair of their members.

A port is what a component declares as one, an effect, or the common beginning "name." of variables; "name[2]" are the second
elements of its arrays. Members of one name belong together, an output of one side with an input of the other.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

from ....components.core.errors import BadInput, nearest
from ....components.core.variables import member_of, port_of
from ...units import Interface
from .graph import Endpoint

JOINED = "<->"
_INDEX = re.compile(r"(.*?)(\[[\d,\s]+\])?")


@dataclass(frozen=True)
class _Port:
    """Members of a port that give and that take: what they are called there -> variable of the unit."""

    unit: str
    outputs: Mapping[str, str]
    inputs: Mapping[str, str]


def port_pairs(
    ends: tuple[Endpoint, Endpoint], where: str, interfaces: Mapping[str, Interface]
) -> list[tuple[Endpoint, Endpoint]]:
    """(source, target) of every pair of members, those from the first port to the second before those back.

    ends: unit and port of both sides. Raises `BadInput` for ports that a unit does not have, or without a pair.
    """
    first, second = (_port(end, where, interfaces[end[0]]) for end in ends)
    pairs = [
        ((one.unit, name), (other.unit, other.inputs[member]))
        for one, other in ((first, second), (second, first))
        for member, name in one.outputs.items()
        if member in other.inputs
    ]
    if not pairs:
        sides = " and ".join(
            f"{'.'.join(end)} with {', '.join(sorted({*p.outputs, *p.inputs}))}"
            for end, p in zip(ends, (first, second), strict=True)
        )
        raise BadInput(
            where, sides, "an output of one side and an input of the other with one name", "Name the variables instead."
        )
    return pairs


def port_names(interface: Interface) -> list[str]:
    """The ports of a unit: declared ones, and common beginnings of its variables."""
    variables = (*interface.inputs, *interface.outputs)
    ports = (port_of(n, interface.ports) or n.partition("[")[0].rpartition(".")[0] for n in variables)
    return list(dict.fromkeys(filter(None, ports)))


def _port(end: Endpoint, where: str, interface: Interface) -> _Port:
    unit, port = end
    matched = _INDEX.fullmatch(port)
    assert matched is not None
    name, index = matched[1], (matched[2] or "").replace(" ", "")
    declared, members = interface.ports, interface.port_members

    def within(variables: Mapping[str, object]) -> dict[str, str]:
        chosen = {}
        for variable in variables:
            whole, bracket, rest = variable.partition("[")
            if name not in (port_of(variable, declared), whole.rpartition(".")[0]) and not whole.startswith(f"{name}."):
                continue
            if index and bracket + rest != index:
                continue
            chosen[member_of(whole, members) + ("" if index else bracket + rest)] = variable
        return chosen

    both = _Port(unit, within(interface.outputs), within(interface.inputs))
    if not (both.outputs or both.inputs):
        raise _no_port(where, end, name, index, interface, set(declared))
    return both


def _no_port(where: str, end: Endpoint, name: str, index: str, interface: Interface, declared: set[str]) -> BadInput:
    known = {p for n in (*interface.outputs, *interface.inputs) if (p := n.partition("[")[0].rpartition(".")[0])} | declared
    if not index and name in interface.effects and not interface.effects[name]:
        remedy = f"Switch on the effect {name!r}."
    elif index and name in known:
        remedy = f"{name} has no elements {index}."
    else:
        remedy = nearest(name, known) or (
            f"Its ports: {', '.join(sorted(known))}." if known else "It has none; name the variables."
        )
    return BadInput(where, repr(".".join(end)), f"a port of {end[0]}", remedy)
