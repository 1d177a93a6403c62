"""From a scene to its resolved coupling: who feeds whom, in what units of measure, and what follows within an instant.

An output's direct dependence on inputs is what its unit declares. An FMU that declares none is taken to have none:
assuming all, as FMI permits, would call every loop of such FMUs an algebraic one.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

from ....components.core.errors import BadInput
from ...settings import SceneSettings
from ...settings.algorithms import ALGORITHMS
from ...settings.study import RUNNING_KINDS, wanted
from ...units import Interface, describe
from .arrays import elements, is_element
from .bonds import Bond, bond
from .checks import check_stepping, targets
from .connections import endpoint, links_of, no_variable
from .contacts import check_contacts, describe_contact
from .graph import Endpoint, Link, Loop, feedthrough_schedule, groups, is_discrete, smooth

LONGEST_RECORDED = 100  # elements of an array that are recorded without being named
SHOWN = 8  # names in a message


@dataclass(frozen=True)
class Shown:
    """An input or output that the scene names; kind: of the figure of all macro steps, "" for the value itself."""

    end: Endpoint
    causality: Literal["input", "output"]
    kind: str = ""


@dataclass(frozen=True)
class Coupling:
    """The checked graph of a scene."""

    interfaces: Mapping[str, Interface]
    links: tuple[Link, ...]  # of numbers
    texts: tuple[Link, ...]  # of texts, which are handed over at the start of every macro step
    undriven: tuple[str, ...]  # "unit.input" that keeps its start value
    signals: tuple[Endpoint, ...]  # recorded outputs that are numbers
    recorded_texts: tuple[Endpoint, ...]  # and those that are texts
    snapshots: Mapping[Endpoint, tuple[str, ...]]  # (unit, array) -> its elements
    feedthrough_schedule: tuple[str | Loop, ...]  # units to update and loops to solve, in this order
    groups: tuple[tuple[str, ...], ...]  # units that feed one another in a circle, sources before those they feed
    rates: Mapping[str, int]  # units that step with every n-th macro step only -> n
    faults: tuple[tuple[Endpoint, ...], ...]  # inputs that each fault of the scene changes
    events: tuple[Endpoint, ...]  # outputs whose changes of sign are located
    bonds: tuple[Bond, ...]  # pairs of connections that carry power
    shown: Mapping[str, Shown]  # what the FMU of the whole scene shows under names of the scene's own

    def order(self, wished: tuple[str, ...] = ()) -> tuple[str, ...]:
        """The units as Gauss-Seidel steps them: as the scene wishes, or else each group behind those that feed it."""
        return wished or tuple(name for group in self.groups for name in group)


def resolve_coupling(scene: SceneSettings) -> Coupling:
    """Describe all units and check every connection and record; raises one `BadInput` that starts with the scene's name."""
    try:
        interfaces = {name: describe(name, unit) for name, unit in scene.units.items()}
        check_contacts(scene, interfaces)
        interfaces |= {contact.name: describe_contact(contact) for contact in scene.contacts}
        _check_names(interfaces)
        connected = links_of(scene, interfaces)
        texts = tuple(link for link in connected if interfaces[link.target[0]].inputs[link.target[1]].is_text)
        links = tuple(link for link in connected if link not in texts)
        interfaces = _with_recorded(scene, interfaces)  # behind the connections: only outputs can be connected
        recorded = _recorded(scene, interfaces, links)
        spoken = tuple((u, n) for u, n in recorded if interfaces[u].outputs[n].is_text)
        coupling = Coupling(
            interfaces,
            links,
            texts,
            undriven=_undriven(interfaces, connected),
            signals=tuple(end for end in recorded if end not in spoken),
            recorded_texts=spoken,
            snapshots={endpoint(s, "record.snapshots", interfaces): _array(s, interfaces) for s in scene.record.snapshots},
            feedthrough_schedule=feedthrough_schedule(interfaces, links),
            groups=groups(interfaces, connected),
            rates={name: unit.every for name, unit in scene.units.items() if unit.every > 1},
            faults=tuple(_faults(scene, interfaces, connected)),
            events=tuple(_output(text, "master.events", interfaces) for text in scene.master.events),
            bonds=tuple(_bond(text, interfaces, links) for text in scene.master.bonds),
            shown=dict(_shown(scene, interfaces, connected)),
        )
        _check_master(scene, coupling)
        return coupling
    except BadInput as error:
        raise BadInput(f"{scene.name}: {error.where}", error.actual, error.expected, error.remedy) from None


