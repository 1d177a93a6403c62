"""The stepping loop: from tick to tick, to the end and never past it; and who watches the steps."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import Any, Protocol

import numpy as np

from ..algorithms import Master
from ..algorithms.energy import EnergyAccount
from ..algorithms.machine import Steps
from ..algorithms.master import NONE
from ..coupling import Endpoint
from .clock import Clock

Action = Callable[[], None]
Stops = Mapping[int, Sequence[Action]]
Observer = Callable[[int, float], None]  # is called with the tick and the time

FOREVER = 1_000_000  # steps
BATCH_STEPS = 4096  # at most in one batch, whose rows are in memory
BATCH_SECONDS = 0.1  # that a batch may last: so long Ctrl-C and the progress bar have to wait
NO_STEP = 1_000_000_000  # less than this part of a stride is no step of its own: 3 * 1e-4 is 3.0000000000000003e-4


@dataclass(frozen=True)
class Needs:
    """What an observer needs of the coming steps, counted from 0.

    unseen: how many of them, it need not be called at.  inputs: behind which it needs all inputs.  states: behind which it needs the
    master saved.  finds: whether it may find among steps that were taken one at which it must be called, see
    `BatchObserver.first_violation`: where steps can be taken back, batches need not end for it.
    """

    unseen: int = FOREVER
    inputs: range = range(0)
    states: tuple[range, ...] = ()
    finds: bool = False


@dataclass(frozen=True)
class Batch:
    """Steps at which no observer was called.

    ticks, times (s): reached by the steps.  rows: the master's sample there, (n, signals).  outputs: (n, columns), what
    `Stepping.watch` was asked for.  at: (m,), steps behind which some observer needs the inputs.  inputs: (m, 2, links), their values
    there, and those which they were given for that instant.  saved: tick, time (s) and state of the master where some observer needs it.
    """

    ticks: range
    times: np.ndarray
    rows: np.ndarray
    outputs: np.ndarray
    at: np.ndarray
    inputs: np.ndarray
    saved: Sequence[tuple[int, float, Any]] = ()


class BatchObserver:
    """An observer that need not be called at every step. This one is called at none."""

    def needs(self, tick: int, length: int) -> Needs:
        """What is needed of the steps of `length` ticks that begin at `tick`."""
        return Needs()

    def first_violation(self, batch: Batch) -> int | None:
        """The first of the steps `at` at which the observer must be called: steps are then repeated up to this one."""
        return None

    def see(self, batch: Batch) -> None:
        """Steps at which the observer was not called."""


class Steppable(Protocol):
    """What steps all units: a master, or a master whose steps are audited."""

    def step(self, t: float, h: float) -> None:
        """One step of all units from t to t + h."""

    def save(self, reuse: Any = None) -> Any:
        """Everything a repeated step depends on."""

    def restore(self, saved: Any) -> None:
        """Take back what `save` gave."""

    def take_steps(self, times: np.ndarray, h: float, sampled: np.ndarray = NONE, saved: Sequence[int] = ()) -> Steps:
        """Steps from each of `times` (n,), s, of length h; see `Master.take_steps`."""


class Stepping:
    """Steps of `stride` ticks from tick 0 to `end`, the last one shorter where they do not divide it.

    `stops`: ticks that have to be met exactly, with what happens there: tick -> actions. When all units have reached the
    tick, its actions are called in their order, and after them the observers, which therefore see what the actions left; those
    of tick 0 come after the initialization. Ticks beyond the end are never met. An action that makes inputs jump restarts
    their history (`Node.restart`), so that the steps behind it extrapolate nothing of what was before.

    `batches`: a master `in_batches`, of whose steps many are one call; observers are `BatchObserver`s then, and see what they
    would have seen step by step. `trusted`: components that save their whole state. Of other components all that kernels write
    is kept, if their steps are nothing else.
    """

    rewinds = False  # whether all units stand at the tick again behind a step that was not completed

    def __init__(
        self,
        master: Steppable,
        clock: Clock,
        stride: int,
        end: int,
        stops: Stops | None = None,
        *,
        batches: Master | None = None,
        trusted: Collection[str] = (),
    ):
        self.master, self.clock, self.stride, self.end = master, clock, stride, end
        self.stops = dict(stops or {})
        self._order = sorted({end, *self.stops})
        self.tick, self._begun = 0, False
        self._whole, self._seconds, self._time = (
            range(0),
            clock.seconds(stride),
            clock.time,
        )  # ticks from which a step is a stride
        self._batches, self._trusted = batches, trusted
        self._pace = BATCH_SECONDS  # s of a step, as in the last batch
        self._under_way: tuple[range, np.ndarray] | None = None  # ticks and times of the batch that is being taken

    def run(self, observers: Sequence[Observer], most: int | None = None) -> None:
        """Step to the end, or over at most so many steps; observers see every instant after all units have reached it, a resumed
        run the new ones."""
        if self.tick == 0 and not self._begun:
            self._arrive(observers)
        self._begun, left = True, self.end if most is None else most
        for k in range(bisect_right(self._order, self.tick), len(self._order)):
            if (stop := self._order[k]) <= self.end:
                while self.tick < stop and left > 0:
                    left -= self._advance(stop, observers, left)
                    if self.tick < stop:
                        self._observe(observers)
                if self.tick < stop:
                    return
                self._arrive(observers)

    def look_ahead(self) -> None:
        """Find out to where `step_unseen` can go."""
        place = bisect_right(self._order, self.tick)
        stop = self._order[place] if place < len(self._order) else self.tick
        self._whole = range(-(-self.tick // self.stride) * self.stride, stop - 2 * self.stride, self.stride)

    def step_unseen(self) -> bool:
        """One step that no observer sees, on the shortest way to the master, and whether there was one: from a multiple of the
        stride, behind the last `look_ahead`, and away from what happens at a tick."""
        tick = self.tick
        if tick not in self._whole:
            return False
        self.master.step(self._time(tick), self._seconds)
        self.tick = tick + self.stride
        return True

    def _advance(self, stop: int, observers: Sequence[Any], most: int) -> int:
        """One step or several, at most so many and to the tick `stop`; observers see all but the last one. Returns how many."""
        length, count = next(lengths(self.tick, stop, self.stride, stop == self.end))
        count = min(count, most)
        if self._batches is not None:
            begin = self.tick
            self._take_batch(self._batches, length, begin + length * count, observers)
            return (self.tick - begin) // length
        time, step, tick = self.clock.time, self.master.step, self.tick
        t, h = time(tick), self.clock.seconds(length)
        for k in range(count):
            if k:
                t = time(tick)
                for observe in observers:
                    observe(tick, t)
            step(t, h)
            self.tick = tick = tick + length
        return count

    def _observe(self, observers: Sequence[Observer]) -> None:
        t = self.clock.time(self.tick)
        for observe in observers:
            observe(self.tick, t)

    def _arrive(self, observers: Sequence[Observer]) -> None:
        """Do what is to be done at the tick that has been reached, and let the observers see it."""
        for act in self.stops.get(self.tick, ()):
            act()
        self._observe(observers)

    def watch(self, ends: Sequence[Endpoint]) -> slice | None:
        """Where in the `outputs` of batches these outputs will stand; None where observers have to ask the units."""
        return None if self._batches is None else self._batches.watch(ends)

    def halt(self) -> None:
        """Let the observers see the next instant that is reached, even where they need not."""
        if self._batches is not None:
            self._batches.halt()

    def warnings(self) -> list[str]:
        """What a user should know of the steps made so far."""
        return []

    def state(self) -> dict[str, Any]:
        """What the next steps depend on beside tick and master, for a checkpoint."""
        return {}

    def set_state(self, state: Mapping[str, Any]) -> None:
        """Go on from a `state`."""

    # -- batches -----------------------------------------------------------------------------------------------------
    def _take_batch(self, master: Master, length: int, last: int, observers: Sequence[Any]) -> None:
        """Steps of one length up to the next one that has to be looked at, at most to the tick `last`."""
        tick = self.tick
        needs = [o.needs(tick, length) for o in observers]
        n, before = self._size(master, (last - tick) // length, needs)
        taken, unseen = self._taken(length, n, needs)
        if before is not None:
            violations = [o.first_violation(unseen) for o, need in zip(observers, needs, strict=True) if need.finds]
            if steps := [step for step in violations if step is not None]:
                self._restore(before)
                self._take_batch(master, length, tick + (min(steps) + 1) * length, observers)
                return
        if unseen.ticks:
            for observe in observers:
                observe.see(unseen)
        self.tick = tick + len(taken.rows) * length
        if taken.failure is not None:
            raise taken.failure

    def _size(self, master: Master, most: int, needs: Sequence[Needs]) -> tuple[int, Any]:
        """Of how many steps the next batch is, and what takes it back where an observer may find that it was too long."""
        n = min(most, 1 + int(BATCH_SECONDS / self._pace), BATCH_STEPS, *(1 + need.unseen for need in needs if not need.finds))
        to_find = min((1 + need.unseen for need in needs if need.finds), default=n)
        if n <= to_find:
            return n, None
        return (n, self._save(master)) if self._saves(master) else (to_find, None)

    def _taken(self, length: int, n: int, needs: Sequence[Needs]) -> tuple[Steps, Batch]:
        """Take n steps; those at which no observer is called are all but the last, or all that come before a failure."""
        ticks = range(self.tick, self.tick + (n + 1) * length, length)
        times = self.clock.times(ticks)
        sampled = np.array(_steps((need.inputs for need in needs), n), dtype=np.int64)
        saved_steps = _steps((steps for need in needs for steps in need.states), n - 1)
        started, self._under_way = perf_counter(), (ticks, times)
        taken = self.master.take_steps(times[:-1], self.clock.seconds(length), sampled, saved_steps)
        self._under_way = None
        self._pace = max((perf_counter() - started) / n, 1e-7)
        unseen = len(taken.rows) if taken.failure is not None else len(taken.rows) - 1
        at = sampled[sampled < unseen]
        saved = [(ticks[k + 1], times[k + 1], state) for k, state in zip(saved_steps, taken.saved, strict=False)]
        return taken, _batch(ticks, times, unseen, taken, at, saved)

    def rescue(self, observers: Sequence[Any]) -> None:
        """This process is about to end inside of a step: let the observers have the steps of a batch that were completed."""
        if self._batches is None or self._under_way is None:
            return
        taken, (ticks, times) = self._batches.so_far(), self._under_way
        if len(taken.rows):
            batch = _batch(ticks, times, len(taken.rows), taken, NONE)
            for observe in observers:
                observe.see(batch)

    def _saves(self, master: Master) -> bool:
        """Whether steps can be taken back: all units are components whose whole state is known."""
        units = [node.unit for node in master.nodes]
        return all(u.component is not None and (u.name in self._trusted or u.written is not None) for u in units)

    def _save(self, master: Master) -> Any:
        """All that the next steps depend on, and counters of the components."""
        units = [node.unit for node in master.nodes]
        arrays = [unit.component.counts for unit in units if unit.component is not None]
        arrays += [array for unit in units if unit.name not in self._trusted for array in unit.written or ()]
        return self.master.save(), [(array, array.copy()) for array in arrays]

    def _restore(self, saved: Any) -> None:
        """Take back what `_save` gave."""
        state, arrays = saved
        self.master.restore(state)
        for array, values in arrays:
            array[...] = values


def _steps(wanted: Iterable[range], n: int) -> list[int]:
    """Of n steps those that are in one of the ranges."""
    return sorted({k for steps in wanted for k in range(steps.start, min(steps.stop, n), steps.step)})


def _batch(ticks: range, times: np.ndarray, n: int, taken: Steps, at: np.ndarray, saved: Sequence[Any] = ()) -> Batch:
    """The first n steps of those that were taken; ticks, times: from before the first one."""
    return Batch(ticks[1 : n + 1], times[1 : n + 1], taken.rows[:n], taken.outputs[:n], at, taken.inputs[: at.size], saved)


def obstacles(master: Master, account: EnergyAccount | None = None) -> Iterator[str]:
    """What of a scene keeps its macro steps from being one call of the kernels, in the scene's own words."""
    present = {
        "connections of texts": master.texts is not None,
        "master.algorithm": not master.algorithm.acts,
        "master.energy_correction": account is not None and account.correction,
    }
    yield from (words for words, there in present.items() if there)
    for solver in master.loops:
        yield f"the algebraic loop {solver.loop.text}"


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
            if 0 < NO_STEP * (distance % stride) < stride:
                length, count = (stride, count - 1) if count > 1 else (distance, 1)
        elif head == stride:
            length, count = stride, (2 * distance - 3 * stride) // (2 * stride) + 1
        else:
            length = head if 2 * head >= stride else (head + stride) // 2
        yield length, count
        tick += length * count
