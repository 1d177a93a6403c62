"""Stability of the two rows under a load along the forearm: closed forms beside runs that are pushed and return or give way."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from ......components.wrist.kinematics import small_angle_matrix
from ......components.wrist.ligament_springs import COUNT
from .....harness.validation import Evidence, Runs
from .....run.results import Result
from .....scene.build import unit
from .....scene.scene import Scene
from .... import build_scene
from .postures import NAME, STANDARD, axes

FIRST, SECOND = 0.015, 0.055  # m, heights of both rows; inferred
HINGES = {"neutral zone": 1.0, "far": 8.59}  # N.m/rad of either hinge; from memory, and from cadaver wrists
PUSH, STOP = 1e-4, 12.0  # rad; s
SIDES = (0.97, 1.03)  # times the load at which the closed form loses its stability
LIGHT_GRIP = 100.0  # N along the forearm; from memory, a light grip loads the wrist by more
TENSE = {"constraint.off_axis": [3e-3] * COUNT, "constraint.prestrain": 0.02}
TRIED = (0.98, 1.02, 1.05, 1.1, 1.2, 1.4, 1.7, 2.0)  # times the load without ligaments


def scenes() -> dict[tuple[str, float], Scene]:
    """Columns of each hinge; the wrist by its load over the critical one, without and with ligaments under tension."""
    critical = wrist_load(1.0)
    return {
        **{("column", hinge): _column_scene(hinge) for hinge in HINGES.values()},
        **{("wrist", f): _wrist_scene(f * critical, {}, ("morphology", "load")) for f in SIDES},
        **{("tense", f): _wrist_scene(f * critical, TENSE, ("morphology", "load", "constraint")) for f in TRIED},
    }


def measure(runs: Runs) -> Evidence:
    """A planar column of two hinges, the wrist with its passive stiffness, and the wrist with ligaments under tension."""
    measured: dict[str, float] = {}
    for name, hinge in HINGES.items():
        measured |= {f"free.{name}": column(hinge, hinge), f"held.{name}": 2.0 * hinge / FIRST}
        below, above = (abs(runs["column", hinge][f"c{k}.first_angle"][-1] - math.pi) / PUSH for k in range(len(SIDES)))
        measured |= {f"column.below.{name}": below, f"column.above.{name}": above}
    critical = wrist_load(1.0)
    measured["wrist"] = critical
    measured |= {f"wrist.{side}": _growth(runs["wrist", f]) for side, f in zip(("below", "above"), SIDES, strict=True)}
    raised = max((f for f in TRIED if _growth(runs["tense", f]) < 1.0), default=0.0)
    measured |= {"raised": raised, "grip": critical / LIGHT_GRIP, "grip.held": raised * critical / LIGHT_GRIP}
    stiffness = np.geomspace(0.5, 30.0, 60)
    loads = {
        "wrist of two rows": critical * stiffness,
        "planar column, free": [column(k, k) for k in stiffness],
        "planar column, hand held": 2.0 * stiffness / FIRST,
    }
    return Evidence(measured, data={"stiffness": stiffness, "loads": loads})


def column(first: float, second: float) -> float:
    """Least load, N, at which a planar column of two hinges gives way under a weight: (k1 + k2 - F h1)(k2 - F h2) = k2²."""
    roots = np.roots([FIRST * SECOND, -(second * FIRST + (first + second) * SECOND), first * second])
    return float(roots.real.min())


def wrist_load(stiffness: float) -> float:
    """The same of the wrist with equal stiffness in flexion and deviation: det(k A^T A - F (h1 e1 e1^T + h2 A^T A)) = 0."""
    a = small_angle_matrix(axes(STANDARD))
    own, row = a.T @ a, np.diag([FIRST, 0.0])
    values = np.linalg.eigvals(np.linalg.solve(row + SECOND * own, stiffness * own))
    return float(values.real.min())


def _column_scene(hinge: float) -> Scene:
    """Two upright links under a weight on top, a little less and a little more than the column bears."""
    common: dict[str, Any] = {
        "first_mass": 0.0,
        "first_length": FIRST,
        "first_centre": 0.0,
        "first_inertia": 1e-4,
        "second_length": SECOND,
        "second_centre": SECOND,
        "second_inertia": 1e-4,
        "viscous": {"first": 0.05, "second": 0.05},
        "springs": {"first_stiffness": hinge, "first_rest": math.pi, "second_stiffness": hinge, "second_rest": 0.0},
        "start_first_angle": math.pi + PUSH,
        "start_second_angle": math.pi + PUSH,
    }
    masses = [side * column(hinge, hinge) / 9.81 for side in SIDES]
    effects = ["gravity", "viscous", "springs"]
    units = {f"c{k}": unit("TwoLinkChain", effects=effects, second_mass=mass, **common) for k, mass in enumerate(masses)}
    record = {"signals": [f"{name}.first_angle" for name in units], "interval": STOP}
    return build_scene(units, stop_time=STOP, step=0.01, name=NAME, title="Columns of two hinges", record=record)


def _wrist_scene(load: float, more: Mapping[str, Any], effects: tuple[str, ...]) -> Scene:
    """A wrist pushed out of rest under a load along the forearm, N."""
    parameters: dict[str, Any] = {
        "morphology.row_offset": FIRST,
        "load.tool_distance": FIRST + SECOND,
        "load.tip_force_y": -load,
        "load.gravity_x": 0.0,
        "proximal_damping": 0.02,
        "distal_damping": 0.02,
        "hand_mass": 0.0,
        "start_proximal_angle": PUSH,
        "start_distal_angle": PUSH,
        **more,
    }
    units = {"wrist": unit("Wrist", effects=effects, **parameters)}
    record = {"signals": ["wrist.flexion", "wrist.deviation"]}
    return build_scene(units, stop_time=STOP, step=0.01, name=NAME, title=f"Wrist under {load:.4g} N", record=record)


def _growth(result: Result) -> float:
    """Distance of the hand from rest at the end over that of the push; 1e6 where the run ends because the wrist gives way."""
    away = np.hypot(result["wrist.flexion"], result["wrist.deviation"])
    return float(away[-1] / away[0]) if result.outcome == "done" else 1e6
