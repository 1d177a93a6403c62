"""How large the effect of an option of a model will be, predicted from one solution without a whole run of its own.

The solution with all effects is run once, and saved at some instants. From each instant the scene without one effect makes a short
run, the branch, beside the known solution. The difference of the two, and its growth from the first half of the branches to the
second, predict the difference of a whole run:

- A difference that grows less than linearly tends to a limit as 1 - exp(-t / T).
- A difference that grows linearly or faster continues with a power of time, halfway between 1 and the observed power.
- Differences of one sign in all branches add up; differences of both signs add up as random numbers do.

An effect with states of its own cannot start from a state without them: its only branch starts with the run.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from typing import Any

import numpy as np

from ....components.core.component import Component
from ....components.core.errors import BadInput, StepFailed
from ...engine.algorithms import Master
from ...scene.scene import Scene
from ...session.open_scene import OpenScene
from ...units.component import ComponentSimulator
from .quantities import Quantity

BRANCHES = 4  # from as many instants of the run
SHARE = 1.0 / 4.0  # of the run, that all branches of an effect take together
FEWEST = 8  # macro steps of a branch
EVEN = 0.99  # growth in the second half over that in the first: from here on the growth is not taken to end


class EffectIndicator:
    """The solution of a scene, with saved states along it, from which other scenes can start.

    Raises `BadInput` or `StepFailed` where the scene cannot be run with macro steps of one length, or its units cannot save
    their state.
    """

    def __init__(self, scene: Scene, quantities: Sequence[Quantity]):
        self._quantities = quantities
        self._signals = [scene.split(s) for s in dict.fromkeys(q.signal for q in quantities)]
        scene = _plain(scene)
        self._step, self._end, self._start = scene.master.step, scene.stop_time, scene.start_time
        count = max(int(scene.duration / self._step * (1.0 + 1e-12)), 1)
        self._length = min(max(int(SHARE * count / BRANCHES), FEWEST), count)
        self._from_start = min(BRANCHES * self._length, count)
        room = count - self._length
        starts = {room * k // BRANCHES for k in range(BRANCHES)}  # the start is among them: much happens there and never again
        with ExitStack() as stack:
            self._master = master = self._started(scene, stack)
            if not all(interface.saves_state for interface in master.coupling.interfaces.values()):
                raise BadInput(f"{scene.name}: indicator", "a unit that does not save its state", "units that do")
            self._components = _components(master)
            self._places = [master.positions[end] for end in self._signals]
            self._saved: dict[int, dict[str, Any]] = {}  # by the step behind which they begin
            rows = [self._row(master)]
            for k in range(count):
                if k in starts and self._alike(master):
                    self._saved[k] = master.state()
                master.step(self._start + k * self._step, self._step)
                rows.append(self._row(master))
        self._rows = np.array(rows)

    def predict(self, scene: Scene) -> tuple[float, int]:
        """(largest expected error of the quantities, number of states fewer) of the scene with other effects.

        The error is NaN where the scene cannot start, and infinite where it fails in a branch.
        """
        try:
            with ExitStack() as stack:
                master = self._started(_plain(scene), stack)
                others = _components(master)
                fewer = sum(c.x.size - others[n].x.size for n, c in self._components.items())
                try:
                    return self._expected(self._branches(master, others)), fewer
                except (StepFailed, ArithmeticError, np.linalg.LinAlgError):
                    return math.inf, fewer
        except (BadInput, StepFailed):
            return math.nan, 0

    def _branches(self, master: Master, others: Mapping[str, Component]) -> list[np.ndarray]:
        """Differences of the quantities' signals after each macro step, (n, signals) for each branch."""
        changed = [n for n, c in self._components.items() if others[n].on != c.on]
        if not self._alike(master) or any(others[n].x.size != self._components[n].x.size for n in changed):
            return [self._branch(master, 0, self._from_start)]
        branches = []
        for first, saved in self._saved.items():
            self._restore(master, saved, changed, others, self._start + first * self._step)
            branches.append(self._branch(master, first, self._length))
        return branches

    def _expected(self, branches: Sequence[np.ndarray]) -> float:
        names = [".".join(end) for end in self._signals]
        errors = []
        for q in self._quantities:
            column = names.index(q.signal)
            each = [branch[:, column] for branch in branches]
            if q.unit == "rad":
                each = [np.remainder(d + np.pi, 2.0 * np.pi) - np.pi for d in each]
            first = min(int(q.transient / self._step), self._rows.shape[0] - 1)
            solution = self._rows[first:, column]
            whole = self._rows.shape[0] - 1
            if q.kind in ("maximum", "minimum"):  # later differences do not count
                whole = first + int(np.argmax(solution) if q.kind == "maximum" else np.argmin(solution))
            error = expected(each, whole, q.kind) / _scale(solution, q.nominal)
            errors.append(error / (1.0 + error))  # of bounded motions: none is off by much more than the whole range
        return max(errors)

    def _started(self, scene: Scene, stack: ExitStack) -> Master:
        master = OpenScene(scene, stack, in_process=True, watched=self._signals).master
        master.initialize(scene.start_time)
        return master

    def _row(self, master: Master) -> list[float]:
        signals = master.signals
        return [float(signals[k]) for k in self._places]

    def _alike(self, master: Master) -> bool:
        """Whether a state of the solution fits this master, but for the units with other effects."""
        mine = self._master
        return (
            master.positions == mine.positions
            and [n.links for n in master.nodes] == [n.links for n in mine.nodes]
            and len(master.loops) == len(mine.loops)
            and all(isinstance(n.unit, ComponentSimulator) for n in master.nodes)
        )

    def _restore(
        self, master: Master, saved: Mapping[str, Any], changed: Sequence[str], others: Mapping[str, Component], t: float
    ) -> None:
        states = [
            _translated(state, self._components[n], others[n]) if (n := node.unit.name) in changed else state
            for node, state in zip(master.nodes, saved["units"], strict=True)
        ]
        master.take({**saved, "units": states})
        for node in master.nodes:
            if node.unit.name in changed:
                others[node.unit.name].refresh()
                node.read()
        master.follow(t)

    def _branch(self, master: Master, first: int, count: int) -> np.ndarray:
        rows = []
        for k in range(first, first + count):
            master.step(self._start + k * self._step, self._step)
            rows.append(self._row(master))
        return np.array(rows) - self._rows[first + 1 : first + count + 1]


