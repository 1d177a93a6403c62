"""The same hull and controller with six and with eight thrusters in the same tasks: energy and error of runs."""

from __future__ import annotations

from typing import Any

import numpy as np

from .....harness.validation import Evidence, Runs
from .....run.results import Result
from .....scene.scene import Scene
from .... import load_scene
from ...records import vehicles
from .layouts import SCENES, ideal_power

TRANSIENT = 20.0  # s
LIFT = 20.0  # N, of the task that only holds depth
CALM = {"units.water.parameters": {"speed": 0.0, "waves": {"height": 0.0}}, "stop_time": 60.0}
TASKS: dict[str, dict[str, Any]] = {
    "lift": {**CALM, "hull.restoring.buoyancy": 112.8 + LIFT},
    "current": {
        "units.water.effects": ["ramp", "gust", "waves"],
        "stop_time": 60.0,
        "units.water.parameters": {
            "speed": 0.3,
            "direction": 0.5,
            "waves": {"height": 0.0},
            "ramp": {"start_time": 5.0, "duration": 10.0},
            "gust": {"start_time": 35.0, "amplitude": 0.2, "direction": 2.0},
        },
    },
    "waves": {},
    "transect": {
        "units.controller.effects": ["inverse_curve", "manoeuvre"],
        "controller.manoeuvre": {
            "time": [0.0, 20.0, 60.0, 65.0, 75.0, 115.0, 115.0, 115.0],
            "north": [0.0, 0.0, 12.0, 12.0, 12.0, 0.0, 0.0, 0.0],
            "east": [0.0, 0.0, 0.0, 0.0, 2.0, 2.0, 2.0, 2.0],
        },
    },
}
POSITION, ATTITUDE = ("error_north", "error_east", "error_down"), ("error_roll", "error_pitch", "error_yaw")


def scenes() -> dict[tuple[str, str], Scene]:
    """Four tasks with both layouts."""
    return {(task, layout): scene(task, layout) for task in TASKS for layout in SCENES}


def measure(runs: Runs) -> Evidence:
    """Mean power, errors and the least share of the wrench: eight thrusters over six."""
    measured: dict[str, float] = {}
    rows = []
    for task in TASKS:
        numbers = {layout: figures(runs[task, layout]) for layout in SCENES}
        six, eight = numbers["six"], numbers["eight"]
        measured |= {f"{task}.power": six["power"] / eight["power"], f"{task}.scale": min(n["scale"] for n in numbers.values())}
        if task != "lift":  # where the error is the way to the set point alone
            measured |= {f"{task}.{what}": eight[what] / six[what] for what in ("position", "attitude")}
        rows += [
            (
                task,
                layout,
                round(n["power"], 3),
                round(1e3 * n["position"], 1),
                round(float(np.degrees(n["attitude"])), 2),
                round(n["scale"], 3),
            )
            for layout, n in numbers.items()
        ]
    energies = {f"energy.{t}": {f"{n} thrusters": _energy(runs[t, n]) for n in SCENES} for t in ("current", "waves", "transect")}
    return Evidence(measured, data={**energies, "rows": rows})


def _energy(result: Result) -> tuple[np.ndarray, np.ndarray]:
    """Time and ideal energy up to it, s and J."""
    power = ideal_power(list(vehicles(result)[0].thrusts.values()))
    return result.time, np.r_[0.0, np.cumsum(power[1:] * np.diff(result.time))]


def scene(task: str, layout: str) -> Scene:
    """A task, a name of `TASKS`, with a layout, a name of `SCENES`."""
    return load_scene(SCENES[layout]).with_changes(TASKS[task])


def figures(result: Result, start: float = TRANSIENT) -> dict[str, float]:
    """Mean ideal power in W, rms errors in m and rad, least share of the wrench, from a time in s on."""
    vehicle = vehicles(result)[0]
    kept = np.asarray(result.time) >= start
    errors = {
        what: np.array([vehicle.errors[n][kept] for n in names])
        for what, names in (("position", POSITION), ("attitude", ATTITUDE))
    }
    power = ideal_power([F[kept] for F in vehicle.thrusts.values()])
    assert vehicle.scale is not None  # the scenes record it
    return {
        "power": float(power.mean()),
        "scale": float(vehicle.scale[kept].min()),
        **{what: float(np.sqrt((values**2).sum(axis=0).mean())) for what, values in errors.items()},
    }
