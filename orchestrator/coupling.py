"""From a scene to its settled graph: who feeds whom, in what units of measure, and what follows within an instant.

An output's direct dependence on inputs is what its unit declares. An FMU that declares none is taken to have none:
assuming all, as FMI permits, would call every loop of such FMUs an algebraic one.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

from components.core.errors import BadInput, nearest
from components.core.measure import conversion

from .settings import SceneSettings
from .units import Interface, describe

Endpoint = tuple[str, str]  # unit, variable
_CONNECTION = re.compile(r"\s*(\w+)\.(\S+)\s*->\s*(\w+)\.(\S+)\s*")


@dataclass(frozen=True)
class Link:
    """One connection: target = factor * source + offset."""

    source: Endpoint
    target: Endpoint
    factor: float
    offset: float


@dataclass(frozen=True)
class Coupling:
    """The checked graph of a scene."""

    interfaces: Mapping[str, Interface]
    links: tuple[Link, ...]
    undriven: tuple[str, ...]  # "unit.input" that keeps its start value
    signals: tuple[Endpoint, ...]  # recorded outputs
    snapshots: Mapping[Endpoint, tuple[str, ...]]  # (unit, array) -> its elements
    passes: tuple[str, ...]  # units to update, in this order, until every output follows its inputs


def settle(scene: SceneSettings) -> Coupling:
    """Describe all units and check every connection and record; raises one `BadInput` that starts with the scene's name."""
    try:
        interfaces = {name: describe(name, unit) for name, unit in scene.units.items()}
        links = _links(scene, interfaces)
        coupling = Coupling(
            interfaces, links,
            undriven=_undriven(interfaces, links),
            signals=_signals(scene, interfaces),
            snapshots={_endpoint(s, "record.snapshots", interfaces): _array(s, interfaces) for s in scene.record.snapshots},
            passes=_passes(interfaces, links),
        )
        _check_master(scene, coupling)
        return coupling
    except BadInput as error:
        raise BadInput(f"{scene.name}: {error.where}", error.came, error.expected, error.remedy) from None


def _endpoint(text: str, where: str, interfaces: Mapping[str, Interface]) -> Endpoint:
    unit, dot, variable = text.partition(".")
    if not dot:
        raise BadInput(where, repr(text), '"unit.variable"')
    if unit not in interfaces:
        raise BadInput(where, f"unit {unit!r}", "a unit of the scene", nearest(unit, interfaces))
    return unit, variable


def _links(scene: SceneSettings, interfaces: Mapping[str, Interface]) -> tuple[Link, ...]:
    links: dict[Endpoint, Link] = {}
    for text in scene.connections:
        where = f"connection {text!r}"
        for source, target in _pairs(text, where, interfaces):
            outputs, inputs = interfaces[source[0]].outputs, interfaces[target[0]].inputs
            if source[1] not in outputs:
                raise _no_variable(where, source, "output", interfaces)
            if target[1] not in inputs:
                raise _no_variable(where, target, "input", interfaces)
            if target in links:
                raise BadInput(where, f"input {'.'.join(target)} driven a second time",
                               f"one source; {'.'.join(links[target].source)} drives it already")
            if target[1] in interfaces[target[0]].set_inputs:
                raise BadInput(f"units.{target[0]}.parameters", f"a value of input {target[1]!r}",
                               "none; the connection drives it and the value would have no effect", "Remove one of them.")
            units = outputs[source[1]].unit, inputs[target[1]].unit
            links[target] = Link(source, target, *(conversion(*units, where) if all(units) else (1.0, 0.0)))
    return tuple(links.values())


def _pairs(text: str, where: str, interfaces: Mapping[str, Interface]) -> list[tuple[Endpoint, Endpoint]]:
    """(source, target) of one connection, or with * at both ends of all that agree in what stands for it."""
    match = _CONNECTION.fullmatch(text)
    if not match or text.count("*") not in (0, 2) or (text.count("*") and not (match[2][-1] == match[4][-1] == "*")):
        raise BadInput("connections", repr(text), '"unit.output -> unit.input", or "unit.* -> unit.*" for all of the same name')
    source, target = (_endpoint(f"{u}.{v}", where, interfaces) for u, v in (match.group(1, 2), match.group(3, 4)))
    if source[0] == target[0]:
        raise BadInput(where, f"unit {source[0]!r} connected with itself", "two units", "Close such a loop inside the unit.")
    if "*" not in text:
        return [(source, target)]
    before, after = source[1][:-1], target[1][:-1]
    rests = [n.removeprefix(before) for n in interfaces[source[0]].outputs if n.startswith(before)]
    found = [((source[0], before + r), (target[0], after + r)) for r in rests if after + r in interfaces[target[0]].inputs]
    if not found:
        inputs = [n for n in interfaces[target[0]].inputs if n.startswith(after)]
        raise BadInput(where, f"outputs {', '.join(rests) or 'of no name'} and inputs {', '.join(inputs) or 'of no name'}",
                       "at least one name on both sides", "Switch on the effect that has them, or name the variables.")
    return found


