"""A run that becomes unstable is stopped while it does: the miss of an input grows, and with it the input itself.

A coupling that is unstable does not find what its extrapolation foretold, and what it finds instead is larger every time. Both
belong together: a miss alone is a coarse step or noise, growth alone may be a motion that swings up and is followed well. The
same is asked of the energy at power bonds: that the coupling makes it, and more of it every time.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..algorithms.energy import EnergyAccount
from ..algorithms.master import Master, Unstable
from .observers import BatchObserver

LOOKS = 4  # in a block, of which the largest values count; and blocks in one of the next, longer kind
KINDS = 3  # of blocks: the longest are for slow growth
SHORT = 160  # looks that even a short run has
BLOCKS = 5  # in a row, each with a larger miss than the one before
RISE = 1.5  # by so much at least
MISSED = 0.1  # of the largest value in the last one: the extrapolation does not follow
BEYOND = 300.0  # times the interface's scale: the nominal value, or what was reached before these blocks; a resonance gives 50


class InstabilityMonitor(BatchObserver):
    """Looks at the inputs now and then; raises `Unstable` with the connection and its growth."""

    EVERY = 29  # macro steps: longer runs are looked at after multiples of it
    RARELY = 3  # at most so many of it

    def __init__(self, master: Master, steps: int, account: EnergyAccount | None = None):
        """`steps`: of the whole run, about."""
        interfaces, self._account = master.coupling.interfaces, account
        often = steps // SHORT
        self._every = self.EVERY * min(often // self.EVERY, self.RARELY) or max(often, 1)
        self._calls = self._looks = 0
        self._nodes = [node for node in master.nodes if len(node.held) < len(node.links)]
        self._links = [link for node in self._nodes for link in node.links]
        self._columns = np.array([n in self._nodes for n in master.nodes for _ in n.links], dtype=bool)  # among all inputs
        nominal = [interfaces[link.target[0]].inputs[link.target[1]].nominal for link in self._links]
        self._free = np.array([k not in node.held for node in self._nodes for k in range(len(node.links))])
        self._values, self._missed = [0.0] * len(self._links), [0.0] * len(self._links)  # largest in the present block
        self._blocks = [_Blocks(np.array(nominal)) for _ in range(KINDS)]
        self._energies = [_Blocks(account.nominal) for _ in range(KINDS)] if account is not None else []
        self._before: tuple[float, np.ndarray, np.ndarray] = (0.0, np.zeros(0), np.zeros(0))
        if account is not None:
            self._before = account.elapsed, account.created, account.exchanged

    def __call__(self, tick: int, t: float) -> None:
        self._calls += 1
        if self._calls % self._every:
            return
        self._looks += 1
        values, missed, k = self._values, self._missed, 0
        for node in self._nodes:  # plain Python: for the few inputs of a usual scene an array takes ten times as long
            present = node.history.present
            for value, reached in zip(present, present if node.reached is None else node.reached, strict=True):
                values[k] = max(values[k], abs(value))
                missed[k] = max(missed[k], abs(value - reached))
                k += 1
        if self._looks % LOOKS:
            return
        block = np.array(values), np.array(missed) * self._free
        self._values, self._missed = [0.0] * k, [0.0] * k
        if (worst := _grown(self._blocks, self._looks // LOOKS, *block)) is not None:
            link, scale = self._links[worst], self._blocks[0].nominal[worst]
            raise Unstable(link.target[0], t, f"input {link.target[1]}, from {'.'.join(link.source)}, has grown to "
                             f"{block[0][worst]:.3g} (nominal {scale:.3g}) and no step comes near to what it foretold, less so "
                             "every time: the coupling is unstable")
        if self._account is not None:
            self._look_at_energy(self._account, t)

    def _look_at_energy(self, account: EnergyAccount, t: float) -> None:
        (elapsed, created, exchanged), self._before = self._before, (account.elapsed, account.created, account.exchanged)
        if (span := account.elapsed - elapsed) <= 0.0:
            return
        powers = np.abs(account.exchanged - exchanged) / span, np.abs(account.created - created) / span
        if (k := _grown(self._energies, self._looks // LOOKS, *powers)) is not None:
            bond = account.bonds[k]
            raise Unstable(bond.given[0][0], t, f"the coupling makes energy at the bond {bond.text}, more of it every time: "
                             f"{account.created[k]:.3g} J so far of {account.exchanged[k]:.3g} J that went through it")

    def steps_not_needed(self, tick: int, length: int) -> int:
        """As in `BatchObserver`; up to the end of a block, where they are judged."""
        return LOOKS * self._every - 1 - self._calls % (LOOKS * self._every)

    def looks(self, n: int) -> range:
        """As in `BatchObserver`."""
        return range(self._every - 1 - self._calls % self._every, n, self._every)

    def observe_ends(self, at: np.ndarray, inputs: np.ndarray, outputs: np.ndarray) -> None:
        """As in `BatchObserver`."""
        looks = inputs[(self._calls + at + 1) % self._every == 0][:, :, self._columns]
        self._looks += len(looks)
        extrapolated = [node.reached is not None for node in self._nodes for _ in node.links]
        missed = np.where(extrapolated, np.abs(looks[:, 0] - looks[:, 1]), 0.0)
        self._values = np.fmax.reduce((self._values, *np.abs(looks[:, 0]))).tolist()  # fmax: numbers, where there are some
        self._missed = np.fmax.reduce((self._missed, *missed)).tolist()

    def observe_batch(self, ticks: range, times: np.ndarray, rows: np.ndarray) -> None:
        """As in `BatchObserver`."""
        self._calls += len(ticks)


class _Blocks:
    """The last blocks of one kind: the largest values and misses in each, and the scale of what was before them."""

    def __init__(self, nominal: np.ndarray):
        self.nominal = self.calm = np.array(nominal)
        self.past: list[np.ndarray] = []  # (2, n) each
        self.values, self.missed = np.zeros(nominal.size), np.zeros(nominal.size)

    def add(self, values: np.ndarray, missed: np.ndarray) -> None:
        """To the present block."""
        np.maximum(self.values, values, out=self.values)
        np.maximum(self.missed, missed, out=self.missed)

    def close(self) -> tuple[np.ndarray, np.ndarray, int | None]:
        """Largest values and misses of the block that ends here, and which of them has grown like an instability."""
        self.past.append(np.array([self.values, self.missed]))
        values, missed = self.past[-1]
        self.values, self.missed = np.zeros_like(values), np.zeros_like(missed)
        if len(self.past) <= BLOCKS - 1:
            return values, missed, None
        whole = np.array(self.past)
        grown = (missed > MISSED * values) & (values > BEYOND * self.calm) & (
            whole[1:, 1] > RISE * whole[:-1, 1]).all(axis=0)
        self.calm = np.maximum(self.calm, self.past.pop(0)[0])
        return values, missed, int(np.argmax(np.where(grown, missed / self.nominal, 0.0))) if grown.any() else None


def _grown(kinds: Sequence[_Blocks], count: int, values: np.ndarray, missed: np.ndarray) -> int | None:
    """Takes the shortest block, the `count`-th one, by absolute values and misses (n,); tells which of them has grown, if any."""
    worst = None
    for blocks in kinds:
        blocks.add(values, missed)
        if blocks is not kinds[0] and count % LOOKS:
            break
        count //= 1 if blocks is kinds[0] else LOOKS
        values, missed, which = blocks.close()
        worst = which if worst is None else worst
    return worst
