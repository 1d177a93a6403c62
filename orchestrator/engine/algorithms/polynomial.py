"""Inputs over a macro step: the polynomial through the last samples, of degree 0 (held), 1 (linear) or 2 (quadratic).

Samples may be unevenly spaced. With fewer samples than the degree needs, the degree is lower: after a start from rest
that costs nothing; otherwise the held first step leaves an error of second order in the macro step, whatever the degree.

What changes at instants only is held at its present value (`PartlyHeld`). A place that moves on is extrapolated linearly at
least: held, it is where it was a step ago, while the force that acts there is new. Inputs from units with a rate of their own:
`multirate`.
"""

from __future__ import annotations

from collections.abc import Sequence

from ...units.interface import PortValues
from .rows import Lists, Rows

Terms = tuple[PortValues, PortValues | None, PortValues | None]  # value, slope, half the second derivative at the start


class History:
    """The last samples of some inputs."""

    def __init__(self, degree: int, rows: Rows = Lists):
        self.degree, self.rows = degree, rows
        self.count = 0  # samples kept, up to degree + 1
        self.present: PortValues = None
        self.before: PortValues = None
        self.earlier: PortValues = None
        self.h1 = self.h2 = 0.0  # s, from `present` back to `before`, from there back to `earlier`

    def __copy__(self) -> History:
        new = object.__new__(type(self))  # a fifth of the time that `copy` takes without this
        new.__dict__.update(self.__dict__)
        return new

    def push(self, values: PortValues, h: float) -> None:
        """Add a sample that lies h behind the newest one."""
        self.earlier, self.before, self.present = self.before, self.present, values
        self.h1, self.h2 = h, self.h1
        if self.count <= self.degree:
            self.count += 1

    def restart(self, values: PortValues) -> None:
        """Forget everything but these present values."""
        self.present, self.before, self.earlier, self.count = values, None, None, 1

    def take(self, other: History) -> None:
        """Become a copy of another history of the same inputs; the rows themselves are never changed."""
        self.__dict__.update(other.__dict__)

    def ahead(self) -> Terms:
        """Extrapolation from the present sample."""
        present, h1 = self.present, self.h1
        if self.count == 1:
            return present, None, None
        slopes = self.rows.chord(present, self.before, h1)
        if self.count == 2:
            return present, slopes, None
        return present, *self._bent(slopes, h1, self.rows.chord(self.before, self.earlier, self.h2), self.h2, h1)

    def towards(self, known: PortValues, h: float) -> Terms:
        """Interpolation from the present sample to values that are known at the end of the step, h ahead."""
        if self.degree == 0:
            return known, None, None
        present = self.present
        slopes = self.rows.chord(known, present, h)
        if self.degree == 1 or self.count <= 1:  # none: forgotten behind the present sample, see `MultirateUnit.restart`
            return present, slopes, None
        return present, *self._bent(slopes, h, self.rows.chord(present, self.before, self.h1), self.h1, -h)

    def _bent(self, slopes: PortValues, h: float, older: PortValues, older_h: float, behind: float
              ) -> tuple[PortValues, PortValues]:
        """(slope, half of the second derivative) of the parabola through three samples, at one end of the newer chord.

        `slopes` over the newer chord of length h, `older` over the one before; `behind`: h at its end, -h at its start.
        """
        halves = self.rows.chord(slopes, older, h + older_h)
        return self.rows.shifted(slopes, halves, behind), halves


class PartlyHeld(History):
    """A history of inputs some of which are constant over a step.

    Those that change at instants only keep their present value; others are held beside places that move on, and are at their
    known value where that is known.
    """

    def __init__(self, degree: int, rows: Rows, held: Sequence[int], n: int, constant: Sequence[int] = ()):
        """`held`: positions of those that change at instants among all n.  constant: of those held beside moving places."""
        super().__init__(degree if len(held) < n else 0, rows)
        self.held, self.constant = tuple(held), tuple(constant)
        self._level, self._zeros = (*held, *constant), [0.0] * (len(held) + len(constant))

    def ahead(self) -> Terms:
        return self._levelled(self.present, *super().ahead())

    def towards(self, known: PortValues, h: float) -> Terms:
        rows = self.rows
        values = rows.put(known, self.held, rows.picked(self.present, self.held)) if self.constant else self.present
        return self._levelled(values, *super().towards(known, h))

    def _levelled(self, own: PortValues, values: PortValues, slopes: PortValues | None, halves: PortValues | None) -> Terms:
        """The polynomials, but for those that stay at their `own` value."""
        rows, level = self.rows, self._level
        return (rows.put(values, level, rows.picked(own, level)),
                slopes if slopes is None else rows.put(slopes, level, self._zeros),
                halves if halves is None else rows.put(halves, level, self._zeros))
