"""An unstable run is stopped early: the extrapolation error of an input grows, and the input grows with it.

Both conditions are needed. An extrapolation error alone may come from a coarse step or noise. Growth alone may be a motion that is
extrapolated well. For power bonds the two conditions are that the coupling creates energy, and that it creates more each time.

At its end a run is judged by its last looks as well, however few they are (`close`), and for how far extrapolations have missed on the
whole (`missed`): what contacts or stops keep bounded does not grow, but nothing is foretold of it any more.
"""

from __future__ import annotations

from collections.abc import Callable
from copy import copy
from typing import Any

import numpy as np

from ..engine.algorithms.energy import EnergyAccount, Sums
from ..engine.algorithms.master import Master, Unstable
from ..engine.stepping.loop import FOREVER, Batch, BatchObserver, Needs
from .run_record import Missed
from .thresholds import BEYOND, BLOCKS, ENERGY, FEWEST_ROWS, HARDLY, MISSED, NOTHING, OVERSHOT, RISE, UNFOLLOWED

LOOKS = 4  # in a block, of which the largest values count; and blocks in one of the next, longer kind
KINDS = 3  # of blocks: the longest are for slow growth
SHORT = 160  # looks that even a short run has
LAST = LOOKS * BLOCKS  # looks that are judged at the end, and longer ends up to the whole run, in as many parts as
PARTS = 4
OF_WHOLE = 160  # rows of the whole run, and up to twice as many


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
        self._nodes = [node for node in master.nodes if len(node.held) < len(node.links)]
        self._links = [link for node in self._nodes for link in node.links]
        self._columns = np.array([n in self._nodes for n in master.nodes for _ in n.links], dtype=bool)  # among all inputs
        self._master = master
        nominal = [interfaces[link.target[0]].inputs[link.target[1]].nominal for link in self._links]
        self._free = np.array([k not in node.held for node in self._nodes for k in range(len(node.links))], dtype=bool)
        self._blocks = [_Blocks(np.array(nominal), LOOKS) for _ in range(KINDS)]
        self._energies = [_Blocks(account.nominal, LOOKS if k else 1) for k in range(KINDS)] if account is not None else []
        self._before = account.sums if account is not None else None  # at the last block's end
        self._seen = False  # the looks of the steps to come, see `first_violation`
        self._last = self._whole = np.zeros((0, 2, len(self._links)))  # looks; and of the whole run the largest of some, the
        # earlier, the more
        self._origin: np.ndarray | None = None  # inputs at the first look
        self._count, self._moments = (
            0,
            np.zeros((3, len(self._links))),
        )  # of inputs from there: sums, of squares, and of squared misses

    def __call__(self, tick: int, t: float) -> None:
        self._calls += 1
        if self._calls % self._every:
            return
        looks = self._sizes(self._master.machine.inputs()[None, :, self._columns])
        sums = self._account.sums if self._account is not None else None
        if (grown := self._first_growth(looks, np.zeros(1, dtype=int), lambda _: sums)) is not None:
            raise Unstable(grown[1], t, grown[2])

    def needs(self, tick: int, length: int) -> Needs:
        """See `BatchObserver.needs`: up to the end of a block, where inputs are judged."""
        to_block = LOOKS * self._every - 1 - self._calls % (LOOKS * self._every)
        return Needs(to_block, range(self._every - 1 - self._calls % self._every, FOREVER, self._every), finds=True)

    def first_violation(self, batch: Batch) -> int | None:
        """See `BatchObserver.first_violation`."""
        at, inputs = batch.at, batch.inputs
        kept = vars(self) | {name: [copy(b) for b in vars(self)[name]] for name in ("_blocks", "_energies")}
        mine = (self._calls + at + 1) % self._every == 0
        grown = self._first_growth(
            self._sizes(inputs[mine][:, :, self._columns]),
            at[mine],
            self._account.sums_behind if self._account is not None else lambda _: None,
        )
        if grown is not None:
            vars(self).update(kept)
            return grown[0]
        self._seen = True
        return None

    def see(self, batch: Batch) -> None:
        """See `BatchObserver.see`."""
        if not self._seen:  # no block ends among them, see `needs`
            mine = (self._calls + batch.at + 1) % self._every == 0
            self._first_growth(self._sizes(batch.inputs[mine][:, :, self._columns]), batch.at[mine], lambda _: None)
        self._seen = False
        self._calls += len(batch.ticks)

    def _sizes(self, looks: np.ndarray) -> np.ndarray:
        """Of inputs and where they were led to, (m, 2, links): how large the inputs are, and by how much they were missed."""
        led = self._master.extrapolated()[self._columns] & self._free
        missed = np.where(led, np.abs(looks[:, 0] - looks[:, 1]), 0.0)
        if len(looks):
            self._origin = looks[0, 0].copy() if self._origin is None else self._origin
            moved = looks[:, 0] - self._origin
            self._count += len(looks)
            with np.errstate(over="ignore", invalid="ignore"):
                self._moments = self._moments + np.stack(
                    [moved.sum(axis=0), np.square(moved).sum(axis=0), np.square(missed).sum(axis=0)]
                )
        return np.stack((np.abs(looks[:, 0]), missed), axis=1)

    def close(self, t: float) -> None:
        """The run has come to its end: raises `Unstable` where its last looks, or those of a longer end, grow beyond bounds.

        They may be too few for blocks. So each part must miss more than the one before, and the last by more than the input
        itself: the input comes on the other side of what was foretold, as no motion does that grows by itself.
        """
        self._judge_end(self._last, t)
        length = len(self._whole)
        while length > LAST:
            self._judge_end(self._whole[-length:], t)
            length //= 2

    def _judge_end(self, looks: np.ndarray, t: float) -> None:
        if len(looks) < 2:
            return
        each, more = divmod(len(looks), count := min(len(looks), PARTS))
        parts = np.maximum.reduceat(looks, [k * each + min(k, more) for k in range(count)], axis=0)
        values, misses = parts[:, 0], parts[:, 1]
        grown = values[-1] > BEYOND * np.maximum(self._blocks[0].nominal, values[0])
        grown &= (misses[-1] > OVERSHOT * values[-1]) & np.all(misses[1:] > RISE * misses[:-1], axis=0)
        if grown.any():
            k = int(np.argmax(np.where(grown, misses[-1] / self._blocks[0].nominal, 0.0)))
            unit, text = self._input_text(k, looks[-1][0])
            raise Unstable(unit, t, text)

    def missed(self) -> Missed | None:
        """The input that extrapolation has missed most; None where none was led."""
        if self._count < FEWEST_ROWS or self._origin is None:
            return None
        with np.errstate(over="ignore", invalid="ignore"):
            mean, square, missed = self._moments / self._count
            size = np.sqrt(np.maximum(square + 2.0 * mean * self._origin + self._origin**2, 0.0))
            scale = np.maximum(np.sqrt(np.maximum(square - mean**2, 0.0)), HARDLY * size)
            shares = np.sqrt(missed) / np.maximum(scale, NOTHING * self._blocks[0].nominal)
        if not np.isfinite(shares).all() or not shares.max(initial=0.0) > 0.0:
            return None
        rounded = [
            float(f"{share:.6g}") for share in shares.tolist()
        ]  # more digits follow from how many steps were taken at once
        link = self._links[rounded.index(share := max(rounded))]
        return Missed(input=".".join(link.target), source=".".join(link.source), share=share)

    def _first_growth(
        self, looks: np.ndarray, steps: np.ndarray, sums: Callable[[int], Sums | None]
    ) -> tuple[int, str, str] | None:
        """Looks (m, 2, links) behind steps (m,), and the account's sums behind a step: the first step behind which something has
        grown, the unit that takes it, and how it has grown; None: nothing has."""
        grown: list[tuple[int, str, str]] = []
        self._remember(looks)
        rows, ends = looks, steps
        for k, blocks in enumerate(self._blocks):
            rows, ends, which = blocks.add(rows, ends)
            if k == 0:
                sizes, closed = rows[:, 0], ends.tolist()
            if which is not None:
                grown.append((which[0], *self._input_text(which[1], sizes[closed.index(which[0])])))
        if self._account is not None:
            rows, ends = self._powers(closed, sums)
            for blocks in self._energies:
                rows, ends, which = blocks.add(rows, ends)
                if which is not None:
                    grown.append((which[0], *self._bond_text(which[1], sums(which[0]))))
        return min(grown, key=lambda one: one[0], default=None)

    def _remember(self, looks: np.ndarray) -> None:
        """Keep the last looks, and of the whole run the largest of pairs, the earlier, the more."""
        self._last, whole = np.concatenate((self._last, looks))[-LAST:], np.concatenate((self._whole, looks))
        while len(whole) > 2 * OF_WHOLE:
            pairs = np.maximum(whole[:-1:2], whole[1::2])
            whole = np.concatenate((pairs, whole[-1:])) if len(whole) % 2 else pairs
        self._whole = whole

    def _input_text(self, k: int, sizes: np.ndarray) -> tuple[str, str]:
        link, scale = self._links[k], self._blocks[0].nominal[k]
        return link.target[0], (
            f"input {link.target[1]}, from {'.'.join(link.source)}, has grown to {sizes[k]:.3g} "
            f"(nominal {scale:.3g}) and no step comes near to what it foretold, less so every time: the "
            "coupling is unstable"
        )

    def _bond_text(self, k: int, sums: Any) -> tuple[str, str]:
        bond = self._account.bonds[k]  # type: ignore[union-attr]
        return bond.given[0][0], (
            f"the coupling makes energy at the bond {bond.text}, more of it every time: "
            f"{sums.created[k]:.3g} J so far of {sums.exchanged[k]:.3g} J that went through it"
        )

    def _powers(self, closed: list[int], sums: Callable[[int], Sums | None]) -> tuple[np.ndarray, np.ndarray]:
        """Mean powers exchanged and created, W, in the blocks that end behind these steps, (b, 2, bonds), and those of them that
        took any time."""
        rows, ends = [], []
        for step in closed:
            before, self._before = self._before, sums(step)
            if before is not None and self._before is not None and (span := self._before.elapsed - before.elapsed) > 0.0:
                change = self._before.exchanged - before.exchanged, self._before.created - before.created
                rows.append(np.abs(change) / span)
                ends.append(step)
        return np.array(rows).reshape(len(rows), 2, self._energies[0].nominal.size), np.array(ends, dtype=int)


