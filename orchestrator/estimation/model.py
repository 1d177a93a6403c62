"""A scene as a filter steps it: which cells of its block move together, and unbounded numbers in the place of its parameters.

A filter needs of a scene: the numbers of all cells that a change of a state, a parameter or an input reaches, how they move along given
directions over a macro step, and what follows from a parameter that has changed. The first two are the tangents of the coupled step.
What follows from a parameter (1/mass, contact constants) lies in cells that initialization has written and no step does; they are
computed anew by an initialization beside the run.
"""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...components.core.errors import BadInput, nearest
from ..derivatives.cells import cell_name, owners
from ..derivatives.coupled_step import MOST, CoupledStep
from ..derivatives.tangent_block import TangentBlock
from ..scene.measured import amount, positive
from ..scene.names import declared, numerical_of, variable_of
from ..scene.scene import Scene
from ..settings.estimate import EstimateSettings, StateSettings
from .bounds import Bounds

SURVEYED = 5  # instants at which the cells of the state are looked for
CONDITION = 1e-9  # relative: an output is one state alone


@dataclass(frozen=True)
class Unknown:
    """A parameter or a free input that is estimated: q is its number without bounds.

    mean, deviation: of q, before the measurement.  walk: of q, per root of s.  memory: s, infinite without.
    """

    name: str
    unit: str
    bounds: Bounds
    mean: float
    deviation: float
    walk: float
    memory: float


@dataclass(frozen=True)
class Disturbed:
    """A state with a deviation at the start and a walk, per root of s, both in its own unit; size: of the cell per unit of it."""

    name: str
    cell: int
    size: float
    deviation: float
    walk: float


