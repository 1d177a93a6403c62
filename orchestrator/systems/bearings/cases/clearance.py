"""Natural frequencies of a mass in a deep groove bearing, which fall as the clearance grows."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

import numpy as np

from .....components.bearings.deep_groove import DeepGrooveBearing
from .....components.bearings.motion import DISPLACEMENT
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
    drawn = {
        "clearance": fine,
        "held": {n: held[:, i] for i, n in enumerate(AXES)},
        "free": {n: free[:, i] for i, n in enumerate(("lower", "upper"))},
        **{"free.low": free_low, "free.high": free_high, "sideways": sideways, "upright": upright},
    }
    return Evidence(measured, data=drawn)


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
