"""Each thruster lost in turn while the vehicle keeps its place in current and waves; the controller learns of it at once."""

from __future__ import annotations

import numpy as np

from .....harness.validation import Evidence, Runs
from .....run.results import Result
from .....scene.scene import Scene
from ...records import vehicles
from .layouts import MATRICES
from .tasks import figures, scene

FAILURE, END = 20.0, 100.0  # s
AFTER = 40.0  # s, from which on errors are counted
KEPT = 0.25  # m, rms error up to which the place counts as kept; ours, ten times that of the whole vehicle


def scenes() -> dict[tuple[str, int], Scene]:
    """Fourteen runs with a loss, and two without, 0."""
    return {(layout, k): failing(layout, k) for layout, matrix in MATRICES.items() for k in range(matrix.shape[1] + 1)}


def measure(runs: Runs) -> Evidence:
    """Errors, power and share of the wrench after each loss beside those without one."""
    measured: dict[str, float] = {}
    rows = []
    tracks: dict[str, dict[str, tuple[np.ndarray, np.ndarray]]] = {}
    for layout in MATRICES:
        results = {k: result for (of, k), result in runs.items() if of == layout}
        numbers = {k: figures(result, AFTER) for k, result in results.items()}
        lost = [n for k, n in numbers.items() if k]
        measured |= {
            f"loss.position.{layout}": max(n["position"] for n in lost) / numbers[0]["position"],
            f"loss.kept.{layout}": float(sum(n["position"] <= KEPT for n in lost)),
            f"loss.scale.{layout}": min(n["scale"] for n in lost),
        }
        rows += [
            (
                layout,
                str(k) if k else "none",
                round(n["position"], 3),
                round(float(np.degrees(n["attitude"])), 2),
                round(n["power"], 2),
                round(n["scale"], 3),
            )
            for k, n in numbers.items()
        ]
        tracks[f"{layout}.all"] = {"all": _distance(results.pop(0))}
        tracks[f"{layout}.lost"] = {f"without {k}": _distance(result) for k, result in results.items()}
    return Evidence(measured, data={**tracks, "rows": rows})


def _distance(result: Result) -> tuple[np.ndarray, np.ndarray]:
    """Time and distance from the set point, s and m, every tenth row."""
    errors = vehicles(result)[0].errors
    distance = np.sqrt(sum(errors[n] ** 2 for n in ("error_north", "error_east", "error_down")))
    return result.time[::10], np.maximum(distance[::10], 1e-4)


def failing(layout: str, number: int) -> Scene:
    """Station keeping in current and waves that loses a thruster, counted from 1; 0: none."""
    faults = (
        [
            {"signal": f"thruster_{number}.{signal}", "kind": "override", "value": 0.0, "begin": FAILURE}
            for signal in ("thrust", "status.available")
        ]
        if number
        else []
    )
    return scene("waves", layout).with_changes({"stop_time": END, "faults": faults})
