"""Algebraic loops, solved at each communication point: outputs that depend on one another within an instant.

Newton's method on the outputs of the loop: x = G(x), where G gives x to the units and reads their outputs. The Jacobian comes
from the units if all of them offer theirs, else from finite differences.
"""

from __future__ import annotations

import numpy as np

from ....components.core.errors import StepFailed
from ..coupling.graph import Loop
from .machine import Machine
from .network import Network
from .records import READ, UPDATE
from .solve import Newton, Unsolved

NUDGE = 2.0**-20  # of an output's size, for finite differences


class LoopSolver:
    """One loop of a network: `solve` at each communication point."""

    def __init__(self, loop: Loop, network: Network):
        interfaces = network.coupling.interfaces
        self.loop, self.nodes = loop, [network.node_of[name] for name in loop.units]
        self._rows = network.rows((UPDATE, self.nodes), (READ, self.nodes))  # what the units give back
        self._cells = [network.positions[end] for end in loop.outputs]
        self._nominals = np.array([interfaces[u].outputs[n].nominal for u, n in loop.outputs])
        self._exact = all(interfaces[name].gives_jacobian for name in loop.units)
        self.newton = Newton(self._nominals)
        self.points = self.evaluations = 0

    def solve(self, machine: Machine, t: float) -> None:
        """Bring the loop's outputs and the inputs of its units together; raises `StepFailed` where that does not come about.

        An output that is not finite is left to the master, who finds it when it checks all outputs.
        """

        def answer(x: np.ndarray) -> np.ndarray:
            """What the units give where the loop's outputs are x, (n,)."""
            self.evaluations += 1
            machine.signals[self._cells] = x
            machine.perform(self._rows, t, 0.0)
            return machine.signals[self._cells]

        def derivatives(x: np.ndarray, given: np.ndarray) -> np.ndarray:
            """dG/dx, (n, n)."""
            if self._exact and not any(node.altered for node in self.nodes):
                return self._chained()
            columns = []
            for k, size in enumerate(np.maximum(np.abs(x), self._nominals)):
                nudged = x.copy()
                nudged[k] += NUDGE * size
                columns.append((answer(nudged) - given) / (nudged[k] - x[k]))
            return np.array(columns).T

        self.points += 1
        try:
            self.newton.solve(machine.signals[self._cells], answer, derivatives)
        except Unsolved as unsolved:
            raise self._failed(unsolved, t) from None

    def _failed(self, unsolved: Unsolved, t: float) -> StepFailed:
        of, residual = f"the algebraic loop of {self.loop.text}", f"{unsolved.residual:.2g}"
        if unsolved.singular:
            reason = f"{of} has no single solution: its gain is 1 there (residual {residual})"
            return StepFailed(", ".join(self.loop.units), t, reason, "Change a gain, or give one of the units a state")
        reason = f"{of} cannot be solved; a residual of {residual} of its size is left"
        return StepFailed(", ".join(self.loop.units), t, reason, "Give one of the units a state, or change a gain")

    def _chained(self) -> np.ndarray:
        """From the units' own derivatives."""
        ranks = {cell: i for i, cell in enumerate(self._cells)}
        whole = np.zeros((len(ranks), len(ranks)))
        for node in self.nodes:
            own = node.unit.jacobian()
            for cell, i in ranks.items():
                if node.place.start <= cell < node.place.stop:
                    for k, (source, link) in enumerate(zip(node.sources, node.links, strict=True)):
                        if source in ranks:
                            whole[i, ranks[source]] += own[cell - node.place.start, k] * link.factor
        return whole

    def counters(self) -> dict[str, float]:
        """For run.json."""
        newton = self.newton
        return {
            "points": self.points,
            "evaluations": self.evaluations,
            "jacobians": newton.jacobians,
            "residual": newton.residual,
        }
