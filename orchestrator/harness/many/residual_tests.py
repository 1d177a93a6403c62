"""Whether what a fit has left of its measurements is their noise: run by run, at a level that all tests share."""

from __future__ import annotations

from dataclasses import dataclass
from math import isnan, nan

import numpy as np

from ...estimation.whiteness import LEAST, white
from ..analysis.least_squares import Fit
from .residuals import PointResults, Residuals

LEVEL = 0.01  # that a right model is doubted by any of the tests
RESIDUAL_TESTS = ("run", "measurement", "samples", "rms", "p of size", "p of whiteness", "limit of p")


@dataclass(frozen=True)
class ResidualTest:
    """Of one measurement of a run, "" where there is one run alone. rms: of the residuals over the noise.

    size, whiteness: probabilities of noise alone; NaN where they are not known.  limit: below it, a test says no.  words: what it says.
    """

    run: str
    what: str
    count: int
    rms: float
    size: float
    whiteness: float
    limit: float
    words: str

    @property
    def holds(self) -> bool:
        """Whether the residuals may be noise."""
        return not (self.size < self.limit or self.whiteness < self.limit)

    @property
    def row(self) -> tuple[str | float, ...]:
        """Of a table; "" for what is not known."""
        size, whiteness = ("" if isnan(p) else p for p in (self.size, self.whiteness))
        return (self.run, self.what, self.count, self.rms, size, whiteness, self.limit)


def residual_tests(residuals: Residuals, best: Fit, rows: PointResults) -> tuple[ResidualTest, ...]:
    """Of all measurements at a fit. The size of residuals is tested where the noise is known, and no loss bears outliers.

    Fitted parameters make residuals smaller: the chi square with as many degrees of freedom as samples rejects seldom enough.
    """
    from scipy.stats import chi2

    known = residuals.wanted.noise_known and residuals.wanted.loss == "linear"
    parts = []
    for run, row in zip(residuals.runs, rows.of, strict=True):
        for part in run.parts(row):
            r = part.residuals
            size = float(chi2.sf(r @ r, r.size)) if known else nan
            p, how = white(r) if part.sampled and r.size >= LEAST and r.any() else (nan, "")
            parts.append((run.wanted.condition, part.what, r, size, p, how))
    limit = LEVEL / max(sum((not isnan(f[3])) + (not isnan(f[4])) for f in parts), 1)
    tests = []
    for condition, what, r, size, p, how in parts:
        rms = float(np.sqrt(np.mean(r**2) / best.variance)) if best.variance > 0.0 else 0.0
        words = [f"are {rms:.3g} times as large as the noise"] * (size < limit) + [f"follow from earlier ones: {how}"] * (
            p < limit
        )
        place = f"{condition}: " if condition else ""
        text = f"{place}the model does not explain {what}, since its residuals {' and '.join(words)}" if words else ""
        tests.append(ResidualTest(condition, what, r.size, rms, size, p, limit, text))
    return tuple(tests)
