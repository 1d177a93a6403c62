"""Resistance over the plane of both loads, through the contacts alone: ratios, exponents, the load zone, a maximum."""

from __future__ import annotations

import math

import numpy as np

from ......components.bearings.load_zone import load_integrals
from .....harness.charts.chart import Chart, Panel, Picture, Series
from .....harness.validation.papers import Evidence
from .....harness.validation.questions import Options
from .network import ANGLES, bearing, exponent, resistance

RATIOS = (0.0, 0.5, 1.0, 1.5, 2.0, 3.0)
AXIAL = {"7008C": (200.0, 1000.0), "7210B": (1000.0, 5000.0)}  # N
ZONES = (0.5, 0.7, 1.0, 1.25, 1.67, 2.5)  # epsilon, loaded share of the circumference, projected
LIGHT = 1.0  # N, axial: the contact angle stays what it is without load
FINE = np.linspace(0.0, 3.0, 61)
PLANE = np.geomspace(50.0, 5000.0, 33)  # N


def study(options: Options) -> Evidence:
    """Equilibria of the component under both loads."""
    models = {preset: bearing(preset) for preset in ANGLES}
    measured: dict[str, float] = {}
    for preset, model in models.items():
        for axial in AXIAL[preset]:
            measured |= {f"{preset}.{axial:g}.{r:g}": resistance(model, axial, r * axial) for r in RATIOS}
        measured |= {f"exponent.{preset}.{axial:g}": exponent(model, axial) for axial in (50.0, 1000.0)}
    steep, flat = models["7210B"], models["7008C"]
    measured["exponent.joining"] = exponent(steep, 1000.0, 1.0)
    measured |= {f"zone.{e:g}": zone(e) for e in ZONES}
    curve = np.array([resistance(steep, 1000.0, r * 1000.0) for r in FINE])
    measured["maximum.ratio"] = float(FINE[int(np.argmax(curve))])
    measured["maximum.fall"] = float(100.0 * (1.0 - curve[-1] / curve.max()))
    rising = np.array([resistance(flat, 1000.0, r * 1000.0) for r in FINE])
    measured["flat.rise"] = float(np.diff(rising).min())
    return Evidence(measured, (_plane(models), _lines(models)), notes=(
        "A radial load beside an axial one raises the resistance: a cube root gains less where the load grows than it loses "
        "where it falls. Once balls are free, more radial load presses the few that are left, and the resistance falls again.",
    ), claim="J3")  # fmt: skip


def zone(epsilon: float) -> float:
    """Resistance over that under the same axial load alone, at the radial load that loads a share epsilon; light loads."""
    model = bearing("7210B")
    radial, axial = load_integrals(epsilon)
    tangent = math.tan(math.radians(ANGLES["7210B"]))
    return resistance(model, LIGHT, LIGHT * radial / (axial * tangent)) / resistance(model, LIGHT)


def _plane(models) -> Chart:
    x = np.log10(PLANE)
    panels = []
    for preset, model in models.items():
        values = np.array([[resistance(model, axial, radial) for axial in PLANE] for radial in PLANE])
        picture = Picture(x, x, np.log10(values), "log10 of K/W")
        panels.append(
            Panel("log10 of the radial force in N", (), title=preset, picture=picture, x_label="log10 of the axial force in N")
        )
    return Chart(
        "Resistance of the contacts over both loads",
        "",
        tuple(panels),
        "Along a diagonal, where the ratio of the loads is fixed, the resistance falls with the cube root of the load. "
        "The ridge of the 40 degree bearing is where its balls come off.",
        columns=2,
    )


def _lines(models) -> Chart:
    panels = []
    for preset, model in models.items():
        series = [
            Series(f"{axial:g} N axial", FINE, [resistance(model, axial, r * axial) for r in FINE]) for axial in AXIAL[preset]
        ]
        panels.append(Panel("K/W", tuple(series), title=f"{preset}, {ANGLES[preset]:g} degrees"))
    return Chart(
        "Resistance over the ratio of radial to axial load",
        "radial over axial force",
        tuple(panels),
        "The 40 degree bearing has a maximum, the 15 degree one has none up to three times the axial force.",
        columns=2,
    )
