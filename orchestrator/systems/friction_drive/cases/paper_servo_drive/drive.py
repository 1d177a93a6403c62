"""The drive under its controller as a scene, and its numbers."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

from ......components.friction_drive.kinematics import ANGLE
from .....scene.build import unit
from .....scene.scene import Scene
from .... import build_scene

WHEEL, SLEEVE = 0.01, 0.005  # m
GEAR, RESISTANCE, CONSTANT, VOLTAGE = 19.0, 2.3, 23.4e-3, 12.0  # 1, Ohm, N.m/A, V
NORMAL, FRICTION, MASS, GRAVITY = 15.0, 0.4, 0.15, 9.81  # N, 1, kg, m/s2
SHAFT, SHAFT_STATIC, GEAR_LOSS = 0.01, 0.015, 0.2  # N.m at a wheel, in motion and at rest; 1
COSINE, SINE = math.cos(ANGLE), math.sin(ANGLE)
FULL = ("exact_slip", "trocar_friction", "shaft_friction")
ROLLERS = "skewed_free_rollers"
INPUTS = ("first_angle", "second_angle", "first_rate", "second_rate", "feed", "rotation")
SIGNALS = [
    "drive.feed",
    "drive.rotation",
    "drive.first_rate",
    "drive.second_rate",
    "controller.first_voltage",
    "controller.second_voltage",
    "controller.wanted_feed",
    "controller.wanted_rotation",
]


def controlled(
    stop: float,
    layout: str,
    effects: Sequence[str],
    drive: Mapping[str, Any],
    control: Mapping[str, Any],
    control_effects: Sequence[str] = (),
) -> Scene:
    """The whole drive under its controller; `drive`, `control`: parameters; record of `SIGNALS`."""
    units = {
        "drive": unit("FrictionDrive", effects=effects, layout=layout, **drive),
        "controller": unit("ServoController", effects=control_effects, layout=layout, **control),
    }
    links = [f"controller.{k}_voltage -> drive.{k}_voltage" for k in ("first", "second")]
    links += [f"drive.{name} -> controller.{name}" for name in INPUTS]
    master = {"extrapolation": 0, "order": ["drive", "controller"]}
    return build_scene(units, links, stop_time=stop, step=1e-3, name="friction_drive", master=master, record={"signals": SIGNALS})


def side_by_side(units: Mapping[str, Any], stop: float, signals: Sequence[str]) -> Scene:
    """Units without connections; record of these signals of each."""
    record = {"signals": [f"{name}.{signal}" for name in units for signal in signals]}
    return build_scene(units, stop_time=stop, step=1e-3, name="friction_drive", record=record)


@cache
def wheel_inertia(way: str) -> float:
    """Inertia at each wheel while the sleeve moves along ("feed") or about its axis ("rotation"), free rollers, kg m²."""
    shaft = 1e-6 * GEAR**2 + 1e-6
    return shaft + (0.5 * MASS * (WHEEL / COSINE) ** 2 if way == "feed" else 0.5 * 1.875e-6 * (WHEEL / (SLEEVE * SINE)) ** 2)
