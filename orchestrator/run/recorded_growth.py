"""Whether inputs or the energy of bonds grow like an instability, by what was recorded of a run: data that nothing changes, and
functions of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..engine.algorithms.energy import Sums
from .thresholds import BEYOND, BLOCKS, FEWEST_ROWS, HARDLY, MISSED, NOTHING, OVERSHOT, RISE

LOOKS = 4  # in a block, of which the largest values count; and blocks in one of the next, longer kind
LENGTHS = 3  # of blocks: the longest are for slow growth
LAST = LOOKS * BLOCKS  # looks that are judged at the end, and longer ends up to the whole run, in as many parts as
PARTS = 4
OF_WHOLE = 160  # rows of the whole run, and up to twice as many
FROM_REST = 3  # values behind a start, of which an extrapolation (degree 2 at most) may go through the value before


@dataclass(frozen=True)
class SeenGrowth:
    """What has grown like an instability. step: behind which it was seen.  column: of an input, or of a bond if there are `sums`.
    size: of the input."""

    step: int
    column: int
    size: float = 0.0
    sums: Sums | None = None


@dataclass(frozen=True)
class Blocks:
    """Blocks of one kind: the largest values and misses of `size` looks, or of so many blocks of the kind before.

    nominal: (n,).  calm: (n,), the scale of what was before the blocks of `past`.  rows: (m, 2, n), of the block that is not full yet.
    past: the last BLOCKS - 1 blocks.
    """

    nominal: np.ndarray
    size: int
    calm: np.ndarray
    rows: np.ndarray
    past: np.ndarray

    @classmethod
    def of(cls, nominal: np.ndarray, size: int) -> Blocks:
        """Before the first look."""
        none = np.zeros((0, 2, nominal.size))
        return cls(nominal, size, nominal, none, none)

    def add(self, rows: np.ndarray, ends: np.ndarray) -> tuple[Blocks, np.ndarray, np.ndarray, tuple[int, int] | None]:
        """With values and misses (m, 2, n) behind the steps `ends` (m,): the blocks after them, those that they fill, (b, 2, n), and
        behind which steps; and of the first that has grown like an instability the step and the column."""
        pending, rows = len(self.rows), np.concatenate((self.rows, rows))
        count = len(rows) // self.size
        full, ends = rows[: count * self.size], ends[self.size - 1 - pending :: self.size][:count]
        blocks = np.fmax.reduce(full.reshape(count, self.size, *rows.shape[1:]), axis=1, initial=0.0)  # fmax: numbers, if any
        after = replace(self, rows=rows[count * self.size :])
        if not count:
            return after, blocks, ends, None
        known, past = len(self.past), np.concatenate((self.past, blocks))
        judged = past[BLOCKS - 1 :]  # those that have enough before them
        calm = np.maximum.accumulate(np.concatenate((self.calm[None], past[:, 0])))
        after = replace(after, calm=calm[len(judged)], past=past[-(BLOCKS - 1) :])
        if (grown := self._first_grown(judged, past, calm[: len(judged)])) is None:
            return after, blocks, ends, None
        block, column = grown
        return after, blocks, ends, (int(ends[block + BLOCKS - 1 - known]), column)

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


@dataclass(frozen=True)
class LookRecord:
    """What was recorded of a run so far.

    blocks: of inputs; energies: of bonds, if they are counted.  before: sums of the bonds at the end of the last block.
    last: (m, 2, links), sizes and misses of the last looks; whole: of the whole run the largest of some, the earlier, the more.
    origin: (links,), inputs at the first look.  count, moments (4, links): of inputs from there their number, and the sums of them, of
    their squares, of squared misses, and how many have left the origin. An input that is switched on jumps from the value at which it
    stood, and extrapolations through that value miss by the jump, whatever the coupling does: their misses are not counted.
    """

    blocks: tuple[Blocks, ...]
    energies: tuple[Blocks, ...]
    before: Sums | None
    last: np.ndarray
    whole: np.ndarray
    origin: np.ndarray | None
    count: int
    moments: np.ndarray

    @classmethod
    def nothing(cls, nominal: np.ndarray, energies: np.ndarray | None, before: Sums | None) -> LookRecord:
        """Before the first look. nominal: of the inputs, energies: of bonds, W; before: sums of these."""
        bonds = () if energies is None else tuple(Blocks.of(energies, LOOKS if k else 1) for k in range(LENGTHS))
        none = np.zeros((0, 2, nominal.size))
        blocks = (Blocks.of(nominal, LOOKS),) * LENGTHS
        return cls(blocks, bonds, before, none, none, None, 0, np.zeros((4, nominal.size)))

    @classmethod
    def restored(cls, data: Mapping[str, Any]) -> LookRecord:
        """From its fields, as a file has them."""
        blocks = {key: tuple(Blocks(**one) for one in data[key]) for key in ("blocks", "energies")}
        return cls(**{**data, **blocks, "before": data["before"] and Sums(*data["before"])})

    @property
    def nominal(self) -> np.ndarray:
        """Of the inputs, (links,)."""
        return self.blocks[0].nominal

    def after(
        self, inputs: np.ndarray, missed: np.ndarray, steps: np.ndarray, sums: Callable[[int], Sums | None]
    ) -> tuple[LookRecord, SeenGrowth | None]:
        """With looks at inputs (m, links) behind steps (m,), by how much they were missed, (m, links), and the sums of the bonds behind
        a step: the record after them, and what has grown first; None: nothing has."""
        if not len(inputs):
            return self, None
        looks, grown = np.stack((np.abs(inputs), missed), axis=1), list[SeenGrowth]()
        blocks, energies, before = list[Blocks](), list[Blocks](), self.before
        rows, ends = looks, steps
        sizes, closed = looks[:0, 0], list[int]()
        for kind in self.blocks:
            after, rows, ends, which = kind.add(rows, ends)
            if not blocks:
                sizes, closed = rows[:, 0], ends.tolist()
            blocks.append(after)
            if which is not None:
                grown.append(SeenGrowth(*which, size=float(sizes[closed.index(which[0]), which[1]])))
        if self.energies:
            rows, ends, before = _powers(before, [(step, sums(step)) for step in closed], self.energies[0].nominal.size)
        for kind in self.energies:
            after, rows, ends, which = kind.add(rows, ends)
            energies.append(after)
            if which is not None:
                grown.append(SeenGrowth(*which, sums=sums(which[0])))
        record = replace(self._with(inputs, looks), blocks=tuple(blocks), energies=tuple(energies), before=before)
        return record, min(grown, key=lambda one: one.step, default=None)

    def _with(self, inputs: np.ndarray, looks: np.ndarray) -> LookRecord:
        """With moments, the last looks, and of the whole run the largest of pairs, the earlier, the more."""
        whole = np.concatenate((self.whole, looks))
        while len(whole) > 2 * OF_WHOLE:
            pairs = np.maximum(whole[:-1:2], whole[1::2])
            whole = np.concatenate((pairs, whole[-1:])) if len(whole) % 2 else pairs
        origin = inputs[0].copy() if self.origin is None else self.origin
        moved = inputs - origin
        with np.errstate(over="ignore", invalid="ignore"):
            left = self.moments[3] + np.cumsum(moved != 0.0, axis=0)
            missed = np.where(left > FROM_REST, looks[:, 1], 0.0)
            more = np.stack([moved.sum(axis=0), np.square(moved).sum(axis=0), np.square(missed).sum(axis=0)])
            moments = np.concatenate((self.moments[:3] + more, left[-1:]))
        last = np.concatenate((self.last, looks))[-LAST:]
        return replace(self, last=last, whole=whole, origin=origin, count=self.count + len(inputs), moments=moments)

    def growth_at_end(self) -> SeenGrowth | None:
        """What of the last looks, or those of a longer end, grows beyond bounds.

        They may be too few for blocks. So each part must miss more than the one before, and the last by more than the input
        itself: the input comes on the other side of what was foretold, as no motion does that grows by itself.
        """
        ends, length = [self.last], len(self.whole)
        while length > LAST:
            ends.append(self.whole[-length:])
            length //= 2
        return next((growth for looks in ends if (growth := self._grown_by_parts(looks)) is not None), None)

    def _grown_by_parts(self, looks: np.ndarray) -> SeenGrowth | None:
        if len(looks) < 2:
            return None
        each, more = divmod(len(looks), count := min(len(looks), PARTS))
        parts = np.maximum.reduceat(looks, [k * each + min(k, more) for k in range(count)], axis=0)
        values, misses = parts[:, 0], parts[:, 1]
        grown = values[-1] > BEYOND * np.maximum(self.nominal, values[0])
        grown &= (misses[-1] > OVERSHOT * values[-1]) & np.all(misses[1:] > RISE * misses[:-1], axis=0)
        if not grown.any():
            return None
        k = int(np.argmax(np.where(grown, misses[-1] / self.nominal, 0.0)))
        return SeenGrowth(len(looks) - 1, k, float(looks[-1, 0, k]))

    def largest_miss(self) -> tuple[int, float] | None:
        """The input that extrapolation has missed most, and by what share of its deviation (rms); None where none was led."""
        if self.count < FEWEST_ROWS or self.origin is None:
            return None
        with np.errstate(over="ignore", invalid="ignore"):
            mean, square, missed, _ = self.moments / self.count
            size = np.sqrt(np.maximum(square + 2.0 * mean * self.origin + self.origin**2, 0.0))
            scale = np.maximum(np.sqrt(np.maximum(square - mean**2, 0.0)), HARDLY * size)
            shares = np.sqrt(missed) / np.maximum(scale, NOTHING * self.nominal)
        if not np.isfinite(shares).all() or not shares.max(initial=0.0) > 0.0:
            return None
        rounded = [float(f"{s:.6g}") for s in shares.tolist()]  # more digits follow from how many steps were taken at once
        return rounded.index(share := max(rounded)), share


def _powers(before: Sums | None, closed: list[tuple[int, Sums | None]], n: int) -> tuple[np.ndarray, np.ndarray, Sums | None]:
    """Mean powers exchanged and created, W, in the blocks that end behind these steps with these sums, (b, 2, n), those of them that
    took any time, and the last sums. before: at the end of the block before."""
    rows, ends = [], []
    for step, now in closed:
        if before is not None and now is not None and (span := now.elapsed - before.elapsed) > 0.0:
            rows.append(np.abs((now.exchanged - before.exchanged, now.created - before.created)) / span)
            ends.append(step)
        before = now
    return np.array(rows).reshape(len(rows), 2, n), np.array(ends, dtype=int), before
