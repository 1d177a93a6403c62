"""Statics of the reference catenaries: elasticity against an independent solver, tensions and sags against closed forms."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from .....components.railway.contact import wire_height
from .....components.railway.mesh import GRAVITY
from .....components.railway.statics import elasticity, messenger_shape
from ....harness.validation import Evidence, Runs
from ....harness.validation.reference import Row, TableRow, compare, load_table
from ....units.component import make
from ... import load_scene

RIGID = {"support_stiffness": 1e9}  # N/m, 10^4 times what the droppers and wires give
CONDITIONS: dict[str, tuple[str, float, Mapping[str, Any]]] = {  # scene, force in N, changes of the catenary's parameters
    "EN 50318:2002, rigid messenger support, 100 N": ("en50318-2002", 100.0, RIGID),
    "EN 50318:2002, 120 N": ("en50318-2002", 120.0, {}),
    "EN 50318:2018 AC simple, 100 N": ("en50318-2018-ac-simple", 100.0, {}),
    "EN 50318:2018 AC simple, 200 N": ("en50318-2018-ac-simple", 200.0, {}),
}
LEFT_OUT = (
    "steady_arm",
    "level_support",
    "moving_window",
    "wire_profile",
    "line_profile",
)  # the reference solvers had no arms; the rest is dynamics
ELEMENT = 0.0625  # m; bending beside a point load is felt over sqrt(EI / T), 0.1 m, and has to be resolved
EXACT = 1e-3  # closed forms hold to rounding; the tolerance is that of the range's printing


def measure(runs: Runs) -> Evidence:
    """Elasticity of four models, then closed forms of strings on droppers."""
    measured: dict[str, dict[str, float]] = {}
    drawn: dict[str, Any] = {}
    for condition, (scene, force, changes) in CONDITIONS.items():
        catenary = resting_catenary(scene, changes, bending=True)
        x, e = _along_the_span(catenary, force)
        k = 1.0 / e
        measured[condition] = {
            "e_support": 1e3 * e[0],
            "e_midspan": 1e3 * e[x.size // 2],
            "k_min": k.min(),
            "k_max": k.max(),
            "k_mean": k[:-1].mean(),
        }
        drawn[condition] = {"elasticity": (x, 1e3 * e)}
        drawn[f"{condition}: droppers"] = [(float(d), "") for d in _within_span(catenary)]
    closed = [row for name in ("en50318-2002", "en50318-2018-ac-simple") for row in _closed_forms(name)]
    rows = (*compare(load_table("catenary-statics").rows, measured), *closed)  # in this order
    return Evidence(rows=rows, data=drawn)


def resting_catenary(scene: str, changes: Mapping[str, Any], bending: bool) -> Any:
    """The scene's catenary at rest on a fine mesh, with or without bending stiffness of the wires whatever the scene says."""
    given = make("catenary", load_scene(scene).units["catenary"])
    effects = [e for e in given.on if e not in (*LEFT_OUT, "bending_stiffness")] + ["bending_stiffness"] * bending
    kept = {n: v for n, v in given.parameters.items() if "." not in n or n.partition(".")[0] in effects}
    catenary = type(given)(effects, {**kept, "element": ELEMENT, "method": "implicit", **changes})
    catenary.initialize(0.0)
    return catenary


def _within_span(catenary: Any) -> np.ndarray:
    count = catenary.parameters["droppers"]
    return np.array([catenary.parameters[f"dropper_position[{i}]"] for i in range(1, count + 1)])


def _along_the_span(catenary: Any, force: float) -> tuple[np.ndarray, np.ndarray]:
    """Positions in a middle span, (n,) m from its support, and elasticity there, (n,) m/N."""
    length, spans = catenary.parameters["span_length"], catenary.parameters["spans"]
    x = np.linspace(0.0, length, 2 * round(length) + 1)
    return x, elasticity(catenary.mesh, (spans // 2) * length + x, force)


def string_tensions(positions: np.ndarray, heights: np.ndarray, weight: float, tension: float, clamp: float) -> np.ndarray:
    """Tension of the inner droppers of a string hung at the given positions (n,) m and heights (n,) m, (n - 2,) N.

    Each carries half the wire to either side (weight in N/m), its clamp (N), and what the kink of the wire there asks for.
    """
    gaps, slopes = np.diff(positions), np.diff(heights) / np.diff(positions)
    return 0.5 * weight * (gaps[:-1] + gaps[1:]) + clamp - tension * np.diff(slopes)


def string_sag(span: float, tension: float, weight: float, positions: np.ndarray, loads: np.ndarray) -> float:
    """Sag in m at midspan of a string with a weight (N/m) and point loads (n,) N at positions (n,) m: moment over tension."""
    return (weight * span**2 / 8.0 + float(np.sum(0.5 * loads * np.minimum(positions, span - positions)))) / tension


def _closed_forms(scene: str) -> list[Row]:
    catenary = resting_catenary(scene, {}, bending=False)
    p, mesh = catenary.parameters, catenary.mesh
    span, middle = p["span_length"], p["spans"] // 2
    within = _within_span(catenary)
    positions = np.concatenate([span * (middle + i) + within for i in (-1, 0, 1)])
    depth = p.get("pre_sag.depth", 0.0)
    heights = np.tile(-4.0 * depth * (within - within[0]) * (within[-1] - within) / (within[-1] - within[0]) ** 2, 3)
    half = 0.5 * p["dropper_mass"]
    weight = GRAVITY * p["contact_wire_mass"]
    clamp = GRAVITY * (p["contact_clamp_mass"] + half)
    n = within.size
    expected = string_tensions(positions, heights, weight, p["contact_wire_tension"], clamp)[n - 1 : 2 * n - 1]
    first = middle * n
    measured = mesh.preload[first : first + n]
    loads = expected + GRAVITY * (p["messenger_clamp_mass"] + half)
    sag = string_sag(span, p["messenger_tension"], GRAVITY * p["messenger_mass"], within, loads)
    shape = messenger_shape(catenary.arguments[1], catenary.arguments[2].bending_stiffness, mesh)
    at_support, at_midspan = np.interp([span * middle, span * (middle + 0.5)], mesh.position, shape)
    gap = slice(n + n // 2, n + n // 2 + 2)  # the droppers beside the middle of the span
    between = positions[gap].mean()
    hang = heights[gap].mean() - wire_height(between, np.zeros_like(mesh.mass), 0, mesh)
    return [
        _row(scene, "tension of the first dropper", "N", expected[0], measured[0]),
        _row(scene, "tension of the middle dropper", "N", expected[n // 2], measured[n // 2]),
        _row(scene, "sum of the dropper tensions of a span", "N", weight * span + n * clamp, measured.sum()),
        _row(scene, "sag of the messenger at midspan", "mm", 1e3 * sag, 1e3 * (at_support - at_midspan)),
        _row(
            scene, "sag of the contact wire beside the middle dropper", "mm",
            1e3 * weight * np.diff(positions[gap])[0] ** 2 / (8.0 * p["contact_wire_tension"]), 1e3 * hang,
        ),
    ]  # fmt: skip


def _row(scene: str, quantity: str, unit: str, expected: float, measured: float) -> Row:
    half = EXACT * abs(expected)
    source = "closed form of a string in equilibrium"
    condition = f"closed forms, {scene}"
    reference = TableRow(quantity, quantity, condition, unit, float(expected - half), float(expected + half), "computed", source)
    return Row(reference, float(measured))