def _no_variable(where: str, end: Endpoint, wished: str, interfaces: Mapping[str, Interface]) -> BadInput:
    unit, name = end
    interface = interfaces[unit]
    here, there = (interface.outputs, interface.inputs) if wished == "output" else (interface.inputs, interface.outputs)
    effect = name.partition(".")[0]
    if name in there:
        remedy = "A connection goes from an output to an input."
    elif effect in interface.effects and not interface.effects[effect]:
        remedy = f"Switch on the effect {effect!r} if it belongs to it."
    else:
        remedy = nearest(name, here)
    return BadInput(where, f"{'.'.join(end)}", f"an {wished} of {unit}", remedy)


def _undriven(interfaces: Mapping[str, Interface], links: tuple[Link, ...]) -> tuple[str, ...]:
    driven = {link.target for link in links}
    return tuple(f"{u}.{n}" for u, i in interfaces.items() for n in i.inputs if (u, n) not in driven and n not in i.set_inputs)


def _array(text: str, interfaces: Mapping[str, Interface]) -> tuple[str, ...]:
    unit, variable = _endpoint(text, "record.snapshots", interfaces)
    elements = _elements(variable, interfaces[unit])
    if not elements:
        raise _no_variable("record.snapshots", (unit, variable), "output", interfaces)
    return elements


def _elements(variable: str, interface: Interface) -> tuple[str, ...]:
    return tuple(n for n in interface.outputs if n.startswith(variable + "[") and n.removeprefix(variable)[1:-1].isdigit())


def _signals(scene: SceneSettings, interfaces: Mapping[str, Interface]) -> tuple[Endpoint, ...]:
    if scene.record.signals is None:
        return tuple((u, n) for u, i in interfaces.items() for n in i.outputs if "[" not in n)
    found: dict[Endpoint, None] = {}
    for text in scene.record.signals:
        unit, variable = _endpoint(text, "record.signals", interfaces)
        names = (variable,) if variable in interfaces[unit].outputs else _elements(variable, interfaces[unit])
        if not names:
            raise _no_variable("record.signals", (unit, variable), "output", interfaces)
        found |= dict.fromkeys((unit, n) for n in names)
    return tuple(found)


def _passes(interfaces: Mapping[str, Interface], links: tuple[Link, ...]) -> tuple[str, ...]:
    """Levels of the graph of direct dependences: a unit is updated once for each level its outputs stand on."""
    sources = {link.target: link.source for link in links}
    levels: dict[Endpoint, int] = {}
    path: list[Endpoint] = []

    def level(end: Endpoint) -> int:
        if end in path:
            loop = " -> ".join(".".join(e) for e in reversed([end, *path[path.index(end) + 1 :], end]))
            raise BadInput("connections", f"an algebraic loop: {loop}", "a loop that at least one state breaks",
                           "Give one of the units a state, or put the loop inside one unit.")
        if end not in levels:
            path.append(end)
            direct = interfaces[end[0]].outputs[end[1]].feedthrough or ()
            behind = [sources[end[0], i] for i in direct if (end[0], i) in sources]
            levels[end] = max((level(s) + 1 for s in behind), default=0)
            path.pop()
        return levels[end]

    steps = {(level((u, n)), k) for k, (u, i) in enumerate(interfaces.items()) for n in i.outputs}
    return tuple(list(interfaces)[k] for depth, k in sorted(steps) if depth)


def _check_master(scene: SceneSettings, coupling: Coupling) -> None:
    master, given = scene.master, scene.master.model_fields_set
    if master.order and sorted(master.order) != sorted(scene.units):
        raise BadInput("master.order", ", ".join(master.order), f"every unit once: {', '.join(scene.units)}")
    if not coupling.links and given & {"extrapolation", "feedthrough", "order"}:
        option = min(given & {"extrapolation", "feedthrough", "order"})
        raise BadInput(f"master.{option}", "a value without connections", "none; it would have no effect", "Remove it.")
    if master.feedthrough == "stale" and not coupling.passes:
        raise BadInput("master.feedthrough", "'stale'", "none; no driven output depends on an input directly", "Remove it.")
    whole = (scene.stop_time / master.step) % 1.0
    if min(whole, 1.0 - whole) > 1e-9:
        for name, interface in coupling.interfaces.items():
            if not interface.variable_step:
                raise BadInput("master.step", f"{master.step:g} s in a run of {scene.stop_time:g} s",
                               f"a step that divides the run; {name} cannot make the last one shorter")
