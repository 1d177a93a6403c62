"""Macro steps of a scene as a map of its state, and the derivative of the map: which cells are the state is found by tangents.

Tangents in the states of all units, and in the samples that inputs are extrapolated from, reach what they act on in a few steps. Of
these cells the state are those that the coming steps read before they write them: their columns of the Jacobian are not zero.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from math import inf, lcm

import numpy as np
from scipy.sparse.csgraph import connected_components

from ...components.core.errors import BadInput
from ..engine.algorithms import Master
from ..scene.scene import Scene
from ..scene.shorter_steps import numbers_in_use
from .tangent_run import CHUNK, TangentScene

SAMPLES = "present", "before", "earlier"  # of a link, the newest first
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


class CoupledStep:
    """Where a scene stands, as a map of its state over macro steps of length h, s; `begin` or `take` comes first.

    steps: macro steps that units with rates of their own and controllers have in common.
    """

    def __init__(self, tangents: TangentScene, h: float | None = None, steps: int | None = None):
        """h, steps: others than those of the scene. Raises `BadInput` where rates have no common period."""
        self.tangent_scene, self.h = tangents, tangents.scene.master.step if h is None else h
        self.steps = common_steps(tangents.scene, self.h) if steps is None else steps
        self._arena, self._n = tangents._arena, tangents.layout.cells
        self._own = tangents._arena.tangents[: self._n]
        self._where = f"linearization of {tangents.scene.name}"
        self._declared = self._declared_cells()

    # -- where it stands ---------------------------------------------------------------------------------------------
    def begin(self, seeds: Sequence[int] = (), at: float | None = None) -> None:
        """At the start of the scene, or begun at a time, s, and on until there are as many samples as inputs are extrapolated from.

        seeds: of the first directions the cells of parameters; what follows from these keeps its tangents beside those of `seed`.
        """
        self.tangent_scene.start(seeds, at)
        self.stand(self.tangent_scene.scene.start_time if at is None else at)

    def take(self, master: Master, t: float) -> None:
        """Where another opening of the scene stands, at t, s, and on as `begin`."""
        self.tangent_scene.take(master)
        self.stand(t)

    def stand(self, t: float) -> None:
        """Where the scene of tangents stands, at t, s, and on as `begin`."""
        self.tangent_scene.end_at(inf)
        self._from, self._taken = t, 0
        self._clear = self._own.copy()  # the addresses of derivatives
        pasts = self.tangent_scene.master.records.memory.pasts
        numbers = self._arena.cells.view(np.int64)
        places = [[self.tangent_scene._cell("pasts", k, name) for k in range(pasts.size)] for name in ("samples", "degree")]
        self._cells: np.ndarray | None = None
        while pasts.size and (numbers[places[0]] <= numbers[places[1]]).any():
            self.advance(1)

    @property
    def time(self) -> float:
        """Where it stands, s."""
        return self._from + self._taken * self.h

    def advance(self, steps: int) -> None:
        """Macro steps, with the tangents that there are; raises `StepFailed`."""
        while steps > 0:
            some = min(steps, CHUNK)
            self.tangent_scene.take_steps(self._from + self.h * np.arange(self._taken, self._taken + some), self.h)
            self._taken, steps, self._cells = self._taken + some, steps - some, None

    def seed(self, cells: np.ndarray, directions: np.ndarray) -> None:
        """Tangents of cells, (n, d) with d up to the width; all others are zero."""
        self._own[:] = self._clear
        self._own[cells, : directions.shape[1]] = directions
        self._arena.ties[0] = 0

    def tangents(self, cells: np.ndarray) -> np.ndarray:
        """The present ones, (n, width)."""
        return self._own[cells]

    # -- which cells are the state -----------------------------------------------------------------------------------
    def _declared_cells(self) -> np.ndarray:
        """Those of all x, and of the samples of all links."""
        layout, memory = self.tangent_scene.layout, self.tangent_scene.master.records.memory
        cells: list[int] = []
        for unit in layout.units:
            cells += (unit.first + k for ends in unit.component.block.ranges("x") for k in range(*ends) if unit.component.x.size)  # type: ignore[union-attr]
        for k in range(memory.links.size):
            degree = int(memory.pasts["degree"][memory.links["past"][k]])
            cells += (self.tangent_scene._cell("links", k, name) for name in SAMPLES[: degree + 1])
        return np.array(cells, dtype=np.intp)

    def reached(self) -> np.ndarray:
        """Cells that tangents of the states reach behind whole periods: neither parameters nor tables, counters, addresses."""
        rng, hit = np.random.default_rng(0), np.zeros(self._n, dtype=bool)
        before = self._save()
        self.seed(self._declared, rng.standard_normal((self._declared.size, self.tangent_scene.width)))
        for _ in range(3):
            self.advance(self.steps)
            hit |= (self._own != self._clear).any(axis=1)
        self._restore(before)
        hit[self._declared] = True
        return np.flatnonzero(hit)

    @property
    def cells(self) -> np.ndarray:
        """The state, (n,): cells of the block that the coming period reads before it writes them. Raises `BadInput` for too many."""
        if self._cells is None:
            self._find()
        assert self._cells is not None
        return self._cells

    def _find(self) -> None:
        cells = self.reached()
        if cells.size > 4 * MOST:
            self._refuse(cells.size)
        columns = self._columns(cells, self.steps)
        ties = self.at_tie
        kept = np.flatnonzero(np.abs(columns).max(axis=0) > 0.0)
        while (read := np.abs(columns[np.ix_(kept, kept)]).max(axis=0, initial=0.0) > 0.0).sum() < kept.size:
            kept = kept[read]
        if kept.size > MOST:
            self._refuse(kept.size)
        self._cells, self._jacobian, self.ties = cells[kept], columns[np.ix_(kept, kept)], ties[kept]

    def _refuse(self, size: int) -> None:
        remedy = "CoupledStep.products gives products with the Jacobian, for SciPy."
        raise BadInput(self._where, f"a state of {size} numbers", f"{MOST} at most", remedy)

    # -- the derivative ----------------------------------------------------------------------------------------------
    def products(self, directions: np.ndarray, steps: int | None = None, cells: np.ndarray | None = None) -> np.ndarray:
        """The derivative of some macro steps times directions, (n, d): of the state, or of other cells. It stays where it is."""
        cells = self.cells if cells is None else cells
        return self.derivative(cells, directions, cells, steps)

    def derivative(self, by: np.ndarray, directions: np.ndarray, of: np.ndarray, steps: int | None = None) -> np.ndarray:
        """Of cells `of` behind some macro steps when cells `by`, (n,), move along directions, (n, d); (k, d).

        `at_tie` has then, (d,), along which ones a decision has stood at its boundary.
        """
        known, before, results, ties = self._cells, self._save(), [np.zeros((of.size, 0))], [np.zeros(0, dtype=bool)]
        width = self.tangent_scene.width
        for k in range(0, directions.shape[1], width):
            some = directions[:, k : k + width]
            self.seed(by, some)
            self.advance(self.steps if steps is None else steps)
            results.append(self.tangents(of)[:, : some.shape[1]])
            ties.append(self.tangent_scene.at_tie()[: some.shape[1]])
            self._restore(before)
        self._cells, self.at_tie = known, np.concatenate(ties)
        return np.concatenate(results, axis=1)

    def _columns(self, cells: np.ndarray, steps: int) -> np.ndarray:
        values = self.derivative(cells, np.eye(cells.size), cells, steps)
        if not np.isfinite(values).all():
            place = cells[np.flatnonzero(~np.isfinite(values).all(axis=0))[0]]
            raise BadInput(self._where, f"an infinite derivative by {self.name(place)} at t = {self.time:g} s", "a smooth state")
        return values

    def jacobian(self, steps: int | None = None) -> np.ndarray:
        """The derivative of the state behind some macro steps by the state, (n, n); default: the common period."""
        cells = self.cells
        return self._jacobian if steps in (None, self.steps) else self._columns(cells, steps)  # type: ignore[arg-type]

    def coupling(self, blocks: Sequence[np.ndarray]) -> list[bool]:
        """Of blocks of the state whether they reach from unit to unit: cells of the master are in them, or of several units."""
        owners = self.owners()
        return [-1 in owners[block] or len(set(owners[block])) > 1 for block in blocks]

    def coupling_blocks(self) -> list[np.ndarray]:
        """The blocks of the state that reach from unit to unit; a coupling grows where they have an eigenvalue beyond 1."""
        blocks = blocks_of(self.jacobian())
        return [block for block, couples in zip(blocks, self.coupling(blocks), strict=True) if couples]

    # -- within an instant -------------------------------------------------------------------------------------------
    def now(self, by: np.ndarray, directions: np.ndarray, of: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Derivatives of outputs, cells `of` (k,), and of the table of signals within the instant, along directions (n, d)."""
        tangents, arena = self.tangent_scene, self._arena
        read = np.array([tangents.layout.output(end) for end in tangents.signals], dtype=np.intp)
        signals = slice(tangents._first_signal, tangents._first_signal + read.size)
        before, outputs, table = self._save(), [np.zeros((of.size, 0))], [np.zeros((read.size, 0))]
        for k in range(0, directions.shape[1], tangents.width):
            some = directions[:, k : k + tangents.width]
            self.seed(by, some)
            tangents.follow(self.time, read)
            outputs.append(self.tangents(of)[:, : some.shape[1]])
            table.append(arena.tangents[signals, : some.shape[1]].copy())
            self._restore(before)
        return np.concatenate(outputs, axis=1), np.concatenate(table, axis=1)

    def with_samples(self, by: np.ndarray, directions: np.ndarray, signals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Cells that move together within the instant, and how far, (k, d): `by`, and samples of units that see them at once.

        signals: how the table of signals moves along the directions, (S, d), as of `now`.
        """
        tangents, records = self.tangent_scene, self.tangent_scene.master.records
        links, pasts = records.memory.links, records.memory.pasts
        cells, moved = list(by), list(directions)
        for k in np.flatnonzero(signals.any(axis=1)):
            cells.append(tangents._first_signal + k)
            moved.append(signals[k])
            for i in range(records.driven):
                if links["source"][i] == k and not links["pairs"][i]:
                    names = SAMPLES[: int(pasts["degree"][links["past"][i]]) + 1]
                    cells += (tangents._cell("links", i, name) for name in names)
                    moved += [links["factor"][i] * signals[k] for _ in names]
        return np.array(cells, dtype=np.intp), np.array(moved).reshape(len(cells), directions.shape[1])

    # -- names -------------------------------------------------------------------------------------------------------
    def owners(self, cells: np.ndarray | None = None) -> np.ndarray:
        """Of each cell, of the state or given, the place of its unit in the layout, or -1 for the master, (n,)."""
        layout = self.tangent_scene.layout
        firsts = [unit.first for unit in layout.units]
        cells = self.cells if cells is None else cells
        return np.where(cells >= layout.at, -1, np.searchsorted(firsts, cells, side="right") - 1)

    def name(self, cell: int) -> str:
        """Of a cell: "unit.x[3]", "unit.input (before)", "unit.output (held)"."""
        layout, master = self.tangent_scene.layout, self.tangent_scene.master
        unit = int(self.owners(np.array([cell]))[0])
        if unit >= 0:
            return f"{layout.units[unit].name}.{layout.units[unit].component.block.name(cell - layout.units[unit].first)}"  # type: ignore[union-attr]
        block, memory = master.records.block, master.records.memory
        for node in master.nodes:
            first = int(memory.units["first_link"][node.called])
            for record in {int(memory.units["first_link"][node.index]), first}:
                width = memory.links.dtype.itemsize // 8
                place, field = divmod(cell - self.tangent_scene._cell("links", record, "at"), width)
                if 0 <= place < len(node.links):
                    assert memory.links.dtype.names is not None
                    return f"{'.'.join(node.links[place].target)} ({memory.links.dtype.names[field]})"
        signal = cell - self.tangent_scene._first_signal
        if 0 <= signal < len(master.positions):
            return f"{'.'.join(list(master.positions)[signal])} (held)"
        return f"coupling.{block.name(cell - layout.at)}"

    # -- the block ---------------------------------------------------------------------------------------------------
    def _save(self) -> tuple[np.ndarray, int]:
        return self._arena.cells[: self._n].copy(), self._taken

    def _restore(self, saved: tuple[np.ndarray, int]) -> None:
        self._arena.cells[: self._n], self._taken = saved


def blocks_of(matrix: np.ndarray) -> list[np.ndarray]:
    """Places of the groups of rows that act on one another, which are strongly connected: the spectrum is that of these blocks."""
    number, labels = connected_components(matrix != 0.0, directed=True, connection="strong")
    return [np.flatnonzero(labels == k) for k in range(number)]
