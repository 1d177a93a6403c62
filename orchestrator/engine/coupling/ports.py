"""Ports that are joined: "pantograph.contact <-> catenary.contact" stands for a connection of each pair of their members.

A port is what a component declares as one, an effect, or the common beginning "name." of variables, or a terminal
of an FMU; "name[2]" are the second elements of its arrays. Members of one name belong together, an output of one side with an input
of the other; a terminal may have another rule.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

from ....components.core.errors import BadInput, nearest
from ....components.core.variables import member_of, port_of
from ...units import Interface
from ...units.terminals import Terminal, at_hand
from .graph import Endpoint

RULES = ("bus", "plug", "sequence")  # of terminals: members of one name; all of them by their names; all in their order
JOINABLE = {("signal", "signal"), ("outflow", "inflow"), ("inflow", "outflow")}  # kinds of two members
REMEDY = "Name the variables instead."
_INDEX = re.compile(r"(.*?)(\[[\d,\s]+\])?")


@dataclass(frozen=True)
class _Port:
    """Members of a port that give and that take: what they are called there -> variable of the unit.

    terminal: of an FMU, whose matching rule holds; None for ports of components and common beginnings of names.
    """

    unit: str
    outputs: Mapping[str, str]
    inputs: Mapping[str, str]
    terminal: Terminal | None = None

    @property
    def members(self) -> list[str]:
        """Names of all members, of a terminal in its order."""
        return [m.name for m in self.terminal.members] if self.terminal is not None else [*self.outputs, *self.inputs]

    def kind(self, member: str) -> str:
        """Of a member: "signal", "inflow", "outflow" or one of a maker's own."""
        named = self.terminal.members if self.terminal is not None else ()
        return next((m.kind for m in named if m.name == member), "signal")


def port_pairs(
    ends: tuple[Endpoint, Endpoint], where: str, interfaces: Mapping[str, Interface]
) -> list[tuple[Endpoint, Endpoint]]:
    """(source, target) of every pair of members, those from the first port to the second before those back.

    ends: unit and port of both sides. Raises `BadInput` for ports that a unit does not have, without a pair, or that the rules of
    their terminals keep apart.
    """
    first, second = (_port(end, where, interfaces[end[0]]) for end in ends)
    partner = _partners(first, second, ends, where)
    pairs = [
        ((one.unit, name), (other.unit, other.inputs[there]))
        for one, other, of in ((first, second, partner), (second, first, {b: a for a, b in partner.items()}))
        for member, name in one.outputs.items()
        if (there := of.get(member, "")) in other.inputs
    ]
    sides = " and ".join(
        f"{'.'.join(end)} with {', '.join(sorted({*p.outputs, *p.inputs}))}" for end, p in zip(ends, (first, second), strict=True)
    )
    if not pairs:
        raise BadInput(
            where, sides, "an output of one side and an input of the other with one name", "Name the variables instead."
        )
    if {"plug", "sequence"} & {p.terminal.rule for p in (first, second) if p.terminal is not None}:
        joined = {end for pair in pairs for end in pair}
        for end, port in zip(ends, (first, second), strict=True):
            left = [n for n in port.members if (port.unit, port.outputs.get(n) or port.inputs.get(n)) not in joined]
            if port.terminal is not None and (left := [*left, *port.terminal.missing]):
                what = f"{', '.join(map(repr, left))} of terminal {'.'.join(end)} without a partner"
                raise BadInput(where, what, f"all members joined, by the rule {port.terminal.rule!r}", REMEDY)
    return pairs


def _partners(first: _Port, second: _Port, ends: tuple[Endpoint, Endpoint], where: str) -> dict[str, str]:
    """Members of the first port -> those of the second that they belong to; raises `BadInput` where terminals refuse it."""
    terminals = [p.terminal for p in (first, second) if p.terminal is not None]
    for end, port in zip(ends, (first, second), strict=True):
        if port.terminal is not None:
            rule, streams = port.terminal.rule, port.terminal.streams
            if rule not in RULES or streams:
                what = f"streams: {', '.join(streams)}" if streams else f"the matching rule {rule!r}"
                raise BadInput(where, f"terminal {'.'.join(end)} with {what}", f"one of {', '.join(RULES)}, no streams", REMEDY)
    if len(terminals) == 2:
        for what, a, b in zip(("rule", "kind"), *((t.rule, t.kind) for t in terminals), strict=True):
            if a != b and (what == "rule" or (a and b)):
                raise BadInput(where, f"terminals of {what} {a!r} and {b!r}", f"two of one {what}", REMEDY)
    if any(t.rule == "sequence" for t in terminals):
        if len(terminals) < 2:
            raise BadInput(where, "a terminal of rule 'sequence' and a port without an order", "two such terminals", REMEDY)
        partner = dict(zip(first.members, second.members, strict=False))
    else:
        partner = {name: name for name in first.members if name in second.members}
    for a, b in partner.items():
        if (first.kind(a), second.kind(b)) not in JOINABLE:
            raise BadInput(
                where,
                f"members {a!r} of kind {first.kind(a)!r} and {b!r} of kind {second.kind(b)!r}",
                "two signals, or an outflow and an inflow",
                "Two flows in one direction add to zero, so that a connection would have to change the sign.",
            )
    return partner


def port_names(interface: Interface) -> list[str]:
    """The ports of a unit: declared ones, and common beginnings of its variables."""
    of_terminals = {m.variable for t in interface.terminals.values() for m in t.members}
    variables = [n for n in (*interface.inputs, *interface.outputs) if not {n, n.partition("[")[0]} & of_terminals]
    ports = (port_of(n, interface.ports) or n.partition("[")[0].rpartition(".")[0] for n in variables)
    return list(dict.fromkeys(filter(None, (*interface.terminals, *ports))))


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

    if whole := interface.terminals.get(port):  # a name of a maker's own may end like an element
        name, index = port, ""
    if terminal := whole or interface.terminals.get(name):
        terminal = at_hand(terminal, (*interface.inputs, *interface.outputs), index)
        give, take = (
            {m.name: m.variable for m in terminal.members if m.variable in v} for v in (interface.outputs, interface.inputs)
        )
        both = _Port(unit, give, take, terminal)
    else:
        both = _Port(unit, within(interface.outputs), within(interface.inputs))
    if not (both.outputs or both.inputs):
        raise _no_port(where, end, name, index, interface, set(declared))
    return both


def _no_port(where: str, end: Endpoint, name: str, index: str, interface: Interface, declared: set[str]) -> BadInput:
    beginnings = {p for n in (*interface.outputs, *interface.inputs) if (p := n.partition("[")[0].rpartition(".")[0])}
    known = beginnings | declared | interface.terminals.keys()
    if not index and name in interface.effects and not interface.effects[name]:
        remedy = f"Switch on the effect {name!r}."
    elif index and name in known:
        remedy = f"{name} has no elements {index}."
    else:
        remedy = nearest(name, known) or (
            f"Its ports: {', '.join(sorted(known))}." if known else "It has none; name the variables."
        )
    return BadInput(where, repr(".".join(end)), f"a port of {end[0]}", f"{remedy} {interface.terminals.fault}".strip())
