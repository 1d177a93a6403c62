"""Exact derivatives of every component against differences, and the numbers beside them against those of a run."""

from collections import Counter
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from cosimo.components.catalogue import CATALOGUE, component_class
from cosimo.components.core.contract import KernelComponent
from cosimo.components.core.kernels import COMPILED, DONE
from cosimo.fmus.native.machine_code import compile_entries, source_of
from cosimo.tests.derivatives.differences import Verdict, verdict

if COMPILED:
    from cosimo.fmus.derivatives.compiled import Arena, Compiled

pytestmark = pytest.mark.skipif(not COMPILED, reason="derivatives are those of machine code")
WIDTH, STEPS = 8, 20
STEP = {"BallBearing": 1e-4, "JeffcottRotor": 1e-4, "DeepGrooveBearing": 1e-4, "DimensionlessBallBearing": 1e-2}  # s; else 1 ms
STATES = 24  # cells of a state that are tried, at most
NUMERICAL = {"substep", "period", "tolerance", "front_threshold"}  # a whole number of steps, samples or nodes follows from them


class Course:
    """A component's initialization and some steps: in its own machine code, and with tangents."""

    def __init__(self, name: str, seed: int, effects: tuple[str, ...] = ()):
        self.component: KernelComponent = component_class(name)(effects)
        self.h = STEP.get(name, 1e-3)
        self.component.call("initialize", 0.0)
        self.component.call("step", 0.0, self.h)  # addresses of kernels stand in the block
        self.block = block = self.component._prepare()
        self.begin, self.size = block.memory.copy(), block.cells
        self.parameters = self._cells(seed)
        code = Compiled([compile_entries(source_of(self.component))], WIDTH)
        self.arena = Arena(self.size, WIDTH)
        self._initialize, self._step = code.entry("model_initialize", 1), code.entry("model_step", 2)
        ends = [r for field in ("y", "x") for r in block.ranges(field)]
        self.seen = np.concatenate([np.arange(*r) for r in ends])
        self.states = self._states(seed)

    def _cells(self, seed: int) -> list[int]:
        """Real parameters and inputs; at a random place where there is a seed."""
        leaves = [
            leaf
            for path, leaf in self.block._leaves.items()
            if path[0] in ("p", "e") and leaf.kind == "f8" and path[-1] not in NUMERICAL
        ]
        first = self.block.cell("s", "u")
        cells = [leaf.cell for leaf in leaves] + list(range(first, first + len(self.component.inputs)))
        cells = [cell for cell in cells if np.isfinite(self.begin[cell])]
        random, usual = np.random.default_rng(seed), self.begin.copy()
        for share in (0.1, 0.02, 0.002):
            if not seed:
                break
            self.begin[cells] = usual[cells] * (1.0 + share * random.uniform(-1, 1, len(cells)))
            self.begin[cells] += (usual[cells] == 0.0) * share * random.uniform(0.1, 1, len(cells))
            if self.run(self.begin)[1] == DONE:
                break
            self.begin[:] = usual
        return cells

    def _states(self, seed: int) -> list[int]:
        cells = np.concatenate([np.zeros(0, dtype=int), *(np.arange(*r) for r in self.block.ranges("x"))])
        random = np.random.default_rng(seed)
        return sorted(random.choice(cells, min(STATES, cells.size), replace=False).tolist())

    def run(self, cells: np.ndarray, shift: tuple[int, float] | None = None) -> tuple[np.ndarray, int]:
        """Outputs and state behind the steps, and the status; shift: of a state behind the initialization."""
        memory = self.block.memory
        memory[:] = cells
        status = self.component.call("initialize", 0.0)
        if shift is not None:
            memory[shift[0]] += shift[1]
        for k in range(STEPS):
            status = status or self.component.call("step", k * self.h, self.h)
        return memory[self.seen].copy() if hasattr(self, "seen") else memory, status

    def tangents(self, seeds: list[int], of_state: bool) -> tuple[np.ndarray, np.ndarray, int]:
        """Numbers and their tangents in the directions of cells, and the bits of ties."""
        arena = self.arena
        arena.cells[: self.size], arena.tangents[:], arena.ties[0] = self.begin, 0.0, 0
        lanes = np.arange(len(seeds))
        if not of_state:
            arena.tangents[seeds, lanes] = 1.0
        status = self._initialize(0.0, *arena.given())
        if of_state:
            arena.tangents[:] = 0.0
            arena.tangents[seeds, lanes] = 1.0
        for k in range(STEPS):
            status = status or self._step(k * self.h, self.h, *arena.given())
        assert status == DONE
        return arena.cells[self.seen].copy(), arena.tangents[self.seen][:, lanes].T.copy(), int(arena.ties[0])


