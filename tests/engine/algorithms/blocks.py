"""Linear systems of two or three blocks with random numbers, any of which may feed any other."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from cosimo.components.core.variables import input_, output, parameter
from cosimo.tests.support import Linear
from scipy.linalg import expm

HERE = "cosimo.tests.engine.algorithms.blocks"
STATES, INPUTS, BLOCKS = 2, 4, 3  # of a block, of a block, at most


class Block(Linear):
    """Two states, two outputs, four inputs: x' = a x + b u, y = c x."""

    a = parameter(0.0, "1", "matrix, row by row", size=STATES * STATES)
    b = parameter(0.0, "1", "matrix", size=STATES * INPUTS)
    c = parameter(0.0, "1", "matrix", size=STATES * STATES)
    start = parameter(0.0, "1", "states at the start", size=STATES)
    u_in = input_(0.0, "1", "inputs", size=INPUTS)
    y_out = output("1", "outputs", size=STATES)

    def matrix(self, name: str, columns: int) -> np.ndarray:
        return np.array([self.parameters[f"{name}[{k + 1}]"] for k in range(STATES * columns)]).reshape(STATES, columns)

    def matrices(self):
        return (
            self.matrix("a", STATES),
            self.matrix("b", INPUTS),
            self.matrix("c", STATES),
            np.zeros((STATES, INPUTS)),
            self.matrix("start", 1).ravel(),
        )


class DirectBlock(Linear):
    """The same with y = c x + d u."""

    a = parameter(0.0, "1", "matrix, row by row", size=STATES * STATES)
    b = parameter(0.0, "1", "matrix", size=STATES * INPUTS)
    c = parameter(0.0, "1", "matrix", size=STATES * STATES)
    d = parameter(0.0, "1", "matrix", size=STATES * INPUTS)
    start = parameter(0.0, "1", "states at the start", size=STATES)
    u_in = input_(0.0, "1", "inputs", size=INPUTS)
    y_out = output("1", "outputs", size=STATES, feedthrough=("u_in",))

    matrix = Block.matrix

    def matrices(self):
        return (
            self.matrix("a", STATES),
            self.matrix("b", INPUTS),
            self.matrix("c", STATES),
            self.matrix("d", INPUTS),
            self.matrix("start", 1).ravel(),
        )


@dataclass(frozen=True)
class System:
    """Blocks of a whole X' = M X with the outputs Y = G X; every number as the scene has it."""

    data: dict
    whole: np.ndarray
    outputs: np.ndarray
    start: np.ndarray
    names: tuple[str, ...]

    def scene(self, step: float, **master) -> dict:
        return {**self.data, "master": {"step": step, **master}}

    @property
    def ends(self) -> list[tuple[str, str]]:
        """(unit, output) of each row of `outputs`."""
        return [(name, f"y_out[{k + 1}]") for name in self.names for k in range(STATES)]

    def row(self, end: tuple[str, str]) -> int:
        """The row of an output."""
        return self.ends.index(end)

    def exact(self, t: float) -> dict:
        """Every output at t."""
        values = self.outputs @ expm(self.whole * t) @ self.start
        return dict(zip(self.ends, values.tolist(), strict=True))


def system(seed: int, direct: tuple[bool, ...], edges: tuple[bool, ...]) -> System:
    """A random stable system; `direct`: which blocks hand inputs on at once; `edges`: which block feeds which, row by row."""
    rng, n = np.random.default_rng(seed), len(direct)
    names = tuple("pqr"[:n])
    A, B, C, D = (np.zeros((n * STATES, n * k)) for k in (STATES, INPUTS, STATES, INPUTS))
    L = np.zeros((n * INPUTS, n * STATES))
    units, connections = {}, []
    for i, name in enumerate(names):
        rows, inputs = slice(i * STATES, (i + 1) * STATES), slice(i * INPUTS, (i + 1) * INPUTS)
        A[rows, rows], B[rows, inputs], C[rows, rows] = (rng.uniform(-1.0, 1.0, (STATES, k)) for k in (STATES, INPUTS, STATES))
        if direct[i]:
            D[rows, inputs] = rng.uniform(-0.3, 0.3, (STATES, INPUTS))
        place = 0
        for j in range(n):
            if i != j and edges[i * n + j]:
                for k in range(STATES):
                    L[i * INPUTS + place, j * STATES + k] = 1.0
                    connections.append(f"{names[j]}.y_out[{k + 1}] -> {name}.u_in[{place + 1}]")
                    place += 1
        units[name] = {"component": f"{HERE}:{'Direct' if direct[i] else ''}Block"}
    G = np.linalg.solve(np.eye(n * STATES) - D @ L, C)
    M = A + B @ L @ G
    shift = max(0.0, float(np.linalg.eigvals(M).real.max()) + 0.1)  # moves every eigenvalue as far
    A, M = A - shift * np.eye(n * STATES), M - shift * np.eye(n * STATES)
    start = rng.uniform(-1.0, 1.0, n * STATES)
    for i, name in enumerate(names):
        rows, inputs = slice(i * STATES, (i + 1) * STATES), slice(i * INPUTS, (i + 1) * INPUTS)
        own = {"a": A[rows, rows], "b": B[rows, inputs], "c": C[rows, rows], "start": start[rows]}
        if direct[i]:
            own["d"] = D[rows, inputs]
        units[name]["parameters"] = {key: matrix.ravel().tolist() for key, matrix in own.items()}
    data = {"stop_time": 1.0, "units": units, "connections": connections, "record": {"signals": [f"{u}.y_out" for u in names]}}
    return System(data, M, G, start, names)
