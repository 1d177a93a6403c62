"""Whether a model explains a measurement: tests of the innovations of its filter, each at a level that all share.

If model and noise are right, normalised innovations are independent with mean 0 and variance 1.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .filtering import Innovations
from .measurements import Measurements
from .model import Unknown
from .suspects import Suspect
from .whiteness import LEAST, white

LEVEL = 0.01  # that a right model is rejected by any of the tests
WINDOWS, SHORTEST = 10, 20  # of the size of innovations: how many, and the least number of innovations in one
NAMED = 3  # findings of one test that a reason names


@dataclass(frozen=True)
class Check:
    """p: probability of a right model to be so far off, for all that the test looks at together.  words: what it says."""

    name: str
    p: float
    words: str
    holds: bool


@dataclass(frozen=True)
class Verdict:
    """checks: all tests.  suspects: numbers that were doubted.  remarks: what is to be known besides."""

    checks: tuple[Check, ...]
    suspects: tuple[Suspect, ...]
    remarks: tuple[str, ...]

    @property
    def explains(self) -> bool:
        """Whether no test says otherwise."""
        return all(check.holds for check in self.checks)

    def __str__(self) -> str:
        if self.explains:
            return "The model explains the measurement."
        reasons = [check.words for check in self.checks if not check.holds]
        return f"The model does not explain the measurement, since {'; '.join(reasons)}."


def verdict(
    measured: Measurements,
    innovations: Innovations,
    unknowns: Sequence[Unknown],
    q: np.ndarray,
    deviations: np.ndarray,
    suspects: Sequence[Suspect],
) -> Verdict:
    """q, deviations: of the unknowns at the end, (p,)."""
    from scipy.stats import chi2, norm

    which, time, e = np.array(innovations.which), np.array(innovations.time), np.array(innovations.normalised)
    names, remarks = measured.signals, []
    tests: list[tuple[str, float, str]] = []  # name of the test, p, words

    known = ~np.isnan(measured.noise)[which]  # what is estimated is as large as it is
    size, n = float(e[known] @ e[known]), int(known.sum())
    if n:
        text = f"innovations are {np.sqrt(size / n):.3g} times as large as model and noise say"
        tests.append(("size of innovations", float(chi2.sf(size, n)), text))
        if chi2.cdf(size, n) < LEVEL:
            remarks.append(f"{text}: noise or disturbances are stated too large, and the bands are too wide")
    parts = [p for p in np.array_split(np.arange(e.size), max(min(WINDOWS, e.size // SHORTEST), 1)) if p.size]
    p = [float(chi2.sf(float(e[k] @ e[k]), k.size)) for k in parts]
    worst = int(np.argmin(p))
    span = parts[worst]
    large = np.sqrt(np.mean(e[span] ** 2))
    text = f"innovations from {time[span[0]]:.4g} to {time[span[-1]]:.4g} s are {large:.3g} times as large as model and noise say"
    tests.append(("size in windows", min(1.0, min(p) * len(p)), text))

    k = int(np.argmax(np.abs(e)))
    text = f"a measurement of {names[which[k]]} at {time[k]:.6g} s is {abs(e[k]):.3g} standard deviations off"
    tests.append(("outliers", min(1.0, 2.0 * float(norm.sf(abs(e[k]))) * e.size), text))

    means, lags = [], []
    for i, name in enumerate(names):
        own = e[which == i]
        z = np.sqrt(own.size) * own.mean() if own.size else 0.0
        means.append(
            (
                2.0 * float(norm.sf(abs(z))),
                f"the mean innovation of {name} is {own.mean() if own.size else 0.0:+.2g} standard deviations",
            )
        )
        if own.size >= LEAST:
            chance, how = white(own)
            lags.append((chance, f"innovations of {name} follow from earlier ones: {how}"))
    for title, pairs in (("mean of innovations", means), ("whiteness", lags)):
        if pairs:
            p_min, text = min(pairs)
            tests.append((title, min(1.0, p_min * len(pairs)), text))

    moved = []
    for u, value, deviation in zip(unknowns, q, deviations, strict=True):
        if not u.walk and (learnt := u.deviation**2 - deviation**2) > 1e-6 * u.deviation**2:
            z = abs(value - u.mean) / np.sqrt(learnt)
            moved.append(
                (
                    2.0 * float(norm.sf(z)),
                    f"{u.name} = {u.bounds.outer(value):.4g} {u.unit} is {z:.2g} standard deviations off what was expected",
                )
            )
    if moved:
        p_min, text = min(moved)
        tests.append(("expected values", min(1.0, p_min * len(moved)), text))
    if suspects:
        p_min = min(1.0, float(chi2.sf(2.0 * suspects[0].gain, 1)) * len(suspects))
        limit = suspects[0].gain / 2.0
        text = ", or ".join(str(s) for s in suspects[:NAMED] if s.gain >= limit)
        tests.append(("other values", p_min, text))
    level = LEVEL / len(tests)
    if (share := float(np.mean(np.array(innovations.between) > 0.1))) > 0.1:
        remarks.append(
            f"between two steps {share:.0%} of the measurements are known to a tenth of their noise at best: reduce master.step"
        )
    return Verdict(tuple(Check(name, p, text, p >= level) for name, p, text in tests), tuple(suspects), tuple(remarks))
