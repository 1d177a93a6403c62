"""A run that becomes unstable is stopped while it does: the miss of an input grows, and with it the input itself.

A coupling that is unstable does not find what its extrapolation foretold, and what it finds instead is larger every time. Both
belong together: a miss alone is a coarse step or noise, growth alone may be a motion that swings up and is followed well. The
same is asked of the energy at power bonds: that the coupling makes it, and more of it every time.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from itertools import pairwise

import numpy as np

from ..engine.algorithms.energy import EnergyAccount, Sums
from ..engine.algorithms.master import Master, Unstable
from ..engine.stepping.observers import BatchObserver

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
    alarms = True

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
        self._values = self._missed = np.zeros(len(self._links))  # largest in the present block
        self._blocks = [_Blocks(np.array(nominal)) for _ in range(KINDS)]
        self._energies = [_Blocks(account.nominal) for _ in range(KINDS)] if account is not None else []
        self._before = account.sums if account is not None else None  # at the last block's end
        self._seen = False  # the looks of the steps to come, see `alarm`

    def __call__(self, tick: int, t: float) -> None:
        self._calls += 1
        if self._calls % self._every:
            return
        rows = [(node.history.present, node.history.present if node.reached is None else node.reached) for node in self._nodes]
        self._look(*self._sizes(np.array([[[v for row in rows for v in row[k]] for k in range(2)]])))
        if self._looks % LOOKS == 0 and (text := self._judge(self._account.sums if self._account is not None else None)):
            raise Unstable(text[0], t, text[1])

    def steps_not_needed(self, tick: int, length: int) -> int:
        """As in `BatchObserver`; up to the end of a block, where they are judged."""
        return LOOKS * self._every - 1 - self._calls % (LOOKS * self._every)

    def looks(self, n: int) -> range:
        """As in `BatchObserver`."""
        return range(self._every - 1 - self._calls % self._every, n, self._every)

    def alarm(self, at: np.ndarray, inputs: np.ndarray) -> int | None:
        """As in `BatchObserver`."""
        kept = vars(self) | {name: [copy(b) for b in vars(self)[name]] for name in ("_blocks", "_energies")}
        mine = (self._calls + at + 1) % self._every == 0
        values, missed, steps, first = *self._sizes(inputs[mine][:, :, self._columns]), at[mine], 0
        while first < len(steps):
            last = first + LOOKS - self._looks % LOOKS
            self._look(values[first:last], missed[first:last])
            if self._looks % LOOKS == 0:
                step = int(steps[last - 1])
                if self._judge(self._account.sums_behind(step) if self._account is not None else None):
                    vars(self).update(kept)
                    return step
            first = last
        self._seen = True
        return None

    def observe_ends(self, at: np.ndarray, inputs: np.ndarray, outputs: np.ndarray) -> None:
        """As in `BatchObserver`."""
        if not self._seen:
            self._look(*self._sizes(inputs[(self._calls + at + 1) % self._every == 0][:, :, self._columns]))
        self._seen = False

    def observe_batch(self, ticks: range, times: np.ndarray, rows: np.ndarray) -> None:
        """As in `BatchObserver`."""
        self._calls += len(ticks)

    def _sizes(self, looks: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Of inputs and where they were led to, (m, 2, links): how large the inputs are, and by how much they were missed."""
        extrapolated = [node.reached is not None for node in self._nodes for _ in node.links]
        return np.abs(looks[:, 0]), np.where(extrapolated, np.abs(looks[:, 0] - looks[:, 1]), 0.0)

    def _look(self, values: np.ndarray, missed: np.ndarray) -> None:
        """Sizes (m, links) into the present block."""
        self._looks += len(values)
        self._values = np.fmax.reduce((self._values, *values))  # fmax: numbers, where there are some
        self._missed = np.fmax.reduce((self._missed, *missed))

    def _judge(self, sums: Sums | None) -> tuple[str, str] | None:
        """Close the block, with the account's sums at its end: the unit that takes what has grown, and how; None: nothing has."""
        block, count = (self._values, self._missed * self._free), self._looks // LOOKS
        self._values = self._missed = np.zeros(len(self._links))
        if (worst := _grown(self._blocks, count, *block)) is not None:
            link, scale = self._links[worst], self._blocks[0].nominal[worst]
            return link.target[0], (f"input {link.target[1]}, from {'.'.join(link.source)}, has grown to {block[0][worst]:.3g} "
                                    f"(nominal {scale:.3g}) and no step comes near to what it foretold, less so every time: the "
                                    "coupling is unstable")
        if self._account is None or sums is None or self._before is None:
            return None
        before, self._before = self._before, sums
        if (span := sums.elapsed - before.elapsed) <= 0.0:
            return None
        powers = np.abs(sums.exchanged - before.exchanged) / span, np.abs(sums.created - before.created) / span
        if (k := _grown(self._energies, count, *powers)) is None:
            return None
        bond = self._account.bonds[k]
        return bond.given[0][0], (f"the coupling makes energy at the bond {bond.text}, more of it every time: "
                                  f"{sums.created[k]:.3g} J so far of {sums.exchanged[k]:.3g} J that went through it")


class _Blocks:
    """The last blocks of one kind: the largest values and misses in each, and the scale of what was before them."""

    def __init__(self, nominal: np.ndarray):
        self.nominal = self.calm = np.array(nominal)
        self.past: list[tuple[np.ndarray, np.ndarray]] = []  # (n,) each
        self.values, self.missed = np.zeros(nominal.size), np.zeros(nominal.size)

    def add(self, values: np.ndarray, missed: np.ndarray) -> None:
        """To the present block."""
        self.values, self.missed = np.maximum(self.values, values), np.maximum(self.missed, missed)

    def close(self) -> tuple[np.ndarray, np.ndarray, int | None]:
        """Largest values and misses of the block that ends here, and which of them has grown like an instability."""
        values, missed = self.values, self.missed
        self.past = [*self.past, (values, missed)]
        self.values = self.missed = np.zeros_like(values)
        if len(self.past) <= BLOCKS - 1:
            return values, missed, None
        beyond, rows = values > BEYOND * self.calm, [row for _, row in self.past]
        self.calm = np.maximum(self.calm, self.past[0][0])
        self.past = self.past[1:]
        if not beyond.any():
            return values, missed, None
        grown = beyond & (missed > MISSED * values) & np.all([new > RISE * old for old, new in pairwise(rows)], axis=0)
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
