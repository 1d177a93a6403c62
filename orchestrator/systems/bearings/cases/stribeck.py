"""How a load spreads over the balls: Stribeck's number, Sjövall's integrals, and finite numbers of balls."""

from __future__ import annotations

import math

import numpy as np

from .....components.bearings.deep_groove import DeepGrooveBearing
from .....components.bearings.load_zone import load_integrals, stribeck_number
from ....harness.charts.chart import Chart, Panel, Series
from ....harness.validation.case import Findings, compare, function_case
from ....harness.validation.questions import Options
from ....harness.validation.reference import load_table
from ..statics import at_rest

BALLS = (6, 7, 8, 9, 12, 16, 32, 64)
EPSILONS = (0.2, 0.5, 0.8, 1.0, 2.5)
LOAD = 100.0  # N; the shares do not depend on it without clearance, and balls of 2 mm bear twice that each
CLEARANCES = np.linspace(-10e-6, 40e-6, 51)  # m, diametral


def findings(options: Options) -> Findings:
    """Integrals, then the equilibria of bearings with 6 to 64 balls, then one over its clearance."""
    table = load_table("stribeck")
    radial, axial = load_integrals(0.5)
    measured = {"many": stribeck_number(), "integral": radial, "axial": axial / radial}
    for epsilon in EPSILONS:
        measured[f"Jr.{epsilon}"], measured[f"Ja.{epsilon}"] = load_integrals(epsilon)
    for n in BALLS:
        measured[f"on.{n}"], measured[f"midway.{n}"] = (_largest(n, first) for first in (0.0, math.pi / n))
    rule = _largest(9, 0.0, 15e-6, 1000.0)
    notes = (
        "Even and odd numbers of balls approach 4.37 from either side; with the load line between two balls the largest load is "
        "smaller.",
        f"With clearance fewer balls carry: 9 balls of a 6207-like bearing with 15 um under 1 kN give {rule:.2f}, where "
        f"the usual rule of thumb for normal clearance says 5.",
    )
    return Findings(compare(table.rows, measured), charts=(_over_clearance(),), notes=notes)


def _largest(balls: int, first: float, clearance: float = 0.0, load: float = LOAD) -> float:
    """Z Qmax / Fr of a bearing in equilibrium under a load along x, ball 1 at `first` rad from it."""
    small = {"ball_diameter": 2e-3, "pitch_diameter": 60e-3} if balls != 9 or not clearance else {}
    parameters = {"balls": balls, "first_ball": first, "diametral_clearance": clearance, **small}
    model = DeepGrooveBearing(parameters=parameters)
    model.initialize(0.0)
    return balls * float(at_rest(model, np.array([load, 0, 0, 0, 0]), ("tilt_x", "tilt_y")).ball_loads.max()) / load


def _over_clearance() -> Chart:
    series = tuple(
        Series(f"{load:g} N", 1e6 * CLEARANCES, np.array([_largest(9, 0.0, c or 1e-12, load) for c in CLEARANCES]))
        for load in (200.0, 1000.0, 5000.0)
    )
    return Chart(
        "Largest ball load over the clearance", "diametral clearance, um", (Panel("Z Qmax / Fr", series),),
        "Nine balls, one on the load line. A light preload spreads the load over more balls; a heavy one adds to it; "
        "with clearance one ball takes all in the end, and the number is that of the balls.",
    )  # fmt: skip


CASE = function_case(
    "stribeck",
    "Distribution of a load over the balls",
    "Compares the loads of the balls in static equilibrium with closed forms, discrete sums and Sjövall's integrals. It "
    "shows that the component shares a load as rigid rings do, for any number and position of balls; flexible rings and "
    "housings, which share it differently, are not modelled.",
    "bearings",
    findings,
)
