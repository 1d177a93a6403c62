"""Inputs over a macro step: the polynomial through the last samples, of degree 0 (held), 1 (linear) or 2 (quadratic).

Samples may be unevenly spaced. With fewer samples than the degree needs, the degree is lower: after a start from rest
that costs nothing; otherwise the held first step leaves an error of second order in the macro step, whatever the degree.
"""

from __future__ import annotations

from operator import sub

Row = list[float]
Terms = tuple[Row, Row | None, Row | None]  # value, slope, half of the second derivative at the start of the step


class History:
    """The last samples of some inputs."""

    def __init__(self, degree: int):
        self.degree = degree
        self.count = 0  # samples kept, up to degree + 1
        self.present: Row = []
        self.before: Row = []
        self.earlier: Row = []
        self.h1 = self.h2 = 0.0  # s, from `present` back to `before`, from there back to `earlier`

    def push(self, values: Row, h: float) -> None:
        """Add a sample that lies h behind the newest one."""
        self.earlier, self.before, self.present = self.before, self.present, values
        self.h1, self.h2 = h, self.h1
        if self.count <= self.degree:
            self.count += 1

    def ahead(self) -> Terms:
        """Extrapolation from the present sample."""
        present, h1 = self.present, self.h1
        if self.count == 1:
            return present, None, None
        slopes = [d / h1 for d in map(sub, present, self.before)]
        if self.count == 2:
            return present, slopes, None
        return present, *_bent(slopes, h1, [d / self.h2 for d in map(sub, self.before, self.earlier)], self.h2, h1)

    def towards(self, fresh: Row, h: float) -> Terms:
        """Interpolation from the present sample to values that are known at the end of the step, h ahead."""
        if self.degree == 0:
            return fresh, None, None
        present = self.present
        slopes = [d / h for d in map(sub, fresh, present)]
        if self.degree == 1 or self.count == 1:
            return present, slopes, None
        h1 = self.h1
        return present, *_bent(slopes, h, [d / h1 for d in map(sub, present, self.before)], h1, -h)


def _bent(slopes: Row, h: float, older: Row, older_h: float, behind: float) -> tuple[Row, Row]:
    """(slope, half of the second derivative) of the parabola through three samples, at one end of the newer chord.

    `slopes` over the newer chord of length h, `older` over the one before; `behind`: h at its end, -h at its start.
    """
    width = h + older_h
    halves = [d / width for d in map(sub, slopes, older)]
    return [s + behind * c for s, c in zip(slopes, halves)], halves  # noqa: B905 - strict costs more than the loop
