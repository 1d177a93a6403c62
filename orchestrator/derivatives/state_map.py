"""Macro steps of a scene as a map of its state and of chosen parameters, with the exact derivative by both."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import ExitStack, suppress
from typing import NamedTuple

import numpy as np

from ...components.core.errors import BadInput, StepFailed
from ...components.core.sampled import NEXT, SampledComponent
from ..engine.algorithms import Master
from ..scene.scene import Scene
from .coupled_step import CoupledStep
from .tangent_run import TangentScene

NEARBY = 1e-3  # of a state


class Image(NamedTuple):
    """Behind the steps: z (n,), y (k,) outputs; by z (n + k, n) and by the parameters (n + k, m) their derivatives."""

    z: np.ndarray
    y: np.ndarray
    by_state: np.ndarray
    by_parameters: np.ndarray


class StateMap:
    """A scene's macro steps from its start, or from `at`, s, z -> z'.

    parameters: real ones and free inputs, by which there are derivatives, too.
    """

    def __init__(self, scene: Scene, stack: ExitStack, where: str, parameters: Sequence[str] = (), outputs: Sequence[str] = ()):
        """`stack` closes the units.  where: of messages.  outputs: "unit.output". Raises `BadInput` for what has no derivatives."""
        self.tangents = TangentScene(scene, stack, remedy="")
        self.scene, self.step, self.parameters = scene, CoupledStep(self.tangents), tuple(parameters)
        if len(self.parameters) >= self.tangents.width:
            raise BadInput(where, f"{len(self.parameters)} free parameters", f"{self.tangents.width - 1} at most")
        ends = {f"{u.name}.{n}": (u.name, n) for u in self.tangents.layout.units for n in u.component.outputs}
        self._places = [self.tangents._place_of(name) for name in parameters]
        self.y = np.array([self.tangents.layout.output(ends[name]) for name in outputs], dtype=np.intp)
        self.cells, self.at = np.zeros(0, dtype=np.intp), scene.start_time
        self._counters = [  # they follow from the time
            unit.first + unit.component.block.ranges("x")[0][0] + NEXT  # type: ignore[union-attr]
            for unit in self.tangents.layout.units
            if isinstance(unit.component, SampledComponent)
        ]
        self._held = np.zeros(0, dtype=np.intp), np.zeros(0)
        self._base: tuple[np.ndarray, int] | None = None
        self._plain: np.ndarray | None = None  # what the tangents are beside those that are sought: addresses
        self._filled = True  # whether the base follows from the length of the steps, by samples
        self._numbers = self.tangents._image.view(np.float64)

    @property
    def p(self) -> np.ndarray:
        """The parameters, (m,)."""
        return self._numbers[self._places].copy()

    def set(self, values: Mapping[str, float]) -> None:
        """Numbers of parameters and free inputs from now on."""
        self._numbers[[self.tangents._place_of(name) for name in values]] = list(values.values())
        self._base = None

    def begin(self, p: np.ndarray | None = None, h: float | None = None, steps: int | None = None) -> None:
        """Parameters (m,), length h of the macro steps, s, and their number from now on; default those that were."""
        h, steps, p = h or self.step.h, steps or self.step.steps, self.p if p is None else p
        same = self._base is not None and (h == self.step.h or not self._filled) and np.array_equal(p, self.p)
        self.step.h, self.step.steps = h, steps
        if same:
            return
        self._numbers[self._places] = p
        if self._plain is None:
            self.step.begin(at=self.at)
            self._plain = self.step._clear
        self.step.begin(self._places, self.at)
        self._seeded, self._base = self.step._clear, self.step._save()
        self._filled = self.step._taken > 0

    def find(self, z: np.ndarray | None = None) -> bool:
        """Find the cells of the state, at z or at the start, beside those that are known; whether there are more. `begin` comes first."""
        self.stand(z)
        known = self.cells
        self.cells = np.union1d(known, self._cells_read())
        return self.cells.size > known.size

    def find_nearby(self) -> None:
        """Find the cells of the state where it stands, and a little away: what is symmetric there may be blind to some."""
        self.find()
        z = self.z
        with suppress(StepFailed, BadInput):
            self.find(z + NEARBY * np.maximum(np.abs(z), NEARBY) * np.random.default_rng(0).standard_normal(z.size))
        self.stand()

    def _cells_read(self) -> np.ndarray:
        assert self._plain is not None
        self.step._cells, self.step._clear = None, self._plain
        return np.setdiff1d(self.step.cells, self._counters)

    def take(self, master: Master, t: float) -> np.ndarray:
        """The state (n,) of another opening of the scene at t, s, whose cells are found; the map is now one from t."""
        self.step.take(master, t)
        self.at, self._plain = t, self.step._clear
        self.cells = np.union1d(self.cells, self._cells_read())
        z, self._base = self.z, None
        self.begin()
        return z

    def stand(self, z: np.ndarray | None = None) -> None:
        """At the start, with the state z, (n,), and without tangents of parameters."""
        assert self._base is not None
        assert self._plain is not None
        self.step._clear = self._plain
        self.step._restore(self._base)
        if z is not None:
            cells, values = self._held
            self.step._arena.cells[cells] = values
            self.step._arena.cells[self.cells] = z

    def hold(self) -> None:
        """Modes, such as those of friction, are from now on what they are where the scene stands, wherever it is put with a state."""
        units = [u for u in self.tangents.layout.units if u.component.x.size]
        states = [np.arange(*ends) + u.first for u in units for ends in u.component.block.ranges("x")]  # type: ignore[union-attr]
        cells = np.setdiff1d(np.concatenate(states), [*self.cells, *self._counters]) if states else self._held[0]
        self._held = cells, self.step._arena.cells[cells].copy()

    @property
    def z(self) -> np.ndarray:
        """The state where the scene stands, (n,)."""
        return self.step._arena.cells[self.cells].copy()

    def run(self, z: np.ndarray, steps: int | None = None) -> np.ndarray:
        """z' (n,) alone; raises `StepFailed`. The scene stands there."""
        self.stand(z)
        self.step.advance(self.step.steps if steps is None else steps)
        return self.z

    def __call__(self, z: np.ndarray) -> Image:
        """z' with all derivatives; raises `StepFailed`."""
        m, n, width, of = len(self.parameters), z.size, self.tangents.width, np.concatenate([self.cells, self.y])
        columns, self.ties = [], np.zeros(n, dtype=bool)
        for k in range(0, max(n, 1), width - m):
            some = range(k, min(n, k + width - m))
            directions = np.zeros((n, m + len(some)))
            directions[list(some), range(m, m + len(some))] = 1.0
            self.stand(z)
            self.step._clear = self._seeded
            self.step.seed(self.cells, directions)
            self.step.advance(self.step.steps)
            columns.append(self.step.tangents(of)[:, : m + len(some)].copy())
            self.ties[list(some)] = self.tangents.at_tie()[m : m + len(some)]
        values = self.step._arena.cells[of]
        by_state = np.concatenate([c[:, m:] for c in columns], axis=1)
        return Image(values[:n].copy(), values[n:].copy(), by_state, columns[0][:, :m])

    def names(self) -> list[str]:
        """Of the cells of the state."""
        return [self.step.name(int(cell)) for cell in self.cells]
