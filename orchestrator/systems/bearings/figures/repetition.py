"""Recurrence plot of the motion and its measures."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ....harness.analysis.recurrence import Quantification, line_survival, quantify, recurrence_matrix, standardised
from ....harness.charts.blocks import Cells
from ....harness.charts.chart import Chart, Panel, Picture, Series
from ....harness.charts.style import number
from ..keys import BearingKeys, RecurrenceKeys
from ..records import BearingRecord
from .motion import after
from .scales import Scales

PER_PASSING = 25  # samples between two balls' passings, where the scene does not say
STATES = 1200  # quantified
DRAWN = 500  # in the picture


@dataclass(frozen=True)
class Recurrence:
    """A quantified recurrence matrix. interval: time between its states."""

    matrix: np.ndarray
    measures: Quantification
    interval: float
    begin: float
    threshold: float
    theiler: int
    coordinates: tuple[str, ...]


def quantified(record: BearingRecord, begin: float, keys: BearingKeys) -> Recurrence:
    """Recurrence of displacements and velocities, standardised, over the last states of the run."""
    settings = keys.recurrence or RecurrenceKeys()
    names = tuple(n for n in record.signals if n.startswith(("displacement", "velocity")))
    wished = 1.0 / (PER_PASSING * record.frequencies["outer"]) if record.frequencies else 0.0
    every = max(1, round((wished if settings.interval is None else settings.interval) * record.rate))
    states = np.stack([record.signals[n][after(record, begin)] for n in names], axis=1)
    states = states[::-every][:STATES][::-1]  # the last ones
    threshold, theiler = settings.threshold, settings.theiler
    matrix = recurrence_matrix(standardised(states), threshold)
    interval = every / record.rate
    start = float(record.time[-1]) - interval * (len(states) - 1)
    return Recurrence(matrix, quantify(matrix, theiler=theiler), interval, start, threshold, theiler, names)


def recurrence_chart(recurrence: Recurrence, record: BearingRecord, who: str = "") -> Chart:
    """The recurrence plot, and how many of its diagonal lines have at least a length."""
    scales, n = Scales(record), min(len(recurrence.matrix), DRAWN)
    t = recurrence.begin + recurrence.interval * np.arange(n)
    plot = Panel(scales.time, (), picture=Picture(t, t, recurrence.matrix[:n, :n], palette="binary"), title="Recurrence plot",
                 x_label=scales.time, equal=True)  # fmt: skip
    survival = line_survival(recurrence.matrix, recurrence.theiler)
    panels = [plot]
    if survival.size > 1:
        lengths = recurrence.interval * np.arange(1, survival.size + 1)
        unit = "s" if scales.dimensional else "1"
        line = Series("diagonal lines", lengths, survival)
        panels.append(Panel("number of at least that length", (line,), title="Lengths of the diagonal lines",
                            x_label=f"length, {unit}", logarithmic=True))  # fmt: skip
    coordinates = ", ".join(c.replace("_", " ") for c in recurrence.coordinates)
    text = (
        f"Dark: the states at the two times are at most {recurrence.threshold:g} σ apart ({coordinates}, each over its standard "
        f"deviation σ; Euclidean distance). The first {n} of {len(recurrence.matrix)} states. Long diagonals: the motion "
        "repeats; broken ones: it diverges. Their number falls exponentially, as a straight line here, where the motion is "
        "chaotic."
    )
    return Chart(f"{who}Recurrence", "", tuple(panels), text, columns=2, height=440)


def recurrence_table(recurrence: Recurrence, record: BearingRecord, who: str = "") -> Cells:
    """The measures with the settings they depend on."""
    q, dt = recurrence.measures, recurrence.interval
    unit = "s" if Scales(record).dimensional else "1"
    rows = [
        ("recurrence rate", "RR", number(100.0 * q.rate), "%"),
        ("determinism", "DET", number(100.0 * q.determinism), "%"),
        ("mean length of diagonal lines", "L", number(dt * q.mean_diagonal), unit),
        ("longest diagonal line", "Lmax", number(dt * q.longest_diagonal), unit),
        ("divergence, 1 / Lmax", "DIV", number(q.divergence / dt), f"1/{unit}" if unit != "1" else "1"),
        ("entropy of diagonal lines", "ENTR", number(q.entropy), "nat"),
        ("laminarity", "LAM", number(100.0 * q.laminarity), "%"),
        ("trapping time", "TT", number(dt * q.trapping_time), unit),
    ]
    text = (
        f"{len(recurrence.matrix)} states every {dt:.4g}{' s' if unit == 's' else ''}, threshold {recurrence.threshold:g} σ, "
        f"lines of two points or more, Theiler window {recurrence.theiler}. The measures depend on all of these: compare "
        "only what has the same."
    )
    return Cells(f"{who}Measures of recurrence", ("measure", "", "value", "unit"), rows, text, frozenset({2}))
