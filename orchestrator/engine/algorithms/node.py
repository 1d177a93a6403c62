"""A unit as a master sees it: where its inputs come from, how they are led over a step, where its outputs go."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from ...units import Unit
from ...units.interface import PortValues
from ..coupling import Link
from .multirate import MultirateUnit
from .polynomial import History, Terms
from .rows import Rows


class Alteration:
    """What faults make of a unit's inputs on their way."""

    def __init__(self, changes: Sequence[tuple[int, float | None, float]]):
        """`changes`, one after the other: position of the input, value in its place (None: an offset), offset."""
        self._changes = changes
        together: dict[int, tuple[bool, float]] = {}
        alike = True
        for k, value, offset in changes:
            replaced, before = together.get(k, (False, None))
            alike &= value is not None or before is None or replaced  # a sum of two offsets could differ in the last digit
            together[k] = (True, value) if value is not None else (replaced, offset if before is None else before + offset)
        self.together = together if alike else None  # position -> (whether it is replaced, by what, or its offset)

    def __call__(self, values: PortValues) -> PortValues:
        for k, value, offset in self._changes:
            values[k] = values[k] + offset if value is None else value
        return values


class Node:
    """One unit in the graph: where its inputs come from and where its outputs go in the table of signals."""

    def __init__(self, unit: Unit | MultirateUnit, place: slice, links: Sequence[Link], sources: Sequence[int],
                 table: PortValues, past: History, held: Sequence[int], follows: bool):
        self.unit, self.place = unit, place
        self.held = tuple(held)  # positions of inputs that jump between steps and never change inside one
        self.follows = follows  # inputs end where they are led to: the unit takes polynomials, and none of them is held
        self.links, self.sources = tuple(links), tuple(sources)
        self.rows = past.rows
        self._pick = self.rows.picker(table, sources)
        converted = [(k, link.factor, link.offset) for k, link in enumerate(links) if (link.factor, link.offset) != (1.0, 0.0)]
        self._conversions = converted or None
        self.alter: Callable[[PortValues], PortValues] | None = None  # faults: from the values as they should be to those given
        self.history = past
        self.direct: list[tuple[int, float]] = []  # inputs that outputs depend on at once: position, relative change of none
        self.reached: PortValues | None = None  # where extrapolation has taken the inputs in the last step
        self.known: PortValues | None = None  # or what they were interpolated to: values that others had reached already

    def inputs(self) -> PortValues:
        """Present values of the driven inputs, in the order of `links`."""
        values = self._pick()
        if self._conversions is not None:
            for k, factor, offset in self._conversions:
                values[k] = factor * values[k] + offset
        return values if self.alter is None else self.alter(values)

    def restart(self) -> None:
        """After a jump: the past of the inputs tells nothing any more, their present values are the only sample."""
        self.history.restart(self.inputs())
        if isinstance(self.unit, MultirateUnit):
            self.unit.restart()

    def drive(self, terms: Terms, h: float) -> None:
        """Give the unit its inputs over the coming step, and note where they will end."""
        self.unit.drive(*terms, h)
        self.known = None
        self.reached = self.rows.end(*terms, h)

    def interpolate(self, known: PortValues, h: float) -> None:
        """Give the unit inputs over the coming step that end at values which are known already."""
        self.unit.drive(*self.history.towards(known, h), h)
        self.known, self.reached = known, None

    def outputs_hold(self, values: PortValues) -> bool:
        """Whether the outputs hold for these inputs as they are: none that they depend on at once has moved."""
        reached = self.reached
        return reached is not None and all(
            abs(values[k] - reached[k]) <= change * abs(values[k]) for k, change in self.direct
        )


class SmoothNode(Node):
    """A node whose inputs have no jumps: they start where they have ended, and go to where they should by the end of the step."""

    def restart(self) -> None:
        super().restart()
        self.reached = None  # a jump on purpose remains one

    def drive(self, terms: Terms, h: float) -> None:
        values, slopes, halves = terms
        if self.reached is not None:
            rows, last = self.rows, rows_held(self.rows, self.reached, self.held, values)
            back = rows.chord(values, last, h)
            values, slopes = last, back if slopes is None else rows.shifted(slopes, back, 1.0)
        super().drive((values, slopes, halves), h)


def rows_held(rows: Rows, row: PortValues, held: Sequence[int], values: PortValues) -> PortValues:
    """The row with those of `values` that are held."""
    return rows.put(row, held, rows.picked(values, held)) if held else row
