"""Stepping in stretches: many macro steps at once, where nobody needs to look at each of them."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from time import perf_counter
from typing import Any

import numpy as np

from ....components.core.kernels import COMPILED
from ...units.component import ComponentUnit
from ...units.fmu import called_by_address
from ..algorithms import Master
from ..algorithms.energy import EnergyAccount, Meter
from ..algorithms.multirate import MultirateUnit
from ..algorithms.node import Node
from .clock import Clock
from .loop import Observer, Steppable, Stepping, Stops, lengths

LONGEST = 4096  # steps of a batch, whose rows are in memory
PATIENCE = 0.1  # s that a stretch may last: so long Ctrl-C and the progress bar have to wait


class BatchStepping(Stepping):
    """Equal steps in batches, see `algorithms.compiled_loop`; observers are `BatchObserver`s.

    The observers see what they would have seen step by step.
    """

    def __init__(self, master: Steppable, clock: Clock, stride: int, end: int, stops: Stops | None, stretch: Any,
                 halt: np.ndarray):
        """`halt`: what ends a stretch early, see `batch_loop_for`."""
        super().__init__(master, clock, stride, end, stops)
        self.loop, self._halt, self._pace = stretch, halt, PATIENCE  # s of a step, as the last stretch was
        self.watch = stretch.watch

    def halt(self) -> None:
        """As in `Stepping`."""
        self._halt[0] = 1

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
        whole = last - length if last == self.end and self.loop.rates else last  # the last step in batches
        if tick == whole or not self.loop.possible(h):
            self.master.step(self.clock.seconds(tick), h)
            self.tick = tick + length
            return
        unwatched = [1 + o.steps_not_needed(tick, length) for o in observers if not o.alarms]
        alarming = [o for o in observers if o.alarms]
        alarmed = [1 + o.steps_not_needed(tick, length) for o in alarming]
        n = min((whole - tick) // length, 1 + int(PATIENCE / self._pace), LONGEST, *unwatched)
        saved = None
        self.loop.prepare(h)
        if n > min(alarmed, default=n):
            if self.loop.saves:
                saved = self.loop.save()
            else:
                n = min(alarmed)
        ticks = range(tick, tick + (n + 1) * length, length)
        times = self.clock.times(ticks)
        begun = perf_counter()
        looks = np.array(sorted({k for o in observers for k in o.looks(n)}), dtype=np.int64)
        kept = sorted({k for o in observers for k in o.keeps(n - 1)})
        rows, failure = self.loop.run(times[:-1], h, looks, kept)
        self._pace = max((perf_counter() - begun) / n, 1e-7)
        self._halt[0] = 0
        done = len(rows)
        unseen = done if failure is not None else done - 1
        at = looks[looks < unseen]
        inputs, outputs = self.loop.inputs[: at.size], self.loop.outputs[:unseen]
        steps = [o.alarm(at, inputs) for o in alarming] if saved is not None else []
        if alarms := [step for step in steps if step is not None]:
            self.loop.restore(saved)
            self._advance(length, tick + (min(alarms) + 1) * length, observers)
            return
        if unseen > 0:
            saved = [(ticks[k + 1], times[k + 1], state) for k, state in zip(kept, self.loop.kept, strict=False)]
            for observe in observers:
                observe.observe_saved(saved)
                observe.observe_ends(at, inputs, outputs)
                observe.observe_batch(ticks[1 : unseen + 1], times[1 : unseen + 1], rows[:unseen])
        self.tick = ticks[done]
        if failure is not None:
            raise failure


def batch_loop_for(master: Master, halt: np.ndarray, account: EnergyAccount | None = None,
                   trusted: Collection[str] = ()) -> Any:
    """Batches of steps for a master, of components in this process or of FMUs; None where there are `obstacles`.

    `account`: the batches are entered in it. `halt`: (1,) uint8; a number other than 0 ends a batch behind its present step.
    `trusted`: components that save their whole state; of others all that kernels write is kept, if their steps are nothing else.
    """
    if any(obstacles(master, account)):
        return None
    from ..algorithms.compiled_loop import CompiledLoop  # loads Numba

    return CompiledLoop(master, [inner(node) for node in master.nodes], halt, account, trusted)


def inner(node: Node) -> Any:
    """The unit of a node, without its meter and its rate."""
    return node.unit.unit if isinstance(node.unit, (Meter, MultirateUnit)) else node.unit


def obstacles(master: Master, account: EnergyAccount | None = None) -> Iterator[str]:
    """What of a scene keeps its steps out of the compiled loop, in the scene's own words."""
    present = {"Numba, which is missing or switched off": not COMPILED, "connections of texts": master.texts is not None,
               "master.algorithm": not master.batched,
               "master.energy_correction": account is not None and account.correction}
    yield from (words for words, there in present.items() if there)
    for solver in master.loops:
        yield f"the algebraic loop {solver.loop.text}"
    for node in master.nodes:
        unit = inner(node)
        if not (isinstance(unit, ComponentUnit) or called_by_address(unit)):
            yield f"units.{unit.name}, a {unit.kind}" + (" that a fault can take away" if hasattr(unit, "lost") else "")
