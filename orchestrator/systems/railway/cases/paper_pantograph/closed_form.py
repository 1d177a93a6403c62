"""Scatter of the contact force over the speed: the closed form of a wire without mass against runs."""

from __future__ import annotations

import numpy as np

from .....harness.charts.chart import Chart, Panel, Series
from .....harness.validation import Evidence, Question, Runs
from .lumped import SWING, last_force, lumped_run, relative_deviation

SPEEDS = (160.0, 200.0, 250.0, 300.0, 350.0)  # km/h
SMALL, MIDDLE = 0.0125, 0.2  # swing of the stiffness: first order, and half-way to the static truth
LONG = 12.0  # s


def measure(runs: Runs) -> Evidence:
    """Runs with three swings of the stiffness at five speeds."""
    ratio = {(a, v): scatter(a, v) for a in (SMALL, MIDDLE, SWING) for v in SPEEDS}
    measured = {f"order.{v:g}": ratio[SMALL, v] / relative_deviation(v, whole=True) for v in SPEEDS}
    measured |= {f"excess.{a:g}.{v:g}": ratio[a, v] / relative_deviation(v) for a in (MIDDLE, SWING) for v in (250.0, 300.0)}
    # the next order is of a²: what halving the swing leaves of the difference
    near, far = (scatter(a, 250.0) / relative_deviation(250.0) for a in (0.1, 0.2))
    exact = scatter(SMALL, 250.0) / relative_deviation(250.0)
    measured["excess.order"] = (far - exact) / (near - exact)
    x = np.linspace(120.0, 380.0, 131)
    panel = Panel(
        "σ / (a Fm)",
        (
            Series("closed form, first order", x, [relative_deviation(v, whole=True) for v in x]),
            *(Series(f"runs, a = {a:g}", SPEEDS, [ratio[a, v] for v in SPEEDS], "points") for a in (SMALL, MIDDLE, SWING)),
        ),
    )
    chart = Chart(
        "Scatter of the contact force under a lumped catenary",
        "speed, km/h",
        (panel,),
        "σ: standard deviation, "
        "a: swing of the stiffness over its mean, Fm: mean force. The largest is a resonance of the pantograph's "
        "mass on the mean stiffness; the wave speed of the wire, 438 km/h, does not occur in the model.",
    )
    return Evidence(measured, (chart,))


def scatter(swing: float, speed: float) -> float:
    """Standard deviation of the contact force over swing and mean."""
    _, force = last_force(lumped_run(speed, swings=(swing,), stop=LONG))
    return float(force.std() / (swing * force.mean()))


QUESTION = Question(measure)
