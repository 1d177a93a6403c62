"""A run of a scene with tangents: initialization and macro steps by the derivatives of the kernels that a run calls.

All units and the master lie in one block, as in the FMU of a scene. Behind it lies a copy of what an initialization of a unit begins
with, and room for the rows.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from typing import Any, NamedTuple

import numpy as np

from ...components.core.block import CELL, Block
from ...components.core.errors import BadInput, StepFailed, nearest
from ...fmus.derivatives.compiled import Arena, Compiled
from ...fmus.derivatives.grammar import Unsupported
from ...fmus.native.instance import Places
from ...fmus.native.machine_code import compile_apart, compile_entries
from ..engine.algorithms import Master
from ..engine.algorithms.initial_kernels import SWEEPS
from ..engine.algorithms.records import ABOUT_ZERO, GIVEN, STALLED, UNKNOWN
from ..engine.stepping.discontinuities import jump_times
from ..engine.stepping.loop import lengths
from ..opened.open_scene import OpenScene
from ..run.results import Result
from ..run.run_record import RunRecord, UnitRecord
from ..scene.names import displaced
from ..scene.scene import Scene
from ..scene_fmu.layout import Layout, PlacedUnit, in_python, stepped_in_python

WIDTH = 8  # directions at once
CHUNK = 256  # macro steps of one call
STANDS = 1e-7  # relative change of a tangent in one more initialization that is rounding; of one below `ABOUT_ZERO` times the
# largest of its direction it is a change of that
BY_DIFFERENCES = "Differences have no such limit: differences = 1e-4."
KERNELS_ALONE = "a scene of components whose macro step is kernels alone (Jacobi or Gauss-Seidel, no algebraic loop)"


class TangentRows(NamedTuple):
    """Signals at the start and behind each macro step, with their derivatives.

    time: (n,) s; values: (n, S); tangents: (n, S, d); at_tie: (d,) of each direction whether a decision stood at its boundary.
    """

    time: np.ndarray
    values: np.ndarray
    tangents: np.ndarray
    at_tie: np.ndarray


class TangentScene:
    """An open scene with the derivatives of its kernels; `run` takes directions, as many as wanted."""

    def __init__(self, scene: Scene, stack: ExitStack, follow: bool = True, width: int = WIDTH, remedy: str = BY_DIFFERENCES):
        """`stack` closes the units.  width: directions at once.  remedy: for scenes without derivatives.

        follow: outputs follow inputs even where these have moved by rounding alone, for their tangents may have moved; without it
        the numbers are bit-identical to those of a run. Raises `BadInput` for what has no derivatives.
        """
        self.scene, self.width, self._where, self._remedy = scene, width, f"derivatives of {scene.name}", remedy
        reasons = in_python(scene)
        reasons += ["faults"] * bool(scene.faults) + ["signals that jump"] * bool(jump_times(scene))
        self._refuse(reasons)
        open_scene = OpenScene(scene, stack, in_process=True)
        self.master, self._clock = open_scene.master, open_scene.clock
        self._refuse(stepped_in_python(scene, self.master))
        self.layout = layout = Layout.of(scene, self.master, changes=False)
        self.signals = list(self.master.positions)
        self._first_signal = layout.at + self.master.records.block.cell("s", "signals")
        self._image, self._addresses = layout.image()
        memory = self.master.records.memory
        numbers = self._image.view(np.float64)
        self._ends = [self._cell("units", k, "stop") for k in range(memory.units.size)]
        self._changes = [self._cell("links", k, "change") for k in range(memory.links.size)]
        numbers[self._ends] = scene.stop_time
        if follow:
            numbers[self._changes] = -np.inf
        self._circular = follow and bool(np.any(memory.groups["last"] - memory.groups["first"] > 1))
        self._arena = Arena(2 * layout.cells + CHUNK * (len(self.signals) + memory.bonded.size * len(GIVEN) + 1), width)
        try:
            master = [text for source in layout.sources if source.prefix == "master" for text in compile_apart(source)]
            self._code = Compiled(self._texts(), width, without_ties=master)  # it looks whether numbers stand; that is no kink
        except Unsupported as error:
            raise BadInput(self._where, str(error), "instructions that have a derivative") from None
        self._places = {name: cell for unit in layout.units for name, cell in self._places_of(unit).items()}
        self._initialize = self._code.entry("master_initialize_groups", 2)
        self._steps = self._code.entry("master_run_steps", 2)

    def _refuse(self, reasons: Sequence[str]) -> None:
        if reasons:
            raise BadInput(self._where, ", ".join(reasons), KERNELS_ALONE, self._remedy)

    def _cell(self, array: str, k: int, field: str) -> int:
        return self.layout.at + self.master.records.place(array, k, field)

    # -- machine code ------------------------------------------------------------------------------------------------
    def _texts(self) -> Iterator[str]:
        layout = self.layout
        for number, source in enumerate(layout.sources):
            if source.prefix not in ("master", "figures"):
                begins = (_begin(k, unit, layout.cells) for k, unit in enumerate(layout.units) if unit.layout == number)
                yield "\n".join([compile_entries(source), *_adapters(number), *begins])

    # -- directions --------------------------------------------------------------------------------------------------
    def parameters(self) -> list[str]:
        """Everything a derivative can be taken by: real parameters in use that are not structural, and inputs that nothing drives."""
        return list(self._places)

    def value(self, parameter: str) -> float:
        """Of a parameter in this scene."""
        return float(self._image.view(np.float64)[self._place_of(parameter)])

    def _places_of(self, unit: PlacedUnit) -> dict[str, int]:
        """Parameters of a unit, "unit.parameter", and their cells in the block."""
        component, places = unit.component, Places(unit.component)
        driven = {link.target[1] for link in unit.node.links}
        u = {name: places.u + k for k, name in enumerate(component.inputs) if name not in driven}
        variables = type(component).variables
        numbers = {n: cell for n, cell in places.settable.items() if isinstance(component.parameters[n], float)}
        unused = component.unused(list(numbers))
        known = {n: c for n, c in (numbers | u).items() if n not in unused and not variables[n].structural}
        finite = np.isfinite(self._image.view(np.float64))
        return {f"{unit.name}.{n}": unit.first + c for n, c in known.items() if finite[unit.first + c]}

    def _place_of(self, parameter: str) -> int:
        if parameter in self._places:
            return self._places[parameter]
        for unit in self.layout.units:
            name = parameter.removeprefix(f"{unit.name}.")
            if name != parameter and (variable := type(unit.component).variables.get(name)) is not None:
                what = "structural" if variable.structural else "not a number in use, or driven"
                raise BadInput(f"{self._where}: {name}", what, "a real parameter that is not structural")
        raise BadInput(self._where, repr(parameter), "a real parameter", nearest(parameter, self.parameters()))

    # -- the run -----------------------------------------------------------------------------------------------------
    def run(self, parameters: Sequence[str]) -> TangentRows:
        """All macro steps, with the derivatives of all signals by each parameter; raises `StepFailed`."""
        cells = [self._place_of(parameter) for parameter in parameters]
        batches = [self._pass(cells[k : k + self.width]) for k in range(0, len(cells), self.width)] or [self._pass([])]
        time, values = batches[0].time, batches[0].values
        return TangentRows(
            time, values, np.concatenate([p.tangents for p in batches], axis=2), np.concatenate([p.at_tie for p in batches])
        )

    def beside(self, parameter: str, way: float) -> TangentRows:
        """As `run` by one parameter, so far from its value: close to a boundary, the derivatives are those of this side."""
        numbers, cell = self._image.view(np.float64), self._place_of(parameter)
        value = numbers[cell]
        numbers[cell] += way
        try:
            return self.run([parameter])
        finally:
            numbers[cell] = value

    def recorded(
        self, point: Mapping[str, float], parameters: Sequence[str]
    ) -> tuple[Result, list[dict[str, np.ndarray]], np.ndarray]:
        """The run with other numbers, by name; of each parameter the tangents (n,) of its columns, and whether it was at a tie.

        It is what figures need of a run: `info` has the parameters of the units. Raises `StepFailed`.
        """
        scene, numbers = self.scene, self._image.view(np.float64)
        numbers[[self._place_of(name) for name in point]] = list(point.values())
        rows = self.run(parameters)
        since, interval = rows.time - scene.start_time, scene.record.interval or scene.master.step
        passed = np.floor(since / interval * (1.0 + 1e-12) + 1e-9)
        kept = np.flatnonzero([True, *(np.diff(passed[:-1]) > 0.0), True])
        ends = scene.coupling.signals
        names = [".".join(end) for end in ends]
        some = np.ix_(kept, np.array([self.signals.index(end) for end in ends]))
        values = {u.name: u.component.parameters for u in self.layout.units}
        parts = {unit: {n: point.get(f"{unit}.{n}", v) for n, v in own.items()} for unit, own in values.items()}
        result = Result(
            displaced(scene, point),
            rows.time[kept],
            dict(zip(names, rows.values[some].T, strict=True)),
            {},
            {name: scene.coupling.interfaces[unit].outputs[n].unit for name, (unit, n) in zip(names, ends, strict=True)},
            RunRecord(outcome="done", units={unit: UnitRecord(parameters=own) for unit, own in parts.items()}),
        )
        of_each = np.moveaxis(rows.tangents[some], 2, 0)
        return result, [dict(zip(names, t.T, strict=True)) for t in of_each], rows.at_tie

    def _pass(self, seeds: Sequence[int]) -> TangentRows:
        arena, scene = self._arena, self.scene
        self.start(seeds)
        S, start = len(self.signals), scene.start_time
        shown = slice(self._first_signal, self._first_signal + S)
        times, values, tangents = [np.array([start])], [arena.cells[None, shown].copy()], [arena.tangents[None, shown].copy()]
        end, tick = self._clock.tick(scene.stop_time), 0
        for length, count in lengths(0, end, self._clock.ticks(scene.master.step), last=True):
            h = self._clock.times(range(length, length + 1))[0] - self._clock.time(0)
            for done in range(0, count, CHUNK):
                steps = min(CHUNK, count - done)
                at = self._clock.times(range(tick, tick + (steps + 1) * length, length))
                some = self.take_steps(at[:-1], h)
                times.append(at[1:])
                values.append(arena.cells[some].reshape(steps, S).copy())
                tangents.append(arena.tangents[some].reshape(steps, S, self.width).copy())
                tick += steps * length
        return TangentRows(
            np.concatenate(times),
            np.concatenate(values),
            np.concatenate(tangents)[:, :, : len(seeds)],
            self.at_tie()[: len(seeds)],
        )

    # -- what is done with the block ---------------------------------------------------------------------------------
    def start(self, seeds: Sequence[int] = (), at: float | None = None) -> None:
        """Initialize the units at the scene's start, or at a time, s; seeds: of each direction the cell that is moved by it."""
        self._begin(seeds)
        start = self.scene.start_time if at is None else at
        self._call(self._initialize, start, 0.0)
        if len(seeds) and self._circular:
            self._let_tangents_stand(list(seeds), start)
        self._arena.cells[[self._cell("units", k, "time") for k in range(self.master.records.memory.units.size)]] = start
        self._ask("push", whole=0, steps=1)
        self._call(self._steps, start, 0.0)

    def _let_tangents_stand(self, seeds: Sequence[int], t: float) -> None:
        """Initialize units that feed one another until their tangents stand, too: numbers may stand before; raises `StepFailed`."""
        answers = self.master.records.memory.answers
        cells, sizes = self._first_signal + answers["cell"], np.abs(self._image.view(np.float64)[seeds])
        sizes[sizes == 0.0] = 1.0
        tangents = self._arena.tangents[cells, : len(seeds)]
        for _ in range(SWEEPS):
            before = tangents
            self._call(self._initialize, t, 0.0)
            tangents = self._arena.tangents[cells, : len(seeds)]
            least = ABOUT_ZERO * np.max(np.abs(tangents), axis=0, initial=0.0)
            rounding = STALLED * np.maximum(np.abs(self._arena.cells[cells]), answers["least"])[:, None] / sizes
            if np.all(np.abs(tangents - before) <= np.maximum(STANDS * np.maximum(np.abs(tangents), least), rounding)):
                return
        raise StepFailed(
            self.scene.name, t, "initial values stand, but not their derivatives", "Give a start that is no equilibrium"
        )

    def take(self, master: Master) -> None:
        """The block as units and master of another opening of the scene stand; raises `BadInput` for units that are FMUs."""
        blocks = self._blocks(master)
        self._begin(())
        cells, own = self._arena.cells, [*self._ends, *self._changes, *(cell for cell, _, _ in self._addresses)]
        kept = cells[own].copy()
        for first, block in (*blocks, (self.layout.at, master.records.block)):
            cells[first : first + block.cells] = block.memory
        cells[own] = kept

    def give(self, master: Master) -> None:
        """Let units and master of another opening of the scene stand as the block does; raises `BadInput` for units that are FMUs."""
        cells, records = self._arena.cells, master.records
        for first, block in self._blocks(master):
            for part in (slice(block.addresses_at), slice(block.addresses_at + len(block.entries), block.cells)):
                block.memory[part] = cells[first : first + block.cells][part]
        records.block.memory[records.changing] = cells[self.layout.at + records.changing]

    def _blocks(self, master: Master) -> list[tuple[int, Block]]:
        """Of each unit the cell where it begins here, and its block there."""
        kernels: dict[str, Any] = {n.unit.name: n.unit.kernels for n in master.nodes}
        self._refuse([f"{name} (opened as an FMU)" for name, component in kernels.items() if component is None])
        return [(u.first, kernels[u.name].block) for u in self.layout.units]

    def places(self, names: Iterable[str]) -> np.ndarray:
        """Cells of parameters and free inputs, (n,); raises `BadInput`."""
        return np.array([self._place_of(name) for name in names], dtype=np.intp)

    def end_at(self, t: float) -> None:
        """The run now ends at a time, s, to which units with a rate of their own take a shorter last step."""
        self._arena.cells[self._ends] = t

    def take_steps(self, times: np.ndarray, h: float) -> slice:
        """Macro steps of length h from each of at most `CHUNK` times, s; returns cells of the signals behind each, one by one."""
        n, arena, steps = self.layout.cells, self._arena, times.size
        rows, given, begins = 2 * n, 2 * n + CHUNK * len(self.signals), arena.cells.size - self._room
        arena.cells[begins : begins + steps] = times
        addresses = {"rows": rows, "given": given, "times": begins}
        self._ask("step", whole=1, steps=steps, **{k: arena.address + CELL * v for k, v in addresses.items()})
        self._call(self._steps, 0.0, h)
        return slice(rows, rows + steps * len(self.signals))

    def follow(self, t: float, outputs: np.ndarray) -> None:
        """Let the outputs of all units follow at an instant, t, s; outputs: cells of the signals in the blocks of their units."""
        cells, read = self._arena.cells, slice(self._first_signal, self._first_signal + len(self.signals))
        for unit in self.layout.units:
            entry = self._code.entry(f"layout{unit.layout}_outputs", 1)
            if entry(cells[self._cell("units", unit.node.called, "time")], *self._arena.given(unit.first)):
                raise StepFailed(unit.name, t, "its outputs have no derivatives")
        cells[read], self._arena.tangents[read] = cells[outputs], self._arena.tangents[outputs]
        cells.view(np.int64)[[self._cell("units", k, "ends") for k in range(len(self._ends))]] = UNKNOWN
        self._ask("follow", whole=0, steps=1, updated=0)
        self._call(self._steps, t, 0.0)

    def at_tie(self) -> np.ndarray:
        """Of each direction whether a decision has stood at its boundary, (width,)."""
        bits = int(self._arena.ties[0])
        return np.array(
            [any(bits >> k & 1 for k in range(direction, 64, self.width)) for direction in range(self.width)], dtype=bool
        )

    @property
    def _room(self) -> int:
        """Cells from the times of a call on to the end."""
        from ...fmus.derivatives.compiled import STACK

        return STACK + CHUNK

    def _begin(self, seeds: Sequence[int]) -> None:
        """The block as it is before initialization, and its tangents."""
        n, arena, code = self.layout.cells, self._arena, self._code
        arena.cells[:], arena.tangents[:], arena.ties[0] = 0.0, 0.0, 0
        arena.cells[:n] = arena.cells[n : 2 * n] = self._image.view(np.float64)
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
        cells = self._arena.cells.view(np.int64)
        for name, value in wanted.items():
            cells[self._cell("request", 0, name)] = value

    def _call(self, entry: Any, t: float, h: float) -> None:
        status = entry(t, h, *self._arena.given(self.layout.at))
        cells = self._arena.cells.view(np.int64)
        unit = int(cells[self._cell("request", 0, "unit")])
        if status or unit != -1:
            name = self.master.nodes[unit].unit.name if unit >= 0 else self.scene.name
            raise StepFailed(name, t, "a run with derivatives has failed", "See what the run alone says")