class Model:
    """An open scene, with what is estimated of it.

    block: where it stands.  live: (l,) cells that directions reach, without those that follow from unknowns.  state: (n,) cells of the
    state among all.  derived: cells that follow from unknowns, their own among them.  stays: (n,) of bool, cells of units that keep what
    an initialization has written.  held: (p,) numbers q where constants are linearised.  constants: places of those that do not walk.
    """

    def __init__(self, scene: Scene, plan: EstimateSettings, stack: ExitStack, steps: int, where: str):
        """steps: macro steps that are going to be made. Raises `BadInput` for names, units, and scenes without tangents."""
        self.scene, self._where = scene, where
        self.block = TangentBlock(scene, stack, remedy="")
        self.step = CoupledStep(self.block)
        self.unknowns = [self._unknown(name, plan, where) for name in plan.estimated]
        self.held: np.ndarray | None = None
        self.constants = np.array([k for k, u in enumerate(self.unknowns) if not u.walk], dtype=np.intp)
        self.cells = self.block.places(u.name for u in self.unknowns)
        self.signals = [".".join(end) for end in self.block.signals]
        self.y = self.block.table
        self.begin()
        self.large = plan.filter == "ensemble" or (not plan.filter and self.step.declared.size > MOST)
        self._survey(steps)
        self.disturbed = [self._disturbed(name, one, f"{where}: states.{name}") for name, one in plan.states.items()]
        self.begin()

    # -- what is estimated -------------------------------------------------------------------------------------------
    def _unknown(self, name: str, plan: EstimateSettings, where: str) -> Unknown:
        given, place = plan.estimated[name], f"{where}: estimated.{name}"
        known = self.block.parameters()
        if name not in known:
            raise BadInput(place, repr(name), "a real parameter, or an input that nothing drives", nearest(name, known))
        if reason := numerical_of(self.scene, [name]):
            raise BadInput(place, f"{name}: {reason[name]}", "a parameter of the model")
        one = self.variable(name)
        start = self.block.value(name)
        start = start if given.start is None else amount(given.start, one.unit, f"{place}.start", start)
        low = one.low if given.low is None else amount(given.low, one.unit, f"{place}.low", start)
        high = one.high if given.high is None else amount(given.high, one.unit, f"{place}.high", start)
        if not low < start < high:
            raise BadInput(f"{place}.start", f"{start:g} with bounds {low:g} and {high:g}", "a start between them")
        bounds = Bounds(low, high)
        q = bounds.inner(start)
        slope = bounds.slope(q)
        deviation = positive(given.deviation, one.unit, f"{place}.deviation", start, 1e-300)
        walk = positive(given.walk, one.unit, f"{place}.walk", start)
        return Unknown(name, one.unit, bounds, q, deviation / slope, walk / slope, given.memory or np.inf)

    def variable(self, name: str) -> Any:
        """The declaration of a variable, or of the array that it is an element of."""
        unit, variable = variable_of(self.scene, name, self._where)
        variables = declared(self.scene, unit)
        return variables.get(variable) or variables[variable.partition("[")[0]]

    def _disturbed(self, name: str, given: StateSettings, place: str) -> Disturbed:
        names = {cell_name(self.block, cell): cell for cell in self.state.tolist()}
        unit, size = "", 1.0
        if name in names:
            cell = names[name]
        else:
            alone = self._outputs_of_one_state()
            if name not in alone:
                known = [*alone, *names]
                raise BadInput(
                    place,
                    repr(name),
                    "a state, or an output that is a state alone",
                    nearest(name, known) or f"They are {', '.join(known)}.",
                )
            cell, slope = alone[name]
            size = 1.0 / slope
            unit = self.variable(name).unit
        deviation, walk = (positive(v, unit, f"{place}.{k}") for k, v in (("deviation", given.deviation), ("walk", given.walk)))
        return Disturbed(name, cell, size, deviation, walk)

    def _outputs_of_one_state(self) -> dict[str, tuple[int, float]]:
        """Of outputs that are a multiple of one state of a unit: its cell, and the factor."""
        of_units = self.state[owners(self.block, self.state) >= 0]
        rows, _ = self.step.now(of_units, np.eye(of_units.size), np.array(list(self.block.outputs.values()), dtype=np.intp))
        alone = {}
        for name, row in zip(self.block.outputs, rows, strict=True):
            if (
                (k := int(np.argmax(np.abs(row)))) >= 0
                and row[k]
                and np.abs(np.delete(row, k)).max(initial=0.0) <= CONDITION * abs(row[k])
            ):
                alone[name] = int(of_units[k]), float(row[k])
        return alone

    def state_names(self) -> dict[int, str]:
        """Cell -> name, of the states of units; the name of an output that is this state, where there is one."""
        owned = self.state[owners(self.block, self.state) >= 0]
        own = {int(cell): cell_name(self.block, int(cell)) for cell in owned}
        names = dict(own)
        for output, (cell, slope) in self._outputs_of_one_state().items():
            if abs(slope - 1.0) <= CONDITION and names[cell] == own[cell]:
                names[cell] = output
        return names

    # -- which cells -------------------------------------------------------------------------------------------------
    def _survey(self, steps: int) -> None:
        """Look along the run for the state, for what tangents reach, and for what stays as initialization has left it."""
        block, step, n = self.block, self.step, self.block.cells.size
        reached, state, stays = np.zeros(n, dtype=bool), np.zeros(n, dtype=bool), np.ones(n, dtype=bool)
        begun = block.cells.copy()
        for _ in range(SURVEYED):
            reached[step.reached()] = True
            if not self.large:
                state[step.state().cells] = True
            block.advance(
                max(steps // SURVEYED, 1) | 1
            )  # an odd number, so that units with rates of their own are met in several phases
            stays &= (block.cells == begun) | (np.isnan(begun) & np.isnan(block.cells))
        addresses = (block.still != 0.0).any(axis=1)
        reached[addresses] = False
        state[step.declared if self.large else []] = True
        reached[self.y] = True
        self.stays = stays & ~reached & ~addresses
        self.stays[block.layout.at :] = False
        self.state, reached[self.cells] = np.flatnonzero(state), False
        _, by = self.started(self.cells)
        follows = self.stays & (by != 0.0).any(axis=1)
        follows[self.cells] = True
        self.derived = np.flatnonzero(follows)
        self.live = np.flatnonzero(reached)
        self.row = {int(cell): k for k, cell in enumerate(self.live)}
        self.y_rows, self.state_rows = (
            np.array([self.row[int(c)] for c in cells], dtype=np.intp) for cells in (self.y, np.setdiff1d(self.state, self.cells))
        )
        count = self.y.size  # how cells follow from the table of signals: itself, and samples of it
        cells, by = self.step.with_samples(self.y[:0], np.zeros((0, count)), np.eye(count))
        self._with_signals = np.zeros((self.live.size, count))
        self._with_signals[[self.row[int(cell)] for cell in cells]] = by
        self.restarts = self.derived.size > self.cells.size

    def begin(self) -> None:
        """Where a filter begins: at the start, and on until there are the samples that inputs are extrapolated from."""
        self.set_unknowns(self.at)
        self.step.begin()

    def started(self, cells: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Numbers of the whole block as initialized, (n,), and how all cells move there by each of some parameters' cells, (n, d)."""
        block, kept = self.block, self.block.save()
        parts = [block.tangents[:, : some.stop - some.start].copy() for some in block.starts(cells)]
        numbers = block.cells.copy()
        block.restore(kept)
        return numbers, np.concatenate(parts, axis=1)

    def prior(self, cells: np.ndarray) -> np.ndarray:
        """How live cells move by parameters' cells behind the first instants, (l, d)."""
        block, kept, parts = self.block, self.block.save(), []
        for some in block.starts(cells):
            block.fill()
            parts.append(block.tangents[self.live, : some.stop - some.start])
        block.restore(kept)
        return np.concatenate(parts, axis=1)

    # -- numbers -----------------------------------------------------------------------------------------------------
    def set_unknowns(self, q: np.ndarray) -> None:
        """Numbers of the unknowns where initialization begins."""
        self.block.initial[self.cells] = [u.bounds.outer(v) for u, v in zip(self.unknowns, q, strict=True)]

    @property
    def at(self) -> np.ndarray:
        """Numbers q of the unknowns where a filter begins, (p,)."""
        return np.array([u.mean for u in self.unknowns]) if self.held is None else self.held

    @property
    def disturbs(self) -> bool:
        """Whether a run does not follow from constants alone."""
        return bool(self.disturbed) or self.constants.size < len(self.unknowns)

    def follow(self, q: np.ndarray) -> None:
        """Let derived cells follow from the numbers q; `along` has then their derivatives by q, (d, p)."""
        self.set_unknowns(q)
        slopes = np.array([u.bounds.slope(v) for u, v in zip(self.unknowns, q, strict=True)])
        if self.restarts:
            numbers, by = self.started(self.cells)
            by[self.cells, np.arange(self.cells.size)] = 1.0
            self.block.cells[self.derived], self.along = numbers[self.derived], by[self.derived] * slopes
        else:
            self.block.cells[self.derived] = self.block.initial[self.derived]
            self.along = (self.derived[:, None] == self.cells) * slopes

    def propagate(self, cells: np.ndarray, directions: np.ndarray) -> np.ndarray:
        """A macro step on; returns how live cells moved with directions, (n, d), of some cells before: (l, d)."""
        moved = []
        for some in self.block.batches(cells, directions):
            self.block.advance(1)
            moved.append(self.block.tangents[self.live, some])
        return np.concatenate(moved, axis=1)

    def kicks(self, deviations: bool, dt: float) -> tuple[np.ndarray, np.ndarray]:
        """What disturbs the scene: (how live cells move (l, d), how the numbers q of unknowns do (p, d)).

        deviations: by what is unknown of states at the start, instead of the walks over dt, s, of states and unknowns.
        """
        cells = np.array([*(one.cell for one in self.disturbed), *self.derived], dtype=np.intp)
        n, p = len(self.disturbed), len(self.unknowns)
        sizes = [(one.deviation if deviations else one.walk * np.sqrt(dt)) * one.size for one in self.disturbed]
        walks = np.zeros(p) if deviations else np.array([u.walk * np.sqrt(dt) for u in self.unknowns])
        directions = np.block([[np.diag(sizes), np.zeros((n, p))], [np.zeros((self.derived.size, n)), self.along * walks]])
        numbers = np.hstack([np.zeros((p, n)), np.diag(walks)])
        acts = directions.any(axis=0)
        directions, numbers = directions[:, acts], numbers[:, acts]
        moved = np.zeros((self.live.size, numbers.shape[1]))
        if acts.any():
            _, signals = self.step.now(cells, directions, self.y[:0])
            moved = self._with_signals @ signals
            at = [self.row.get(int(cell), -1) for cell in cells[:n]]  # the cells of unknowns are none of the live ones
            moved[at] += directions[:n]
        return moved, numbers