def _plain(scene: Scene) -> Scene:
    """The scene with macro steps of one length, and without what only keeps account of it."""
    changes: dict[str, Any] = {"control": None, "events": (), "bonds": (), "energy_correction": False}
    return scene.with_changes({f"master.{key}": value for key, value in changes.items()} | {"faults": ()})


def _components(master: Master) -> dict[str, Component]:
    return {node.unit.name: node.unit.component for node in master.nodes if isinstance(node.unit, ComponentSimulator)}


def _translated(state: bytes, of: Component, to: Component) -> bytes:
    """A saved state of a component for one with other effects and as many states: inputs and outputs by their names."""
    values = np.frombuffer(state)
    ends = np.cumsum([1, of.u.size, of.y.size])
    u = dict(zip(of.inputs, values[1 : ends[1]].reshape(of.u.shape).T, strict=True))
    y = dict(zip(of.outputs, values[ends[1] : ends[2]], strict=True))
    inputs = np.array([u.get(n, to.u[:, i]) for i, n in enumerate(to.inputs)]).reshape(len(to.inputs), 3).T
    outputs = np.array([y.get(n, to.y[i]) for i, n in enumerate(to.outputs)])
    return np.concatenate((values[:1], inputs.ravel(), outputs, values[ends[2] :])).tobytes()


def _scale(solution: np.ndarray, nominal: float) -> float:
    width, size = float(np.ptp(solution)), float(np.abs(solution).max())
    return next((s for s in (width, size) if s > 1e-6 * max(size, nominal)), nominal)


def expected(branches: Sequence[np.ndarray], whole: int, kind: str) -> float:
    """The expected difference after `whole` steps, from branches of a few steps each, (n,), the first from the start.

    kind: of the quantity. A history and the like are means over the run, a maximum and the like the largest value.
    """
    n = min(branch.size for branch in branches)
    if whole < n:
        return float(np.abs(branches[0][: max(whole, 1)]).max())
    half = max(n // 2, 1)
    early = math.sqrt(np.mean([np.abs(branch[:half]).max() ** 2 for branch in branches]))
    late = math.sqrt(np.mean([np.abs(branch[:n]).max() ** 2 for branch in branches]))
    if late == 0.0 or not math.isfinite(late):
        return late
    growth = late / early - 1.0 if early else math.inf  # of the second half over the first
    times, shape = whole / n, 1.0
    if growth < EVEN:
        size = late * (1.0 - growth ** (2.0 * times)) / (1.0 - growth**2) if growth else late
    else:
        power = 0.5 * (1.0 + min(math.log2(1.0 + growth), 2.0))
        size = late * _together([float(branch[n - 1]) for branch in branches], times) * times**power
        shape = 1.0 / math.sqrt(2.0 * power + 1.0)  # mean square of a power of time, over its end
    seconds = [branch[half:n] for branch in branches if n > half] or list(branches)
    largest = max(float(np.abs(s).max()) for s in seconds)
    if largest == 0.0:
        return size
    if kind in ("time history", "standard deviation"):
        crest = math.sqrt(np.mean([np.mean(s**2) for s in seconds])) / largest
        return size * (crest if growth < EVEN else shape)
    if kind == "mean":
        return size * abs(float(np.mean([np.mean(s) for s in seconds]))) / largest
    return size


def _together(ends: Sequence[float], times: float) -> float:
    """The share of the differences at the ends of branches that adds up over so many branches: 1 where all have one sign."""
    square = float(np.mean(np.square(ends)))
    mean = float(np.mean(ends)) ** 2
    return math.sqrt((mean + (square - mean) / times) / square) if square else 1.0
