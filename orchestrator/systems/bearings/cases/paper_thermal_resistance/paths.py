"""Shares of conduction, convection and radiation, and what they do to the law of the cube root."""

from __future__ import annotations

import math

import numpy as np

from ......components.bearings.radiation import STEFAN_BOLTZMANN
from .....harness.charts.chart import Chart, Panel, Series
from .....harness.validation.papers import Evidence
from .....harness.validation.questions import Options
from .network import ANGLES, ANNULUS, BULK, SIDE, bearing, exponent, resistance, shares

HEAVY = 1000.0  # N
LIGHT = (1.0, 1e-3)  # N
OVER = np.geomspace(1.0, 1e4, 17)  # N
AIR, GAP, COEFFICIENT, EMISSIVITY, TEMPERATURE = 0.026, 8e-3, 10.0, 0.2, 300.0  # of the component's defaults
RINGS = {"7008C": (54e-3, 15e-3), "7210B": (70e-3, 20e-3)}  # pitch diameter, width, m


def study(options: Options) -> Evidence:
    """Networks with all paths, with gas between the rings alone, and with the rings in series."""
    measured: dict[str, float] = {}
    for preset in ANGLES:
        whole = shares(preset, HEAVY)
        rest = shares(preset, HEAVY, beside=False, convection=False)
        measured |= {
            f"{preset}.contacts": whole["contacts"],
            f"{preset}.radiation": whole["radiation"],
            f"{preset}.annulus.contacts": rest["contacts"],
            f"{preset}.annulus.radiation": rest["radiation"],
        }
        network = bearing(preset, (*BULK, *SIDE))
        measured |= {f"{preset}.exponent.{f:g}": exponent(network, f) for f in (HEAVY, *LIGHT)}
        series = bearing(preset, BULK)
        measured[f"{preset}.series"] = exponent(series, 5000.0) / exponent(series, 50.0)
        unloaded = resistance(bearing(preset, SIDE, **ANNULUS), 0.0)
        measured[f"{preset}.unloaded"] = unloaded * side_paths(preset) - 1.0
    return Evidence(measured, (_chart(),), notes=(
        "With air in the narrow gap beside the contacts, the groove that follows the ball carries much of the heat: the contacts "
        "have a smaller share than between rings that exchange heat over their distance alone.",
    ), claim="J2")  # fmt: skip


def side_paths(preset: str) -> float:
    """Conductance of an annulus of still air, moving air and radiation between rings at one temperature, W/K."""
    diameter, width = RINGS[preset]
    area = math.pi * diameter * width
    return area * (AIR / GAP + 0.5 * COEFFICIENT + 4.0 * EMISSIVITY * STEFAN_BOLTZMANN * TEMPERATURE**3)


def _chart() -> Chart:
    panels = []
    for preset in ANGLES:
        parts = [shares(preset, float(f)) for f in OVER]
        series = tuple(Series(name, np.log10(OVER), [p[name] for p in parts]) for name in parts[0])
        panels.append(Panel("share of the heat", series, title=preset, y_range=(0.0, 1.0)))
    return Chart(
        "Paths of the heat over the axial force",
        "log10 of the axial force in N",
        tuple(panels),
        "Air at 300 K, beside the contacts, too; 10 W/(m².K) inside the bearing, an exchange factor of 0.2.",
        columns=2,
    )
