"""Inertial converter."""

from __future__ import annotations

from . import Facts

FACTS: dict[str, Facts] = {
    "InertialConverter": Facts(
        small={"substep": 2.5e-5},  # what slipping clutches need, for every configuration
        plain=(("stresses",), {}, 20),
        disturbance={"turbine_speed": 1.0},
        structural=frozenset({"compliant_clutches"}),
        form=frozenset({f"stresses.{n}" for n in ("shaft_diameter", "driven_shaft_diameter", "lever_arm", "lever_width",
                                                  "lever_height", "pin_diameter")}),
    ),
}
