"""Outputs that follow their inputs within an instant: units that are updated, algebraic loops that are solved."""

from __future__ import annotations

from math import inf

from ..coupling.graph import Loop
from .loops import LoopSolver
from .machine import Machine
from .network import Acts, Network, RowRange
from .node import Node
from .records import FOLLOW, LEFT, LOOK, PUSH, RIGHT, SHIFT

UNMOVED = 16 * 2.0**-52  # relative: an input this near to the end of its polynomial has not moved


class Feedthrough:
    """What follows behind the steps of all units, in the order of the coupling.

    loops: the algebraic ones. acts: what a step ends with where there are none: outputs follow, and the inputs of the new instant are
    kept; those behind inputs that jump follow twice, to the left and to the right of the jump. rows: what follows within an instant.
    """

    def __init__(self, network: Network, delayed: bool):
        """delayed: nothing follows; values are exchanged once per step."""
        schedule = network.coupling.feedthrough_schedule
        self.why_it_grows = ""  # a coupling whose algebraic loop gets its values one step late
        if delayed and (loop := next((part for part in schedule if isinstance(part, Loop)), None)) is not None:
            self.why_it_grows = (
                f"{' and '.join(loop.units)} depend on one another within an instant but exchange values "
                "one step late; where that amplifies, no shorter step helps. Use master.feedthrough = "
                "'immediate', which solves their loop"
            )
        parts: list[LoopSolver | list[Node]] = []
        for step in () if delayed else schedule:
            if isinstance(step, Loop):
                parts.append(LoopSolver(step, network))
            elif parts and isinstance(parts[-1], list):
                parts[-1].append(network.node_of[step])
            else:
                parts.append([network.node_of[step]])
        self.loops = [part for part in parts if isinstance(part, LoopSolver)]
        following = [part for part in parts if isinstance(part, list)]
        for node in dict.fromkeys(node for part in following for node in part):
            interface = network.coupling.interfaces[node.unit.name]
            # of all outputs, read or not: when a unit is updated must not depend on what is recorded of it
            at_once = {i for output in interface.outputs.values() for i in output.feedthrough or ()}
            exact = interface.input_degree >= network.degree
            for k, link in enumerate(node.links):
                if link.target[1] in at_once:
                    node.direct.append((k, UNMOVED if exact or k in node.held else -inf))
        follow, push = [(FOLLOW, part) for part in following], (PUSH, network.fed)
        self.acts: Acts = [*follow, push]
        if any(k in node.held for part in following for node in part for k, _ in node.direct):
            left, right = ([(act, part) for part in following] for act in (LEFT, RIGHT))
            bonded = {link.target[0] for bond in network.coupling.bonds for link in bond.links}  # whose jumps are noted
            kept = [  # of which more than the newest sample counts, the one that `PUSH` sets anyway
                node
                for node in network.fed
                if node.own or node.unit.name in bonded or any(s.degree or s.every > 1 for s in node.samples)
            ]
            self.acts = [*left, (LOOK, kept), *right, (SHIFT, kept), push]
        self.rows = network.rows(*follow)
        self._parts: list[LoopSolver | RowRange] = [
            part if isinstance(part, LoopSolver) else network.rows((FOLLOW, part)) for part in parts
        ]

    def solve(self, machine: Machine, t: float) -> None:
        """Update the units whose inputs have moved, and solve the loops, each where it stands among them."""
        machine.records.ask(updated=0)
        for part in self._parts:
            if isinstance(part, LoopSolver):
                part.solve(machine, t)
                machine.records.ask(updated=1)
            else:
                machine.perform(part, t, 0.0)
