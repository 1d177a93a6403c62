"""What a scene settles to at a value of a parameter: a stable orbit, or a motion whose largest Lyapunov exponent is measured.

Exponents after Benettin et al. (1980), by the tangent of one direction along a run, shortened after each period.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ...components.core.errors import StepFailed
from .orbit import Orbit, Shooting

PARTS = 20  # of a run: their means tell how sure the mean of all is
SURE = 2.0  # standard errors of a mean
SETTLING = 5  # a part in so many of the run comes before those that count
MOTION_COLUMNS = ("motion", "stable orbits", "periods", "largest exponent, 1/s", "two standard errors, 1/s")
PERIODIC, CHAOTIC, REGULAR, NEITHER, NONE = "periodic", "chaotic", "no chaos", "exponent near 0", "no run"


class Regime(NamedTuple):
    """value: of the parameter.  stable: so many stable orbits were found there.  periods: of that with the fewest, 0 without any.

    exponent, error: the largest Lyapunov exponent, 1/s, of that orbit by its multipliers, or by tangents along a run with two standard
    errors; NaN where the run failed.
    """

    value: float
    stable: int
    periods: int
    exponent: float
    error: float = 0.0

    def row(self) -> list[float | str]:
        """For `MOTION_COLUMNS`, behind the value."""
        return [self.value, self.kind, self.stable, self.periods, self.exponent, self.error]

    @property
    def kind(self) -> str:
        """ "periodic" where a stable orbit was found; else by the exponent: "chaotic" where it is surely positive."""
        if self.periods:
            return PERIODIC
        if not np.isfinite(self.exponent):
            return NONE
        return CHAOTIC if self.exponent > self.error else REGULAR if self.exponent < -self.error else NEITHER


def motions(
    shooting: Shooting, branches: Sequence[tuple[int, Sequence[Orbit]]], values: Iterable[float], after: int, periods: int
) -> Iterator[Regime]:
    """The motion at each value.

    branches: (periods, orbits).  after, periods: of the run to a motion without an orbit, and of that which measures its exponent.
    """
    single = shooting.multiple
    for value in values:
        attractors: list[tuple[int, float]] = []
        for multiple, points in branches:
            shooting.multiple = multiple
            attractors += ((multiple, exponent_of(orbit)) for orbit in _orbits_at(shooting, points, value) if orbit.stable)
        shooting.multiple = single
        if attractors:
            yield Regime(value, len(attractors), *min(attractors))
        else:
            try:
                yield Regime(value, 0, 0, *exponent(shooting, value, after, periods))
            except StepFailed:
                yield Regime(value, 0, 0, np.nan, np.nan)


def _orbits_at(shooting: Shooting, points: Sequence[Orbit], value: float) -> Iterator[Orbit]:
    """The orbits of a branch at a value of the parameter, where a neighbour of them is stable."""
    for a, b in pairwise(points):
        between = min(a.value, b.value) <= value <= max(a.value, b.value) and (value != b.value or b is points[-1])
        if between and a.value != b.value and (a.stable or b.stable):
            guess = a.unknown + (value - a.value) / (b.value - a.value) * (b.unknown - a.unknown)
            guess[-1] = value
            shooting.near(guess)
            unknown = shooting.solve(guess)
            if unknown is not None and not (orbit := shooting.orbit(unknown)).refused:
                yield orbit


def exponent_of(orbit: Orbit) -> float:
    """Of small deviations from an orbit, 1/s."""
    return float(np.log(np.abs(orbit.multipliers).max()) / orbit.period)


def exponent(shooting: Shooting, value: float, after: int, periods: int) -> tuple[float, float]:
    """The largest Lyapunov exponent of the motion behind `after` periods, over so many more, and two standard errors, 1/s.

    The phase of a forcing and what acts on nothing are left out. Raises `StepFailed`.
    """
    unknown = shooting.start(value, after)
    z, period, _ = shooting.split(unknown)
    cells = shooting.map.cells[shooting.kept]
    size = np.maximum(np.abs(unknown[: cells.size]), 1e-12)
    fixed = np.flatnonzero(shooting.kept) == (-1 if shooting.turning is None else shooting.turning)
    way = np.where(fixed, 0.0, np.random.default_rng(0).standard_normal(cells.size))
    growth = np.zeros(periods)
    block = shooting.map.block
    shooting.map.stand(z)
    for k in range(periods):
        block.seed(cells, (shooting.across @ (way * size))[:, None])
        block.advance(shooting.steps)
        way = np.where(fixed, 0.0, shooting.across @ block.tangents[cells, 0]) / size
        length = np.linalg.norm(way)
        if not length > 0.0:
            return -np.inf, 0.0
        growth[k], way = np.log(length), way / length
    late = growth[periods // SETTLING :]
    means = np.array([part.mean() for part in np.array_split(late, PARTS)]) / period
    return float(means.mean()), float(SURE * means.std(ddof=1) / np.sqrt(PARTS))
