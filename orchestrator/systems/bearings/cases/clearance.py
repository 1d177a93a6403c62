"""Natural frequencies of a mass in a deep groove bearing, which fall as the clearance grows."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

import numpy as np

from .....components.bearings.deep_groove import DISPLACEMENT, DeepGrooveBearing
from ....harness.charts.chart import Chart, Panel, Series
from ....harness.validation import Evidence, Runs
from .statics import at_rest

MASS, GRAVITY = 20.0, 9.81
CLEARANCES = (-10, -5, 0, 5, 15, 30, 50)  # um, diametral
AXES = ("horizontal", "vertical")
BEARINGS: dict[str, dict[str, Any]] = {  # ball diameter and pitch diameter in m
    "6207-like": {},
    "6205": {"ball_diameter": 7.94e-3, "pitch_diameter": 39.04e-3},
    "6306": {"balls": 8, "ball_diameter": 11.906e-3, "pitch_diameter": 52e-3},
}
PLANE = ("z", "tilt_x", "tilt_y")  # held: the shaft is guided
DOWN = np.array([0.0, -1.0, 0.0, 0.0, 0.0])


def measure(runs: Runs) -> Evidence:
    """Frequencies from the bearing's own linearisation in its equilibrium; displacements under 1 kN."""
    measured: dict[str, float] = {}
    for c in CLEARANCES:
        for axis, frequency in zip(AXES, frequencies(c, ("x",))[0], strict=True):
            measured[f"held.{c}.{axis}"] = frequency
    fine = np.arange(-10.0, 50.5, 1.0)
    held = np.array([frequencies(c, ("x",))[0] for c in fine])
    free = np.array([frequencies(c, ())[1] for c in fine])
    for names, curves in ((AXES, held), (("lower", "upper"), free)):
        for i, name in enumerate(names):
            measured[f"rise.{name}"] = np.diff(curves[:, i]).max()
    for name, parameters in BEARINGS.items():
        for c in (0, 15):
            model = _bearing(c, parameters)
            measured[f"{name}.{c}"] = -1e6 * at_rest(model, 1000.0 * DOWN, (*PLANE, "x")).displacement[1]
    (free_low, free_high), (sideways, upright) = free[fine == 15.0][0], held[fine == 15.0][0]
    notes = (
        "Nine balls with one on the horizontal axis are no mirror image of themselves about the vertical: under its weight "
        f"the shaft also moves sideways. Left free to do so, it has {free_low:.1f} and {free_high:.1f} Hz at 15 um, against "
        f"{sideways:.1f} and {upright:.1f} Hz held.",
        "The vertical frequency of the shaft held sideways does not fall everywhere: it rises by "
        f"{measured['rise.vertical']:.2f} Hz over a micrometre at most, where balls lose their load.",
        "From where two balls carry all of a light weight on, more clearance changes nothing for a shaft that is free sideways.",
    )
    return Evidence(measured, (_chart(fine, held, free),), notes=notes)


def _bearing(clearance: float, parameters: dict[str, Any]) -> DeepGrooveBearing:
    given = {"hertz": "brewe-hamrock", "diametral_clearance": 1e-6 * clearance, "linearisation.idle_stiffness": 0.0} | parameters
    model = DeepGrooveBearing(["linearisation"], given)
    model.initialize(0.0)
    return model


def frequencies(clearance: float, held: Collection[str]) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies along x and y alone, and of both together, ascending, Hz; of the weight at rest, clearance in um."""
    model = _bearing(clearance, {})
    rest = at_rest(model, MASS * GRAVITY * DOWN, (*PLANE, *held)).displacement
    for name, value in zip(DISPLACEMENT, rest, strict=True):
        model.set(name, value)
    model.refresh()
    K = np.array([[model[f"linearisation.stiffness[{5 * i + j + 1}]"] for j in (0, 1)] for i in (0, 1)])
    squares = np.diag(K) / MASS, np.maximum(np.linalg.eigvalsh(K), 0.0) / MASS
    along, together = (np.sqrt(s) / (2.0 * np.pi) for s in squares)
    return along, together


def _chart(clearance: np.ndarray, held: np.ndarray, free: np.ndarray) -> Chart:
    panels = []
    for title, curves, names in (("held sideways", held, AXES), ("free", free, ("lower", "upper"))):
        panels.append(Panel("Hz", tuple(Series(n, clearance, curves[:, i]) for i, n in enumerate(names)), title=title))
    return Chart(
        "Natural frequencies over the clearance", "diametral clearance, um", tuple(panels),
        "A rigid mass of 20 kg under its weight. Preload stiffens all round; with clearance the load zone narrows, and "
        "with it what holds the shaft sideways.",
        columns=2,
    )  # fmt: skip
