"""Distribution around the circumference: contact areas, and conductance ball by ball, lumped and in finite volumes."""

from __future__ import annotations

import math

import numpy as np

from .....harness.charts.chart import Chart, Panel, Series
from .....harness.validation.papers import Evidence
from .....harness.validation.questions import Options
from ...heat_path import ball_path
from .network import ANGLES, BORES, BULK, ball_conductances, bearing, resistance

LOAD = 1000.0  # N, both ways
HALF = 9  # balls from the load line to the other side
SOLVED = {"7008C": (0, 2, 3, 8), "7210B": (0, 2, 4)}  # balls in finite volumes; the first is the most loaded
FINENESS = 5  # of their grids: with 3 the shares scatter by 3 %, with 5 by less than 1 %


def study(options: Options) -> Evidence:
    """One equilibrium each: loads, areas of the inner contacts, conductances."""
    measured: dict[str, float] = {}
    curves: dict[str, tuple[np.ndarray, ...]] = {}
    for preset in ANGLES:
        model = bearing(preset)
        resistance(model, LOAD, LOAD)
        loads = model.ball_loads[:HALF]
        lumped = ball_conductances(model)[:HALF]
        at = list(SOLVED[preset])
        solid = np.array([ball_path(model, load, *BORES[preset], fineness=FINENESS).conductance for load in loads[at]])
        whole = bearing(preset, BULK)
        resistance(whole, LOAD, LOAD)
        bulk = ball_conductances(whole)[:HALF]
        area = areas(model, loads)
        root = np.cbrt(loads / loads.max())
        measured |= {f"{preset}.{j}": float(g) for j, g in enumerate(lumped / lumped.max())}
        measured[f"{preset}.volumes"] = float(100.0 * np.abs(solid / solid[0] - root[at]).max())
        measured[f"{preset}.bulk"] = float(100.0 * np.abs(solid / solid[0] - (bulk / bulk[0])[at]).max())
        measured[f"{preset}.area"] = float(np.abs(area / area.max() - root**2).max())
        curves[preset] = (area, lumped / lumped.max(), solid / solid[0], root)
    return Evidence(measured, (_chart(curves),), claim="J1")


def areas(model, loads: np.ndarray) -> np.ndarray:
    """Area of the inner contact of each ball, (n,) m2, by Hertz's solution for its own load."""
    contact = model.geometry().contact("inner", model.material())
    return np.array([0.25 * math.pi * math.prod(contact.axes(load)) if load > 0.0 else 0.0 for load in loads])


def _chart(curves: dict[str, tuple[np.ndarray, ...]]) -> Chart:
    angle = 360.0 / 16 * np.arange(HALF)
    panels = []
    for preset, (area, lumped, solid, root) in curves.items():
        panels.append(Panel("share of the largest", (
            Series("conductance, lumped", angle, lumped, "line+points"),
            Series("conductance, finite volumes", angle[list(SOLVED[preset])], solid, "points"),
            Series("cube root of the load", angle, root, faint=True), Series("contact area", angle, area / area.max())),
            title=f"{preset}, largest area {1e6 * area.max():.3f} mm²"))  # fmt: skip
    return Chart(
        "Distribution around the circumference",
        "angle from the radial load, degrees",
        tuple(panels),
        "1 kN axial and 1 kN radial. Heat follows the cube root of a ball's load, contact areas its square.",
        columns=2,
    )
