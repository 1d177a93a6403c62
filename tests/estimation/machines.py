"""Machines that are estimated from what their sensors see: the model, what is unknown of it, how the truth differs, and a wrong model."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import cosimo
import numpy as np
from cosimo.tests.systems.equations import ball_bearing, lumped_catenary

CLEARANCE, LOAD, FORCE = "bearing.clearance.radial_clearance", "bearing.load", "pantograph.static_force"


@dataclass(frozen=True)
class Solved:
    """Signals over time, (n,) each, of equations that share no code with the model."""

    time: np.ndarray
    columns: Mapping[str, np.ndarray]

    def __getitem__(self, name: str) -> np.ndarray:
        return self.columns[name]


@dataclass(frozen=True)
class Machine:
    """changes: of the shipped scene.  unknown: [estimated] of the plan.  noise: of each measured signal, SI.

    every: s from measurement to measurement.  states, suspected: of the plan.  solution: of times and unknown numbers, the truth by
    equations of its own; else it runs as FMUs of pythonfmu.  wrong: changes of the model that the verdict has to reject; happens: of the
    truth, where it is the truth that does what the model does not know.
    """

    scene: str
    changes: Mapping[str, Any]
    unknown: Mapping[str, Mapping[str, Any]]
    noise: Mapping[str, float]
    every: float
    suspected: Sequence[str]
    solution: Callable[[np.ndarray, Mapping[str, float]], Mapping[str, np.ndarray]] | None = None
    states: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    wrong: Mapping[str, Any] = field(default_factory=dict)
    happens: Mapping[str, Any] = field(default_factory=dict)

    def model(self, **changes: Any) -> cosimo.Scene:
        """What the estimate takes the machine for."""
        return cosimo.load_scene(self.scene).with_changes({**self.changes, **changes})

    def truth(self, values: Mapping[str, Any]) -> cosimo.Result | Solved:
        """With other values than the model's."""
        model = self.model(**self.happens)
        if self.solution is None:
            return cosimo.run(model.with_changes(values), in_process=False, verify="no")
        time = model.master.step * np.arange(round(model.stop_time / model.master.step) + 1)
        return Solved(time, self.solution(time, values))

    def plan(self, **changes: Any) -> dict[str, Any]:
        """What a user would say of it."""
        measured = [{"signal": n, "noise": s} for n, s in self.noise.items()]
        given = {"estimated": self.unknown, "states": self.states, "suspected": list(self.suspected)}
        return {"measured": measured, **given} | changes

    def measured(self, result: cosimo.Result | Solved, seed: int = 0) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """What the sensors say of a run: white noise on some rows."""
        rng, every = np.random.default_rng(seed), round(self.every / (result.time[1] - result.time[0]))
        rows = slice(every, None, every)
        time = result.time[rows]
        return {n: (time, result[n][rows] + s * rng.standard_normal(time.size)) for n, s in self.noise.items()}

    def estimate(self, data: Mapping[str, Any], model: cosimo.Scene | None = None, **changes: Any) -> Any:
        """By cosimo, without numerical errors."""
        return cosimo.estimate(model or self.model(), self.plan(**changes), data=data, halved=False)


BEARING = Machine(
    "ball-bearing-clearance",
    {"stop_time": 0.3, CLEARANCE: 6e-6},
    {CLEARANCE: {"deviation": "20 %"}, LOAD: {"deviation": "10 %"}},
    {"bearing.displacement_x": 2e-7, "bearing.displacement_y": 2e-7},
    1e-3,
    ["bearing.contact_stiffness", "bearing.speed"],
    solution=lambda time, values: ball_bearing(time, values[CLEARANCE], values[LOAD]),
    states={"bearing.velocity_x": {"walk": 2e-3}, "bearing.velocity_y": {"walk": 2e-3}},
    wrong={"bearing.speed": 1.01 * 104.72},
)
GIMBAL = Machine(
    "gimbal-scan",
    {"stop_time": 3.0},
    {"body.frame_inertia": {"deviation": "15 %"}, "body.inner_inertia": {"deviation": "15 %"}},
    {"body.outer_angle": 1e-3, "body.inner_angle": 1e-3},
    0.02,
    ["body.stick_friction.*", "body.gravity.mass", "*_motor.constant"],
    wrong={"body.stick_friction.outer_level": 0.08},
)
CATENARY = Machine(
    "lumped-catenary",
    {"stop_time": 2.0},
    {FORCE: {"deviation": "8 N"}},
    {"pantograph.head_velocity": 5e-3, "pantograph.frame_height": 1e-3},
    5e-3,
    ["catenary.mean_stiffness", "catenary.mass", "pantograph.head_mass"],
    solution=lambda time, values: lumped_catenary(time, values[FORCE]),
    states={"pantograph.head_velocity": {"walk": 0.01}, "catenary.wire_velocity": {"walk": 0.01}},
    wrong={"catenary.mean_stiffness": 0.95 * 2807.0},
)
WIND_PUMP = Machine(
    "wind-pump-gusts",
    {"stop_time": 8.0},
    {"pipe.static_head": {"deviation": "20 %"}},
    {"turbine.speed": 0.05, "converter.speed": 0.05, "wind.speed": 0.2},
    0.05,
    ["converter.lever_mass", "turbine.inertia", "turbine.density"],
    states={"turbine.speed": {"walk": 0.02}},
    wrong={"converter.lever_mass": 44.0},
)
TROCAR = Machine(
    "friction-drive-step",
    {"stop_time": 0.8, "controller.effects.quantisation": False},
    {"wheels.trocar_friction.level": {"deviation": "20 %"}},
    {"wheels.feed": 2e-5, "wheels.rotation": 1e-3, "first_motor.current": 0.01, "second_motor.current": 0.01},
    0.01,
    ["*_motor.shaft_friction.level", "*_motor.constant"],
    wrong={"first_motor.shaft_friction.level": 0.016},
)
VEHICLE = Machine(
    "rov-thruster-failed",
    {"controller.set_north": 0.5, "stop_time": 10.0, "faults": []},
    {"current.speed": {"deviation": 0.1}, "current.direction": {"deviation": 0.4}},
    {"hull.position_north": 0.02, "hull.position_east": 0.02, "hull.depth": 5e-3, "hull.roll": 3e-3, "hull.pitch": 3e-3},
    0.1,
    ["hull.mass"],
)
LOST = replace(VEHICLE, happens={"faults": [{"signal": "thruster_4.thrust", "kind": "override", "value": 0.0, "begin": 8.0}]})
