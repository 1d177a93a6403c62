"""An unstable run is stopped early: the extrapolation error of an input grows, and the input grows with it.

Both conditions are needed. An extrapolation error alone may come from a coarse step or noise. Growth alone may be a motion that is
extrapolated well. For power bonds the two conditions are that the coupling creates energy, and that it creates more each time.

At its end a run is judged by its last looks as well, however few they are (`close`), and for how far extrapolations have missed on the
whole (`missed`): what contacts or stops keep bounded does not grow, but nothing is foretold of it any more. The judgement is that of
`recorded_growth`, of what the monitor has recorded.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ..engine.algorithms.energy import EnergyAccount, Sums
from ..engine.algorithms.master import Master, Unstable
from ..engine.stepping.loop import FOREVER, Batch, BatchObserver, Needs
from .recorded_growth import LOOKS, LookRecord, SeenGrowth
from .run_record import Missed
from .thresholds import ENERGY, UNFOLLOWED

SHORT = 160  # looks that even a short run has


class InstabilityMonitor(BatchObserver):
    """Looks at the inputs now and then; raises `Unstable` with the connection and its growth."""

    EVERY = 29  # macro steps: longer runs are looked at after multiples of it
    RARELY = 3  # at most so many of it

    def __init__(self, master: Master, steps: int, account: EnergyAccount | None = None):
        """`steps`: of the whole run, about."""
        interfaces, self._account = master.coupling.interfaces, account
        often = steps // SHORT
        self._every = self.EVERY * min(often // self.EVERY, self.RARELY) or max(often, 1)
        self._calls = 0
        nodes = [node for node in master.nodes if len(node.held) < len(node.links)]
        self._links = [link for node in nodes for link in node.links]
        self._columns = np.array([n in nodes for n in master.nodes for _ in n.links], dtype=bool)  # among all inputs
        self._master = master
        nominal = np.array([interfaces[link.target[0]].inputs[link.target[1]].nominal for link in self._links])
        self._free = np.array([k not in node.held for node in nodes for k in range(len(node.links))], dtype=bool)
        energies, sums = (None, None) if account is None else (np.array(account.nominal), account.sums)
        self._recorded = LookRecord.nothing(nominal, energies, sums)
        self._ahead: LookRecord | None = None  # behind the steps to come, where nothing has grown in them

    def __call__(self, tick: int, t: float) -> None:
        self._calls += 1
        if self._calls % self._every:
            return
        sums = self._account.sums if self._account is not None else None
        self._recorded, grown = self._judged(self._master.machine.inputs()[None], np.zeros(1, dtype=int), lambda _: sums)
        if grown is not None:
            raise self._unstable(grown, t)

    def needs(self, tick: int, length: int) -> Needs:
        """See `BatchObserver.needs`: up to the end of a block, where inputs are judged."""
        self._ahead = None
        to_block = LOOKS * self._every - 1 - self._calls % (LOOKS * self._every)
        return Needs(to_block, range(self._every - 1 - self._calls % self._every, FOREVER, self._every), finds=True)

    def first_violation(self, batch: Batch) -> int | None:
        """See `BatchObserver.first_violation`; nothing is recorded before `see`, and what is found here is taken over there."""
        record, grown = self._behind(batch, self._account.sums_behind if self._account is not None else lambda _: None)
        self._ahead = record if grown is None else None
        return None if grown is None else grown.step

    def see(self, batch: Batch) -> None:
        """See `BatchObserver.see`."""
        if self._ahead is None:  # no block ends among them, see `needs`
            self._ahead, _ = self._behind(batch, lambda _: None)
        self._recorded, self._ahead = self._ahead, None
        self._calls += len(batch.ticks)

    def _behind(self, batch: Batch, sums: Callable[[int], Sums | None]) -> tuple[LookRecord, SeenGrowth | None]:
        mine = (self._calls + batch.at + 1) % self._every == 0
        return self._judged(batch.inputs[mine], batch.at[mine], sums)

    def _judged(
        self, inputs: np.ndarray, steps: np.ndarray, sums: Callable[[int], Sums | None]
    ) -> tuple[LookRecord, SeenGrowth | None]:
        """`LookRecord.after` of all inputs of the master and where they were led to, (m, 2, all), behind steps (m,)."""
        looks, led = inputs[:, :, self._columns], self._master.extrapolated()[self._columns] & self._free
        missed = np.where(led, np.abs(looks[:, 0] - looks[:, 1]), 0.0)
        return self._recorded.after(looks[:, 0], missed, steps, sums)

    def close(self, t: float) -> None:
        """The run has come to its end: raises `Unstable` where its last looks, or those of a longer end, grow beyond bounds."""
        if (grown := self._recorded.growth_at_end()) is not None:
            raise self._unstable(grown, t)

    def state(self) -> list[Any]:
        """What was recorded, for a checkpoint."""
        return [self._calls, self._recorded]

    def set_state(self, state: Sequence[Any]) -> None:
        """Go on from a `state`."""
        self._calls, self._recorded, self._ahead = state[0], LookRecord.restored(state[1]), None

    def missed(self) -> Missed | None:
        """The input that extrapolation has missed most; None where none was led."""
        if (largest := self._recorded.largest_miss()) is None:
            return None
        link = self._links[largest[0]]
        return Missed(input=".".join(link.target), source=".".join(link.source), share=largest[1])

    def _unstable(self, grown: SeenGrowth, t: float) -> Unstable:
        k, sums = grown.column, grown.sums
        if sums is not None and self._account is not None:
            bond = self._account.bonds[k]
            text = f"the coupling makes energy at the bond {bond.text}, more of it every time: "
            return Unstable(
                bond.given[0][0], t, f"{text}{sums.created[k]:.3g} J so far of {sums.exchanged[k]:.3g} J that went through it"
            )
        link = self._links[k]
        text = (
            f"input {link.target[1]}, from {'.'.join(link.source)}, has grown to {grown.size:.3g} "
            f"(nominal {self._recorded.nominal[k]:.3g}) and no step comes near to what it foretold, less so every time: the "
            "coupling is unstable"
        )
        return Unstable(link.target[0], t, text)


def unfollowed(missed: Missed | None) -> list[str]:
    """What a user should know of inputs of a run that no repetition has judged."""
    if missed is None or missed.share <= UNFOLLOWED:
        return []
    return [
        f"the macro step is too long: extrapolation misses {missed.input} by {100.0 * missed.share:.0f} % of its deviation "
        "(rms), so the coupling may be unstable. Reduce master.step, and let the run be repeated"
    ]


def energy_warnings(account: EnergyAccount | None) -> list[str]:
    """What a user should know of the energy that the coupling has made; account: None of a scene without bonds."""
    if account is None:
        return []
    return [
        f"the coupling made {created:.3g} J at the bond {bond.text}, {100.0 * abs(created) / exchanged:.0f} % of the "
        "energy that went through it. Reduce master.step, or switch on master.energy_correction"
        for bond, created, exchanged in zip(account.bonds, account.created, account.exchanged, strict=True)
        if abs(created) > ENERGY * exchanged
    ]
