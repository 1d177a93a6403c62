"""Consistent initial values, group by group: units that feed one another, behind the groups that feed them.

A group of one unit has its inputs and is initialized once. In a larger one the units are initialized one after the other until
their outputs stop changing. Where these sweeps do not converge, a quasi-Newton method goes on from their best result: it takes
the outputs that a sweep begins with as unknowns, and learns from all its earlier answers (Anderson's method with full
memory; for a linear group of n unknowns n + 2 of its steps are enough but for rounding, up to a gain of a sweep of about 1e6).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ....components.core.errors import StepFailed
from ...units import Interface
from ..coupling import Endpoint
from .node import Node
from .texts import Texts

SWEEPS = 30
SECANTS = 30
CONVERGED = 1e-12  # relative change of an output from one sweep to the next
STALLED = 1e-9  # and what is left of it where stiff units answer the rounding of one another: it no longer falls then
ABOUT_ZERO = 1e-3  # of the nominal value: an output below it is compared with it instead of with itself
RUNAWAY = 1e12  # times the nominal value: no answer of a model any more, even where a nominal value was left at 1
RETURNED = 1e-7  # change of a miss relative to the change of an answer; below it a circle gives back what it gets
NEW = 1e-10  # share of an answer that earlier ones do not foretell; less of it is rounding


@dataclass(frozen=True)
class InitializationResult:
    """How a group came to its initial values; `residual`: relative change in the last sweep."""

    units: tuple[str, ...]
    sweeps: int
    secants: int
    residual: float


class Group:
    """Units that feed one another, before the first step."""

    def __init__(
        self,
        nodes: Sequence[Node],
        signals: np.ndarray,
        cells: Mapping[Endpoint, int],
        interfaces: Mapping[str, Interface],
        texts: Texts | None,
        check: Callable[[float], None],
        t: float,
    ):
        """`signals`: the master's table, `cells`: where in it every output stands; `check` raises for values that are none."""
        self._nodes, self._signals, self._texts, self._check, self._t = list(nodes), signals, texts, check, t
        self.initialization: InitializationResult | None = None  # what `solve` came to, before it raises, too
        self._names = tuple(node.unit.name for node in nodes)
        self._ends = [end for end in cells if end[0] in self._names]
        self._cells = [cells[end] for end in self._ends]
        self._least = ABOUT_ZERO * np.array([interfaces[u].outputs[n].nominal for u, n in self._ends])
        given: set[int] = set()
        needed: set[int] = set()  # cells that a sweep reads before it writes them: it depends on no others
        for node in self._nodes:
            needed |= set(node.sources) - given
            given |= {cells[end] for end in self._ends if end[0] == node.unit.name}
        self._unknown = [k for k, cell in enumerate(self._cells) if cell in needed]

    def solve(self) -> None:
        """Bring the units to initial values that fit together; raises `StepFailed` with what is left where it cannot be."""
        if len(self._nodes) == 1:
            self._sweep()
            self.initialization = InitializationResult(self._names, 1, 0, 0.0)
            self._check(self._t)
            return
        best, least, last = self._values(), np.inf, np.inf
        for sweep in range(1, SWEEPS + 1):
            before = self._values()
            self._sweep()
            residual = self._residual(before)
            if residual <= CONVERGED or 0.5 * last <= residual <= STALLED:
                self.initialization = InitializationResult(self._names, sweep, 0, residual)
                return
            if residual == np.inf:
                break
            miss = float((np.abs(self._values() - before) / self._least).max())
            if miss < least:
                best, least = before, miss
            last = residual
        self._by_secants(best, sweep)

    def _by_secants(self, x: np.ndarray, sweeps: int) -> None:
        answers: list[np.ndarray] = []
        misses: list[np.ndarray] = []
        last = np.inf
        for k in range(1, SECANTS + 1):
            self._set(x)
            self._sweep()
            answer = self._values()
            residual = self._residual(x)
            self.initialization = InitializationResult(self._names, sweeps, k, residual)
            if residual <= CONVERGED or 0.5 * last <= residual <= STALLED:
                return
            if not np.isfinite(answer).all():
                break
            last = residual
            answers.append(answer)
            misses.append((answer - x)[self._unknown])
            x = answer + _foretold(answers, misses, np.maximum(np.abs(answer), self._least)[self._unknown])
        self._check(self._t)
        raise self._not_converged(residual, sweeps, k, _parallel([answer[self._unknown] for answer in answers], misses))

    def _not_converged(self, residual: float, sweeps: int, secants: int, parallel: bool) -> StepFailed:
        unit, name = self._ends[int(np.argmax(self._changes))]
        returned = ", and what goes round comes back as it went: they have no common equilibrium, or many" if parallel else ""
        return StepFailed(
            unit,
            self._t,
            f"the initial values of {', '.join(self._names)} did not converge in {sweeps} sweeps "
            f"and {secants} quasi-Newton steps; {name} still changes by {residual:.2g} of its value{returned}",
            "Give parameters closer to a common equilibrium",
        )

    def _sweep(self) -> None:
        texts = self._texts
        for node in self._nodes:
            if texts is not None:
                texts.give(node.unit.name)
            node.unit.initialize(self._t, node.inputs())
            node.read()
            if texts is not None:
                texts.take(node.unit.name)

    def _values(self) -> np.ndarray:
        """Outputs of the group, (n,)."""
        return self._signals[self._cells]

    def _set(self, values: np.ndarray) -> None:
        self._signals[self._cells] = values

    def _residual(self, before: np.ndarray) -> float:
        """Largest change in the last sweep; infinite where an output has run away."""
        values = self._values()
        bound = RUNAWAY / ABOUT_ZERO * self._least
        self._changes = np.abs(values - before) / np.maximum(np.maximum(np.abs(values), np.abs(before)), self._least)
        return float(max(self._changes, default=0.0)) if (np.abs(values) < bound).all() else np.inf


def _foretold(answers: list[np.ndarray], misses: list[np.ndarray], sizes: np.ndarray) -> np.ndarray:
    """What to add to the last answer, (n,), so that the misses of all answers, weighted like this, vanish as far as they can."""
    if len(answers) < 2:
        return np.zeros_like(answers[-1])
    differences = (np.array(misses[:-1]).T - misses[-1][:, None]) / sizes[:, None]
    lengths = np.maximum(np.sqrt((differences**2).sum(axis=0)), np.finfo(float).tiny)
    weights = np.linalg.lstsq(differences / lengths, -misses[-1] / sizes, rcond=NEW)[0] / lengths
    return (np.array(answers[:-1]).T - answers[-1][:, None]) @ weights


def _parallel(answers: list[np.ndarray], misses: list[np.ndarray]) -> bool:
    """Whether answers differ although their misses do not."""
    pairs = range(1, len(answers))
    return any(np.abs(misses[k] - misses[k - 1]).max() < RETURNED * np.abs(answers[k] - answers[k - 1]).max() for k in pairs)
