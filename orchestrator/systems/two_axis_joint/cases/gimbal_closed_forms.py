"""The body on two axes against closed forms: motion without torques, governor, pendulum, nutation and precession."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from .....components.two_axis_joint.closed_forms import governor
from ....harness.analysis.sections import swing_frequency
from ....harness.validation import Evidence, Runs
from ....scene.build import unit
from ....scene.scene import Scene
from ... import build_scene

BODY = {"frame_inertia": 0.02, "inner_inertia": 0.05, "cross_inertia": 0.03, "axial_inertia": 0.06}  # kg.m2
MOMENTUM = 0.4  # N.m.s
AMPLITUDES = {"small": 1e-4, "wide": 0.5}  # rad
SLENDER = {"inner_inertia": 0.06, "cross_inertia": 0.06, "axial_inertia": 0.02, "gravity.mass": 2.0, "gravity.distance": 0.15}
WEIGHT = 2.0 * 9.81 * 0.15  # N.m
IMPOSED = 1e9  # kg.m2 of the frame: its speed stays, whatever the body does
BELOW, ABOVE = (5.0, 8.0), (9.0, 12.0, 20.0)  # rad/s, of the governor's 8.58
SPINNING = {"axis_orientation": "horizontal", "frame_inertia": 0.005, "inner_inertia": 0.015, "cross_inertia": 0.015,
            "axial_inertia": 0.015, "rotor.spin_momentum": 2.0, "substep": 1e-4}  # fmt: skip
TORQUE = 0.3  # N.m
INCLINATIONS = {"level": 0.0, "inclined": 1.2}  # rad
SIGNALS = ("inner_angle", "outer_rate", "inner_rate")


def measure(runs: Runs) -> Evidence:
    """One run for each subject, with a unit for each case of it."""
    free, held, rested, swung, spun = runs.values()
    measured: dict[str, float] = {}
    for name in AMPLITUDES:
        measured[f"inertial.period.{name}"] = 2.0 * math.pi / swing_frequency(free.time, free[f"{name}.inner_angle"])
    for name in ("outer_momentum", "mechanical_energy"):
        values = np.asarray(free[f"wide.{name}"])
        measured[f"drift.{name}"] = float(np.abs(values / values[0] - 1.0).max())
    hanging = [swing_frequency(held.time, held[f"speed{speed:g}.inner_angle"]) for speed in BELOW]
    squares = np.square([*BELOW, *hanging])
    critical = squares[0] + squares[2] * (squares[1] - squares[0]) / (squares[2] - squares[3])  # frequency² is linear in speed²
    measured["governor.speed"] = math.sqrt(critical)
    for speed in ABOVE:
        angle = held[f"speed{speed:g}.inner_angle"]
        measured[f"governor.frequency.{speed:g}"] = swing_frequency(held.time, angle - 0.5 * (angle.max() + angle.min()))
        measured[f"governor.angle.{speed:g}"] = rested[f"speed{speed:g}.inner_angle"][-1]
    for axis in ("outer", "inner"):
        measured[f"pendulum.{axis}"] = swing_frequency(swung.time, swung[f"body.{axis}_angle"])
    measured["nutation"] = swing_frequency(spun.time, spun["nutating.inner_rate"])
    for name in INCLINATIONS:
        measured[f"precession.{name}"] = float(np.mean(spun[f"{name}.outer_rate"]))
    speeds = np.linspace(0.0, 22.0, 400)
    angles, frequencies = np.array(
        [governor(w, WEIGHT, *(SLENDER[f"{n}_inertia"] for n in ("inner", "cross", "axial"))) for w in speeds]
    ).T
    return Evidence(measured, data={"speeds": speeds, "angles": angles, "frequencies": frequencies})


def scenes() -> dict[str, Scene]:
    """Every run by its name."""
    free = {name: _gimbal([], {**BODY, "start_inner_angle": a, "start_outer_rate": _rate(a)}) for name, a in AMPLITUDES.items()}
    held = {f"speed{w:g}": _held([], w, 1e-5) for w in BELOW}
    rested = {}
    for speed in ABOVE:
        about, _ = governor(speed, WEIGHT, *(SLENDER[f"{n}_inertia"] for n in ("inner", "cross", "axial")))
        held[f"speed{speed:g}"] = _held([], speed, about + 1e-5)
        damping = {"viscous.outer_coefficient": 0.0, "viscous.inner_coefficient": 0.1}
        rested[f"speed{speed:g}"] = _held(["viscous"], speed, 0.3, damping)
    level = {**SLENDER, "axis_orientation": "horizontal", "start_outer_angle": 1e-5, "start_inner_angle": 1e-5}
    spun = {"nutating": _gimbal(["rotor"], {**SPINNING, "start_inner_angle": 0.0, "start_inner_rate": 1e-4})}
    for name, b in INCLINATIONS.items():
        spun[name] = _gimbal(["rotor"], {**SPINNING, "start_inner_angle": b, "inner_torque": TORQUE,
                                         "start_outer_rate": -TORQUE / (2.0 * math.cos(b))})  # fmt: skip
    return {
        "motion without torques": _scene(free, 30.0, 0.005, [*SIGNALS, "outer_angle", "outer_momentum", "mechanical_energy"]),
        "governor, small motion": _scene(held, 20.0, 0.002, SIGNALS),
        "governor, damped": _scene(rested, 40.0, 0.02, SIGNALS),
        "small motion about a horizontal axis": _scene({"body": _gimbal(["gravity"], level)}, 20.0, 0.005,
                                                       ["outer_angle", "inner_angle"]),
        "rotor": _scene(spun, 2.0, 0.001, SIGNALS),
    }  # fmt: skip


def _rate(inner_angle: float) -> float:
    """Rate of the outer axis that gives the momentum."""
    across, along = BODY["cross_inertia"] * math.sin(inner_angle) ** 2, BODY["axial_inertia"] * math.cos(inner_angle) ** 2
    return MOMENTUM / (BODY["frame_inertia"] + across + along)


def _held(effects: Sequence[str], speed: float, start: float, more: Mapping[str, Any] | None = None) -> dict[str, Any]:
    parameters = {**SLENDER, "frame_inertia": IMPOSED, "start_outer_rate": speed, "start_inner_angle": start, **(more or {})}
    return _gimbal(["gravity", *effects], parameters)


def _gimbal(effects: Sequence[str], parameters: Mapping[str, Any]) -> dict[str, Any]:
    return unit("GimbalBody", effects=effects, **parameters)


def _scene(units: Mapping[str, Any], stop: float, step: float, signals: Sequence[str]) -> Scene:
    record = {"signals": [f"{u}.{s}" for u in units for s in signals]}
    return build_scene(units, stop_time=stop, step=step, name="gimbal", title="Body on two axes", record=record)
