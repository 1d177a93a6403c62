"""Macro steps of a scene as a map of its state, and the derivative of the map: which cells are the state is found by tangents.

Tangents in the states of all units, and in the samples that inputs are extrapolated from, reach what they act on in a few steps. Of
these cells the state are those that the coming steps read before they write them: their columns of the Jacobian are not zero.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from math import lcm
from typing import NamedTuple

import numpy as np
from scipy.sparse.csgraph import connected_components

from ...components.core.errors import BadInput
from ..engine.algorithms import Master
from ..scene.scene import Scene
from ..scene.shorter_steps import numbers_in_use
from .cells import cell_name, owners, states
from .tangent_block import TangentBlock

MOST = 2000  # cells of a state whose Jacobian is computed
LONGEST = 1000  # macro steps to a common period
SAME_INSTANT = 1e-6  # of a macro step: rounding of periods


def sampling_periods(scene: Scene) -> dict[str, float]:
    """Place in the scene -> period, s, of every controller."""
    return {
        place: period
        for place, period in numbers_in_use(scene, "period").items()
        if scene.component_classes[place.removesuffix(".period")].holds_outputs
    }


def common_steps(scene: Scene, h: float) -> int:
    """Macro steps of h, s, behind which units with rates of their own and controllers begin anew; raises `BadInput`."""
    counts = [unit.every for unit in scene.units.values()]
    counts += [(Fraction(repr(period)) / Fraction(repr(h))).numerator for period in sampling_periods(scene).values()]
    if (steps := lcm(*counts)) > LONGEST:
        remedy = "Choose a macro step that divides the periods, or give steps."
        raise BadInput(f"{scene.name}: steps", f"periods that meet every {steps} macro steps", f"{LONGEST} at most", remedy)
    return steps


def check_steps(scene: Scene, steps: int) -> None:
    """Raise `BadInput` unless units with rates of their own and controllers begin anew behind so many macro steps of the scene."""
    rates = {f"{name}.every": unit.every for name, unit in scene.units.items()}
    periods = {place: period / scene.master.step for place, period in sampling_periods(scene).items()}
    for place, count in {**rates, **periods}.items():
        if abs(steps - max(round(steps / count), 1) * count) > SAME_INSTANT:
            raise BadInput(f"linearization of {scene.name}: steps", str(steps), f"a multiple of the {count:g} of {place}")


class CoupledState(NamedTuple):
    """The state of a coupled step where it was found, and the derivative of the common period by it.

    cells: (n,) of the block, which the period reads before it writes them.  jacobian: (n, n).  at_tie: (n,) whether a decision has stood
    at its boundary in the period along a cell of the state.
    """

    cells: np.ndarray
    jacobian: np.ndarray
    at_tie: np.ndarray


class CoupledStep:
    """Macro steps of a tangent block from where it stands, as a map of its state.

    steps: macro steps that units with rates of their own and controllers have in common.  declared: cells of all x, and of the samples
    of all links.
    """

    def __init__(self, block: TangentBlock, h: float | None = None, steps: int | None = None):
        """h, steps: others than those of the scene. Raises `BadInput` where rates have no common period."""
        self.block, self._where = block, f"linearization of {block.scene.name}"
        if h is not None:
            block.pace(h)
        self.steps = common_steps(block.scene, block.h) if steps is None else steps
        links = range(block.master.records.memory.links.size)
        self.declared = np.array([*states(block), *(cell for k in links for cell in block.samples(k))], dtype=np.intp)

    @property
    def period(self) -> float:
        """Of the steps that are common, s."""
        return self.steps * self.block.h

    def begin(self, seeds: Sequence[int] | np.ndarray = (), at: float | None = None) -> None:
        """At the start of the scene, or begun at a time, s, and on until there are as many samples as inputs are extrapolated from.

        seeds: of the first directions the cells of parameters; what follows from these keeps its tangents beside those of `seed`.
        """
        self.block.start(seeds, at)
        self.block.fill()

    def take(self, master: Master, t: float) -> None:
        """Where another opening of the scene stands, at t, s, and on as `begin`."""
        self.block.take(master, t)
        self.block.fill()

    # -- which cells are the state -----------------------------------------------------------------------------------
    def reached(self) -> np.ndarray:
        """Cells that tangents of the states reach behind whole periods: neither parameters nor tables, counters, addresses."""
        block, rng = self.block, np.random.default_rng(0)
        hit, before = np.zeros(block.cells.size, dtype=bool), block.save()
        block.seed(self.declared, rng.standard_normal((self.declared.size, block.width)))
        for _ in range(3):
            block.advance(self.steps)
            hit |= (block.tangents != block.still).any(axis=1)
        block.restore(before)
        hit[self.declared] = True
        return np.flatnonzero(hit)

    def state(self) -> CoupledState:
        """The state where the block stands. Raises `BadInput` for one that is too large, or has an infinite derivative."""
        cells = self.reached()
        if cells.size > 4 * MOST:
            self._refuse(cells.size)
        columns, ties = self._derivative(cells, np.eye(cells.size), cells, self.steps)
        if not np.isfinite(columns).all():
            place = cell_name(self.block, cells[np.flatnonzero(~np.isfinite(columns).all(axis=0))[0]])
            raise BadInput(self._where, f"an infinite derivative by {place} at t = {self.block.time:g} s", "a smooth state")
        kept = np.flatnonzero(np.abs(columns).max(axis=0) > 0.0)
        while (read := np.abs(columns[np.ix_(kept, kept)]).max(axis=0, initial=0.0) > 0.0).sum() < kept.size:
            kept = kept[read]
        if kept.size > MOST:
            self._refuse(kept.size)
        return CoupledState(cells[kept], columns[np.ix_(kept, kept)], ties[kept])

    def _refuse(self, size: int) -> None:
        remedy = "CoupledStep.derivative gives products with the Jacobian, for SciPy."
        raise BadInput(self._where, f"a state of {size} numbers", f"{MOST} at most", remedy)

    # -- the derivative ----------------------------------------------------------------------------------------------
    def derivative(self, by: np.ndarray, directions: np.ndarray, of: np.ndarray, steps: int | None = None) -> np.ndarray:
        """Of cells `of` behind some macro steps when cells `by`, (n,), move along directions, (n, d); (k, d). It stays where it is."""
        return self._derivative(by, directions, of, self.steps if steps is None else steps)[0]

    def _derivative(self, by: np.ndarray, directions: np.ndarray, of: np.ndarray, steps: int) -> tuple[np.ndarray, np.ndarray]:
        """As `derivative`, and along which directions a decision has stood at its boundary, (d,)."""
        block, before, parts = self.block, self.block.save(), []
        for some in block.batches(by, directions):
            block.advance(steps)
            parts.append((block.tangents[of, some], block.at_tie()[some]))
        block.restore(before)
        values, ties = (np.concatenate(of_all, axis=-1) for of_all in zip(*parts, strict=True))
        return values, ties

    def couples(self, cells: np.ndarray) -> bool:
        """Whether cells reach from unit to unit: cells of the master are among them, or of several units."""
        units = set(owners(self.block, cells).tolist())
        return -1 in units or len(units) > 1

    def coupling_blocks(self, state: CoupledState) -> list[np.ndarray]:
        """The blocks of a state that reach from unit to unit; a coupling grows where they have an eigenvalue beyond 1."""
        return [places for places in blocks_of(state.jacobian) if self.couples(state.cells[places])]

    # -- within an instant -------------------------------------------------------------------------------------------
    def now(self, by: np.ndarray, directions: np.ndarray, of: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Derivatives of outputs, cells `of` (k,), and of the table of signals within the instant, along directions (n, d)."""
        block, before, parts = self.block, self.block.save(), []
        for some in block.batches(by, directions):
            block.follow()
            parts.append((block.tangents[of, some], block.tangents[block.table, some]))
        block.restore(before)
        outputs, table = (np.concatenate(of_all, axis=1) for of_all in zip(*parts, strict=True))
        return outputs, table

    def with_samples(self, by: np.ndarray, directions: np.ndarray, signals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Cells that move together within the instant, and how far, (k, d): `by`, and samples of units that see them at once.

        signals: how the table of signals moves along the directions, (S, d), as of `now`.
        """
        block, records = self.block, self.block.master.records
        links = records.memory.links
        cells, moved = list(by), list(directions)
        for k in np.flatnonzero(signals.any(axis=1)):
            cells.append(block.table[k])
            moved.append(signals[k])
            for i in range(records.driven):
                if links["source"][i] == k and not links["pairs"][i]:
                    samples = block.samples(i)
                    cells += samples
                    moved += [links["factor"][i] * signals[k]] * len(samples)
        return np.array(cells, dtype=np.intp), np.array(moved).reshape(len(cells), directions.shape[1])


def blocks_of(matrix: np.ndarray) -> list[np.ndarray]:
    """Places of the groups of rows that act on one another, which are strongly connected: the spectrum is that of these blocks."""
    number, labels = connected_components(matrix != 0.0, directed=True, connection="strong")
    return [np.flatnonzero(labels == k) for k in range(number)]
