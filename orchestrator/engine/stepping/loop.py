"""The stepping loop: from tick to tick, to the end and never past it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, Protocol

import numpy as np

from ..algorithms.machine import Steps
from ..coupling import Endpoint
from .clock import Clock

Action = Callable[[], None]
Stops = Mapping[int, Sequence[Action]]
Observer = Callable[[int, float], None]  # is called with the tick and the time


class Steppable(Protocol):
    """What steps all units: a master, or one whose steps are audited."""

    def step(self, t: float, h: float) -> None:
        """One step of all units from t to t + h."""

    def save(self, reuse: Any = None) -> Any:
        """Everything a repeated step depends on."""

    def restore(self, saved: Any) -> None:
        """Take back what `save` gave."""

    def adopt(self, saved: Any) -> None:
        """As `restore`, of another one of the same scene; raises `ValueError` where it does not fit."""

    def run_steps(self, times: np.ndarray, h: float) -> Steps:
        """Steps from each of `times` (n,), s, of length h."""


ROUNDING = 1_000_000_000  # less than this part of a stride is no step of its own: 3 * 1e-4 is 3.0000000000000003e-4


class Stepping:
    """Steps of `stride` ticks from tick 0 to `end`, the last one shorter where they do not divide it.

    `stops`: ticks that have to be met exactly, with what happens there: tick -> actions. When all units have reached the
    tick, its actions are called in their order, and after them the observers, which therefore see what the actions left; those
    of tick 0 come after the initialization. Ticks beyond the end are never met. An action that makes inputs jump restarts
    their history (`Node.restart`), so that the steps behind it extrapolate nothing of what was before.
    """

    # Where in the outputs that batches of steps leave to observers those of units will stand; None where observers have to ask
    watch: Callable[[Sequence[Endpoint]], slice | None] = staticmethod(lambda ends: None)
    rewinds = False  # whether all units stand at the tick again behind a step that was not completed

    def __init__(self, master: Steppable, clock: Clock, stride: int, end: int, stops: Stops | None = None):
        self.master, self.clock, self.stride, self.end = master, clock, stride, end
        self.stops = dict(stops or {})
        self.tick = 0

    def run(self, observers: Sequence[Observer]) -> None:
        """Step to the end; observers see every instant after all units have reached it, a resumed run the new ones."""
        if self.tick == 0:
            self._arrive(observers)
        for stop in sorted({self.end, *self.stops}):
            if self.tick < stop <= self.end:
                self._approach(stop, observers)

    def rescue(self, observers: Sequence[Any]) -> None:
        """This process is about to end inside of a step: let the observers have what was completed before it."""

    def halt(self) -> None:
        """Let the observers see the next instant that is reached, even where they need not."""

    def warnings(self) -> list[str]:
        """What a user should know of the steps made so far."""
        return []

    def state(self) -> dict[str, Any]:
        """What the next steps depend on beside tick and master, for a checkpoint."""
        return {}

    def take(self, state: Mapping[str, Any]) -> None:
        """Go on from a `state`."""

    def _approach(self, stop: int, observers: Sequence[Observer]) -> None:
        """Step until the tick `stop` is reached, and arrive there."""
        seconds, step, tick = self.clock.seconds, self.master.step, self.tick
        t = seconds(tick)
        for length, count in lengths(tick, stop, self.stride, stop == self.end):
            h = seconds(length)
            for _ in range(count):
                step(t, h)
                self.tick = tick = tick + length
                if tick == stop:
                    break
                t = seconds(tick)
                for observe in observers:
                    observe(tick, t)
        self._arrive(observers)

    def _arrive(self, observers: Sequence[Observer]) -> None:
        """Do what is to be done at the tick that has been reached, and let the observers see it."""
        for act in self.stops.get(self.tick, ()):
            act()
        t = self.clock.seconds(self.tick)
        for observe in observers:
            observe(self.tick, t)


def lengths(tick: int, stop: int, stride: int, last: bool) -> Iterator[tuple[int, int]]:
    """Steps from a tick to a stop, as (ticks of a step, number of such steps).

    Steps end at multiples of the stride. What is left over before and after a stop that is no multiple gets no step below half
    a stride of its own, but shares two equal ones with a whole stride: a chord over a step much shorter than its neighbours
    extrapolates the rounding of its ends. Only the `last` stop, behind which nothing is extrapolated, is met by what is left,
    unless that is the rounding of a time that was computed: then the last step has it in it.
    Every step follows from tick and stop alone, so a run that is resumed on the way takes the same ones.
    """
    while (distance := stop - tick) > 0:
        head, count = stride - tick % stride, 1
        if distance <= stride:
            length = distance
        elif 2 * distance < 3 * stride and not last:
            length = distance // 2
        elif head == stride and last:
            length, count = stride, distance // stride
            if 0 < ROUNDING * (distance % stride) < stride:
                length, count = (stride, count - 1) if count > 1 else (distance, 1)
        elif head == stride:
            length, count = stride, (2 * distance - 3 * stride) // (2 * stride) + 1
        else:
            length = head if 2 * head >= stride else (head + stride) // 2
        yield length, count
        tick += length * count