def _check_names(interfaces: Mapping[str, Interface]) -> None:
    """Refuse that "unit.variable" means two variables: b.c of a unit a, and c of a unit a.b."""
    for unit, interface in interfaces.items():
        for other in (name for name in interfaces if name.startswith(f"{unit}.")):
            theirs = {f"{other}.{n}" for n in (*interfaces[other].inputs, *interfaces[other].outputs)}
            if both := theirs & {f"{unit}.{n}" for n in (*interface.inputs, *interface.outputs)}:
                what = f"{min(both)!r}, a variable of {unit!r} and one of {other!r}"
                raise BadInput("units", what, "names that are unique", "Call one of the units something else.")


def _undriven(interfaces: Mapping[str, Interface], links: tuple[Link, ...]) -> tuple[str, ...]:
    driven = {link.target for link in links}
    return tuple(f"{u}.{n}" for u, i in interfaces.items() for n in i.inputs if (u, n) not in driven and n not in i.set_inputs)


def _array(text: str, interfaces: Mapping[str, Interface]) -> tuple[str, ...]:
    unit, variable = endpoint(text, "record.snapshots", interfaces)
    elements = _elements(variable, interfaces[unit])
    if not elements:
        raise no_variable("record.snapshots", (unit, variable), "output", interfaces)
    if interfaces[unit].outputs[elements[0]].is_text:
        raise BadInput("record.snapshots", f"{text!r}, an array of texts", "one of numbers", "Write it under record.signals.")
    return elements


def _elements(variable: str, interface: Interface) -> tuple[str, ...]:
    return tuple(elements(variable, interface.outputs).values())


def _recorded(scene: SceneSettings, interfaces: Mapping[str, Interface], links: Sequence[Link]) -> tuple[Endpoint, ...]:
    """Outputs to record, of numbers and texts."""
    if scene.record.signals is None:
        judged = [
            end
            for end in scene.analysis.judged([(link.source, link.target) for link in links])
            for end in ((end[0], n) for n in (_elements(end[1], interfaces[end[0]]) or end[1:]))
        ]
        known = [(u, n) for u, n in judged if n in interfaces[u].outputs]
        return tuple(dict.fromkeys((*_recorded_by_default(scene, interfaces), *known)))
    recorded: dict[Endpoint, None] = {}
    for text in scene.record.signals:
        unit, variable = endpoint(text, "record.signals", interfaces)
        outputs = interfaces[unit].outputs
        names = (
            (variable,) if variable in outputs else interfaces[unit].arrays.get(variable) or _elements(variable, interfaces[unit])
        )
        if not names:
            raise no_variable("record.signals", (unit, variable), "output", interfaces)
        recorded |= dict.fromkeys((unit, n) for n in names)
    if not (recorded or scene.record.snapshots):
        raise BadInput("record.signals", "no signal", "at least one; a result without columns tells nothing", "Or leave it out.")
    sums = [(u, n) for u, i in interfaces.items() for n, parts in i.sums.items() if any((u, p) in recorded for p in parts)]
    beside = (*scene.analysis.beside(recorded), *sums)
    return tuple(recorded | {(u, n): None for u, n in beside if n in interfaces[u].outputs})


def _recorded_by_default(scene: SceneSettings, interfaces: Mapping[str, Interface]) -> tuple[Endpoint, ...]:
    """Scalar outputs, and arrays of FMI 3 that are not too long; elements of other arrays where there is nothing else.

    Raises `BadInput` where a result would have no column.
    """
    short = {
        (u, n) for u, i in interfaces.items() for names in i.arrays.values() if len(names) <= LONGEST_RECORDED for n in names
    }
    numbers = [(u, n) for u, i in interfaces.items() for n, s in i.outputs.items() if not s.is_text]
    recorded = tuple(end for end in numbers if not is_element(end[1]) or end in short)
    if not recorded and not scene.record.snapshots:
        recorded = tuple(numbers[:LONGEST_RECORDED])
    if not recorded and not scene.record.snapshots:
        names = [f"{u}.{n}" for u, i in interfaces.items() for n in (*i.outputs, *i.recordable)]
        shown = ", ".join(names[:SHOWN]) + (", ..." if len(names) > SHOWN else "")
        raise BadInput(
            "record.signals",
            "no unit with an output that is a number",
            "at least one signal to record",
            f"What can be recorded by its name: {shown}." if names else "Nothing else can be recorded, either.",
        )
    return recorded


