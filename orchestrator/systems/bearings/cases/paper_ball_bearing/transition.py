"""From periodic to chaotic motion over the clearance: section, largest Lyapunov exponent and recurrence measures side by side."""

from __future__ import annotations

import math

import numpy as np
from scipy.spatial.distance import pdist
from scipy.stats import spearmanr

from .....harness.analysis.lyapunov import lyapunov_spectrum
from .....harness.analysis.recurrence import Quantification, quantify, recurrence_matrix, standardised
from .....harness.analysis.sections import distinct
from .....harness.validation import Evidence, Runs
from ..lyapunov_sum import INTERVAL, INTERVALS, SAME, SCALES, SPEED, STATES, TRANSIENT, bearing, passages

GAPS = np.arange(0.0, 30.5, 1.0)  # um, radial
RATE = 0.05  # of recurrence, the same in every plot
SAMPLES = 1500
PER_PASSAGE = {"fine": 19.3, "coarse": 3.3}  # samples in the passage of a ball, no whole number: 1 ms, and a natural period
WAIT = 4.0  # s; disturbances of a periodic motion decay with exp(-5 t)
ORDER, CHAOS = -4.0, 5.0  # 1/s, of the largest exponent: below, beyond
DRAWN, PLOTTED = 300, (5.0, 20.0, 30.0)  # states in a recurrence plot; um
SIGNALS = ("displacement_x", "displacement_y", "velocity_x", "velocity_y")


def measure(runs: Runs) -> Evidence:
    """Components stepped alone at 1000 rpm, without unbalance, each from equilibrium."""
    largest = np.array([largest_exponent(gap) for gap in GAPS])
    points = [passages(gap) for gap in GAPS]
    places = np.array([distinct(p, SAME) for p in points])
    matrices = {name: [recurrence(states(gap, n), math.ceil(n)) for gap in GAPS] for name, n in PER_PASSAGE.items()}
    plots = {name: [quantify(m, theiler=math.ceil(PER_PASSAGE[name])) for m in of] for name, of in matrices.items()}
    divergence = [np.array([q.divergence for q in of]) for of in plots.values()]
    first = [first_beyond(largest, 0.0), first_beyond(places, 50.0)]
    first += [first_beyond(d, 2.0 / SAMPLES) for d in divergence]
    measured = {
        "exponent.small": float(largest[GAPS <= 5.0].max()),
        "exponent.30": float(largest[-1]),
        "places.small": float(places[GAPS <= 5.0].max()),
        "places.30": float(places[-1]),
        "agreement": max(first) - min(first),
    }
    for name, of in plots.items():
        measured |= {f"{name}.{n}": v for n, v in separation(largest, of).items()}
    coarse, at = plots["coarse"], np.arange(DRAWN)
    drawn = {
        "gaps": GAPS,
        "passed": np.repeat(GAPS, [len(p) for p in points]),
        "across": np.concatenate([1e6 * p[:, 1] for p in points]),
        "largest": largest,
        "shares": {"DET": [q.determinism for q in coarse], "LAM": [q.laminarity for q in coarse]},
        "fine": [q.determinism for q in plots["fine"]],
        "divergence": divergence[-1],
        "transition": ((first[0], "transition"),),
        **{f"plot.{gap:g}": (at, at, matrices["coarse"][int(np.flatnonzero(gap == GAPS)[0])][:DRAWN, :DRAWN]) for gap in PLOTTED},
        **dict(zip(("first.exponent", "first.places", "first.fine", "first.coarse"), first, strict=True)),
    }
    return Evidence(measured, data=drawn)


def separation(largest: np.ndarray, plots: list[Quantification]) -> dict[str, float]:
    """What recurrence measures make of order and chaos, as the exponents (n,) tell them apart."""
    determinism, divergence, laminarity = (
        np.array([getattr(q, n) for q in plots]) for n in ("determinism", "divergence", "laminarity")
    )
    periodic, chaotic = largest < ORDER, largest > CHAOS
    return {
        "determinism": float(determinism[chaotic].mean() / determinism[periodic].mean()),
        "divergence": float(divergence[chaotic].mean() / divergence[periodic].mean()),
        "laminarity": float(laminarity[chaotic].mean() / laminarity[periodic].mean()),
        "rank": float(spearmanr(largest, determinism).statistic),
        "rate": float(100.0 * max(abs(q.rate / RATE - 1.0) for q in plots)),
    }


def first_beyond(values: np.ndarray, limit: float) -> float:
    """Smallest clearance at which a measure exceeds a limit, um; infinite where none does."""
    beyond = np.flatnonzero(values > limit)
    return float(GAPS[beyond[0]]) if beyond.size else math.inf


def largest_exponent(clearance: float) -> float:
    """Largest Lyapunov exponent over 6 s after 3 s, 1/s; clearance: radial, um."""
    return lyapunov_spectrum(
        bearing(clearance), STATES, SCALES, interval=INTERVAL, intervals=INTERVALS, transient=TRANSIENT, count=1
    ).largest


def states(clearance: float, per_passage: float) -> np.ndarray:
    """Positions and velocities after the transient, so many in the passage of a ball, (SAMPLES, 4); clearance: radial, um."""
    model = bearing(clearance)
    interval = 1.0 / (per_passage * model.geometry.defect_frequencies(SPEED / (2.0 * math.pi))["outer"])
    model.step(0.0, WAIT)
    at, rows = model.output_positions(SIGNALS), np.empty((SAMPLES, len(SIGNALS)))
    for k in range(SAMPLES):
        model.step(WAIT + k * interval, interval)
        rows[k] = model.y[at]
    return rows


def recurrence(rows: np.ndarray, window: int) -> np.ndarray:
    """Recurrence matrix of standardised states (n, d) at the threshold that gives the chosen rate outside a Theiler window."""
    z = standardised(rows)
    n = len(z)
    first, second = np.triu_indices(n, window)
    distances = pdist(z)[n * first - first * (first + 1) // 2 + second - first - 1]
    return recurrence_matrix(z, float(np.quantile(distances, RATE)))
