"""A scene about an instant as a linear system in discrete time: its matrices, modes and frequency response."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from math import ceil, isnan, nan, pi
from pathlib import Path
from typing import Any

import numpy as np
from scipy.linalg import eig
from scipy.sparse.csgraph import connected_components

from ...components.core.errors import BadInput, nearest
from ..engine.algorithms import Master
from ..scene.scene import Scene
from .cells import cell_name, owners
from .coupled_step import CoupledState, CoupledStep, blocks_of, check_steps
from .tangent_block import TangentBlock

VANISHING = 1e-4  # eigenvalues below: what is left of samples, whose Jordan blocks rounding spreads
AGREE = 1e-9  # relative: an output is a function of the state
BESIDE = 1e-6  # of differences to either side of a decision
COUPLING = "coupling"  # the owner of samples and held signals
UNIT, SAMPLE, DISCRETE = "unit", "samples", "discrete"  # kinds of modes, beside coupling


@dataclass(frozen=True)
class Mode:
    """An eigenvalue of the macro step, or a pair of them.

    factor: the eigenvalue, which multiplies the mode in `Linear.step`.  rate: 1/s, of which it is the exponential, or as the rule of
    the unit's integrator has it.  shares: unit -> its participation, from 0 to 1.
    kind: "unit" (of one unit), "coupling" (of several), "samples" (of the coupling alone), "discrete" (changes sign from step to step).
    """

    factor: complex
    rate: complex
    kind: str
    shares: dict[str, float]

    @property
    def frequency(self) -> float:
        """Hz, damped."""
        return abs(self.rate.imag) / (2.0 * pi)

    @property
    def damping(self) -> float:
        """The damping ratio, -Re / abs; NaN of a mode that stands still."""
        return -self.rate.real / abs(self.rate) if self.rate else nan

    @property
    def where(self) -> str:
        """The units in which it lives."""
        return ", ".join(f"{name} {share:.0%}" for name, share in self.shares.items() if share >= 0.005)

    def __str__(self) -> str:
        damping = "" if isnan(self.damping) else f", damping ratio {self.damping:.4g}"
        return f"{self.kind}: {self.rate.real:.6g} 1/s, {self.frequency:.6g} Hz{damping}; {self.where}"


@dataclass(frozen=True)
class Linear:
    """x[k+1] = A x[k] + B u[k], y[k] = C x[k] + D u[k], deviations from an instant; inputs are held over `step`, s.

    A: (n, n), B: (n, m), C: (k, n), D: (k, m).  states: their names, owners: units, or "coupling".  time: s, of the instant.
    y0, u0: values there.  midpoint: unit -> internal step, s, of units that integrate by the midpoint rule.
    remarks: what is to be known of the matrices.
    """

    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    D: np.ndarray
    step: float
    time: float
    states: tuple[str, ...]
    owners: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    u0: np.ndarray
    y0: np.ndarray
    midpoint: dict[str, float]
    remarks: tuple[str, ...] = ()

    def modes(self) -> list[Mode]:
        """Those that do not vanish within a step, the slowest first; of a pair the one that turns forward."""
        modes = []
        for block in blocks_of(self.A):
            values, left, right = eig(self.A[np.ix_(block, block)], left=True)
            owners = [self.owners[k] for k in block]
            for k in np.flatnonzero((np.abs(values) >= VANISHING) & (values.imag >= 0.0)):
                parts = np.abs(left[:, k].conj() * right[:, k])
                parts = parts if parts.sum() > 0.0 else np.abs(right[:, k])
                shares = {
                    n: float(sum(p for p, o in zip(parts, owners, strict=True) if o == n) / parts.sum()) for n in set(owners)
                }
                shares = dict(sorted(shares.items(), key=lambda item: -item[1]))
                factor = complex(values[k])
                modes.append(Mode(factor, self._rate(factor, set(owners)), _kind(factor, shares), shares))
        return sorted(modes, key=lambda mode: (mode.kind == DISCRETE, mode.kind == SAMPLE, abs(mode.rate)))

    def _rate(self, factor: complex, owners: set[str]) -> complex:
        if abs(factor - 1.0) < 1e-10:
            return 0.0
        if not all(name in self.midpoint for name in owners):
            return np.log(factor) / self.step  # type: ignore[no-any-return]
        internal = self.midpoint[next(iter(owners))]
        one = factor ** (internal / self.step)
        return 2.0 / internal * (one - 1.0) / (one + 1.0)

    def response(self, frequencies: Sequence[float] | np.ndarray) -> np.ndarray:
        """Outputs per input at frequencies, (n,) Hz below half of 1 / `step`: (n, k, m) complex; raises `BadInput` at a pole."""
        given = np.atleast_1d(np.asarray(frequencies, dtype=float))
        if not ((given >= 0.0) & (given <= 0.5 / self.step)).all():
            raise BadInput("response", f"{given.max():g} Hz", f"0 to {0.5 / self.step:g} Hz, half of one in a step")
        acting = self.reduced()  # motions that are not asked for have poles, too
        unit, values = np.eye(len(acting.states)), np.zeros((given.size, *self.D.shape), dtype=complex)
        for value, f in zip(values, given, strict=True):
            try:
                value[:] = acting.C @ np.linalg.solve(np.exp(2j * pi * f * self.step) * unit - acting.A, acting.B) + self.D
            except np.linalg.LinAlgError:
                raise BadInput("response", f"{f:g} Hz", "a frequency that is no pole: the response is infinite there") from None
        return values

    def reduced(self) -> Linear:
        """Without states that no input reaches, and those on which no output depends."""
        acts = self.A != 0.0
        reached, seen = (self.B != 0.0).any(axis=1), (self.C != 0.0).any(axis=0)
        for _ in self.states:
            reached, seen = reached | acts[:, reached].any(axis=1), seen | acts[seen].any(axis=0)
        kept = np.flatnonzero(reached & seen)
        names, owners = (tuple(values[k] for k in kept) for values in (self.states, self.owners))
        parts = {"A": self.A[np.ix_(kept, kept)], "B": self.B[kept], "C": self.C[:, kept], "states": names, "owners": owners}
        return Linear(**{**vars(self), **parts})

    def to_control(self) -> Any:
        """As a state space of python-control in discrete time (`pip install cosimo[control]`)."""
        try:
            import control
        except ImportError:
            raise BadInput("to_control", "no python-control", "an installed control", "pip install cosimo[control]") from None
        names = {"inputs": list(self.inputs), "outputs": list(self.outputs), "states": list(self.states)}
        names = {kind: [n.replace(".", "_") for n in given] for kind, given in names.items() if given}
        return control.ss(self.A, self.B, self.C, self.D, self.step, **names)

    def save(self, path: str | Path) -> Path:
        """Matrices, names, step and time as a file for NumPy (.npz) or MATLAB (.mat)."""
        path = Path(path)
        content = {n: getattr(self, n) for n in ("A", "B", "C", "D", "step", "time", "u0", "y0")}
        content |= {
            n: np.array(getattr(self, n), dtype=object if path.suffix == ".mat" else str) for n in ("states", "inputs", "outputs")
        }
        path.parent.mkdir(parents=True, exist_ok=True)
        if path.suffix == ".npz":
            np.savez(path, **content)
        elif path.suffix == ".mat":
            from scipy.io import savemat

            savemat(path, content)
        else:
            raise BadInput("save", str(path), "a path that ends in .npz or .mat")
        return path

    def __repr__(self) -> str:
        lines = [f"<Linear: {len(self.states)} states, step {self.step:g} s, at t = {self.time:.9g} s>"]
        return "\n".join([*lines, *map(str, self.modes()), *self.remarks])


def _kind(factor: complex, shares: dict[str, float]) -> str:
    turns = factor.imag == 0.0 and factor.real < 0.0  # from step to step, as no motion of a unit does
    if turns and abs(factor + 1.0) < 1e-9:
        return DISCRETE
    if turns or shares.get(COUPLING, 0.0) > 0.5:
        return SAMPLE
    return COUPLING if len(shares) > 1 else UNIT


def linearize(
    scene: Scene, master: Master, t: float, inputs: Sequence[str] = (), outputs: Sequence[str] = (), steps: int | None = None
) -> Linear:
    """A scene where an opening of it stands, at t, s; the rest as of `Session.linearize`."""
    if steps is not None and (type(steps) is not int or steps < 1):
        raise BadInput(f"linearization of {scene.name}: steps", repr(steps), "a whole number of macro steps, 1 at least")
    if steps is not None:
        check_steps(scene, steps)
    with ExitStack() as stack:
        step = CoupledStep(TangentBlock(scene, stack, remedy=""), steps=steps)
        step.take(master, t)
        return Linearization(step, inputs, outputs).result()


class Linearization:
    """What `linearize` finds at the place of a coupled step."""

    def __init__(self, step: CoupledStep, inputs: Sequence[str], outputs: Sequence[str]):
        self.step, self.block, self.scene = step, step.block, step.block.scene
        self.where = f"linearization of {self.scene.name}"
        known, recorded = self.block.outputs, [".".join(end) for end in self.scene.coupling.signals]
        self.outputs = [self._known(n, known) for n in outputs] if outputs else [n for n in recorded if n in known]
        free = {f"{u.name}.{n}" for u in self.block.layout.units for n in u.component.inputs} & set(self.block.parameters())
        self.inputs = [self._known(n, free) for n in inputs]
        for names in (self.inputs, self.outputs):
            if twice := sorted({n for n in names if names.count(n) > 1}):
                raise BadInput(self.where, f"{', '.join(twice)} more than once", "each name once")
        self.u = self.block.places(self.inputs)
        self.y = np.array([known[n] for n in self.outputs], dtype=np.intp)
        self.every_y = np.array(list(known.values()), dtype=np.intp)

    def _known(self, name: str, known: Any) -> str:
        if name not in known:
            raise BadInput(self.where, repr(name), "a free input, or an output, of a component", nearest(name, known))
        return name

    def result(self) -> Linear:
        """All of it."""
        block, state = self.block, self.step.state()
        cells, matrix, _ = state
        kept = np.setdiff1d(np.arange(cells.size), self._silent(cells, matrix))
        remarks = self._remarks(state, kept)
        A, B, C, D, late = self._matrices(cells[kept], matrix[np.ix_(kept, kept)])
        cells = np.concatenate([cells[kept], self.y[late]])
        units = [unit.name for unit in block.layout.units]
        return Linear(
            A,
            B,
            C,
            D,
            self.step.period,
            block.time,
            tuple(cell_name(block, int(cell)) for cell in cells),
            tuple(units[k] if k >= 0 else COUPLING for k in owners(block, cells)),
            tuple(self.inputs),
            tuple(self.outputs),
            block.cells[self.u],
            block.cells[self.y],
            self._midpoint(),
            tuple(remarks),
        )

    def _silent(self, cells: np.ndarray, matrix: np.ndarray) -> list[int]:
        """Cells that stay as they are, or turn their sign, and that neither other cells nor an output follows."""
        every = self.step.derivative(cells, np.eye(cells.size), self.every_y)
        alone = np.array([b[0] for b in blocks_of(matrix) if b.size == 1], dtype=np.intp)
        return [
            k
            for k in alone
            if abs(abs(matrix[k, k]) - 1.0) < 1e-12 and not (np.delete(matrix[:, k], k).any() or every[:, k].any())
        ]

    def _matrices(self, cells: np.ndarray, A: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """A, B, C and D; and the outputs that are not of the instant alone, which are states behind those of the cells."""
        step, n, m = self.step, cells.size, len(self.inputs)
        C, _ = step.now(cells, np.eye(n), self.y)
        D, signals = step.now(self.u, np.eye(m), self.y)
        by, moved = step.with_samples(self.u, np.eye(m), signals)
        B, H = (step.derivative(by, moved, of) for of in (cells, self.y))
        place = dict(zip(by, moved, strict=True))
        B -= np.array([place.get(cell, np.zeros(m)) for cell in cells]).reshape(n, m)  # inputs are taken back behind the step
        G = step.derivative(cells, np.eye(n), self.y)
        size = AGREE * (np.abs(G).max(axis=1, initial=0.0) + np.abs(H).max(axis=1, initial=0.0))
        miss = np.maximum(np.abs(C @ A - G).max(axis=1, initial=0.0), np.abs(C @ B + D - H).max(axis=1, initial=0.0))
        late = np.flatnonzero(miss > size)
        A = np.block([[A, np.zeros((n, late.size))], [G[late], np.zeros((late.size, late.size))]])
        B, C = np.vstack([B, (H - D)[late]]), np.hstack([C, np.zeros((len(self.y), late.size))])
        C[late] = np.eye(n + late.size)[n:]
        return A, B, C, D, late

    def _remarks(self, state: CoupledState, kept: np.ndarray) -> list[str]:
        cells, matrix, at_tie = state
        verdicts: dict[str, list[str]] = {}
        for k in kept[at_tie[kept]]:
            sides = [side for way, side in ((-1.0, "below"), (1.0, "above")) if self._holds(cells, k, matrix[:, k], way)]
            if len(sides) < 2:
                verdict = f"hold {sides[0]} them alone" if sides else "do not exist"
                verdicts.setdefault(verdict, []).append(cell_name(self.block, int(cells[k])))
        remarks = [
            f"Decisions change at {', '.join(names)}: derivatives by them {verdict}." for verdict, names in verdicts.items()
        ]
        links, units = self.scene.coupling.links, list(self.scene.units)
        graph = np.zeros((len(units), len(units)))
        for link in links:
            if link.source[0] in units and link.target[0] in units:
                graph[units.index(link.source[0]), units.index(link.target[0])] = 1.0
        number, labels = connected_components(graph, directed=True, connection="strong")
        rings = [[u for u, label in zip(units, labels, strict=True) if label == k] for k in range(number)]
        acting = any(places.size > 1 for places in self.step.coupling_blocks(state))
        if any(len(ring) > 1 for ring in rings) and not acting:
            names = " and ".join(", ".join(ring) for ring in rings if len(ring) > 1)
            gone = f"{names} feed one another, but no small change comes back at t = {self.block.time:g} s"
            if remarks:
                raise BadInput(self.where, f"{gone}: a joint sticks", "an instant of motion", " ".join(remarks))
            remarks.append(f"{gone}: a contact that is open, or a joint that sticks.")
        return remarks

    def _holds(self, cells: np.ndarray, k: int, column: np.ndarray, way: float) -> bool:
        """Whether a column of the Jacobian is that of differences to one side."""
        block, numbers, behind = self.block, self.block.cells, []
        before, length = block.save(), way * BESIDE * max(1.0, abs(float(numbers[cells[k]])))
        for by in (0.0, 0.5 * length, length):
            numbers[cells[k]] += by
            block.advance(self.step.steps)
            behind.append(numbers[cells])
            block.restore(before)
        slope = (4.0 * behind[1] - behind[2] - 3.0 * behind[0]) / length
        size = np.maximum(np.abs(slope), np.abs(column))
        return bool((np.abs(slope - column) <= 1e-3 * size + 1e-6 * size.max() + 1e-13 * np.abs(behind[0]) / abs(length)).all())

    def _midpoint(self) -> dict[str, float]:
        """Unit -> internal step, s, of those that integrate by the midpoint rule."""
        internal = {}
        for unit in self.block.layout.units:
            if unit.component.by_midpoint_rule:
                length = unit.node.every * self.block.h
                internal[unit.name] = length / ceil(length / float(unit.component.parameters["substep"]) * (1.0 - 1e-12))  # type: ignore[arg-type]
        return internal