class _Blocks:
    """Blocks of one kind: the largest values and misses of `size` looks, or of so many blocks of the kind before."""

    def __init__(self, nominal: np.ndarray, size: int):
        self.nominal = self.calm = np.array(nominal)  # calm: the scale of what was before the blocks of `past`
        self.size, self.rows = size, np.zeros((0, 2, nominal.size))  # rows: of the block that is not full yet
        self.past = np.zeros((0, 2, nominal.size))  # the last BLOCKS - 1 blocks

    def add(self, rows: np.ndarray, ends: np.ndarray) -> tuple[np.ndarray, np.ndarray, tuple[int, int] | None]:
        """Values and misses (m, 2, n) behind the steps `ends` (m,): the blocks they fill, (b, 2, n), and behind which steps; and
        of the first that has grown like an instability the step and the column."""
        blocks, ends = self._filled(rows, ends)
        if not len(blocks):
            return blocks, ends, None
        known, past = len(self.past), np.concatenate((self.past, blocks))
        judged = past[BLOCKS - 1 :]  # those that have enough before them
        calm = np.maximum.accumulate(np.concatenate((self.calm[None], past[:, 0])))
        self.calm, self.past = calm[len(judged)], past[-(BLOCKS - 1) :]
        if (grown := self._first_grown(judged, past, calm[: len(judged)])) is None:
            return blocks, ends, None
        block, column = grown
        return blocks, ends, (int(ends[block + BLOCKS - 1 - known]), column)

    def _filled(self, rows: np.ndarray, ends: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The largest of each block that is full now, and the steps behind which they end; the rest waits."""
        pending, rows = len(self.rows), np.concatenate((self.rows, rows))
        count = len(rows) // self.size
        full, self.rows = rows[: count * self.size], rows[count * self.size :]
        blocks = np.fmax.reduce(full.reshape(count, self.size, *rows.shape[1:]), axis=1, initial=0.0)  # fmax: numbers, if any
        return blocks, ends[self.size - 1 - pending :: self.size][:count]

    def _first_grown(self, judged: np.ndarray, past: np.ndarray, calm: np.ndarray) -> tuple[int, int] | None:
        """The first of the judged blocks that is far beyond the scale before it and misses more every time, and its worst column."""
        beyond = judged[:, 0] > BEYOND * calm
        if not beyond.any():
            return None
        rises = past[1:, 1] > RISE * past[:-1, 1]
        grown = beyond & (judged[:, 1] > MISSED * judged[:, 0])
        grown &= np.all([rises[k : k + len(judged)] for k in range(BLOCKS - 1)], axis=0)
        if not grown.any():
            return None
        first = int(np.argmax(grown.any(axis=1)))
        return first, int(np.argmax(np.where(grown[first], judged[first, 1] / self.nominal, 0.0)))


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