def _adapters(layout: int) -> Iterator[str]:
    """Functions of one signature around the entries of a layout, which the master calls by address."""
    for entry, times in (("step", "double %t, double %h"), ("outputs", "double %t")):
        yield f"""define i32 @{entry}_{layout}(double %t, double %h, ptr %block) {{
  %address = ptrtoint ptr %block to i64
  %status = call i32 @layout{layout}_{entry}({times}, i64 %address)
  ret i32 %status
}}"""


def _begin(k: int, unit: PlacedUnit, image: int) -> str:
    """What initializes a unit anew, with its present inputs and parameters: else it begins with what stands `image` cells further on."""
    u, inputs = unit.left[0][0], unit.component.u
    size = unit.component.block.cells  # type: ignore[union-attr]
    kept = sorted([*unit.left, *unit.follows])
    starts, ends = [0, *(end for _, end in kept)], [*(first for first, _ in kept), size]
    names = iter(range(10**6))

    def copies(ranges: Sequence[tuple[int, int]]) -> str:
        lines = []
        for first, end in ranges:
            if end > first:
                to, source = f"%to.{next(names)}", f"%from.{next(names)}"
                lines += [
                    f"  {to} = getelementptr i64, ptr %block, i64 {first}",
                    f"  {source} = getelementptr i64, ptr %block, i64 {image + first}",
                    f"  call void @llvm.memcpy.p0.p0.i64(ptr {to}, ptr {source}, i64 {CELL * (end - first)}, i1 false)",
                ]
        return "\n".join(lines)

    flag = unit.follows[0][0] if unit.follows else 0
    slopes = inputs.size - inputs.size // 3
    return f"""define i32 @begin_{k}(double %t, double %h, ptr %block) {{
entry:
{copies(list(zip(starts, ends, strict=True)))}
  %flag.at = getelementptr double, ptr %block, i64 {flag}
  %flag = load double, ptr %flag.at, align 8
  %known = fcmp une double %flag, 0.000000e+00
  br i1 %known, label %ready, label %anew
anew:
{copies(unit.follows)}
  br label %ready
ready:
  %slopes = getelementptr double, ptr %block, i64 {u + inputs.size // 3}
  call void @llvm.memset.p0.i64(ptr %slopes, i8 0, i64 {CELL * slopes}, i1 false)
  store double %t, ptr %block, align 8
  %address = ptrtoint ptr %block to i64
  %failed = call i32 @layout{unit.layout}_initialize(double %t, i64 %address)
  %fine = icmp eq i32 %failed, 0
  br i1 %fine, label %go, label %end
go:
  %status = call i32 @layout{unit.layout}_outputs(double %t, i64 %address)
  ret i32 %status
end:
  ret i32 %failed
}}"""
