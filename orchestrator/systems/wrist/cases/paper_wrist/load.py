"""Stability of the two rows under a load along the forearm: closed forms beside runs that are pushed and return or give way."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ......components.wrist.kinematics import small_angle_matrix
from ......components.wrist.ligament_springs import COUNT
from .....harness.charts.chart import Chart, Panel, Series
from .....harness.validation.papers import Evidence
from .....harness.validation.questions import Options
from .....run import run
from .... import read_scene
from .postures import NAME, STANDARD, axes

FIRST, SECOND = 0.015, 0.055  # m, heights of both rows; inferred
HINGES = {"neutral zone": 1.0, "far": 8.59}  # N.m/rad of either hinge; recalled, and from cadaver wrists
PUSH, STOP = 1e-4, 12.0  # rad; s
SIDES = (0.97, 1.03)  # times the load at which the closed form loses its stability
LIGHT_GRIP = 100.0  # N along the forearm; recalled, a light grip loads the wrist by more
TENSE = {"constraint.off_axis": [3e-3] * COUNT, "constraint.prestrain": 0.02}
TRIED = (0.98, 1.02, 1.05, 1.1, 1.2, 1.4, 1.7, 2.0)  # times the load without ligaments


def study(options: Options) -> Evidence:
    """A planar column of two hinges, the wrist with its passive stiffness, and the wrist with ligaments under tension."""
    measured: dict[str, float] = {}
    for name, hinge in HINGES.items():
        free = column(hinge, hinge)
        measured |= {f"free.{name}": free, f"held.{name}": 2.0 * hinge / FIRST}
        below, above = _column_runs(hinge, [s * free for s in SIDES], options)
        measured |= {f"column.below.{name}": below, f"column.above.{name}": above}
    critical = wrist_load(1.0)
    measured["wrist"] = critical
    pushes = _wrist_runs([s * critical for s in SIDES], {}, ("morphology", "load"), options)
    measured |= {"wrist.below": pushes[0], "wrist.above": pushes[1]}
    effects = ("morphology", "load", "constraint")
    tried = _wrist_runs([f * critical for f in TRIED], TENSE, effects, options)
    borne = [f for f, x in zip(TRIED, tried, strict=True) if x < 1.0]
    raised = max(borne, default=0.0)
    measured |= {"raised": raised, "grip": critical / LIGHT_GRIP, "grip.held": raised * critical / LIGHT_GRIP}
    note = (
        f"With a passive stiffness of 1 N.m/rad the free hand is stable up to {critical:.1f} N along the forearm, with five "
        f"ligaments under tension up to {measured['raised']:g} times as much. A grip loads the wrist by hundreds of newtons: "
        "muscles that guide the load, and contact, have to bear the rest."
    )
    return Evidence(measured, (_chart(critical),), notes=(note,), claim="G2")


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


def _column_runs(hinge: float, loads: list[float], options: Options) -> list[float]:
    """Largest angle over the push at the end of runs of two upright links under a weight on top."""
    units = {}
    for k, load in enumerate(loads):
        units[f"c{k}"] = {"component": "TwoLinkChain", "effects": ["gravity", "viscous", "springs"], "parameters": {
            "first_mass": 0.0, "first_length": FIRST, "first_centre": 0.0, "first_inertia": 1e-4, "second_mass": load / 9.81,
            "second_length": SECOND, "second_centre": SECOND, "second_inertia": 1e-4, "viscous.first": 0.05,
            "viscous.second": 0.05, "springs.first_stiffness": hinge, "springs.first_rest": math.pi,
            "springs.second_stiffness": hinge, "springs.second_rest": 0.0,
            "start_first_angle": math.pi + PUSH, "start_second_angle": math.pi + PUSH}}  # fmt: skip
    result = run(read_scene({"title": "Columns of two hinges", "stop_time": STOP, "units": units, "master": {"step": 0.01},
                             "record": {"signals": [f"{u}.first_angle" for u in units], "interval": STOP}}, NAME),
                 in_process=options.in_process)  # fmt: skip
    return [abs(float(result[f"{u}.first_angle"][-1]) - math.pi) / PUSH for u in units]


def _wrist_runs(loads: list[float], more: dict[str, Any], effects: tuple[str, ...], options: Options) -> list[float]:
    """Distance of the hand from rest at the end of runs over that of the push; 1e6 where the run ends because it gives way."""
    ends = []
    for load in loads:
        parameters = {"morphology.row_offset": FIRST, "load.tool_distance": FIRST + SECOND, "load.tip_force_y": -load,
                      "load.gravity_x": 0.0, "proximal_damping": 0.02, "distal_damping": 0.02, "hand_mass": 0.0,
                      "start_proximal_angle": PUSH, "start_distal_angle": PUSH, **more}  # fmt: skip
        result = run(read_scene({"title": f"Wrist under {load:.4g} N", "stop_time": STOP,
                                 "units": {"wrist": {"component": "Wrist", "effects": list(effects), "parameters": parameters}},
                                 "master": {"step": 0.01}, "record": {"signals": ["wrist.flexion", "wrist.deviation"]}}, NAME),
                     in_process=options.in_process)  # fmt: skip
        away = np.hypot(result["wrist.flexion"], result["wrist.deviation"])
        ends.append(float(away[-1] / away[0]) if result.outcome == "done" else 1e6)
    return ends


def _chart(critical: float) -> Chart:
    stiffness = np.geomspace(0.5, 30.0, 60)
    lines = (
        Series("wrist of two rows", stiffness, critical * stiffness),
        Series("planar column, free", stiffness, [column(k, k) for k in stiffness]),
        Series("planar column, hand held", stiffness, 2.0 * stiffness / FIRST),
    )
    return Chart(
        "Load along the forearm at which the wrist gives way",
        "stiffness of each hinge, N.m/rad",
        (Panel("load, N", lines, logarithmic=True),),
        "Rows of 15 and 55 mm; the load keeps its direction.",
    )
