"""Steady states: fixed points of the coupled macro step, found by Newton's method on its exact derivative.

The state of a scene is that of `coupled_step`, samples for extrapolation included, so that a steady state is one of the coupled
run itself. What acts on nothing else, such as the angle of a shaft or the position in a homogeneous current, may move steadily.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from math import isfinite
from numbers import Real
from pathlib import Path
from typing import Any

import numpy as np

from ...components.core.errors import BadInput, StepFailed, counted, nearest
from ...components.core.measure import number_in
from ..engine.algorithms import Master
from ..output import write_table
from ..scene.names import declared
from ..scene.scene import Scene
from .linear import Linear, Linearization
from .newton import ROUNDING, Solution, newton
from .state_map import StateMap

INSIDE, SURE = 1e-7, 1e-11  # of the sizes: what residuals may leave, and what tells without corrections that vanish
ASIDE = 1e-9  # of the largest move: a heading that nothing holds is known to rounding only, and leads a motion aside by it
ACTS = 1e-13  # derivatives below are none
WORDS = {True: "stable", False: "unstable", None: "not known"}
SMALLEST_SIZE = 1e-3  # size of what is judged: smaller numbers may be rounding
GROWS = 1e-9  # of an eigenvalue beyond 1: more than rounding
SEEN_ON = 3  # further common periods in which it has to stay


@dataclass(frozen=True)
class SteadyState:
    """states, outputs: by name. free: parameters and inputs that were found. moving: state -> rate, 1/s, of what goes on steadily.

    linear: the scene about it as a linear system; None where it has none, as `remarks` say.
    """

    scene: Scene
    states: dict[str, float]
    outputs: dict[str, float]
    free: dict[str, float]
    moving: dict[str, float]
    linear: Linear | None
    remarks: tuple[str, ...]

    @property
    def stable(self) -> bool | None:
        """Whether no small deviation grows; None where nothing tells."""
        if self.linear is None:
            return None
        return max((abs(mode.factor) for mode in self.linear.modes()), default=0.0) <= 1.0 + GROWS

    def rows(self) -> list[tuple[str, str, float, str]]:
        """(kind, name, value, unit): what was free, outputs, and what moves."""
        interfaces = self.scene.coupling.interfaces

        def unit(name: str) -> str:
            of, variable = self.scene.split(name)
            known = {**interfaces[of].outputs, **interfaces[of].inputs}
            return known[variable].unit if variable in known else declared(self.scene, of)[variable].unit

        rows = [("free", n, v, unit(n)) for n, v in self.free.items()]
        rows += [("output", n, v, unit(n)) for n, v in self.outputs.items()]
        return rows + [("moves, per s", n, v, "") for n, v in self.moving.items()]

    def __repr__(self) -> str:
        stable = {True: "stable", False: "unstable", None: "not known whether stable"}[self.stable]
        lines = [f"<Steady state of {self.scene.name}: {stable}>", *(f"{n} = {v:.10g} {u} ({k})" for k, n, v, u in self.rows())]
        return "\n".join([*lines, *([] if self.linear is None else map(str, self.linear.modes())), *self.remarks])


@dataclass(frozen=True)
class SteadyStates:
    """Steady states over the values of a parameter, "" where there is one alone; refused: (value, reason)."""

    scene: Scene
    parameter: str
    points: tuple[tuple[float | None, SteadyState], ...]
    refused: tuple[tuple[float | None, str], ...] = ()

    def save(self, directory: str | Path) -> list[Path]:
        """Write trim.csv and, of a single one, linear.npz and linear.mat."""
        if not self.parameter:
            state = self.points[0][1]
            files = [write_table(directory, "trim.csv", ("kind", "name", "value", "unit"), [list(r) for r in state.rows()])]
            kinds = ("npz", "mat") if state.linear is not None else ()
            return files + [state.linear.save(Path(directory) / f"linear.{kind}") for kind in kinds]  # type: ignore[union-attr]
        names = [f"{name}, {unit}" if unit else name for _, name, _, unit in self.points[0][1].rows()]
        rows: list[list[float | str]] = [
            [float(value or 0.0), WORDS[state.stable], *(v for _, _, v, _ in state.rows())] for value, state in self.points
        ]
        return [write_table(directory, "trim.csv", (self.parameter, "stable", *names), rows)]

    def to_json(self) -> dict[str, Any]:
        """All of it as plain data."""
        points = [
            {"value": value, "stable": s.stable, "free": s.free, "outputs": s.outputs, "moving": s.moving, "states": s.states}
            for value, s in self.points
        ]
        return {"scene": self.scene.name, "parameter": self.parameter, "points": points, "refused": dict(self.refused)}


def trim(
    scene: Scene,
    free: Sequence[str] = (),
    want: Mapping[str, float | str] | None = None,
    *,
    moving: Sequence[str] = (),
    over: tuple[str, Sequence[float]] | None = None,
    inputs: Sequence[str] = (),
    outputs: Sequence[str] = (),
    at: tuple[Master, float] | None = None,
    given: Mapping[str, float] | None = None,
) -> SteadyStates:
    """Steady states, sought from a scene's start, or from where another opening of it stands, `at` (its master, time in s).

    free: parameters and free inputs to be found, as many as outputs in `want`, by name with their values.  moving: names of
    states or outputs that may go on steadily beside angles, or "all".  over: a parameter and its values, each sought from the
    last, else as the first.  inputs, outputs: of the linear systems.  given: values of free inputs.
    Raises `BadInput` where there is none; over a parameter it is noted.
    """
    with ExitStack() as stack:
        search = _Search(scene, stack, tuple(free), dict(want or {}), tuple(moving), inputs, outputs)
        z = search.begin(at, given or {})
        if over is None:
            return SteadyStates(scene, "", ((None, search.steady_state(z)[0]),))
        points: list[tuple[float | None, SteadyState]] = []
        refused: list[tuple[float | None, str]] = []
        first = dict(zip(search.map.cells, z, strict=True))
        for value in map(float, over[1]):
            search.map.set({over[0]: value})
            try:
                state, z = search.steady_state(z)
            except (BadInput, StepFailed) as error:
                try:
                    state, z = search.steady_state(np.array([first.get(cell, 0.0) for cell in search.map.cells]))
                except (BadInput, StepFailed):
                    refused.append((value, str(error)))
                    continue
            points.append((value, state))
        if not points:
            raise BadInput(search.where, f"none at {counted(len(refused), 'value')}", "a steady state", refused[0][1])
        return SteadyStates(scene, over[0], tuple(points), tuple(refused))


class _Search:
    """The equations of a steady state: state and free parameters are unknown."""

    def __init__(self, scene: Scene, stack: ExitStack, free: tuple[str, ...], want: dict[str, float | str], moving: tuple[str, ...],
                 inputs: Sequence[str], outputs: Sequence[str]):  # fmt: skip
        self.scene, self.where, self.free, self.moving = scene, f"steady state of {scene.name}", free, moving
        if len(free) != len(want):
            raise BadInput(self.where, f"{len(free)} free and {len(want)} wanted", "one wanted output for each free parameter")
        interfaces = scene.coupling.interfaces
        known = [f"{u}.{n}" for u in scene.units for n, s in interfaces[u].outputs.items() if not s.is_text]
        if wrong := [name for name in want if name not in known]:
            raise BadInput(self.where, repr(wrong[0]), "an output", nearest(wrong[0], known))
        self.every = known
        self.wanted = np.array([self._number(*scene.split(name), value) for name, value in want.items()])
        self.map = StateMap(scene, stack, self.where, free, known)
        self.rows = [known.index(name) for name in want]
        self._linear = Linearization(self.map.step, inputs, outputs)

    def _number(self, unit: str, name: str, value: float | str) -> float:
        signal = self.scene.coupling.interfaces[unit].outputs[name]
        where = f"{self.where}: {unit}.{name}"
        number = number_in(value, signal.unit, where, signal.measure, signal.relative) if isinstance(value, str) else value
        if not isinstance(number, Real) or not isfinite(number):
            raise BadInput(where, repr(value), f"a finite number in {signal.unit or '1'}")
        return float(number)

    def begin(self, at: tuple[Master, float] | None, given: Mapping[str, float]) -> np.ndarray:
        """The state to search from."""
        self.map.set(given)
        if at is not None:
            return self.map.take(*at)
        self.map.begin()
        self.map.find_nearby()
        return self.map.z

    def _equations(self, unknown: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        n = self.map.cells.size
        self.map.begin(unknown[n:])
        z = unknown[:n].copy()
        image = self.map(z)
        alone = self._alone(image.by_state[:n])
        if alone.any() and (image.z != z)[alone].any():  # discrete modes first take the value that the rest asks for
            z[alone] = image.z[alone]
            image = self.map(z)
        moves = np.abs(image.z - z) > ROUNDING * np.maximum(np.abs(z), np.abs(image.z))
        self._moves = np.where(alone & moves, image.z - z, 0.0)
        k = [n + row for row in self.rows]
        top = np.hstack([image.by_state[:n] - np.eye(n), image.by_parameters[:n]])
        matrix = np.vstack([top, np.hstack([image.by_state[k], image.by_parameters[k]])])
        self._by_outputs = image.by_state[n:]
        return np.concatenate([image.z - z, image.y[self.rows] - self.wanted]), matrix

    def _alone(self, matrix: np.ndarray) -> np.ndarray:
        """Cells that keep their value and act on no other, (n,) of bool."""
        return np.asarray((np.abs(matrix - np.eye(len(matrix))) <= ACTS).all(axis=0))

    def _primary(self, matrix: np.ndarray) -> np.ndarray:
        n = self.map.cells.size
        alone = (np.abs(matrix[:n, :n]) <= ACTS).all(axis=0)
        return np.concatenate([~alone, np.ones(len(matrix) - n, dtype=bool)])

    def steady_state(self, z: np.ndarray) -> tuple[SteadyState, np.ndarray]:
        """The steady state from z, (n,), and the z of it; raises `BadInput`."""
        self.map.begin()
        p = self.map.p
        for _ in range(4):
            solution = newton(self._equations, np.concatenate([z, p]), self._primary)
            self._refuse_unconverged(solution)
            n = self.map.cells.size
            z, p, before = solution.x[:n], solution.x[n:], self.map.cells
            if not self.map.find(z):
                break
            self.map.stand()
            z = np.array(
                [dict(zip(before, z, strict=True)).get(cell, v) for cell, v in zip(self.map.cells, self.map.z, strict=True)]
            )
        return self._state(solution, z, p), z

    def _refuse_unconverged(self, solution: Solution) -> None:
        left = np.where(self._primary(solution.matrix), solution.left, 0.0)
        if (left <= (INSIDE if solution.converged else SURE)).all():
            return
        names = self.map.names() + list(self.free)
        worst = int(np.argmax(np.nan_to_num(left, posinf=1e300)))
        n, period = self.map.cells.size, self.map.step.period
        if worst >= n:
            name = self.every[self.rows[worst - n]]
            what = f"{name} = {solution.residual[worst] + self.wanted[worst - n]:.6g} instead of {self.wanted[worst - n]:.6g}"
            raise BadInput(self.where, what, "a value that it can have", f"After {solution.steps} steps of Newton's method.")
        what = f"{self._alias(worst)} still changes by {solution.residual[worst] / period:.3g} per s after {solution.steps} steps"
        if self._turns(worst) or not np.abs(solution.matrix[worst]).max() > ACTS:
            remedy = "It acts on others while it moves on: the motion may be periodic. cosimo orbit finds such motions."
        elif self.map.ties.any():
            tied = ", ".join(names[k] for k in np.flatnonzero(self.map.ties)[:3])
            remedy = f"A decision stands at its boundary there, by {tied}: a joint that sticks, or a contact about to open."
        else:
            remedy = "Start closer to it; there may be none."
        raise BadInput(self.where, what, "a state that keeps", remedy)

    def _turns(self, k: int) -> bool:
        """Whether a state is an angle, for an output that is it is one."""
        alias = self._alias(k).partition(" (")[2].rstrip(")")
        unit, name = self.scene.split(alias) if alias and "." in alias else ("", "")
        return bool(alias) and "." in alias and self.scene.coupling.interfaces[unit].outputs[name].unit == "rad"

    def _alias(self, k: int) -> str:
        """A state with an output that is it, "unit.x[3] (unit.angle)"."""
        name = self.map.names()[k]
        same = np.flatnonzero(np.abs(np.abs(self._by_outputs[:, k]) - 1.0) < 1e-9)
        return f"{name} ({self.every[same[0]]})" if same.size else name

    def _state(self, solution: Solution, z: np.ndarray, p: np.ndarray) -> SteadyState:
        step, n = self.map.step, self.map.cells.size
        names, period = self.map.names(), step.period
        self._equations(np.concatenate([z, p]))
        seen = (np.abs(self._by_outputs) > ACTS).any(axis=0)
        far = np.abs(self._moves) > np.maximum(
            SURE * np.maximum(solution.size[:n], SMALLEST_SIZE), ASIDE * np.abs(self._moves).max(initial=0.0)
        )
        moves = {int(k): float(self._moves[k] / period) for k in np.flatnonzero(far & seen)}
        if refused := [f"{self._alias(k)} by {rate:.6g} per s" for k, rate in moves.items() if not self._may_move(k)]:
            remedy = "It acts on nothing else: it may be left out with moving (--moving)."
            raise BadInput(self.where, f"{', '.join(refused)} moves on", "a state that keeps", remedy)
        after = self.map.run(z, step.steps * SEEN_ON)
        size = np.maximum(solution.size[:n], SMALLEST_SIZE)
        self.map.run(z)
        remarks: list[str] = []
        try:
            linear = self._linear.result()
            remarks += linear.remarks
            growth = max(1.0, float(np.abs(np.linalg.eigvals(linear.A)).max(initial=0.0))) ** SEEN_ON
        except BadInput as error:
            linear, growth = None, 1.0
            remarks.append(f"{error} Its modes are not known.")
        left = np.where(self._moves == 0.0, np.abs(after - z), 0.0)
        if (left > INSIDE * growth * size).any():
            worst = self._alias(int(np.argmax(left / size)))
            raise BadInput(
                self.where, f"{worst} moves later", "a state that keeps", "The scene depends on time: see cosimo orbit."
            )
        outputs = dict(zip(self.every, self.map.block.cells[self.map.y].tolist(), strict=True))
        return SteadyState(
            self.scene,
            dict(zip(names, z.tolist(), strict=True)),
            outputs,
            dict(zip(self.free, p.tolist(), strict=True)),
            {self._alias(k): rate for k, rate in moves.items()},
            linear,
            tuple(remarks),
        )

    def _may_move(self, k: int) -> bool:
        """Whether a state turns, or was named to move on, or an output that depends on it."""
        outputs = {self.every[i] for i in np.flatnonzero(np.abs(self._by_outputs[:, k]) > ACTS)}
        return self._turns(k) or bool({self.map.names()[k], "all", *outputs} & set(self.moving))
