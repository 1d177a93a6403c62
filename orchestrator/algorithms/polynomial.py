"""Inputs over a macro step: the polynomial through the last samples, of degree 0 (held), 1 (linear) or 2 (quadratic).

Samples may be unevenly spaced. With fewer samples than the degree needs, the degree is lower: after a start from rest
that costs nothing; otherwise the held first step leaves an error of second order in the macro step, whatever the degree.
"""

from __future__ import annotations

Row = list[float]
Terms = tuple[Row, Row | None, Row | None]  # value, slope, half of the second derivative at the start of the step


class History:
    """The last samples of some inputs, newest first."""

    def __init__(self, degree: int):
        self.degree = degree
        self.samples: list[Row] = []
        self.widths: list[float] = []  # s, from each sample back to the next older one

    def push(self, values: Row, h: float) -> None:
        """Add a sample that lies h behind the newest one."""
        self.widths = [h, *self.widths][: len(self.samples)][: self.degree]
        self.samples = [values, *self.samples][: self.degree + 1]

    def ahead(self) -> Terms:
        """Extrapolation from the present sample."""
        samples = self.samples
        if len(samples) == 1:
            return samples[0], None, None
        h1 = self.widths[0]
        if len(samples) == 2:
            return samples[0], [(a - b) / h1 for a, b in zip(samples[0], samples[1], strict=True)], None
        h2 = self.widths[1]
        present, slopes, halves = samples[0], [], []
        for a, b, c in zip(present, samples[1], samples[2], strict=True):
            d = (a - b) / h1
            half = (d - (b - c) / h2) / (h1 + h2)
            slopes.append(d + half * h1)
            halves.append(half)
        return present, slopes, halves

    def towards(self, fresh: Row, h: float) -> Terms:
        """Interpolation from the present sample to values that are known at the end of the step, h ahead."""
        if self.degree == 0:
            return fresh, None, None
        samples = self.samples
        if self.degree == 1 or len(samples) == 1:
            return samples[0], [(f - a) / h for f, a in zip(fresh, samples[0], strict=True)], None
        h1 = self.widths[0]
        present, slopes, halves = samples[0], [], []
        for f, a, b in zip(fresh, present, samples[1], strict=True):
            d = (f - a) / h
            half = (d - (a - b) / h1) / (h + h1)
            slopes.append(d - half * h)
            halves.append(half)
        return present, slopes, halves
