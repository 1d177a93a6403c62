"""Hull of an underwater vehicle against closed forms: speed, roll and pitch, a tumbling body, moving water."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from .....components.rov.hull import RovHull
from .....components.rov.vehicles import WATER
from ....harness.analysis.sections import swing_frequency
from ....harness.validation import Evidence, Runs
from ....run.results import Result
from ....scene.build import unit
from ....scene.scene import Scene
from ... import build_scene, load_scene
from ..records import QUATERNION, vehicles

BENZON = RovHull.presets["von Benzon 2022, BlueROV2 Heavy"].parameters
MASS, LINEAR, QUADRATIC = 17.0, 4.03, 18.18  # surge of Wu's vehicle with its added mass: kg, N.s/m, N.s2/m2
FORCES = (10.0, 40.0)  # N
LEVEL = {"centre_of_gravity_z": 0.0}
FLOW = {"north": 0.4, "east": -0.7, "down": 0.2}  # m/s
THRUSTS = [2.0, -1.5, 3.0, 1.0, -2.5, 1.5]  # N


def measure(runs: Runs) -> Evidence:
    """A run for each closed form."""
    measured: dict[str, float] = {}
    for force in FORCES:
        result = runs[f"{force:g} N ahead"]
        measured |= {
            f"speed.{force:g}": result["hull.surge"][-1],
            f"start.{force:g}": float(np.abs(result["hull.surge"] - start_up(result.time, force)).max()),
        }
    measured |= {n: swing_frequency(runs[n].time, runs[n][f"hull.{n}"]) for n in ("roll", "pitch")}
    small, large = (swing_frequency(r.time, r["hull.roll"]) for r in (runs[f"roll from {d} degrees"] for d in ("10^-4", "90")))
    measured["period"] = small / large
    tumbling = runs["tumbling"]
    for name, values in vehicles(tumbling)[0].constants.items():
        change = np.linalg.norm(values - values[:, :1], axis=0).max() / np.linalg.norm(values[:, 0])
        measured[f"drift.{name.replace(' ', '_')}"] = float(change)
    norms = np.linalg.norm([tumbling[f"hull.{n}"] for n in QUATERNION], axis=0)
    measured["norm"] = float(np.abs(norms - 1.0).max())
    munk = runs["ahead, slightly disturbed"]
    measured["munk"] = float(np.polyfit(munk.time, np.log(munk["hull.pitch_rate"]), 1)[0])
    measured["galileo"] = apart(runs["in still and in moving water"])
    t = runs["10 N ahead"].time
    begin = t[: np.searchsorted(t, 8.0)]
    starts = {f"closed.{force:g}": start_up(begin, force) for force in FORCES}
    growth = munk["hull.pitch_rate"][0] * np.exp(_munk_rate() * munk.time)
    return Evidence(measured, data={"begin": begin, **starts, "munk.time": munk.time, "munk.rate": growth})


def scenes() -> dict[str, Scene]:
    """Every run by its name."""
    surge = ["added_mass", "linear_drag", "quadratic_drag", "external"]
    cases = {f"{force:g} N ahead": _scene(40.0, 0.05, surge, {**LEVEL, "external.force_x": force}, ["surge"]) for force in FORCES}
    plain = {n: v for n, v in BENZON.items() if "drag" not in n}
    for name in ("roll", "pitch"):
        cases[name] = _scene(40.0, 0.01, ["added_mass", "restoring"], {**plain, f"start_{name}": 1e-5, "substep": 2e-3}, [name])
    hanging = {**LEVEL, "restoring.buoyancy": 112.8, "restoring.centre_of_buoyancy_z": -0.02, "substep": 2e-3}
    for degrees, label in ((90.0, "90"), (1e-4, "10^-4")):
        start = {**hanging, "start_roll": math.radians(degrees)}
        cases[f"roll from {label} degrees"] = _scene(
            30.0,
            0.01,
            ["added_mass", "coriolis", "restoring"],
            start,
            ["roll", "pitch", "yaw", "roll_rate", *QUATERNION, "position_north", "position_east", "depth"],
        )
    cases["tumbling"] = load_scene("rov-tumbling")
    rate, small = _munk_rate(), 1e-7
    cases["ahead, slightly disturbed"] = _scene(
        2.0,
        0.01,
        ["added_mass", "coriolis"],
        {**LEVEL, "start_surge": 1.0, "start_pitch_rate": small, "substep": 2e-3, "start_heave": small * 17.0 / (26.07 * rate)},
        ["pitch_rate"],
    )
    pose: dict[str, Any] = {f"start_{angle}": 0.0 for angle in ("roll", "pitch", "yaw")}
    pose |= {"start_yaw_rate": 1.0, "thrust": THRUSTS, "substep": 2e-3}
    signals = ["position_north", "position_east", "depth", "roll", "pitch"]
    still = unit("RovHull", effects=WATER, **pose)
    drift: dict[str, Any] = {"start_surge": FLOW["north"], "start_sway": FLOW["east"], "start_heave": FLOW["down"]}
    drift |= {f"current.velocity_{n}": v for n, v in FLOW.items()}
    moved = unit("RovHull", effects=[*WATER, "current"], **pose, **drift)
    record = {"signals": [f"{u}.{s}" for u in ("still", "moved") for s in signals]}
    units = {"still": still, "moved": moved}
    cases["in still and in moving water"] = build_scene(units, stop_time=20.0, step=0.02, name="rov", record=record)
    return cases


def _scene(stop: float, step: float, effects: Sequence[str], parameters: Mapping[str, Any], signals: Sequence[str]) -> Scene:
    hull, record = unit("RovHull", effects=effects, **parameters), {"signals": [f"hull.{s}" for s in signals]}
    title = "Hull of an underwater vehicle"
    return build_scene({"hull": hull}, stop_time=stop, step=step, name="rov", title=title, record=record)


def start_up(t: np.ndarray, force: float) -> np.ndarray:
    """Speed from rest under a constant force, m/s: Riccati's equation."""
    delta = math.sqrt(LINEAR**2 + 4.0 * QUADRATIC * force)
    u1, u2 = (delta - LINEAR) / (2.0 * QUADRATIC), (delta + LINEAR) / (2.0 * QUADRATIC)
    decay = np.exp(-delta / MASS * np.asarray(t))
    return u1 * (1.0 - decay) / (1.0 + u1 / u2 * decay)


def apart(result: Result) -> float:
    """Largest distance of the two tracks once the water's way is taken off, and of the angles, m and rad."""
    t = np.asarray(result.time)
    ways = [
        result[f"moved.{p}"] - result[f"still.{p}"] - t * v
        for p, v in zip(("position_north", "position_east", "depth"), FLOW.values(), strict=True)
    ]
    angles = [result[f"moved.{a}"] - result[f"still.{a}"] for a in ("roll", "pitch")]
    return float(np.abs([*ways, *angles]).max())


def _munk_rate() -> float:
    return math.sqrt(17.0 * (26.07 - 17.0) / (26.07 * 0.28))
