"""Whether the coupling of a scene lets disturbances grow: told by exact derivatives of its macro steps, of any length.

Where the derivative of a macro step is the same all along the run, the largest absolute eigenvalue of the part that reaches from unit
to unit decides. Where it changes, eigenvalues at an instant prove nothing: a push is followed over stretches of the run. Each
stretch begins on a run with a quarter of the scene's step, so that no contact or stop has bounded yet what grows. The push goes on
from stretch to stretch, so that of all that decays nothing is left in it, and its growth is that from the first to the last instant:
growth within stretches, one by one, has the chance of where in an oscillation each begins and ends. Beside it the growth with a
quarter of the step shows what grows by itself. A little of a new push is added in each stretch, for what grows may have been lost.
Where pushes grow by themselves, as of a motion that is chaotic, growth tells nothing of the coupling.
"""

from __future__ import annotations

import math
from contextlib import ExitStack
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ...components.core.errors import BadInput, StepFailed
from ..derivatives.coupled_step import CoupledStep, sampling_periods
from ..derivatives.push import PushedScene
from ..derivatives.tangent_block import Instant
from ..run.thresholds import AT_REST, EXCESS, SAME_MAP
from ..scene.scene import Scene
from .growth import Grown, Growth, StepLimit, grown_in, growth_along, longest_stable

FINER = 4  # steps that one is compared with
FINEST = FINER**3  # parts of a step, one of which shows what grows by itself where a longer one does not
STRETCHES = 12  # of a run, over which a push is followed
LEAD = 6  # stretches, the last ones, that a push passes before: by then what grows least slowly is left of it
FEWEST = 16  # macro steps of a stretch
NEW = 1e-6  # what is added to a push in each stretch: stiff bearings make 1e3 times as much of it for some steps
WARM = 3  # macro steps, which fill the histories of the inputs with samples of one distance
MOST = 400  # states of units whose Jacobian is worth its time
ACCURACY = 1.01, 1.0 + 1e-9  # of a limit: of growth along the run, of an eigenvalue
FEWEST_STEPS = 36.0  # macro steps of a run for which a limit is looked for
SHORTEST = 64.0  # part of the scene's macro step below which no limit is looked for
ROUNDING = 1e-9  # of an absolute eigenvalue


class Rates(NamedTuple):
    """Growth, 1/s: over the run, and over each stretch; without stretches, of an eigenvalue.  failure: why a run ended."""

    mean: float
    stretches: tuple[float, ...] = ()
    failure: str = ""


