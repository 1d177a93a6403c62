"""Units that step with every n-th macro step only, over all n of them.

Such a unit steps last of all: when the others have reached the end of the n steps, so that its inputs need no guess but over
the last one. Until then those that it feeds see the polynomial through its own samples, which are n steps apart. The order of
accuracy stays degree + 1; the part of the error that comes from its outputs grows with n^(degree + 1).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from copy import copy
from typing import Any

import numpy as np

from ...units import Unit
from ...units.interface import PortValues
from .polynomial import History, PartlyHeld, Terms
from .rows import Rows

ROUNDING = 1e-12  # relative: of sums of steps against the end of the run


def history(degree: int, rows: Rows, n: int, held: Sequence[int] = (),
            rates: Mapping[int, Iterable[int]] | None = None, moving: Sequence[int] = ()) -> History:
    """A history of n inputs; `held`: those that are held whatever the degree; `rates`: inputs by the n of `every = n`.

    `moving`: places that move on, which have degree 1 at least, the others beside them the degree that was asked for.
    """
    if rates and set(rates) != {1}:
        return Mixed([Part(degree, rows, tuple(at), held, every, moving) for every, at in rates.items()], rows, n)
    if degree == 0 and moving:
        return PartlyHeld(1, rows, held, n, [k for k in range(n) if k not in {*held, *moving}])
    return PartlyHeld(degree, rows, held, n) if held else History(degree, rows)


class Part:
    """Inputs from units of one rate: samples at their own instants, polynomials seen from between them."""

    def __init__(self, degree: int, rows: Rows, at: tuple[int, ...], held: Sequence[int], every: int, moving: Sequence[int] = ()):
        self.at, self.every, self.elapsed = at, every, 0.0  # s, since the last sample
        self.history = history(degree, rows, len(at), [k for k, place in enumerate(at) if place in held],
                               moving=[k for k, place in enumerate(at) if place in moving])

    def push(self, values: PortValues, h: float, due: bool) -> None:
        self.elapsed += h
        if due:
            self.history.push(self.history.rows.picked(values, self.at), self.elapsed)
            self.elapsed = 0.0

    def ahead(self) -> Terms:
        return self._seen(*self.history.ahead())

    def towards(self, known: PortValues, h: float) -> Terms:
        return self._seen(*self.history.towards(self.history.rows.picked(known, self.at), self.elapsed + h))

    def _seen(self, values: PortValues, slopes: PortValues | None, halves: PortValues | None) -> Terms:
        """The polynomial from the present instant instead of from the last sample."""
        rows, e = self.history.rows, self.elapsed
        if slopes is None or e == 0.0:
            return values, slopes, halves
        return rows.end(values, slopes, halves, e), slopes if halves is None else rows.shifted(slopes, halves, 2.0 * e), halves


class Mixed(History):
    """A history of inputs from units that step at different rates: each of them only counts where its unit has stepped."""

    def __init__(self, parts: Sequence[Part], rows: Rows, n: int):
        super().__init__(0, rows)
        self.parts, self.n, self.pushes = tuple(parts), n, 0

    def __copy__(self) -> Mixed:
        """With parts of its own: they change with every sample."""
        new = Mixed([copy(part) for part in self.parts], self.rows, self.n)
        for part in new.parts:
            part.history = copy(part.history)
        new.present, new.h1, new.count, new.pushes = self.present, self.h1, self.count, self.pushes
        return new

    def push(self, values: PortValues, h: float) -> None:
        for part in self.parts:
            part.push(values, h, self.pushes % part.every == 0)
        self.present, self.h1, self.count = values, h, 1
        self.pushes += 1

    def restart(self, values: PortValues) -> None:
        for part in self.parts:
            part.history.restart(self.rows.picked(values, part.at))
            part.elapsed = 0.0
        self.present = values

    def take(self, other: History) -> None:
        self.__dict__.update(copy(other).__dict__)

    def ahead(self) -> Terms:
        return self._together([part.ahead() for part in self.parts])

    def towards(self, known: PortValues, h: float) -> Terms:
        """Towards what units have reached that step now; the others have nothing new, their polynomials go on."""
        return self._together([part.towards(known, h) if self.pushes % part.every == 0 else part.ahead() for part in self.parts])

    def _together(self, terms: Sequence[Terms]) -> Terms:
        def whole(k: int) -> PortValues | None:
            if all(term[k] is None for term in terms):
                return None
            row = self.rows.zeros(self.n)
            for part, term in zip(self.parts, terms, strict=True):
                if term[k] is not None:
                    row = self.rows.put(row, part.at, term[k])
            return row

        return whole(0), whole(1), whole(2)


class MultirateUnit:
    """A unit with a rate of its own, in the place of the unit: it takes part in every macro step, and steps in every n-th.

    `own`: history of its inputs at its own instants; `past`: of its outputs. `estimates`: where in the table of signals the
    values of its outputs stand that the others go by; its own place holds what it really gave.
    """

    def __init__(self, unit: Unit, every: int, own: History, past: History, signals: PortValues, estimates: slice, end: float):
        self.unit, self.name, self.every = unit, unit.name, every
        self._own, self._past, self._signals, self.estimates, self._end = own, past, signals, estimates, end
        self._count = 0  # macro steps since its own instant
        self._t0 = self._length = 0.0  # s, that instant, and how far behind it the others are
        self._given: PortValues = []  # what it gave there
        self._aim: PortValues | None = None  # where its inputs are now

    @property
    def event(self) -> float | None:
        """The first event inside its last step, asked for after it has stepped."""
        return None if self._count else self.unit.event

    def initialize(self, t: float, values: PortValues) -> None:
        self.unit.initialize(t, values)

    def start(self) -> None:
        self.unit.start()

    def drive(self, values: PortValues, slopes: PortValues | None, halves: PortValues | None, h: float) -> None:
        """Note where the inputs are at the end of the macro step; the unit gets them when it steps."""
        if self._count == 0:
            self._own.push(values, self._length)
        self._aim = self._own.rows.end(values, slopes, halves, h)

    def step(self, t: float, h: float) -> None:
        if self._count == 0:
            self._past.push(self._given, self._length)
            self._t0 = t
        self._count += 1
        equal = self._count == 1 or self._length == (self._count - 1) * h  # then no difference of times rounds the length
        self._length = self._count * h if equal else self._length + h
        if self._count == self.every or t + h >= self._end * (1.0 - ROUNDING):
            if self._aim is not None:
                self.unit.drive(*self._own.towards(self._aim, self._length), self._length)
            self.unit.step(self._t0, self._length)
            self._count = 0

    def update(self, values: PortValues) -> None:
        if self._count == 0:  # between its instants its outputs are what the polynomial says
            self.unit.update(values)

    def get(self) -> PortValues:
        if self._count == 0:
            self._given = self.unit.get().copy()
            self._signals[self.estimates] = self._given
        else:
            past = self._past
            self._signals[self.estimates] = past.rows.end(*past.ahead(), self._length)
        return self._given

    def jacobian(self) -> np.ndarray:
        """Derivatives at the unit's own instant."""
        return self.unit.jacobian()

    def restart(self) -> None:
        """The inputs have jumped: what was before tells nothing of the steps to come."""
        self._own.count = 0

    @property
    def histories(self) -> tuple[History, History]:
        """Of its inputs and of its outputs, at its own instants."""
        return self._own, self._past

    @property
    def progress(self) -> tuple[int, float, float]:
        """Macro steps since its own instant, that instant, and how far behind it the others are, s."""
        return self._count, self._t0, self._length

    def advance(self, count: int, t0: float, length: float, given: PortValues) -> None:
        """Compiled code has come to this `progress`, with these outputs at the last instant of the unit's own."""
        self._count, self._t0, self._length, self._given = count, t0, length, given

    def hold(self) -> None:
        """The unit is lost: the others go by what it has given last, no more by a guess."""
        self._past.restart(self._given)
        self._signals[self.estimates] = self._given

    def save(self, reuse: Any = None) -> Any:
        kept = {name: value for name, value in vars(self).items() if name.startswith("_") and name != "_signals"}
        return self.unit.save(reuse and reuse[0]), kept | {"_own": copy(self._own), "_past": copy(self._past)}

    def restore(self, state: Any) -> None:
        inner, kept = state
        self.unit.restore(inner)
        vars(self).update(kept | {"_own": copy(kept["_own"]), "_past": copy(kept["_past"])})

    def release(self, state: Any) -> None:
        self.unit.release(state[0])
