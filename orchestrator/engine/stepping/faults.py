"""Faults on purpose: signals that are changed between outputs and inputs, and units that take no more steps.

A fault starts and ends where a macro step ends. Outputs with feed-through follow a changed input at once, and inputs that jump lose
their samples. The row at such an instant has the values after the change.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import partial
from typing import Any

from ...settings import FaultSettings
from ..algorithms import Master
from ..coupling import Coupling
from .clock import Clock
from .loop import Action


def edges(faults: Iterable[FaultSettings]) -> list[float]:
    """Times at which faults begin or end, s, but 0."""
    return [t for fault in faults for t in (fault.begin, fault.end) if t]


class Faults:
    """The faults of a scene: on the way to the inputs of a master's units, or that units are lost."""

    def __init__(self, faults: tuple[FaultSettings, ...], coupling: Coupling, master: Master, clock: Clock):
        self.faults, self._master, self._clock = faults, master, clock
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
        edges_at: dict[int, tuple[list[int], list[int]]] = {}
        for i, fault in enumerate(self.faults):
            if i not in self._from_start:
                edges_at.setdefault(self._clock.ticks(fault.begin), ([], []))[0].append(i)
            if fault.end is not None:
                edges_at.setdefault(self._clock.ticks(fault.end), ([], []))[1].append(i)
        return {tick: [partial(self._edge, self._clock.seconds(tick), *edge)] for tick, edge in edges_at.items()}

    def state(self) -> dict[str, Any]:
        """What acts now, as plain data for a checkpoint."""
        return {"values": [[i, values] for i, values in self._values.items()]}

    def take(self, state: Mapping[str, Any]) -> None:
        """Go on from a `state`; what is lost, and the samples of the inputs, the master knows."""
        self._values = {i: list(values) for i, values in state["values"]}
        self._alter()

    def _begin(self, i: int) -> None:
        fault = self.faults[i]
        if fault.kind == "lost":
            self._master.node_of[fault.unit].lose()
        elif fault.kind == "freeze":
            self._values[i] = [float(node.inputs()[k]) for node, k in self._places[i]]
        elif fault.kind == "drop":
            self._values[i] = list(self._starts[i])
        else:
            self._values[i] = [fault.value if fault.kind == "override" else None] * len(self._places[i])

    def _edge(self, t: float, begins: list[int], ends: list[int]) -> None:
        """Some faults end and others begin, and what follows within the instant follows."""
        fed = [node for node in self._master.nodes if node.sources]
        before = [list(node.inputs()) for node in fed]
        for i in ends:
            del self._values[i]
        for i in begins:
            self._begin(i)
        self._alter()
        self._master.follow(t)
        lost = {self.faults[i].unit for i in begins}
        changed = {id(node) for i in (*begins, *ends) for node, _ in self._places[i]}
        changed |= {id(node) for node in fed for link in node.links if link.source[0] in lost}
        for node, values in zip(fed, before, strict=True):
            if id(node) in changed or list(node.inputs()) != values:
                node.restart()
                node.jump()

    def _alter(self) -> None:
        """Put what acts now between the signals and the units, in the order of the scene."""
        changes: dict[int, dict[int, tuple[bool, float]]] = {}
        for i in sorted(self._values):
            for (node, k), value in zip(self._places[i], self._values[i], strict=True):
                of_node = changes.setdefault(id(node), {})
                replaced, before = of_node.get(k, (False, 0.0))
                of_node[k] = (replaced, before + (self.faults[i].value or 0.0)) if value is None else (True, value)
        for node in self._master.nodes:
            node.alter(changes.get(id(node), {}))
