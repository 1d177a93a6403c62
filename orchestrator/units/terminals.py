"""Terminals of an FMU, the ports that its maker declares: terminalsAndIcons/terminalsAndIcons.xml, FMI 3.0.2, section 2.4.9.

FMI 2.0 has the same file by its layered standard. A terminal in a terminal is a port "outer.inner", and its members are members
"inner.member" of the outer one.
"""

from __future__ import annotations

import zipfile
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from ..loading import MOST_XML

FILE = "terminalsAndIcons/terminalsAndIcons.xml"
OWN_REST = ("signals", "derivatives")  # terminals of our FMUs for signals that are of no port


class Member(NamedTuple):
    """variable: of the FMU, or an array of it.  kind: "signal", "inflow", "outflow" or one of a maker's own."""

    name: str
    variable: str
    kind: str


@dataclass(frozen=True)
class Terminal:
    """rule: "plug", "bus", "sequence" or one of a maker's own.  kind: which other terminals it is made for; "": any.

    streams: names of members that are streams of a fluid, which are no connections of two variables.
    missing: names of members that are neither inputs nor outputs.
    """

    rule: str
    kind: str
    members: tuple[Member, ...]
    streams: tuple[str, ...] = ()
    missing: tuple[str, ...] = ()


class Terminals(dict[str, Terminal]):
    """By name. fault: why the file cannot be read, or ""."""

    fault: str = ""


def read_terminals(file: zipfile.ZipFile, own: bool) -> Terminals:
    """Of an FMU; none where it has no such file, or one that cannot be read. own: of our making."""
    from lxml import etree

    terminals = Terminals()
    if FILE not in file.namelist():
        return terminals
    try:
        if file.getinfo(FILE).file_size > MOST_XML:
            raise ValueError(f"more than {MOST_XML} bytes")
        content = file.read(FILE)
        if b"<!DOCTYPE" in content or b"<!ENTITY" in content:
            raise ValueError("a document type and entities of its own")
        root = etree.fromstring(content)
        for parent in root.iterfind("Terminals"):
            for element in parent.iterfind("Terminal"):
                terminals.update(_terminals(element, ""))
    except (etree.XMLSyntaxError, ValueError, KeyError) as error:
        terminals.clear()
        terminals.fault = f"Its {FILE} cannot be read: {error or type(error).__name__}."
    for name in OWN_REST if own else ():
        terminals.pop(name, None)
    return terminals


def _terminals(element: Any, outer: str) -> Iterator[tuple[str, Terminal]]:
    """(name, terminal) of an element and of those in it."""
    name = outer + element.attrib["name"]
    members = [
        Member(m.get("memberName") or "", m.attrib["variableName"], m.get("variableKind") or "signal")
        for m in element.iterfind("TerminalMemberVariable")
    ]
    if twice := [m.name for k, m in enumerate(members) if m.name and m.name in [o.name for o in members[:k]]]:
        raise ValueError(f"terminal {name} has two members {twice[0]!r}")
    streams = [m.get("inStreamMemberName") or m.tag for m in element.iterfind("TerminalStreamMemberVariable")]
    for child in element.iterfind("Terminal"):
        for inner, terminal in _terminals(child, f"{name}."):
            yield inner, terminal
            if inner == f"{name}.{child.attrib['name']}":
                own = child.attrib["name"]
                members += [Member(f"{own}.{m.name}", m.variable, m.kind) for m in terminal.members]
                streams += [f"{own}.{s}" for s in terminal.streams]
    yield name, Terminal(element.get("matchingRule") or "", element.get("terminalKind") or "", tuple(members), tuple(streams))


def at_hand(terminal: Terminal, variables: Iterable[str], index: str = "") -> Terminal:
    """A terminal with those of its members that are among some variables, all named: of a sequence by their numbers, of an array
    each element, as "member[2]". index: only the elements with it, as in "[2]", by the names of their arrays.

    `missing` has the others.
    """
    variables, chosen, missing = list(variables), list[Member](), list[str]()
    for k, member in enumerate(terminal.members, 1):
        name = f"#{k}" if terminal.rule == "sequence" else member.name
        whole = member.variable
        if not name:
            missing.append(whole)
            continue
        elements = [whole] if whole in variables else [v for v in variables if v.startswith(f"{whole}[")]
        missing += [] if elements else [member.name or whole]
        chosen += [Member(name + v[len(whole) :], v, member.kind) for v in elements]
    if index:
        chosen = [m._replace(name=m.name.removesuffix(index)) for m in chosen if m.name.endswith(index)]
    return replace(terminal, members=tuple(chosen), missing=tuple(missing))
