"""Pipe robot."""

from __future__ import annotations

from . import Facts

FACTS: dict[str, Facts] = {
    "PipeRobot": Facts(
        small={"start_velocity": 0.3, "start_stretch": 1e-3},  # without an exciter nothing else moves it
        moving=frozenset({"*"}),
        other_ways=(({"start_velocity": 0.0, "backward_friction": 0.5}, ("harmonic_force", "tow", "route")),),
        plain=(("harmonic_force", "bristles", "cubic_spring", "tow", "route"), {}, 20),
        strengths={
            "harmonic_force.amplitude": ({}, 1e-3),
            "cubic_spring.stiffness": ({}, 1e3),
            "tow.force": ({}, 1e-3),
            "route.slope": ({}, 1e-5),
            "route.acceleration": ({"route.slope": 0.1}, 1e-3),
        },
        structural=frozenset({"prescribed_motion", "unbalance", "bristles", "smoothed_friction", "lugre_friction"}),
        form=frozenset({"harmonic_force.frequency", "cubic_spring.largest_stretch", "route.friction_factor",
                        "route.largest_factor"}),
    ),
}
