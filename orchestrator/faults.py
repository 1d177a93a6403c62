"""Faults on purpose: signals that are changed on their way to the inputs, and units that take no more steps.

A fault begins and ends at an instant that a macro step ends at. Outputs that depend on a changed input directly follow at once,
and inputs that jump forget their past. What is recorded at such an instant is what it is from then on.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

from components.core.errors import BadInput, nearest

from .graph import Endpoint, Link
from .settings import FaultSettings, SceneSettings
from .units import Interface, Unit
from .units.interface import Row

if TYPE_CHECKING:
    from .algorithms import Master
    from .clock import Clock
    from .coupling import Coupling
    from .stepping import Action


def targets(fault: FaultSettings, where: str, end: Endpoint | None, scene: SceneSettings, interfaces: Mapping[str, Interface],
            links: Iterable[Link]) -> tuple[Endpoint, ...]:
    """The inputs that a fault changes; raises `BadInput` for one that would change nothing, or cannot be.

    `where`: the fault as messages name it. `end`: its signal, None for a lost unit.
    """
    if fault.begin >= scene.stop_time:
        raise BadInput(f"{where}.begin", f"{fault.begin:g} s", f"a time before the end of the run, {scene.stop_time:g} s")
    for key, time in (("begin", fault.begin), ("end", fault.end)):
        rest = (time or 0.0) / scene.master.step % 1.0
        if min(rest, 1.0 - rest) > 1e-9:
            for name, interface in interfaces.items():
                if not interface.variable_step:
                    raise BadInput(f"{where}.{key}", f"{time:g} s", f"a multiple of master.step, {scene.master.step:g} s; "
                                   f"{name} cannot make a step shorter")
    if end is None:
        if fault.unit not in interfaces:
            raise BadInput(f"{where}.unit", repr(fault.unit), "a unit of the scene", nearest(fault.unit, interfaces))
        return ()
    unit, name = end
    found = tuple(link for link in links if end in (link.source, link.target))
    if not found:
        interface = interfaces[unit]
        if name in interface.inputs or name in interface.outputs:
            raise BadInput(f"{where}.signal", f"{fault.signal!r}, which nothing is connected to", "a connected signal",
                           "A value for such an input stands in its unit's parameters." if name in interface.inputs else "")
        raise BadInput(f"{where}.signal", repr(fault.signal), f"an output or input of {unit}",
                       nearest(name, [*interface.outputs, *interface.inputs]))
    for link in found:
        _check_kind(fault, where, link, interfaces)
    return tuple(link.target for link in found)


def _check_kind(fault: FaultSettings, where: str, link: Link, interfaces: Mapping[str, Interface]) -> None:
    signal = interfaces[link.target[0]].inputs[link.target[1]]
    name, value = ".".join(link.target), fault.value
    if signal.is_text:
        raise BadInput(f"{where}.signal", f"{fault.signal!r}, a text", "a number")
    if fault.kind == "offset" and signal.kind in ("boolean", "enumeration"):
        raise BadInput(f"{where}.kind", f"'offset' of {name}", f"override, freeze or drop for a signal of kind {signal.kind}")
    if value is not None and signal.kind != "real":
        if not value.is_integer():
            raise BadInput(f"{where}.value", f"{value:g}", f"a whole number for {name}")
        if signal.kind == "boolean" and value not in (0.0, 1.0):
            raise BadInput(f"{where}.value", f"{value:g}", f"0 or 1 for {name}")
    if fault.kind == "offset" and value == 0.0:
        raise BadInput(f"{where}.value", "0", "another offset; this one has no effect")


class Mortal:
    """A unit that can be lost: from then on it takes no steps and no inputs, and its outputs stay as they are."""

    def __init__(self, unit: Unit):
        self._unit, self.lost = unit, False

    def __getattr__(self, name: str) -> Any:
        return getattr(self._unit, name)

    @property
    def event(self) -> float | None:
        """The first event inside the last step, none in one that was not taken."""
        return None if self.lost else self._unit.event

    def drive(self, values: Row, slopes: Row | None, halves: Row | None, h: float) -> None:
        """As of the unit."""
        if not self.lost:
            self._unit.drive(values, slopes, halves, h)

    def step(self, t: float, h: float) -> None:
        """As of the unit."""
        if not self.lost:
            self._unit.step(t, h)

    def update(self, values: Row) -> None:
        """As of the unit."""
        if not self.lost:
            self._unit.update(values)


class Faults:
    """The faults of a scene on the way to the inputs of a master's units; `mortals`: the units that will be lost, by name."""

    def __init__(self, faults: tuple[FaultSettings, ...], coupling: Coupling, master: Master, mortals: Mapping[str, Mortal],
                 clock: Clock):
        self.faults, self._master, self._mortals, self._clock = faults, master, mortals, clock
        inputs = {link.target: (node, k) for node in master.nodes for k, link in enumerate(node.links)}
        self._places = [[inputs[end] for end in ends] for ends in coupling.faults]
        self._starts = [[float(coupling.interfaces[u].inputs[n].start) for u, n in ends] for ends in coupling.faults]
        self._values: dict[int, list[float | None]] = {}  # faults that act -> what takes the place of each input; None: an offset
        self._from_start = [i for i, f in enumerate(faults) if not f.begin and f.kind in ("override", "offset", "drop")]

    def before_start(self) -> None:
        """Units find their initial states with the faults that change inputs from time 0."""
        for i in self._from_start:
            self._begin(i)
        self._alter()

    def stops(self) -> dict[int, list[Action]]:
        """Ticks where faults begin or end, each with one action for all of them."""
        edges: dict[int, tuple[list[int], list[int]]] = {}
        for i, fault in enumerate(self.faults):
            if i not in self._from_start:
                edges.setdefault(self._clock.ticks(fault.begin), ([], []))[0].append(i)
            if fault.end is not None:
                edges.setdefault(self._clock.ticks(fault.end), ([], []))[1].append(i)
        return {tick: [partial(self._edge, *edge)] for tick, edge in edges.items()}

    def state(self) -> dict[str, Any]:
        """What acts now, as plain data for a checkpoint."""
        return {"values": [[i, values] for i, values in self._values.items()],
                "lost": [name for name, unit in self._mortals.items() if unit.lost]}

    def take(self, state: Mapping[str, Any]) -> None:
        """Go on from a `state`; the units and the master's histories come from elsewhere."""
        self._values = {i: list(values) for i, values in state["values"]}
        for name in state["lost"]:
            self._mortals[name].lost = True
        self._alter()

    def _begin(self, i: int) -> None:
        fault = self.faults[i]
        if fault.kind == "lost":
            self._mortals[fault.unit].lost = True
        elif fault.kind == "freeze":
            self._values[i] = [float(node.inputs()[k]) for node, k in self._places[i]]
        elif fault.kind == "drop":
            self._values[i] = list(self._starts[i])
        else:
            self._values[i] = [fault.value if fault.kind == "override" else None] * len(self._places[i])

    def _edge(self, begins: list[int], ends: list[int]) -> None:
        """Some faults end and others begin, and what follows within the instant follows."""
        fed = [node for node in self._master.nodes if node.sources]
        before = [list(node.inputs()) for node in fed]
        for i in ends:
            del self._values[i]
        for i in begins:
            self._begin(i)
        self._alter()
        self._master.follow(self._clock.seconds(0))
        touched = {id(node) for i in (*begins, *ends) for node, _ in self._places[i]}
        for node, values in zip(fed, before, strict=True):
            if id(node) in touched or list(node.inputs()) != values:
                node.restart()
                node.reached = node.fresh = None  # where its inputs were led to is no guess of where they have jumped

    def _alter(self) -> None:
        """Put what acts now between the signals and the units, in the order of the scene."""
        changes: dict[int, list[tuple[int, float | None, float]]] = {}
        for i in sorted(self._values):
            for (node, k), value in zip(self._places[i], self._values[i], strict=True):
                changes.setdefault(id(node), []).append((k, value, self.faults[i].value or 0.0))
        for node in self._master.nodes:
            node.alter = partial(_changed, changes[id(node)]) if id(node) in changes else None


def _changed(changes: list[tuple[int, float | None, float]], values: Row) -> Row:
    for k, value, offset in changes:
        values[k] = values[k] + offset if value is None else value
    return values
