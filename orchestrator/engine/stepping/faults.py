"""Faults on purpose: signals that are changed between outputs and inputs, and units that take no more steps.

A fault starts and ends where a macro step ends. Outputs with feed-through follow a changed input at once, and inputs that jump lose
their samples. The row at such an instant has the values after the change.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence
from functools import partial

from ...settings import FaultSettings
from ..algorithms import Master
from ..algorithms.records import BEGINS, DROPPED, ENDS, FROZEN, LOST, OFFSET, OVERRIDE
from ..coupling import Coupling
from .clock import Clock
from .loop import Action

FAULT_CODES = {"override": OVERRIDE, "offset": OFFSET, "freeze": FROZEN, "drop": DROPPED, "lost": LOST}


def edges(faults: Iterable[FaultSettings], start: float) -> list[float]:
    """Times at which faults begin or end behind the start of the run, s."""
    return [t for fault in faults for t in (fault.begin, fault.end) if t is not None and t > start]


class Faults:
    """The faults of a scene: on the way to the inputs of a master's units, or that units are lost; records of the master."""

    def __init__(self, faults: tuple[FaultSettings, ...], coupling: Coupling, master: Master, clock: Clock):
        self.faults, self._master, self._clock, self._start = faults, master, clock, clock.time(0)
        self.from_start = [i for i, fault in enumerate(faults) if acts_from_start(fault, self._start)]
        if not faults:
            return
        memory = master.records.memory
        inputs = {
            link.target: int(memory.units["first_link"][node.index]) + k
            for node in master.nodes
            for k, link in enumerate(node.links)
        }
        memory.faults["kind"] = [FAULT_CODES[fault.kind] for fault in faults]
        memory.faults["value"] = [fault.value or 0.0 for fault in faults]
        memory.faults["unit"] = [master.node_of[fault.unit].index if fault.unit else -1 for fault in faults]
        ends = [end for of_fault in coupling.faults for end in of_fault]
        memory.fault_ends["link"] = [inputs[end] for end in ends]
        memory.fault_ends["start"] = [float(coupling.interfaces[u].inputs[n].start) for u, n in ends]

    def before_start(self) -> None:
        """Units find their initial states with the faults that change inputs from the start."""
        if self.from_start:
            change = self._master.records.memory.faults["change"]
            change[self.from_start] = BEGINS
            self._master.records.call("begin_change", self._start)
            change[:] = 0

    def stops(self) -> dict[int, list[Action]]:
        """Ticks where faults begin or end, each with one action for all of them."""
        return {
            tick: [partial(self._edge, self._clock.time(tick), changes)]
            for tick, changes in changes_of(self.faults, self.from_start, self._clock.tick).items()
        }

    def _edge(self, t: float, changes: Sequence[tuple[int, int]]) -> None:
        """Some faults end and others begin, and what follows within the instant follows."""
        records = self._master.records
        for i, change in changes:
            records.memory.faults["change"][i] = change
        records.call("begin_change", t)
        self._master.follow(t)
        records.call("end_change", t)


def acts_from_start(fault: FaultSettings, start: float) -> bool:
    """Whether units find their initial states with it; start: of the run, s."""
    return fault.begin <= start and fault.kind in ("override", "offset", "drop")


def changes_of(
    faults: Sequence[FaultSettings], from_start: Collection[int], tick: Callable[[float], int]
) -> dict[int, list[tuple[int, int]]]:
    """Tick -> faults that begin or end there, and which of both; `tick`: of a time, s; from_start: act before the first one.

    What began before the run begins with it.
    """
    changes: dict[int, list[tuple[int, int]]] = {}
    for i, fault in enumerate(faults):
        if i not in from_start:
            changes.setdefault(max(tick(fault.begin), 0), []).append((i, BEGINS))
        if fault.end is not None:
            changes.setdefault(tick(fault.end), []).append((i, ENDS))
    return changes
