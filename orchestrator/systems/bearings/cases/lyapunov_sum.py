"""Lyapunov exponents of the ball bearing: a sum that is known exactly, and signs that tell order from chaos."""

from __future__ import annotations

import math

import numpy as np

from .....components.bearings.ball_bearing import BallBearing
from ....harness.analysis.lyapunov import Lyapunov, lyapunov_spectrum
from ....harness.analysis.sections import distinct, stroboscopic_points
from ....harness.charts.chart import Chart
from ....harness.report.bifurcation import bifurcation_chart
from ....harness.validation import Evidence, Runs

SPEED = 1000.0 * 2.0 * math.pi / 60.0  # rad/s
STATES, SCALES = (0, 1, 2, 3), (6e-6, 6e-6, 8e-3, 8e-3)  # m, m/s: of the bearing's dimensionless form
INTERVAL = 4e-3  # s, a fifth of a ball's passage
INTERVALS, TRANSIENT = 1500, 750
STUDY = (0.0, 1.0, 2.0, 5.0, 10.0, 15.0, 20.0, 22.5, 25.0, 27.5, 30.0)  # um
SAME = 1e-9  # m, of two places; the motion repeats to rounding, and different places lie 1e-7 m apart or more


def bearing(clearance: float, damping: float = 200.0) -> BallBearing:
    """The JIS 6306 set at 1000 rpm, initialized; clearance: radial, um."""
    parameters = {"clearance.radial_clearance": 1e-6 * clearance, "speed": SPEED, "damping": damping}
    model = BallBearing(["clearance"], parameters)
    model.initialize(0.0)
    return model


def exponents(clearance: float, damping: float = 200.0) -> Lyapunov:
    """The spectrum over 6 s after 3 s."""
    return lyapunov_spectrum(
        bearing(clearance, damping), STATES, SCALES, interval=INTERVAL, intervals=INTERVALS, transient=TRANSIENT
    )


def passages(clearance: float) -> np.ndarray:
    """Position, (300, 2) m, at 300 passages of a ball, after 200 more."""
    model = bearing(clearance)
    period = 1.0 / model.geometry.defect_frequencies(SPEED / (2.0 * math.pi))["outer"]
    return stroboscopic_points(model, period, 300, ("displacement_x", "displacement_y"), transient=200)


def places(clearance: float) -> int:
    """Number of places of the shaft at the passages."""
    return distinct(passages(clearance), SAME)


def measure(runs: Runs) -> Evidence:
    """Components stepped alone; a scene would add nothing but time."""
    by_gap = {gap: exponents(gap) for gap in STUDY}
    measured: dict[str, float] = {"damped.sum": exponents(30.0, 600.0).sum}
    for gap in (0.0, 2.0, 5.0, 30.0):
        measured |= {f"{gap:g}.sum": by_gap[gap].sum, f"{gap:g}.largest": by_gap[gap].largest, f"{gap:g}.places": places(gap)}
    drawn = {"gaps": STUDY, "exponents": {f"exponent {i + 1}": [e.exponents[i] for e in by_gap.values()] for i in range(4)}}
    return Evidence(measured, (_diagram(by_gap),), data=drawn)


def _diagram(by_gap: dict[float, Lyapunov]) -> Chart:
    across = [1e6 * passages(gap)[:, 1] for gap in by_gap]
    return bifurcation_chart(
        "Section of the motion over the clearance, and its largest exponent", "radial clearance, µm", "across the load, µm",
        tuple(by_gap), across, [e.largest for e in by_gap.values()],
        text="Position across the load at 300 passages of a ball. What the exponent says of a motion shows in the points: one or "
        "few below zero, a cloud above.",
    )  # fmt: skip
