"""Waves as the vehicle meets them: a sea of its height, the force that holds a vehicle, a free one that follows the water."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ......components.rov.hull import RovHull
from ......components.rov.vehicles import WATER
from ......components.rov.waves import wave_number
from .....harness.validation import Runs
from .....scene.build import unit
from .....scene.scene import Scene
from .... import build_scene

HEIGHT, PERIOD, DEPTH, BOTTOM = 1.0, 6.0, 5.0, 500.0  # m, s
SMALL = 0.01  # m, height of the wave that a free vehicle meets: its own motion does not change the wave it sees
SEA, SEA_DEPTH, SEA_TIME = (0.5, 4.0), 5.0, 1800.0  # m, s; m; s
NEUTRAL = 11.5  # kg, mass of the hull; what it displaces in the published set is 1.8 % more
FREQUENCY = 2.0 * math.pi / PERIOD
SETS = {"wu": "Wu 2018, BlueROV2 Heavy", "benzon": "von Benzon 2022, BlueROV2 Heavy"}


def scenes() -> dict[str, Scene]:
    """A sea of half an hour, and a hull that is free in a regular wave."""
    return {"sea": _sea_scene(), "free": free_scene()}


def measure(runs: Runs) -> dict[str, float]:
    """Height and speed of the sea, forces on a hull that is held, and the motion of the one that is free."""
    sea, free = runs["sea"], runs["free"]
    elevation, speed = sea["water.waves.elevation"], sea["water.velocity_north"]
    k = wave_number(FREQUENCY, BOTTOM, 0.0)
    orbit = 0.5 * SMALL * math.exp(-k * DEPTH)
    late = free.time > free.time[-1] - 4.0 * PERIOD
    surge, water = free["hull.surge"][late], free["water.velocity_north"][late]
    measured = {
        "sea.height": 4.0 * float(np.std(elevation)) / SEA[0],
        "sea.speed": float(np.sqrt(np.mean(speed**2))),
        "free.response": float(np.std(surge) / np.std(water)),
        "free.orbit": float(np.ptp(free["hull.position_north"][late]) / (2.0 * orbit)),
    }
    for name, preset in SETS.items():
        inertia, drag = held(preset)
        measured |= {f"held.inertia.{name}": inertia, f"held.drag.{name}": drag}
    return measured


def _sea_scene() -> Scene:
    waves = {"height": SEA[0], "period": SEA[1], "depth": SEA_DEPTH, "water_depth": BOTTOM}
    water = unit("WaterCurrent", effects=["waves", "spectrum"], speed=0.0, waves=waves)
    record = {"signals": ["water.waves.elevation", "water.velocity_north", "water.velocity_down"]}
    return build_scene({"water": water}, stop_time=SEA_TIME, step=0.2, name="rov", record=record)


def free_scene() -> Scene:
    """A neutral vehicle without thrust in a regular wave; its drag is linear, so that its response has a closed form."""
    parameters: dict[str, Any] = {"start_depth": DEPTH, "centre_of_gravity_z": 0.0, "pressure_gradient.displaced_mass": NEUTRAL}
    wave = {"height": SMALL, "period": PERIOD, "water_depth": BOTTOM}
    return build_scene(
        {
            "hull": unit("RovHull", effects=["added_mass", "linear_drag", "current", "pressure_gradient"], **parameters),
            "water": unit("WaterCurrent", effects=["waves"], speed=0.0, waves=wave),
        },
        ["water.* -> hull.current.*", "hull.position_north -> water.waves.position_north", "hull.depth -> water.waves.depth"],
        stop_time=90.0,
        step=0.01,
        name="rov",
        master={"algorithm": "gauss-seidel"},
        record={"signals": ["hull.position_north", "hull.depth", "hull.surge", "water.velocity_north"]},
    )


def held(preset: str) -> tuple[float, float]:
    """Largest force of inertia and of drag, N, ahead on a hull that is held in the wave: what a thruster would have to give."""
    k = wave_number(FREQUENCY, BOTTOM, 0.0)
    speed = 0.5 * HEIGHT * FREQUENCY * math.exp(-k * DEPTH)
    values = RovHull.presets[preset].parameters
    forces = []
    for inputs in ({"current.acceleration_north": FREQUENCY * speed}, {"current.velocity_north": speed}):
        displaced = values["restoring.buoyancy"] / 9.80665
        hull = RovHull(
            (*WATER, "current", "pressure_gradient", "external"),
            {**values, **inputs, "centre_of_gravity_z": 0.0, "pressure_gradient.displaced_mass": displaced},
        )
        hull.initialize(0.0)
        forces.append((values["mass"] + values["added_mass.surge"]) * hull["external.acceleration_x"])
    return forces[0], forces[1]
