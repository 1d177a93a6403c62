"""A unit as a master sees it: where its inputs come from and where its outputs go, with its records."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ...units import Simulator
from ...units.interface import PortValues, port_values
from ..coupling import Link
from .memory import Records
from .records import GIVEN, UNKNOWN


@dataclass(frozen=True)
class Samples:
    """Inputs whose sources step together, in every `every`-th macro step: their places, and which of these do not change in one.

    jumping: those that change at instants only; constant: those that are held beside places that move on.
    """

    degree: int
    places: tuple[int, ...]
    every: int = 1
    jumping: tuple[int, ...] = ()
    constant: tuple[int, ...] = ()


def samples_of(degree: int, places: Sequence[int], every: int, held: Sequence[int], moving: Sequence[int] = ()) -> Samples:
    """`moving`: places that move on, which have degree 1 at least, the others beside them the degree that was asked for."""
    jumping = tuple(k for k in places if k in held)
    if degree == 0 and any(k in moving for k in places):
        return Samples(1, tuple(places), every, jumping, tuple(k for k in places if k not in held and k not in moving))
    return Samples(degree if len(jumping) < len(places) else 0, tuple(places), every, jumping)


@dataclass(eq=False)
class Node:
    """One unit in the graph.

    place: of its outputs in the table of signals; extrapolated: so many of its links are, the first ones; sources: cells there of
    what its links take; held: places of inputs that jump
    between steps and never change inside one; follows: the others end where their polynomials do, which the unit takes; direct:
    inputs that outputs depend on at once, and the relative change that is none; every: macro steps to one of its own. Of a unit
    with a rate of its own, own: samples of its inputs and outputs at its own instants; estimates: cells of what others go by.
    look_rows: rows of the program that note its inputs.
    """

    unit: Simulator
    place: slice
    links: tuple[Link, ...]
    extrapolated: int
    sources: tuple[int, ...]
    held: tuple[int, ...]
    follows: bool
    samples: tuple[Samples, ...]
    own: tuple[Samples, Samples] | None = None
    every: int = 1
    estimates: slice | None = None
    direct: list[tuple[int, float]] = field(default_factory=list)
    look_rows: tuple[int, int] = (0, 0)

    def bind(self, records: Records, k: int) -> None:
        """The node's records: the k-th unit, its links and their samples, and those of its other two units if it has a rate."""
        units, links, pasts = records.memory.units, records.memory.links, records.memory.pasts

        def part(array: np.ndarray, unit: int, first: str, count: str) -> np.ndarray:
            return array[int(units[first][unit]) : int(units[first][unit] + units[count][unit])]

        self.index, self._records = k, records
        self.called = k if self.own is None else int(units["slow"][k])  # the record of what steps
        self.unit_record, self.link_records = units[k : k + 1], part(links, k, "first_link", "links")
        self.sample_records = part(pasts, k, "first_past", "pasts")
        self.of_called = units[self.called : self.called + 1], part(links, self.called, "first_link", "links")
        if self.own is not None:
            self._own = part(pasts, self.called, "first_past", "pasts")

    def inputs(self) -> PortValues:
        """Present values of the driven inputs, in the order of `links`."""
        self._look()
        return port_values(self.link_records["looked"])

    def _look(self) -> None:
        self._records.take_rows(self.look_rows, 0.0, 0.0)

    def foreseen(self) -> np.ndarray:
        """Where extrapolation will have taken the inputs, as of the last `FORESEE`, (n,)."""
        return self.link_records["foreseen"]

    def read(self) -> None:
        """The present outputs of the unit into the table of signals."""
        self._records.memory.signals[self.place] = given = self.unit.get()
        if self.estimates is not None:
            self._records.memory.signals[self.estimates] = given

    @property
    def event(self) -> float | None:
        """The first event inside the unit's last step, s; none in a macro step in which it does not step."""
        row = self.unit_record[0]
        return None if row["lost"] or row["count"] else self.unit.event

    @property
    def n_samples(self) -> int:
        """Samples of the inputs that there are."""
        return int(self.sample_records["samples"].max(initial=0))

    @property
    def spans(self) -> tuple[float, ...]:
        """Between the samples of the inputs, s, the newest first."""
        return tuple(float(self.sample_records[name][0]) for name in ("h1", "h2")[: self.n_samples - 1])

    @property
    def ends(self) -> np.ndarray:
        """The inputs behind the last step, and the ends of their polynomials, (2, n)."""
        return np.stack([self.link_records["now"], self.link_records["reached"]])

    def restart(self) -> None:
        """After a jump: the past of the inputs tells nothing any more, their present values are the only sample."""
        self._look()
        links = self.link_records
        links["now"] = links["present"] = links["looked"]
        self.sample_records["samples"], self.sample_records["elapsed"] = 1, 0.0
        if self.own is not None:
            self._own["samples"] = 0
        self.unit.restart()

    def jump(self) -> None:
        """The ends of the polynomials are no guess of the inputs any more."""
        self.unit_record["ends"] = UNKNOWN

    def press(self, k: int, value: float, slope: float) -> None:
        """Over the coming step the k-th input is a line, unless a fault alters it."""
        links = self.link_records
        links["pressed"][k], links["force"][k], links["rate"][k] = 1, value, slope
        self.unit_record["pressed"] = 1

    @property
    def given(self) -> np.ndarray:
        """What the inputs were given in the last step, (n, 5): value, slope, half of the second derivative, degree, jump behind it."""
        return np.stack([self.link_records[name] for name in GIVEN], axis=1)

    @property
    def altered(self) -> bool:
        """Whether faults change any input."""
        return bool(self.link_records["fault"].any())
