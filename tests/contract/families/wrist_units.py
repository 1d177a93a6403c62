"""Wrist: the units without mass."""

from __future__ import annotations

from cosimo.tests.contract.families import Facts

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
    "ForearmTendons": Facts(
        small={"excitation[1]": 0.3, "excitation[5]": 0.5},  # muscles at rest pull at nothing
        plain=(("programme", "fibres", "force_velocity", "varying_arms"),
               {"programme.time[2]": 0.1, "programme.ecrl[2]": 1.0}, 20),
        disturbance={"excitation[1]": 0.6, "flexion": -0.3, "deviation": 0.1, "flexion_rate": 1.0},
        strengths={f"programme.{n}": ({}, 1e-3) for n in ("fcr[16]", "fcu[16]", "ecrl[16]", "ecrb[16]", "ecu[16]")}
        | {"varying_arms.slope[1]": ({f"varying_arms.slope[{i}]": 0.0 for i in range(2, 6)}, 1e-5)},
        structural=frozenset({"fibres", "force_velocity"}),  # vanish with an infinite length or rate
        form=frozenset({"programme.time"}),
    ),
}
