"""Stepping in batches: many macro steps at once, where nobody needs to look at each of them."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from time import perf_counter
from typing import Any

import numpy as np

from ...units.component import ComponentSimulator
from ..algorithms import Master
from ..algorithms.energy import EnergyAccount
from .clock import Clock
from .loop import Observer, Stepping, Stops, lengths

LONGEST = 4096  # steps of a batch, whose rows are in memory
PATIENCE = 0.1  # s that a batch may last: so long Ctrl-C and the progress bar have to wait


class BatchStepping(Stepping):
    """Equal steps in batches, of a master `in_batches`; observers are `BatchObserver`s.

    The observers see what they would have seen step by step.
    """

    def __init__(
        self,
        master: Master,
        account: EnergyAccount | None,
        clock: Clock,
        stride: int,
        end: int,
        stops: Stops | None = None,
        trusted: Collection[str] = (),
    ):
        """`trusted`: components that save their whole state; of others all that kernels write is kept, if their steps are nothing
        else."""
        super().__init__(account or master, clock, stride, end, stops)
        self._stepper, self._master, self._trusted = account or master, master, trusted
        self._pace = PATIENCE  # s of a step, as the last batch was
        self.watch = master.watch
        self._under_way: tuple[range, np.ndarray] | None = None  # ticks and times of the batch that is being taken

    def halt(self) -> None:
        """As in `Stepping`."""
        self._master.halt()

    def _approach(self, stop: int, observers: Sequence[Observer]) -> None:
        for length, count in lengths(self.tick, stop, self.stride, stop == self.end):
            last = self.tick + length * count
            while self.tick < min(last, stop):
                self._advance(length, min(last, stop), observers)
                if self.tick < stop:
                    t = self.clock.seconds(self.tick)
                    for observe in observers:
                        observe(self.tick, t)
        self._arrive(observers)

    def _advance(self, length: int, last: int, observers: Sequence[Any]) -> None:
        """Steps of one length up to the next that has to be looked at, at most to the tick `last`."""
        tick, h = self.tick, self.clock.seconds(length)
        unwatched = [1 + o.steps_not_needed(tick, length) for o in observers if not o.alarms]
        alarming = [o for o in observers if o.alarms]
        alarmed = [1 + o.steps_not_needed(tick, length) for o in alarming]
        n = min((last - tick) // length, 1 + int(PATIENCE / self._pace), LONGEST, *unwatched)
        saved = None
        if n > min(alarmed, default=n):
            if self._saves:
                saved = self._save()
            else:
                n = min(alarmed)
        ticks = range(tick, tick + (n + 1) * length, length)
        times = self.clock.times(ticks)
        begun = perf_counter()
        looks = np.array(sorted({k for o in observers for k in o.looks(n)}), dtype=np.int64)
        kept = sorted({k for o in observers for k in o.keeps(n - 1)})
        self._under_way = ticks, times
        taken = self._stepper.run_steps(times[:-1], h, looks, kept)
        self._under_way = None
        self._pace = max((perf_counter() - begun) / n, 1e-7)
        done = len(taken.rows)
        unseen = done if taken.failure is not None else done - 1
        at = looks[looks < unseen]
        inputs, outputs = taken.inputs[: at.size], taken.outputs[:unseen]
        steps = [o.alarm(at, inputs) for o in alarming] if saved is not None else []
        if alarms := [step for step in steps if step is not None]:
            self._restore(saved)
            self._advance(length, tick + (min(alarms) + 1) * length, observers)
            return
        if unseen > 0:
            saved = [(ticks[k + 1], times[k + 1], state) for k, state in zip(kept, taken.kept, strict=False)]
            for observe in observers:
                observe.observe_saved(saved)
                observe.observe_ends(at, inputs, outputs)
                observe.observe_batch(ticks[1 : unseen + 1], times[1 : unseen + 1], taken.rows[:unseen])
        self.tick = ticks[done]
        if taken.failure is not None:
            raise taken.failure

    def rescue(self, observers: Sequence[Any]) -> None:
        """This process is about to end in a batch: let the observers have the steps that were completed."""
        taken = self._master.so_far()
        if not len(taken.rows) or self._under_way is None:
            return
        ticks, times = self._under_way
        n = len(taken.rows)
        for observe in observers:
            observe.observe_ends(np.zeros(0, dtype=np.int64), taken.inputs[:0], taken.outputs)
            observe.observe_batch(ticks[1 : n + 1], times[1 : n + 1], taken.rows)

    @property
    def _components(self) -> list[ComponentSimulator]:
        return [unit for node in self._master.nodes if isinstance(unit := node.unit, ComponentSimulator)]

    @property
    def _saves(self) -> bool:
        """Whether steps can be taken back: all units are components whose whole state is known."""
        components = self._components
        return len(components) == len(self._master.nodes) and all(
            u.name in self._trusted or u.written is not None for u in components
        )

    def _save(self) -> Any:
        """All that the next steps depend on, and counters of the components."""
        arrays = [unit.component.counts for unit in self._components]
        arrays += [array for unit in self._components if unit.name not in self._trusted for array in unit.written or ()]
        return self.master.save(), [(array, array.copy()) for array in arrays]

    def _restore(self, saved: Any) -> None:
        """Take back what `_save` gave."""
        state, arrays = saved
        self.master.restore(state)
        for array, values in arrays:
            array[...] = values


def obstacles(master: Master, account: EnergyAccount | None = None) -> Iterator[str]:
    """What of a scene keeps its macro steps from being one call of the kernels, in the scene's own words."""
    present = {
        "connections of texts": master.texts is not None,
        "master.algorithm": not master.batched,
        "master.energy_correction": account is not None and account.correction,
    }
    yield from (words for words, there in present.items() if there)
    for solver in master.loops:
        yield f"the algebraic loop {solver.loop.text}"
