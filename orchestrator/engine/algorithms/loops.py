"""Algebraic loops, solved at each communication point: outputs that depend on one another within an instant.

Newton's method on the outputs of the loop: x = G(x), where G gives x to the units and reads their outputs. The Jacobian comes
from the units if all of them offer theirs, else from finite differences. It is reused at the next points as long as it reduces
the residual enough, so that a linear loop costs two evaluations a point.
"""

from __future__ import annotations

import numpy as np

from ....components.core.errors import StepFailed
from ..coupling.graph import Loop
from .machine import Machine
from .network import Network
from .records import READ, UPDATE

CONVERGED = 1e-12  # residual of an output relative to its size
STALLED = 1e-9  # and where it no longer falls: gains above 1 amplify the rounding
CONTRACTION = 0.3  # what a Jacobian may leave of a residual before it is taken anew
LIMIT = 50  # corrections at one point
HALVINGS = 12  # of a correction that makes the residual larger
SINGULAR = 1e-7  # smallest over largest singular value of I - dG/dx, equilibrated; below it no answer is certain
ABOUT_ZERO = 1e-3  # of the nominal value: an output below it is compared with it instead of with itself
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
        self.jacobian: np.ndarray | None = None  # dG/dx, (n, n); never changed in place
        self.points = self.evaluations = self.jacobians = 0
        self.residual = 0.0  # the largest that was left

    def solve(self, machine: Machine, t: float) -> None:
        """Bring the loop's outputs and the inputs of its units together; raises `StepFailed` where that does not come about."""
        self.points += 1
        self._machine, self._t = machine, t
        x = self._present()
        answer = self._answer(x)
        residual = self._residual(x, answer)
        if residual == np.inf:
            return  # an output is not finite, which the master finds when it checks all outputs
        for _ in range(LIMIT):
            if residual <= CONVERGED:
                break
            first_time = self.jacobian is None
            if self.jacobian is None:
                self.jacobian = self._derivatives(x, answer)
            tried, given, contraction = self._corrected(x, answer, residual, HALVINGS if first_time else 1, t)
            left = self._residual(tried, given)
            stalled = left <= STALLED and contraction > 0.5
            if contraction > CONTRACTION and not stalled:
                self.jacobian = None
            if contraction < 1.0 or stalled:
                x, answer, residual = tried, given, left
            elif first_time:
                raise self._failed(left, t)
            if stalled:
                break
        else:
            raise self._failed(residual, t)
        self.residual = max(self.residual, residual)

    def _failed(self, residual: float, t: float) -> StepFailed:
        return StepFailed(
            ", ".join(self.loop.units),
            t,
            f"the algebraic loop of {self.loop.text} cannot be solved; a residual of {residual:.2g} of its size is left",
            "Give one of the units a state, or change a gain",
        )

    def _corrected(
        self, x: np.ndarray, answer: np.ndarray, residual: float, halvings: int, t: float
    ) -> tuple[np.ndarray, np.ndarray, float]:
        """The next x, its answer and what share of the residual is left; a correction that leads astray is shortened.

        `halvings`: how often it is tried at most.
        """
        sizes = self._sizes(x, answer)
        assert self.jacobian is not None
        scaled = np.eye(len(x)) - self.jacobian * (sizes / sizes[:, None])
        spread = np.linalg.svd(_equilibrated(scaled), compute_uv=False) if np.isfinite(scaled).all() else np.zeros(1)
        if not spread[-1] > SINGULAR * spread[0]:
            raise StepFailed(
                ", ".join(self.loop.units),
                t,
                f"the algebraic loop of {self.loop.text} has no single solution: its gain is 1 there (residual {residual:.2g})",
                "Change a gain, or give one of the units a state",
            )
        missed = answer - x
        change = sizes * np.linalg.solve(scaled, missed / sizes)
        for halving in range(halvings):
            tried = x + change * 0.5**halving
            given = self._answer(tried)
            sizes = self._sizes(tried, given)
            left = float(np.max(np.abs(given - tried) / sizes) / np.max(np.abs(missed) / sizes))
            if left < 1.0:
                break
        return tried, given, left if np.isfinite(left) else np.inf

    def _present(self) -> np.ndarray:
        return self._machine.signals[self._cells]

    def _answer(self, x: np.ndarray) -> np.ndarray:
        """What the units give where the loop's outputs are x, (n,)."""
        self.evaluations += 1
        self._machine.signals[self._cells] = x
        self._machine.perform(self._rows, self._t, 0.0)
        return self._present()

    def _sizes(self, x: np.ndarray, answer: np.ndarray) -> np.ndarray:
        """What changes of the outputs are compared with, (n,)."""
        return np.maximum(np.maximum(np.abs(x), np.abs(answer)), ABOUT_ZERO * self._nominals)

    def _residual(self, x: np.ndarray, answer: np.ndarray) -> float:
        """Largest change from x to its answer, relative to their size; infinite where it is no number."""
        worst = float(np.max(np.abs(answer - x) / self._sizes(x, answer)))
        return worst if np.isfinite(worst) else np.inf

    def _derivatives(self, x: np.ndarray, answer: np.ndarray) -> np.ndarray:
        """dG/dx, (n, n)."""
        self.jacobians += 1
        if self._exact and not any(node.altered for node in self.nodes):
            return self._chained()
        columns = []
        for k, size in enumerate(np.maximum(np.abs(x), self._nominals)):
            nudged = x.copy()
            nudged[k] += NUDGE * size
            columns.append((self._answer(nudged) - answer) / (nudged[k] - x[k]))
        return np.array(columns).T

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
        return {"points": self.points, "evaluations": self.evaluations, "jacobians": self.jacobians, "residual": self.residual}


def _equilibrated(matrix: np.ndarray) -> np.ndarray:
    """Rows and columns divided by their largest entries: an output that is near zero now makes no matrix singular."""
    for axis in (1, 0, 1, 0):
        largest = np.abs(matrix).max(axis=axis, keepdims=True)
        matrix = matrix / np.where(largest > 0.0, largest, 1.0)
    return matrix