def judged(course: Course, cell: int, exact: np.ndarray, told: bool, of_state: bool) -> Verdict:
    """The derivative by a cell."""
    base, status = course.run(course.begin)

    def at(way: float) -> np.ndarray | None:
        cells = course.begin.copy()
        cells[cell] += 0.0 if of_state else way
        y, reached = course.run(cells, (cell, way) if of_state else None)
        return y if reached == status else None

    return verdict(exact, base, at, [abs(course.begin[cell]) if abs(course.begin[cell]) > 1e-3 else 1.0], told)


def verdicts(course: Course) -> Iterator[tuple[int, Verdict]]:
    """Of each parameter, input and state; the numbers beside tangents have to be bit-identical to those without."""
    for cells, of_state in ((course.parameters, False), (course.states, True)):
        for first in range(0, len(cells), WIDTH):
            some = cells[first : first + WIDTH]
            numbers, tangents, ties = course.tangents(some, of_state)
            np.testing.assert_array_equal(numbers, course.run(course.begin)[0])
            for k, cell in enumerate(some):
                told = bool(ties & sum(1 << (k + WIDTH * j) for j in range(8)))
                yield cell, judged(course, cell, tangents[k], told, of_state)


def name_of(block: Any, cell: int) -> str:
    """Where a cell lies, for a message."""
    path, leaf = max(((p, one) for p, one in block._leaves.items() if one.cell <= cell), key=lambda item: item[1].cell)
    return f"{'.'.join(map(str, path))}[{cell - leaf.cell}]" if leaf.kind == "array" else ".".join(map(str, path))


def disagreeing(component: str, seed: int, effects: tuple[str, ...] = ()) -> tuple[Counter[str], list[str]]:
    """How many derivatives are of each kind, and those that are wrong without being told."""
    course = Course(component, seed, effects)
    counts: Counter[str] = Counter()
    wrong = []
    for cell, one in verdicts(course):
        counts[one.kind] += 1
        if one.kind == "wrong":
            wrong.append(f"{name_of(course.block, cell)} = {course.begin[cell]:g}: {one.error:.1e}")
    return counts, wrong


@pytest.mark.parametrize("component", ["Pantograph", "BallBearing", "JeffcottRotor", "Thruster"])
def test_derivatives_are_exact_or_told_to_be_at_a_tie(component):
    counts, wrong = disagreeing(component, 0)
    assert wrong == []
    assert counts["exact"] > 0


@pytest.mark.full
@pytest.mark.parametrize("seed", [0, 1])
@pytest.mark.parametrize("component", CATALOGUE)
def test_all_derivatives_are_exact_or_told_to_be_at_a_tie(component, seed):
    counts, wrong = disagreeing(component, seed)
    print(component, dict(counts))
    assert wrong == []


@pytest.mark.full
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_derivatives_of_balls_with_inertia(seed):
    """Effects that none of the usual ones has: Newton's method for each ball, and for the cage."""
    counts, wrong = disagreeing("DeepGrooveBearing", seed, ("ball_inertia", "linearisation", "rating_life", "cage_slip"))
    assert wrong == []
    assert counts["exact"] > 10
