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
from .cells import cell_name, states
from .coupled_step import CoupledStep
from .tangent_block import Instant, TangentBlock

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
        self.block = block = TangentBlock(scene, stack, remedy="")
        self.scene, self.step, self.parameters = scene, CoupledStep(block), tuple(parameters)
        if len(self.parameters) >= block.width:
            raise BadInput(where, f"{len(self.parameters)} free parameters", f"{block.width - 1} at most")
        self._places = block.places(parameters)
        self.y = np.array([block.outputs[name] for name in outputs], dtype=np.intp)
        self.cells, self.at = np.zeros(0, dtype=np.intp), scene.start_time
        self._counters = [  # they follow from the time
            unit.first + unit.component.block.ranges("x")[0][0] + NEXT  # type: ignore[union-attr]
            for unit in block.layout.units
            if isinstance(unit.component, SampledComponent)
        ]
        self._held = np.zeros(0, dtype=np.intp), np.zeros(0)
        self._base: Instant | None = None  # where steps begin, with the tangents of parameters
        self._plain: np.ndarray | None = None  # tangents that stay without those of parameters

    @property
    def p(self) -> np.ndarray:
        """The parameters, (m,)."""
        return self.block.initial[self._places]

    def set(self, values: Mapping[str, float]) -> None:
        """Numbers of parameters and free inputs from now on."""
        self.block.set(values)
        self._base = None

    def begin(self, p: np.ndarray | None = None, h: float | None = None, steps: int | None = None) -> None:
        """Parameters (m,), length h of the macro steps, s, and their number from now on; default those that were."""
        block, base, p, h = self.block, self._base, self.p if p is None else p, h or self.block.h
        self.step.steps = steps or self.step.steps
        block.pace(h)
        if base is not None and (h == base.h or not base.taken) and np.array_equal(p, self.p):  # no steps have filled samples
            self._base = base._replace(h=h)
            return
        block.initial[self._places] = p
        if self._plain is None:
            self.step.begin(at=self.at)
            self._plain = block.still
        self.step.begin(self._places, self.at)
        self._base = block.save()

    def find(self, z: np.ndarray | None = None) -> bool:
        """Find the cells of the state, at z or at the start, beside those that are known; whether there are more. `begin` comes first."""
        self.stand(z)
        known = self.cells
        self.cells = np.union1d(known, self._cells_there())
        return self.cells.size > known.size

    def find_nearby(self) -> None:
        """Find the cells of the state where it stands, and a little away: what is symmetric there may be blind to some."""
        self.find()
        z = self.z
        with suppress(StepFailed, BadInput):
            self.find(z + NEARBY * np.maximum(np.abs(z), NEARBY) * np.random.default_rng(0).standard_normal(z.size))
        self.stand()

    def _cells_there(self) -> np.ndarray:
        """Cells of the state where the scene stands without tangents of parameters."""
        return np.setdiff1d(self.step.state().cells, self._counters)

    def take(self, master: Master, t: float) -> np.ndarray:
        """The state (n,) of another opening of the scene at t, s, whose cells are found; the map is now one from t."""
        self.step.take(master, t)
        self.at, self._plain = t, self.block.still
        self.cells = np.union1d(self.cells, self._cells_there())
        z, self._base = self.z, None
        self.begin()
        return z

    def stand(self, z: np.ndarray | None = None, parameters: bool = False) -> None:
        """At the start, with the state z, (n,), and without tangents of parameters, or with them."""
        assert self._base is not None
        assert self._plain is not None
        self.block.restore(self._base if parameters else self._base._replace(still=self._plain))
        if z is not None:
            cells, values = self._held
            self.block.cells[cells] = values
            self.block.cells[self.cells] = z

    def hold(self) -> None:
        """Modes, such as those of friction, are from now on what they are where the scene stands, wherever it is put with a state."""
        cells = np.setdiff1d(states(self.block), [*self.cells, *self._counters])
        self._held = cells, self.block.cells[cells]

    @property
    def z(self) -> np.ndarray:
        """The state where the scene stands, (n,)."""
        return self.block.cells[self.cells]

    def run(self, z: np.ndarray, steps: int | None = None) -> np.ndarray:
        """z' (n,) alone; raises `StepFailed`. The scene stands there."""
        self.stand(z)
        self.block.advance(self.step.steps if steps is None else steps)
        return self.z

    def __call__(self, z: np.ndarray) -> Image:
        """z' with all derivatives; raises `StepFailed`."""
        m, n, of, columns = len(self.parameters), z.size, np.concatenate([self.cells, self.y]), []
        ties: list[np.ndarray] = []
        self.stand(z, parameters=True)
        for some in self.block.batches(self.cells, np.eye(n), first=m):
            self.block.advance(self.step.steps)
            columns.append(self.block.tangents[of, : some.stop])
            ties.append(self.block.at_tie()[some])
        self.ties = np.concatenate(ties)
        values = self.block.cells[of]
        by_state = np.concatenate([c[:, m:] for c in columns], axis=1)
        return Image(values[:n], values[n:], by_state, columns[0][:, :m])

    def names(self) -> list[str]:
        """Of the cells of the state."""
        return [cell_name(self.block, int(cell)) for cell in self.cells]
