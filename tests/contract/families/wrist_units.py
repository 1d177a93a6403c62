"""Wrist: the units without mass."""

from __future__ import annotations

from . import Facts

CHANGE_POINT = {"crank": 0.02, "coupler": 0.05, "rocker": 0.02, "ground": 0.05, "change_point": "through"}

FACTS: dict[str, Facts] = {
    "FourBar": Facts(
        plain=(("pin_damping", "rocker_spring", "coupler_point"), {}, 20),
        other_ways=((CHANGE_POINT, ("pin_damping",)),),
        disturbance={"input_rate": 1.0, "load_torque": 0.5},
        strengths={"pin_damping.coefficient": ({}, 1e-4), "rocker_spring.stiffness": ({}, 1e-3)},
        structural=frozenset({"coupler_point"}),
        form=frozenset({"rocker_spring.rest_angle"}),
    ),
}
