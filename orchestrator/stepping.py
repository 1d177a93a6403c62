"""The stepping loop: from tick to tick, to the end and never past it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

from .algorithms import Master
from .clock import Clock

Action = Callable[[], None]
Observer = Callable[[int, float], None]  # is called with the tick and the time


class Stepping:
    """Steps of `stride` ticks from tick 0 to `end`, the last one shorter where they do not divide it.

    `stops`: ticks that have to be met exactly, with what happens there: tick -> actions. When all units have reached the
    tick, its actions are called in their order, and after them the observers, which therefore see what the actions left; those
    of tick 0 come after the initialization. Ticks beyond the end are never met. An action that makes inputs jump restarts
    their history (`Node.restart`), so that the steps behind it extrapolate nothing of what was before.
    """

    def __init__(self, master: Master, clock: Clock, stride: int, end: int, stops: Mapping[int, Sequence[Action]] | None = None):
        self.master, self.clock, self.stride, self.end = master, clock, stride, end
        self.stops = dict(stops or {})
        self.tick = 0

    def run(self, observers: Sequence[Observer]) -> None:
        """Step to the end; observers see every instant after all units have reached it."""
        self._arrive(observers)
        for stop in sorted({self.end, *self.stops}):
            if self.tick < stop <= self.end:
                self._approach(stop, observers)

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

    Between stops steps end at multiples of the stride. What is left over before and after a stop that is no multiple gets no
    step below half a stride of its own, but shares two equal ones with a whole stride: a chord over a step much shorter than
    its neighbours extrapolates the rounding of its ends. Only the `last` stop, behind which nothing is extrapolated, ends with
    what is left.
    """
    if stop - tick < 2 * stride and not last:
        yield from _shared(stop - tick, stride)
        return
    head = -tick % stride
    if 0 < head < stride / 2:
        head += stride
    if head and head < stop - tick:
        yield from _shared(head, stride)
        tick += head
    whole, rest = divmod(stop - tick, stride)
    if whole and rest and (2 * rest < stride) and not last:
        whole, rest = whole - 1, rest + stride
    if whole:
        yield stride, whole
    yield from [(rest, 1)] if last and rest else _shared(rest, stride)


def _shared(length: int, stride: int) -> Iterator[tuple[int, int]]:
    """A length below two strides in one step, or in two that are equal to one tick."""
    if length > stride:
        yield length // 2, 1
        yield length - length // 2, 1
    elif length:
        yield length, 1
