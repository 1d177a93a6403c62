"""The drive under its controller as a scene, and its numbers."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

from ......components.friction_drive.kinematics import ANGLE
from .....results import Result
from .....run import run
from .... import read_scene

WHEEL, SLEEVE = 0.01, 0.005  # m
GEAR, RESISTANCE, CONSTANT, VOLTAGE = 19.0, 2.3, 23.4e-3, 12.0  # 1, Ohm, N.m/A, V
NORMAL, FRICTION, MASS, GRAVITY = 15.0, 0.4, 0.15, 9.81  # N, 1, kg, m/s2
SHAFT, SHAFT_STATIC, GEAR_LOSS = 0.01, 0.015, 0.2  # N.m at a wheel, in motion and at rest; 1
COSINE, SINE = math.cos(ANGLE), math.sin(ANGLE)
FULL = ("exact_slip", "trocar_friction", "shaft_friction")
ROLLERS = "skewed_free_rollers"
INPUTS = ("first_angle", "second_angle", "first_rate", "second_rate", "feed", "rotation")
SIGNALS = (
    "drive.feed",
    "drive.rotation",
    "drive.first_rate",
    "drive.second_rate",
    "controller.first_voltage",
    "controller.second_voltage",
    "controller.wanted_feed",
    "controller.wanted_rotation",
)


def controlled(
    stop: float,
    layout: str,
    effects: Sequence[str],
    drive: Mapping[str, Any],
    control: Mapping[str, Any],
    control_effects: Sequence[str] = (),
) -> Result:
    """A run of the whole drive under its controller; `drive`, `control`: parameters; record of `SIGNALS`."""
    units = {
        "drive": {"component": "FrictionDrive", "effects": list(effects), "parameters": {"layout": layout, **drive}},
        "controller": {
            "component": "ServoController",
            "effects": list(control_effects),
            "parameters": {"layout": layout, **control},
        },
    }
    links = [f"controller.{k}_voltage -> drive.{k}_voltage" for k in ("first", "second")]
    links += [f"drive.{name} -> controller.{name}" for name in INPUTS]
    return run(
        read_scene(
            {
                "title": "Drive with friction wheels under control",
                "stop_time": stop,
                "units": units,
                "connections": links,
                "master": {"step": 1e-3, "extrapolation": 0, "order": ["drive", "controller"]},
                "record": {"signals": list(SIGNALS)},
            },
            "friction_drive",
        ),
        in_process=True,
    )


@cache
def wheel_inertia(way: str) -> float:
    """Inertia at each wheel while the sleeve moves along ("feed") or about its axis ("rotation"), free rollers, kg m²."""
    shaft = 1e-6 * GEAR**2 + 1e-6
    return shaft + (0.5 * MASS * (WHEEL / COSINE) ** 2 if way == "feed" else 0.5 * 1.875e-6 * (WHEEL / (SLEEVE * SINE)) ** 2)
