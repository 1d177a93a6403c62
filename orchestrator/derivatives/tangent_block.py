"""The tangent block of an opened scene: its units and its master in one block of memory, with the derivatives of all that it holds.

The block lies as that of a scene's FMU does, and is stepped by the derivatives of the kernels that a run calls. Cells have tangents, in
`width` directions at once. Behind the block lies a copy of what an initialization of a unit begins with, and room for the rows.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from copy import copy
from math import inf
from typing import Any, NamedTuple

import numpy as np

from ...components.core.block import CELL
from ...components.core.contract import KernelComponent
from ...components.core.errors import BadInput, StepFailed, nearest
from ...fmus.derivatives.compiled import Arena
from ...fmus.derivatives.grammar import Unsupported
from ..engine.algorithms import Master
from ..engine.algorithms.initial_kernels import SWEEPS
from ..engine.algorithms.records import ABOUT_ZERO, GIVEN, STALLED, UNKNOWN
from ..engine.stepping.discontinuities import jump_times
from ..opened.open_scene import OpenScene
from ..scene.scene import Scene
from ..scene_fmu.layout import Layout, in_python, stepped_in_python
from .tangent_code import compiled

WIDTH = 8  # directions at once
CHUNK = 256  # macro steps of one call
STANDS = 1e-7  # relative change of a tangent in one more initialization that is rounding; of one below `ABOUT_ZERO` times the
# largest of its direction it is a change of that
SAMPLES = "present", "before", "earlier"  # of a link, the newest first
BY_DIFFERENCES = "Differences have no such limit: differences = 1e-4."
KERNELS_ALONE = "a scene of components whose macro step is kernels alone (Jacobi or Gauss-Seidel, no algebraic loop)"


class Instant(NamedTuple):
    """Where a block stands: numbers of its cells (n,), tangents that stay (n, width), and `taken` steps of h, s, behind `origin`, s."""

    cells: np.ndarray
    still: np.ndarray
    origin: float
    taken: int
    h: float

    @property
    def time(self) -> float:
        """In s."""
        return self.origin + self.taken * self.h


class TangentBlock:
    """An opened scene with derivatives; `start` or `take` comes first.

    initial: (n,) numbers that the scene starts from, parameters and free inputs among them.  cells: (n,), tangents: (n, width), where it
    stands.  still: (n, width) tangents that stay when others are chosen: addresses of derivatives, and those by `start`.
    outputs: "unit.output" -> its cell.  signals: "unit", "output" of those that the master holds; table: their cells there, (S,).
    h: length of the macro steps, s.  taken: how many since it was started, taken, or given another length of step.
    """

    def __init__(self, scene: Scene, stack: ExitStack, follow: bool = True, width: int = WIDTH, remedy: str = BY_DIFFERENCES):
        """`stack` closes the units.  width: directions at once.  remedy: for scenes without derivatives.

        follow: outputs follow inputs even where these have moved by rounding alone, for their tangents may have moved; without it
        the numbers are bit-identical to those of a run. Raises `BadInput` for what has no derivatives.
        """
        self.scene, self.width, self._where, self._remedy = scene, width, f"derivatives of {scene.name}", remedy
        reasons = in_python(scene)
        self._refuse([*reasons, *["faults"] * bool(scene.faults), *["signals that jump"] * bool(jump_times(scene))])
        open_scene = OpenScene(scene, stack, in_process=True)
        self.master, self.clock = open_scene.master, open_scene.clock
        self._refuse(stepped_in_python(scene, self.master))
        self.layout = layout = Layout.of(scene, self.master, changes=False)
        memory, n = self.master.records.memory, layout.cells
        image, self._addresses = layout.image()
        self.initial = image.view(np.float64)
        self.signals = list(self.master.positions)
        self.table = layout.at + self.master.records.block.cell("s", "signals") + np.arange(len(self.signals))
        self.outputs = {f"{u.name}.{n}": layout.output((u.name, n)) for u in layout.units for n in u.component.outputs}
        self._ends = [self.cell("units", k, "stop") for k in range(memory.units.size)]
        self._changes = [self.cell("links", k, "change") for k in range(memory.links.size)]
        self.initial[self._ends] = scene.stop_time
        if follow:
            self.initial[self._changes] = -inf
        self._circular = follow and bool(np.any(memory.groups["last"] - memory.groups["first"] > 1))
        self._rows = 2 * n
        self._given = self._rows + CHUNK * len(self.signals)
        self._times = self._given + CHUNK * memory.bonded.size * len(GIVEN)
        self._arena = Arena(self._times + CHUNK, width)
        self.cells, self.tangents = self._arena.cells[:n], self._arena.tangents[:n]
        try:
            self._code = compiled(layout, width)
        except Unsupported as error:
            raise BadInput(self._where, str(error), "instructions that have a derivative") from None
        self._places = {n: c for unit in layout.units for n, c in unit.settable.items() if np.isfinite(self.initial[c])}
        self._initialize = self._code.entry("master_initialize_groups", 2)
        self._steps = self._code.entry("master_run_steps", 2)
        self.h = scene.master.step
        self._stand(scene.start_time)

    def another(self) -> TangentBlock:
        """The same scene and machine code in memory of its own, for another thread; as this one, `start` comes first."""
        other, n = copy(self), self.layout.cells
        other.initial, other._arena = self.initial.copy(), Arena(self._times + CHUNK, self.width)
        other.cells, other.tangents = other._arena.cells[:n], other._arena.tangents[:n]
        other._stand(self.scene.start_time)
        return other

    def _refuse(self, reasons: Sequence[str]) -> None:
        if reasons:
            raise BadInput(self._where, ", ".join(reasons), KERNELS_ALONE, self._remedy)

    # -- parameters --------------------------------------------------------------------------------------------------
    def parameters(self) -> list[str]:
        """Everything a derivative can be taken by: real parameters in use that are not structural, and inputs that nothing drives."""
        return list(self._places)

    def places(self, names: Iterable[str]) -> np.ndarray:
        """Cells of parameters and free inputs, (n,); raises `BadInput`."""
        return np.array([self._place_of(name) for name in names], dtype=np.intp)

    def value(self, parameter: str) -> float:
        """Of a parameter in this scene."""
        return float(self.initial[self._place_of(parameter)])

    def set(self, values: Mapping[str, float]) -> None:
        """Numbers of parameters and free inputs, which the scene starts with from now on."""
        self.initial[self.places(values)] = list(values.values())

    def _place_of(self, parameter: str) -> int:
        if parameter in self._places:
            return self._places[parameter]
        for unit in self.layout.units:
            name = parameter.removeprefix(f"{unit.name}.")
            if name != parameter and (variable := type(unit.component).variables.get(name)) is not None:
                what = "structural" if variable.structural else "not a number in use, or driven"
                raise BadInput(f"{self._where}: {name}", what, "a real parameter that is not structural")
        raise BadInput(self._where, repr(parameter), "a real parameter", nearest(parameter, self.parameters()))

    # -- records of the master ---------------------------------------------------------------------------------------
    def cell(self, array: str, k: int, field: str) -> int:
        """Of a field of the master's records."""
        return self.layout.at + self.master.records.place(array, k, field)

    def samples(self, link: int) -> list[int]:
        """Cells of the samples that an input is extrapolated from, the newest first."""
        memory = self.master.records.memory
        degree = int(memory.pasts["degree"][memory.links["past"][link]])
        return [self.cell("links", link, name) for name in SAMPLES[: degree + 1]]

    # -- where it stands ---------------------------------------------------------------------------------------------
    @property
    def time(self) -> float:
        """Where it stands, s."""
        return self._origin + self.taken * self.h

    def pace(self, h: float) -> None:
        """Macro steps of h, s, from here on."""
        self._origin, self.taken, self.h = self.time, 0, h

    def _stand(self, t: float) -> None:
        self._origin, self.taken, self.still = t, 0, self.tangents.copy()

    def start(self, seeds: Sequence[int] | np.ndarray = (), at: float | None = None) -> None:
        """Initialize the units at the scene's start, or at a time, s; seeds: of each direction the cell that is moved by it."""
        self._begin(seeds)
        t = self.scene.start_time if at is None else at
        self._call(self._initialize, t, 0.0)
        if len(seeds) and self._circular:
            self._let_tangents_stand(seeds, t)
        self.cells[[self.cell("units", k, "time") for k in range(len(self._ends))]] = t
        self._ask("push", whole=0, steps=1)
        self._call(self._steps, t, 0.0)
        self.end_at(inf)
        self._stand(t)

    def starts(self, seeds: np.ndarray) -> Iterator[slice]:
        """`start` with as many of the seeds, (d,), at once as there are directions; yields which of the seeds. Without any, once."""
        for k in range(0, max(seeds.size, 1), self.width):
            some = slice(k, min(k + self.width, seeds.size))
            self.start(seeds[some])
            yield some

    def _let_tangents_stand(self, seeds: Sequence[int] | np.ndarray, t: float) -> None:
        """Initialize units that feed one another until their tangents stand, too: numbers may stand before; raises `StepFailed`."""
        answers = self.master.records.memory.answers
        cells, sizes = self.table[answers["cell"]], np.abs(self.initial[list(seeds)])
        sizes[sizes == 0.0] = 1.0
        tangents = self.tangents[cells, : len(seeds)]
        for _ in range(SWEEPS):
            before = tangents
            self._call(self._initialize, t, 0.0)
            tangents = self.tangents[cells, : len(seeds)]
            least = ABOUT_ZERO * np.max(np.abs(tangents), axis=0, initial=0.0)
            rounding = STALLED * np.maximum(np.abs(self.cells[cells]), answers["least"])[:, None] / sizes
            if np.all(np.abs(tangents - before) <= np.maximum(STANDS * np.maximum(np.abs(tangents), least), rounding)):
                return
        raise StepFailed(
            self.scene.name, t, "initial values stand, but not their derivatives", "Give a start that is no equilibrium"
        )

    def take(self, master: Master, t: float) -> None:
        """Where another opening of the scene stands, at t, s; raises `BadInput` for units that are FMUs."""
        blocks: list[tuple[int, Any]] = [(first, component.block) for first, component in self._components(master)]
        self._begin(())
        own = [*self._ends, *self._changes, *(cell for cell, _, _ in self._addresses)]
        kept = self.cells[own].copy()
        for first, block in (*blocks, (self.layout.at, master.records.block)):
            self.cells[first : first + block.cells] = block.memory
        self.cells[own] = kept
        self.end_at(inf)
        self._stand(t)

    def give(self, master: Master) -> None:
        """Let units and master of another opening of the scene stand as the block does; raises `BadInput` for units that are FMUs."""
        for first, component in self._components(master):
            component.stand(self.cells[first:])
        records = master.records
        records.block.memory[records.changing] = self.cells[self.layout.at + records.changing]

    def _components(self, master: Master) -> list[tuple[int, KernelComponent]]:
        """Of each unit the cell where it begins here, and the component there."""
        kernels: dict[str, Any] = {n.unit.name: n.unit.kernels for n in master.nodes}
        self._refuse([f"{name} (opened as an FMU)" for name, component in kernels.items() if component is None])
        return [(u.first, kernels[u.name]) for u in self.layout.units]

    def save(self) -> Instant:
        """Where it stands; of tangents those that stay."""
        return Instant(self.cells.copy(), self.still, self._origin, self.taken, self.h)

    def restore(self, instant: Instant) -> None:
        """Back to an instant; `seed` has to choose the tangents."""
        self.cells[:], self.still, self._origin, self.taken, self.h = instant

    # -- directions --------------------------------------------------------------------------------------------------
    def seed(self, cells: Sequence[int] | np.ndarray = (), directions: np.ndarray | None = None, first: int = 0) -> None:
        """Let cells move along directions, (n, d), alone, the `first` of the block and those behind it; others keep tangents that stay."""
        self.tangents[:] = self.still
        self._arena.ties[0] = 0
        if directions is not None:
            self.tangents[cells] = 0.0
            self.tangents[cells, first : first + directions.shape[1]] = directions

    def batches(self, cells: np.ndarray, directions: np.ndarray, first: int = 0) -> Iterator[slice]:
        """Seed directions, (n, d), as many at once as have room behind the first ones, each time where the block stands now.

        Yields which directions of the block they are. Without any, once.
        """
        d, room = directions.shape[1], self.width - first
        before = self.save() if d > room else None
        for k in range(0, max(d, 1), room):
            if k and before is not None:
                self.restore(before)
            some = directions[:, k : k + room]
            self.seed(cells, some, first)
            yield slice(first, first + some.shape[1])

    def at_tie(self) -> np.ndarray:
        """Of each direction whether a decision has stood at its boundary, (width,)."""
        bits = int(self._arena.ties[0])
        return np.array([any(bits >> k & 1 for k in range(one, 64, self.width)) for one in range(self.width)], dtype=bool)

    # -- what it does ------------------------------------------------------------------------------------------------
    def along(self, times: np.ndarray, h: float) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Macro steps of length h, s, from times (n,), s; raises `StepFailed`.

        Yields signals behind some of the steps, (k, S), and their tangents, (k, S, width), which the next ones overwrite.
        """
        arena, S = self._arena, len(self.signals)
        addresses = {"rows": self._rows, "given": self._given, "times": self._times}
        asked = {k: arena.address + CELL * v for k, v in addresses.items()}
        for done in range(0, times.size, CHUNK):
            some = times[done : done + CHUNK]
            arena.cells[self._times : self._times + some.size] = some
            self._ask("step", whole=1, steps=some.size, **asked)
            self._call(self._steps, 0.0, h)
            rows = slice(self._rows, self._rows + some.size * S)
            yield arena.cells[rows].reshape(-1, S), arena.tangents[rows].reshape(-1, S, self.width)

    def rows(self, steps: int) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Macro steps from here on, as of `along`: they are taken as far as rows are asked for."""
        for values, tangents in self.along(self._origin + self.h * np.arange(self.taken, self.taken + steps), self.h):
            self.taken += len(values)
            yield values, tangents

    def advance(self, steps: int) -> None:
        """Macro steps from here on; raises `StepFailed`."""
        for _ in self.rows(steps):
            pass

    def fill(self) -> None:
        """On until there are as many samples as inputs are extrapolated from."""
        pasts, numbers = self.master.records.memory.pasts, self.cells.view(np.int64)
        known, needed = ([self.cell("pasts", k, name) for k in range(pasts.size)] for name in ("samples", "degree"))
        while pasts.size and (numbers[known] <= numbers[needed]).any():
            self.advance(1)

    def end_at(self, t: float) -> None:
        """The run now ends at a time, s, to which units with a rate of their own take a shorter last step."""
        self.cells[self._ends] = t

    def follow(self) -> None:
        """Let the outputs of all units, and the signals, follow within the instant."""
        for unit in self.layout.units:
            entry = self._code.entry(f"layout{unit.layout}_outputs", 1)
            if entry(self.cells[self.cell("units", unit.node.called, "time")], *self._arena.given(unit.first)):
                raise StepFailed(unit.name, self.time, "its outputs have no derivatives")
        shown = [self.outputs[".".join(end)] for end in self.signals]
        self.cells[self.table], self.tangents[self.table] = self.cells[shown], self.tangents[shown]
        self.cells.view(np.int64)[[self.cell("units", k, "ends") for k in range(len(self._ends))]] = UNKNOWN
        self._ask("follow", whole=0, steps=1, updated=0)
        self._call(self._steps, self.time, 0.0)

    # -- calls of machine code ---------------------------------------------------------------------------------------
    def _begin(self, seeds: Sequence[int] | np.ndarray) -> None:
        """The block as it is before initialization, and its tangents."""
        n, arena, code = self.layout.cells, self._arena, self._code
        arena.cells[:], arena.tangents[:], arena.ties[0] = 0.0, 0.0, 0
        arena.cells[:n] = arena.cells[n : 2 * n] = self.initial
        cells, first = arena.cells.view(np.int64), arena.tangents.view(np.int64)[:, 0]
        for cell, target, function in self._addresses:
            cells[cell] = arena.address + CELL * target
            if function:
                cells[cell] = first[cell] = code.address(function)
        arena.tangents[list(seeds), np.arange(len(seeds))] = 1.0

    def _ask(self, what: str, **fields: int) -> None:
        """Write a request for rows of the master's program."""
        first, last = self.master.rows(what)
        wanted = {"first": first, "last": last, "sampled_count": 0, "watches": 0, "halt": 0, "rows": 0, "times": 0} | fields
        cells = self.cells.view(np.int64)
        for name, value in wanted.items():
            cells[self.cell("request", 0, name)] = value

    def _call(self, entry: Any, t: float, h: float) -> None:
        status = entry(t, h, *self._arena.given(self.layout.at))
        unit = int(self.cells.view(np.int64)[self.cell("request", 0, "unit")])
        if status or unit != -1:
            name = self.master.nodes[unit].unit.name if unit >= 0 else self.scene.name
            raise StepFailed(name, t, "a run with derivatives has failed", "See what the run alone says")