class CouplingStability:
    """Of a scene of kernels in which units feed one another, for macro steps of any length."""

    def __init__(self, scene: Scene, stack: ExitStack):
        """`stack` closes the units. Raises `BadInput` for what has no derivatives, `StepFailed` where the scene does not start."""
        self.scene, self._pushed = scene, PushedScene(scene, stack)
        self._known: dict[float, Rates] = {}

    def growth(self, h: float) -> Growth:
        """Of disturbances with macro steps of h, s."""
        new, fraction = self._rate(h), FINER
        noise = 0.0 if self.constant else EXCESS / self.scene.duration
        while (finer := self._rate(h / fraction)).mean > noise and fraction < FINEST:
            fraction *= FINER  # a quarter of the step may be too long, too
        everywhere = all(a > max(b, 0.0) for a, b in zip(new.stretches, finer.stretches, strict=False))
        return Growth(h, self.scene.duration, new.mean, finer.mean, self.constant, new.failure, everywhere)

    def grows(self, h: float) -> str:
        """What disturbances do with macro steps of h, s, where the coupling lets them grow; "" where it does not."""
        if self._rate(h).mean <= 0.0:
            return ""
        growth = self.growth(h)
        return growth.text if growth.unstable else ""

    def longest(self) -> StepLimit:
        """The longest macro step of those that the run has room for."""
        step, least = self.scene.master.step, self.scene.master.step / SHORTEST
        if self.constant:
            return longest_stable(self.grows, least, least, max(step, self.scene.duration / FEWEST_STEPS), ACCURACY[True])
        if why := self.growth(step).untold:
            return StepLimit(math.nan, why, step)
        return longest_stable(self.grows, step, least, max(self.most, least), ACCURACY[False])

    @property
    def most(self) -> float:
        """The longest macro step of which growth along the run tells that it is stable, s: with longer ones stretches leave the run."""
        return math.inf if self.constant else self._stretch / FEWEST

    @property
    def constant(self) -> bool:
        """Whether the derivative of a macro step is the same all along the run."""
        return self._map is not None

    # -- where the derivative is the same ----------------------------------------------------------------------------
    @cached_property
    def _map(self) -> tuple[np.ndarray, int] | None:
        """Cells of the state that couple units, where the derivative of a macro step by them is the same all along the run.

        Beside them how many eigenvalues are at 1, of free bodies: with shorter steps those of slow modes come as near to 1.
        """
        if sum(unit.component.x.size for unit in self._pushed.block.layout.units) > MOST or sampling_periods(self.scene):
            return None  # steps that are tried have no period in common with those of controllers
        try:
            cells, first = self._coupling(self._instants[0])
            for instant in self._instants[1:]:
                now, matrix = self._coupling(instant)
                if now.tolist() != cells.tolist() or np.abs(matrix - first).max(initial=0.0) > SAME_MAP * np.abs(first).max(
                    initial=0.0
                ):
                    return None
        except (BadInput, StepFailed):  # such as an infinite derivative
            return None
        return (cells, int((np.abs(np.linalg.eigvals(first) - 1.0) <= AT_REST).sum())) if cells.size else None

    def _coupling(self, instant: Instant) -> tuple[np.ndarray, np.ndarray]:
        """Cells of the state that couple units at an instant, (n,), and the derivative of a macro step by them, (n, n)."""
        step = self._step(self.scene.master.step, instant)
        state = step.state()
        rows = np.sort(np.concatenate([np.zeros(0, dtype=int), *step.coupling_blocks(state)]))
        return state.cells[rows], state.jacobian[np.ix_(rows, rows)]

    def _step(self, h: float, instant: Instant) -> CoupledStep:
        self._pushed.back(instant, h)
        step = CoupledStep(self._pushed.block)
        step.block.fill()
        step.block.advance(WARM * step.steps)
        return step

    def _radius(self, h: float, cells: np.ndarray, at_rest: int) -> float:
        """The largest absolute eigenvalue of the coupling in a macro step of h, s, but for so many next to 1, of free bodies."""
        step = self._step(h, self._instants[0])
        values = np.linalg.eigvals(step.derivative(cells, np.eye(cells.size), cells))
        moving = values[np.argsort(np.abs(values - 1.0))[at_rest:]]
        radius = float(np.abs(moving).max(initial=np.finfo(float).tiny))
        return 1.0 if abs(radius - 1.0) < ROUNDING else radius ** (1.0 / step.steps)

    # -- where it changes --------------------------------------------------------------------------------------------
    @property
    def _stretch(self) -> float:
        """In s; half of one is left before the first and behind the last."""
        return self.scene.duration / (STRETCHES + 1)

    @cached_property
    def _instants(self) -> list[Instant]:
        """The start, and where the stretches begin, of the run with a quarter of the scene's step, as far as that comes."""
        scene, block = self.scene, self._pushed.block
        reached = [block.save()]
        block.pace(scene.master.step / FINER)
        for k in range(STRETCHES):
            t = scene.start_time + (k + 0.5) * self._stretch
            try:
                block.advance(FINER * max(round((t - block.time) / scene.master.step), 1))
            except StepFailed:
                break
            reached.append(block.save())
        return reached

    def _rate(self, h: float) -> Rates:
        """With macro steps of h, s."""
        if h not in self._known:
            same = self._map
            self._known[h] = self._along_the_run(h) if same is None else Rates(math.log(self._radius(h, *same)) / h)
        return self._known[h]

    def _along_the_run(self, h: float) -> Rates:
        pushed, scene = self._pushed, self.scene
        n = max(round(self._stretch / h), FEWEST)
        reached, fine = self._instants[1:] or self._instants, scene.master.step / FINER
        begins = [reached[0].time + k * n * h for k in range(len(reached))]  # a push goes on at the instant that it has come to
        begins = [t for k, t in enumerate(begins) if not k or t + (n + WARM) * h <= scene.stop_time]
        grown: list[Grown] = []
        along = None
        for t in [*begins[-LEAD:], *begins]:
            instant = next(one for one in reversed(reached) if one.time <= t)
            pushed.back(instant, fine)
            try:
                pushed.block.advance(round((t - instant.time) / fine))
                pushed.block.pace(h)
                pushed.block.advance(WARM)
                pushed.push(along, NEW)
                sizes = pushed.sizes(n)
            except StepFailed as error:
                return Rates(math.inf, failure=str(error))
            grown.append(grown_in(sizes, h, new=along is None))
            along = pushed.direction(float(sizes[-1]))
        grown = grown[-len(begins) :]
        return Rates(growth_along(grown, n * h), tuple(one.whole / (n * h) for one in grown))
