"""Recurrence quantification of signals whose measures have closed forms: noise, a sine, the logistic map."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from scipy.integrate import quad
from scipy.special import erf
from scipy.stats import norm

from ....harness.analysis.recurrence import Quantification, embed, line_survival, quantify, recurrence_matrix
from ....harness.validation import Evidence, Runs
from ....harness.validation.reference import Row, TableRow

STATES = 2000
REALISATIONS = 10  # of what is random; their mean is compared
NOISE, SINE, CHAOS = "white noise", "sine", "logistic map, r = 4"
NOISE_THRESHOLD = 0.3  # standard deviations
STARTS = np.linspace(0.11, 0.89, REALISATIONS)
PER_PERIOD, SINE_THRESHOLD = 40, 0.5  # samples; radius of the circle is 1
CHAOS_THRESHOLD = 0.01  # of the range
WINDOWS = {3.2: 2, 3.5: 4, 3.83: 3}  # r -> period
NOISE_TOLERANCE = 0.02  # a rate scatters by 2 std(p) / sqrt(n) = 1.5 %, the mean of ten by 0.5 %: four of these
CHAOS_TOLERANCE = 0.03  # what the fold adds is of the order of the threshold, 1 %; the rest is scatter
RELATIVE_ACCURACY = 1e-9
DRAWN = 160  # states in a picture
MEASURES: dict[str, tuple[str, Callable[[Quantification], float]]] = {
    "RR": ("recurrence rate RR", lambda q: q.rate),
    "DET": ("determinism DET", lambda q: q.determinism),
    "L": ("mean diagonal line L", lambda q: q.mean_diagonal),
    "Lmax": ("longest diagonal line Lmax", lambda q: q.longest_diagonal),
    "DIV": ("divergence DIV", lambda q: q.divergence),
    "ENTR": ("entropy of diagonal lines ENTR", lambda q: q.entropy),
    "LAM": ("laminarity LAM", lambda q: q.laminarity),
    "TT": ("trapping time TT", lambda q: q.trapping_time),
}
UNITS = {"L": "samples", "Lmax": "samples", "TT": "samples", "DIV": "1/samples", "ENTR": "nat"}


def measure(runs: Runs) -> Evidence:
    """Measures beside their closed forms, the recurrence plots, and the fall of the number of lines with their length."""
    noise = [recurrence_matrix(x, NOISE_THRESHOLD) for x in np.random.default_rng(1).normal(size=(REALISATIONS, STATES, 1))]
    angle = 2.0 * np.pi / PER_PERIOD * np.arange(STATES)
    sine = [recurrence_matrix(np.stack((np.sin(angle), np.cos(angle)), axis=1), SINE_THRESHOLD)]
    chaos = [recurrence_matrix(uniform(logistic(4.0, s)), CHAOS_THRESHOLD) for s in STARTS]
    rows = _rows(NOISE, _mean(noise, 1), of_noise(NOISE_THRESHOLD), NOISE_TOLERANCE,
                 "closed form for independent normal numbers")  # fmt: skip
    rows += _rows(SINE, _mean(sine, PER_PERIOD // 2), of_circle(STATES, PER_PERIOD, SINE_THRESHOLD), RELATIVE_ACCURACY,
                  "counting chords of the circle")  # fmt: skip
    rows += [_at_least(SINE, "DET", _mean(sine, PER_PERIOD // 2)["DET"], 0.9999, "lines end at the plot's edges only")]
    rows += _rows(CHAOS, _mean(chaos, 1), of_doubling(CHAOS_THRESHOLD), CHAOS_TOLERANCE,
                  "tent map, conjugate to it: distances double, lines have geometric lengths of ratio 1/2")  # fmt: skip
    embedded = [recurrence_matrix(embed(uniform(logistic(4.0, s))[:, 0], 2), CHAOS_THRESHOLD, "maximum") for s in STARTS]
    rows += [_row(CHAOS, "recurrence rate of two delay coordinates, maximum norm", "RR2", "1", _mean(embedded, 1)["RR"],
                  0.5 * of_doubling(CHAOS_THRESHOLD)["RR"], CHAOS_TOLERANCE, "half of the near pairs stay near")]  # fmt: skip
    entropy = -float(np.mean([_slope(line_survival(m)) for m in chaos]))
    rows += [_row(CHAOS, "correlation entropy K2 from the lengths of the lines", "K2", "nat/sample", entropy, np.log(2.0),
                  CHAOS_TOLERANCE, "ln 2, as every Rényi entropy of the map")]  # fmt: skip
    for r, period in WINDOWS.items():
        matrix = recurrence_matrix(logistic(r, 0.3, settle=100_000)[: STATES - STATES % period], 1e-9)
        source = f"a point returns after exactly {period} steps"
        rows += _rows(f"logistic map, r = {r:g}", _mean([matrix], 1), of_period(len(matrix), period), RELATIVE_ACCURACY, source)
    at = np.arange(DRAWN)
    drawn: dict[str, Any] = {n: (at, at, m[0][:DRAWN, :DRAWN]) for n, m in (("noise", noise), ("sine", sine), ("chaos", chaos))}
    for name, matrix, ratio in ((NOISE, noise[0], of_noise(NOISE_THRESHOLD)["RR"]), (CHAOS, chaos[0], 0.5)):
        survival = line_survival(matrix)
        lengths = np.arange(1, survival.size + 1)
        exact = survival[0] * ratio ** (lengths - 1.0)
        drawn[f"{name}.lines"] = {name: (lengths, survival)}
        drawn[f"{name}.exact"] = {f"{name}, exact slope": (lengths[exact >= 0.5], exact[exact >= 0.5])}
    return Evidence(rows=tuple(rows), data=drawn)


def logistic(r: float, start: float, settle: int = 1000, states: int = STATES) -> np.ndarray:
    """Orbit (states, 1) of x -> r x (1 - x) after `settle` steps."""
    x, orbit = start, np.empty((states, 1))
    for k in range(-settle, states):
        if k >= 0:
            orbit[k] = x
        x = r * x * (1.0 - x)
    return orbit


def uniform(x: np.ndarray) -> np.ndarray:
    """The coordinate in which the logistic map at r = 4 is the tent map, and its density even on [0, 1]."""
    return 2.0 / np.pi * np.arcsin(np.sqrt(x))


def of_noise(eps: float) -> dict[str, float]:
    """Independent standard normal numbers, |x - y| <= eps; difference of variance 2, so that RR = erf(eps / 2).

    Along a diagonal the points are independent: geometric lengths. Along a column they share a state x, and are independent
    given it, each recurrent with the probability p(x).
    """
    p = float(erf(0.5 * eps))

    def mean(f: Callable[[float], float]) -> float:
        return float(quad(lambda x: norm.pdf(x) * f(norm.cdf(x + eps) - norm.cdf(x - eps)), -9.0, 9.0, epsabs=1e-12)[0])

    in_lines = mean(lambda q: q * (1.0 - (1.0 - q) ** 2))
    return {
        "RR": p,
        "DET": 1.0 - (1.0 - p) ** 2,
        "L": (2.0 - p) / (1.0 - p),
        "ENTR": -np.log(1.0 - p) - p / (1.0 - p) * np.log(p),
        "LAM": in_lines / p,
        "TT": in_lines / mean(lambda q: (1.0 - q) * q * q),
    }


def of_circle(n: int, per_period: int, eps: float) -> dict[str, float]:
    """A circle of radius 1 sampled evenly, Theiler window of half a period: k steps apart is a chord of 2 sin(pi k / period)."""
    reach = int(np.floor(per_period / np.pi * np.arcsin(0.5 * eps)))
    window = per_period // 2
    steps = np.arange(window, n)
    recurrent = np.minimum(steps % per_period, -steps % per_period) <= reach
    lengths = (n - steps)[recurrent]
    long = lengths[lengths >= 2]
    return {
        "RR": float(2.0 * lengths.sum() / ((n - window) * (n - window + 1))),
        "L": float(long.mean()),
        "Lmax": n - (per_period - reach),
        "DIV": 1.0 / (n - (per_period - reach)),
        "ENTR": float(np.log(long.size)),  # every diagonal has a length of its own
    }


def of_doubling(eps: float) -> dict[str, float]:
    """The tent map with an even density, for small thresholds: a pair that is near stays so with the probability 1/2."""
    return {"RR": 2.0 * eps - eps**2, "DET": 0.75, "L": 3.0, "ENTR": 2.0 * np.log(2.0)}


def of_period(n: int, period: int) -> dict[str, float]:
    """n states, a multiple of the period, all of a period different: full diagonals at every multiple of the period."""
    return {
        "RR": (n / period - 1.0) / (n - 1.0),
        "DET": 1.0,
        "L": 0.5 * n,
        "Lmax": n - period,
        "ENTR": float(np.log(n / period - 1.0)),
        "LAM": 0.0,
    }


def _mean(matrices: Sequence[np.ndarray], theiler: int) -> dict[str, float]:
    measured = [quantify(m, theiler=theiler) for m in matrices]
    return {name: float(np.mean([value(q) for q in measured])) for name, (_, value) in MEASURES.items()}


def _rows(condition: str, measured: dict[str, float], expected: dict[str, float], tolerance: float, source: str) -> list[Row]:
    return [
        _row(condition, MEASURES[name][0], name, UNITS.get(name, "1"), measured[name], value, tolerance, source)
        for name, value in expected.items()
    ]


def _row(
    condition: str, quantity: str, measure: str, unit: str, measured: float, expected: float, tolerance: float, source: str
) -> Row:
    low, high = expected * (1.0 - tolerance), expected * (1.0 + tolerance)
    return Row(TableRow(quantity, measure, condition, unit, low, high, "computed", source), measured)


def _at_least(condition: str, name: str, measured: float, low: float, source: str) -> Row:
    return Row(TableRow(MEASURES[name][0], name, condition, "1", low, None, "computed", source), measured)


def _slope(survival: np.ndarray) -> float:
    """Fall of the logarithm of the number of lines per sample of length, where there are enough to count."""
    enough = np.flatnonzero(survival >= 100)
    return float(np.polyfit(enough, np.log(survival[enough]), 1)[0])