def _with_recorded(scene: SceneSettings, interfaces: Mapping[str, Interface]) -> dict[str, Interface]:
    """Interfaces in which the variables that the scene records by name are outputs, too."""
    named = [endpoint(text, "record.signals", interfaces) for text in scene.record.signals or ()]
    wanted = [(u, n) for u, name in named for n in interfaces[u].arrays.get(name, (name,))]
    return {
        unit: replace(i, outputs={**i.outputs, **{n: i.recordable[n] for u, n in wanted if u == unit and n in i.recordable}})
        if i.recordable
        else i
        for unit, i in interfaces.items()
    }


def _faults(scene: SceneSettings, interfaces: Mapping[str, Interface], links: tuple[Link, ...]) -> Iterator[tuple[Endpoint, ...]]:
    for i, fault in enumerate(scene.faults, 1):
        end = endpoint(fault.signal, f"faults[{i}].signal", interfaces) if fault.signal else None
        yield targets(fault, f"faults[{i}]", end, scene, interfaces, links)


def _output(text: str, where: str, interfaces: Mapping[str, Interface]) -> Endpoint:
    unit, name = end = endpoint(text, where, interfaces)
    if name not in interfaces[unit].outputs:
        raise no_variable(where, end, "output", interfaces)
    if interfaces[unit].outputs[name].is_text:
        raise BadInput(where, f"{text!r}, a text", "a number")
    return end


def _shown(scene: SceneSettings, interfaces: Mapping[str, Interface], links: tuple[Link, ...]) -> Iterator[tuple[str, Shown]]:
    """What the scene names in [interface]."""
    drivers = {link.target: ".".join(link.source) for link in links}
    names: dict[Endpoint, str] = {}
    for name, text in scene.interface.inputs.items():
        where, end = f"interface.inputs.{name}", endpoint(text, f"interface.inputs.{name}", interfaces)
        if end[1] not in interfaces[end[0]].inputs:
            raise no_variable(where, end, "input", interfaces)
        if end in drivers:
            raise BadInput(where, text, f"an input that no connection drives; {drivers[end]} drives this one")
        if end in names:
            raise BadInput(where, f"{text}, which is {names[end]!r} already", "one name for each input")
        names[end] = name
        yield name, Shown(end, "input")
    for name, text in scene.interface.outputs.items():
        where, kind = f"interface.outputs.{name}", ""
        signal, (unit, variable) = text, endpoint(text, where, interfaces)
        before = text.rpartition(",")[0]
        if variable not in interfaces[unit].outputs and before and before.count("[") == before.count("]"):  # [1,2] is an element
            of = wanted(text)
            signal, kind = of.signal, of.kind
            if kind not in RUNNING_KINDS or of.cutoff:
                whole = f"{str(of).rpartition(', ')[2]!r}, which needs the whole signal"
                raise BadInput(
                    where, whole, "one of " + ", ".join(RUNNING_KINDS), "Show the output itself, and compute it behind the run."
                )
        yield name, Shown(_output(signal, where, interfaces), "output", kind)


def _bond(text: str, interfaces: Mapping[str, Interface], links: tuple[Link, ...]) -> Bond:
    where, parts = "master.bonds", [part.strip() for part in text.split("*")]
    if len(parts) != 2:
        raise BadInput(where, repr(text), '"unit.output * unit.output"')
    return bond(text, (_output(parts[0], where, interfaces), _output(parts[1], where, interfaces)), interfaces, links)


