"""Machines that are estimated from what their sensors see: the model, what is unknown of it, and how the truth differs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import cosimo
import numpy as np


@dataclass(frozen=True)
class Machine:
    """changes: of the shipped scene.  unknown: [estimated] of the plan.  noise: of each measured signal, SI.

    every: rows of the truth from measurement to measurement.  truth: how its scene differs beside unknown numbers.
    fmus: the truth runs as FMUs of pythonfmu.  states, suspected: of the plan.
    """

    scene: str
    changes: Mapping[str, Any]
    unknown: Mapping[str, Mapping[str, Any]]
    noise: Mapping[str, float]
    every: int
    suspected: Sequence[str]
    truth: Mapping[str, Any] = field(default_factory=dict)
    fmus: bool = False
    states: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)

    def model(self, **changes: Any) -> cosimo.Scene:
        """What the estimate takes the machine for."""
        return cosimo.load_scene(self.scene).with_changes({**self.changes, **changes})

    def run(self, values: Mapping[str, Any]) -> cosimo.Result:
        """The truth, with other values than the model's."""
        return cosimo.run(self.model(**{**self.truth, **values}), in_process=not self.fmus, verify="no")

    def plan(self, **changes: Any) -> dict[str, Any]:
        """What a user would say of it."""
        measured = [{"signal": n, "noise": s} for n, s in self.noise.items()]
        given = {"estimated": self.unknown, "states": self.states, "suspected": list(self.suspected)}
        return {"measured": measured, **given} | changes

    def measured(self, result: cosimo.Result, seed: int = 0) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """What the sensors say of a run: white noise on some rows."""
        rng, rows = np.random.default_rng(seed), slice(self.every, None, self.every)
        time = result.time[rows]
        return {n: (time, result[n][rows] + s * rng.standard_normal(time.size)) for n, s in self.noise.items()}

    def estimate(self, data: Mapping[str, Any], model: cosimo.Scene | None = None, **changes: Any) -> Any:
        """By cosimo, without numerical errors."""
        return cosimo.estimate(model or self.model(), self.plan(**changes), data=data, halved=False)


BEARING = Machine(
    "ball-bearing-clearance",
    {"stop_time": 0.3, "bearing.clearance.radial_clearance": 6e-6},
    {"bearing.clearance.radial_clearance": {"deviation": "20 %"}, "bearing.load": {"deviation": "10 %"}},
    {"bearing.displacement_x": 2e-7, "bearing.displacement_y": 2e-7},
    20,
    ["bearing.contact_stiffness", "bearing.speed"],
    truth={"master.step": 5e-5},
    states={"bearing.velocity_x": {"walk": 2e-3}, "bearing.velocity_y": {"walk": 2e-3}},
)
GIMBAL = Machine(
    "gimbal-scan",
    {"stop_time": 3.0},
    {"body.frame_inertia": {"deviation": "15 %"}, "body.inner_inertia": {"deviation": "15 %"}},
    {"body.outer_angle": 1e-3, "body.inner_angle": 1e-3},
    10,
    ["body.stick_friction.*", "body.gravity.mass", "*_motor.constant"],
    fmus=True,
)
CATENARY = Machine(
    "lumped-catenary",
    {"stop_time": 2.0},
    {"pantograph.static_force": {"deviation": "8 N"}},
    {"pantograph.head_velocity": 5e-3, "pantograph.frame_height": 1e-3},
    10,
    ["catenary.mean_stiffness", "catenary.mass", "pantograph.head_mass"],
    truth={"master.step": 5e-4},
    fmus=True,
    states={"pantograph.head_velocity": {"walk": 0.01}, "catenary.wire_velocity": {"walk": 0.01}},
)
WIND_PUMP = Machine(
    "wind-pump-gusts",
    {"stop_time": 8.0},
    {"pipe.static_head": {"deviation": "20 %"}},
    {"turbine.speed": 0.05, "converter.speed": 0.05, "wind.speed": 0.2},
    20,
    ["converter.lever_mass", "turbine.inertia", "turbine.density"],
    fmus=True,
    states={"turbine.speed": {"walk": 0.02}},
)
TROCAR = Machine(
    "friction-drive-step",
    {"stop_time": 0.8, "controller.effects.quantisation": False},
    {"wheels.trocar_friction.level": {"deviation": "20 %"}},
    {"wheels.feed": 2e-5, "wheels.rotation": 1e-3, "first_motor.current": 0.01, "second_motor.current": 0.01},
    20,
    ["*_motor.shaft_friction.level", "*_motor.constant"],
    fmus=True,
)
VEHICLE = Machine(
    "rov-thruster-failed",
    {"controller.set_north": 0.5, "stop_time": 10.0, "faults": []},
    {"current.speed": {"deviation": 0.1}, "current.direction": {"deviation": 0.4}},
    {"hull.position_north": 0.02, "hull.position_east": 0.02, "hull.depth": 5e-3, "hull.roll": 3e-3, "hull.pitch": 3e-3},
    5,
    ["hull.mass"],
    fmus=True,
)
