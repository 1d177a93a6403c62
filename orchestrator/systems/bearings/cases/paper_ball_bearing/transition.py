"""From periodic to chaotic motion over the clearance: section, largest Lyapunov exponent and recurrence measures side by side."""

from __future__ import annotations

import math

import numpy as np
from scipy.spatial.distance import pdist
from scipy.stats import spearmanr

from .....harness.analysis.lyapunov import lyapunov_spectrum
from .....harness.analysis.recurrence import Quantification, quantify, recurrence_matrix, standardised
from .....harness.analysis.sections import distinct
from .....harness.charts.chart import Chart, Panel, Picture, Series
from .....harness.validation import Evidence, Runs
from ..lyapunov_sum import INTERVAL, INTERVALS, SAME, SCALES, SPEED, STATES, TRANSIENT, bearing, passages

GAPS = np.arange(0.0, 30.5, 1.0)  # um, radial
RATE = 0.05  # of recurrence, the same in every plot
SAMPLES = 1500
PER_PASSAGE = {"fine": 19.3, "coarse": 3.3}  # samples in the passage of a ball, no whole number: 1 ms, and a natural period
WAIT = 4.0  # s; disturbances of a periodic motion decay with exp(-5 t)
ORDER, CHAOS = -4.0, 5.0  # 1/s, of the largest exponent: below, beyond
DRAWN = 300  # states in a recurrence plot
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
    charts = _diagram(points, largest, plots, first[0]), _plots(matrices["coarse"])
    notes = (
        f"First beyond zero: the exponent at {first[0]:g} um; beyond 50 places at {first[1]:g} um; longest line below "
        f"half a record at {first[2]:g} um (fine) and {first[3]:g} um (coarse sampling).",
        "Sampled finely, any smooth motion stays near its past for some samples: DET is high in chaos, too, and does not tell it "
        "from order. Sampled once a natural period, it does.",
    )
    return Evidence(measured, charts, notes=notes)


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


def _diagram(points: list[np.ndarray], largest: np.ndarray, plots: dict[str, list[Quantification]], transition: float) -> Chart:
    section = Series(
        "across the load", np.repeat(GAPS, [len(p) for p in points]), np.concatenate([1e6 * p[:, 1] for p in points]), "dots"
    )
    coarse, fine = plots["coarse"], plots["fine"]
    shares = (
        Series("DET", GAPS, [q.determinism for q in coarse], "line+points"),
        Series("LAM", GAPS, [q.laminarity for q in coarse], "line+points"),
        Series("DET, finely sampled", GAPS, [q.determinism for q in fine], faint=True),
    )
    lengths = (Series("DIV = 1 / Lmax", GAPS, [q.divergence for q in coarse], "line+points"),)
    mark = ((transition, "transition"),)
    return Chart(
        "From order to chaos over the clearance", "radial clearance, um",
        (Panel("position, um", (section,), x_marks=mark, title="once a passing ball"),
         Panel("1/s", (Series("largest exponent", GAPS, largest, "line+points"),), x_marks=mark, title="Lyapunov exponent"),
         Panel("share", shares, x_marks=mark, title=f"recurrence at a rate of {100.0 * RATE:g} %"),
         Panel("1/samples", lengths, x_marks=mark, logarithmic=True)),
        "JIS 6306 at 1000 rpm, no fault and no unbalance. Recurrence of all four states, without neighbours in time.",
        height=230,
    )  # fmt: skip


def _plots(matrices: list[np.ndarray]) -> Chart:
    at = np.arange(DRAWN)
    shown = {gap: matrices[int(np.flatnonzero(gap == GAPS)[0])][:DRAWN, :DRAWN] for gap in (5.0, 20.0, 30.0)}
    pictures = {f"{gap:g} um": Picture(at, at, m, palette="binary") for gap, m in shown.items()}
    panels = tuple(Panel("sample", (), picture=p, title=n, x_label="sample", equal=True) for n, p in pictures.items())
    return Chart(
        "Recurrence plots before, at and beyond the transition",
        "",
        panels,
        "Unbroken diagonals at multiples of the period; broken ones; short pieces and single points.",
        columns=3,
        height=300,
    )