def _check_master(scene: SceneSettings, coupling: Coupling) -> None:
    master, given = scene.master, scene.master.model_fields_set
    if master.order and sorted(master.order) != sorted(coupling.interfaces):
        raise BadInput("master.order", ", ".join(master.order), f"every unit once: {', '.join(coupling.interfaces)}")
    needless = given & {"extrapolation", "moving_places", "feedthrough", "order"}
    if not coupling.links and needless:
        option = min(needless)
        raise BadInput(f"master.{option}", "no effect without connections", "", "Remove it.")
    if master.feedthrough == "delayed" and not coupling.feedthrough_schedule:
        raise BadInput("master.feedthrough", "no effect, as no connected output has direct feedthrough", "", "Remove it.")
    if master.feedthrough == "immediate":
        for loop in (step for step in coupling.feedthrough_schedule if isinstance(step, Loop)):
            _check_loop(loop, coupling)
    if master.abilities.rollback:
        _check_rollback(scene, coupling)
    for name in coupling.rates:
        _check_rate(name, scene)
    check_stepping(scene.master, coupling.interfaces, coupling.links, coupling.bonds, coupling.rates)
    for name, interface in coupling.interfaces.items():
        _check_fixed_step(name, interface.fixed_step, scene)
        whole = (scene.duration / (master.step * coupling.rates.get(name, 1))) % 1.0
        if min(whole, 1.0 - whole) > 1e-9 and not interface.variable_step:
            raise BadInput(
                "master.step",
                f"{master.step * coupling.rates.get(name, 1):g} s in a run of {scene.duration:g} s",
                f"a step that divides the run; {name} cannot make the last one shorter",
            )


def _check_fixed_step(name: str, fixed: float, scene: SceneSettings) -> None:
    """All steps of a unit with internal steps of one length are multiples of it, the last, shorter one, too."""
    step = scene.master.step * (scene.units[name].every if fixed else 1)
    for length in (step, scene.duration) if fixed else ():
        if abs(length / fixed - round(length / fixed)) > 1e-9 * max(length / fixed, 1.0):
            where = "master.step" if length == step else "stop_time" if not scene.start_time else "stop_time - start_time"
            raise BadInput(where, f"{length:.9g} s", f"a multiple of {fixed:.9g} s, the fixed internal step of {name}")


def _check_loop(loop: Loop, coupling: Coupling) -> None:
    """Algebraic loops are solved at each communication point: their signals must be smooth, and all units must be there."""
    where, remedy = "connections", "Give one of the units a state, or put the loop inside one unit."
    for unit, name in loop.outputs:
        if is_discrete(coupling.interfaces[unit].outputs[name]):
            raise BadInput(
                where,
                f"an algebraic loop of {loop.text}, where {unit}.{name} only jumps",
                "a loop of continuous numbers, or one that a state breaks",
                remedy,
            )
        if unit in coupling.rates:
            raise BadInput(
                f"units.{unit}.every",
                f"{coupling.rates[unit]} in an algebraic loop of {loop.text}",
                "1, for all units of such a loop",
                remedy,
            )


def _check_rollback(scene: SceneSettings, coupling: Coupling) -> None:
    """Only circles of units with values that change inside a step repeat one, and their units must be able to."""
    interfaces, where, actual = coupling.interfaces, "master.algorithm", repr(scene.master.algorithm)
    circles = [group for group in groups(interfaces, smooth(interfaces, coupling.links)) if len(group) > 1]
    if not circles:
        raise BadInput(
            where,
            actual,
            "units that feed one another in a circle; here nothing has to be repeated",
            'Take "gauss-seidel", which gives the same in one pass.',
        )
    for name in (name for group in circles for name in group):
        if not interfaces[name].saves_state:
            raise BadInput(
                where,
                actual,
                f"units that save their state, so that a step can be repeated; {name} cannot",
                'Take "jacobi" or "gauss-seidel".',
            )


def _check_rate(name: str, scene: SceneSettings) -> None:
    master, where, actual = scene.master, f"units.{name}.every", str(scene.units[name].every)
    if not master.abilities.rates:
        able = " and ".join(name for name, of in ALGORITHMS.items() if of.rates)
        raise BadInput(where, actual, f"1 with {master.algorithm}; {able} can step units at rates of their own")
    for option in ("control", "events"):
        if getattr(master, option):
            raise BadInput(where, actual, f"1 with master.{option}, which changes the macro step")
    if master.step * scene.units[name].every > scene.duration * (1.0 + 1e-9):
        raise BadInput(where, actual, f"at most the steps of the run, {scene.duration / master.step:.0f}")
