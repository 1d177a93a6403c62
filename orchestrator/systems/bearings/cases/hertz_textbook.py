"""Elliptic contacts, curvature sums, stiffnesses and films of textbook bearings."""

from __future__ import annotations

import math

import numpy as np

from .....components.bearings.film import Lubricant, entrainment_speed, film_thickness
from .....components.bearings.geometry import BallGeometry
from .....components.bearings.hertz import brewe_hamrock, effective_modulus, exact_ellipse, point_contact
from ....harness.validation import Evidence, Runs

RATIOS = (1.0001, 2.0, 5.0, 10.0, 20.0, 32.35, 100.0)  # Ry / Rx
NEWTON_PER_MM = 10.0**4.5  # N/m^1.5 in 1 N/mm^1.5
HARRIS = {
    "209": BallGeometry(9, 0.0127, 0.065, 0.52, 0.52),
    "218": BallGeometry(16, 0.022225, 0.12526, 0.5232, 0.5232, math.radians(40.0)),
}
HARRIS_MODULUS = effective_modulus(2.0685e11, 0.3, 2.0685e11, 0.3)
HAMROCK = BallGeometry(9, 0.0127, 0.5 * (0.052291 + 0.077706), 0.52, 0.52)
HAMROCK_MODULUS = effective_modulus(2e11, 0.3, 2e11, 0.3)
HAMROCK_LOAD, HAMROCK_SPEED, HAMROCK_OIL = 4944.0, 400.0, Lubricant(0.04, 2.3e-8)  # N a ball, rad/s


def measure(runs: Runs) -> Evidence:
    """Every number of the table by the code the components use."""
    ratios = np.geomspace(1.0, 120.0, 200)
    drawn = {
        "ratios": np.log10(ratios),
        "errors": [_fit_error(float(r)) for r in ratios],
        "races": ((math.log10(21.75), "outer race"), (math.log10(32.3), "inner race")),
    }
    return Evidence(_ellipses() | _harris() | _hamrock(), data=drawn)


def _fit_error(ratio: float) -> float:
    """Stiffness by the fit of Brewe and Hamrock less the exact one, %."""
    fit, exact = (point_contact(1.0, ratio, 1.0, ellipse).stiffness for ellipse in (brewe_hamrock, exact_ellipse))
    return 100.0 * (fit / exact - 1.0)


def _ellipses() -> dict[str, float]:
    measured: dict[str, float] = {}
    for ratio in RATIOS:
        shape = exact_ellipse(ratio)
        measured |= {f"{ratio:g}.k": shape.k, f"{ratio:g}.second": shape.second, f"{ratio:g}.first": shape.first,
                     f"{ratio:g}.fit": _fit_error(ratio)}  # fmt: skip
    return measured


def _harris() -> dict[str, float]:
    measured: dict[str, float] = {}
    for name, bearing in HARRIS.items():
        for race in ("inner", "outer"):
            total, difference = bearing.curvature(race)
            measured[f"{name}.sum_{race}"], measured[f"{name}.difference_{race}"] = 1e-3 * total, difference
            measured[f"{name}.{race}"] = bearing.contact(race, HARRIS_MODULUS).stiffness
        measured[f"{name}.both"] = bearing.stiffness(HARRIS_MODULUS)
        measured[f"{name}.millimetre"] = measured[f"{name}.both"] / NEWTON_PER_MM
    return measured


def _hamrock() -> dict[str, float]:
    inner = HAMROCK.contact("inner", HAMROCK_MODULUS)
    short, long = inner.axes(HAMROCK_LOAD)
    speed = entrainment_speed(HAMROCK, HAMROCK_SPEED)
    measured = {
        "k": inner.ellipse.k,
        "second": inner.ellipse.second,
        "first": inner.ellipse.first,
        "both": HAMROCK.stiffness(HAMROCK_MODULUS),
        "long": 1e3 * long,
        "short": 1e3 * short,
        "pressure": 1e-9 * inner.peak_pressure(HAMROCK_LOAD),
        "deflection": 1e6 * inner.deflection(HAMROCK_LOAD),
        "speed": speed,
    }
    for race in ("inner", "outer"):
        contact, (rx, ry) = HAMROCK.contact(race, HAMROCK_MODULUS), HAMROCK.radii(race)
        measured[race], measured[f"ratio_{race}"] = contact.stiffness, ry / rx
        for name, thinnest in (("central", False), ("least", True)):
            measured[f"{name}_{race}"] = 1e6 * film_thickness(contact, rx, HAMROCK_LOAD, speed, HAMROCK_OIL, thinnest=thinnest)
    return {f"hamrock.{name}": value for name, value in measured.items()}
