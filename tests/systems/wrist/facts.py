"""Wrist: the two rows, and what moves and holds them."""

from cosimo.tests.contract.facts import Facts

WEIGHTLESS = {"load.gravity_x": 0.0}
TAUT = {"constraint.prestrain": 0.05}
OTHERS_CUT = {f"constraint.stiffness[{j}]": 0.0 for j in range(1, 6)}

RIGID = {"constraint.kind": "rigid", **{f"constraint.off_axis[{j}]": 0.0 for j in (1, 3, 4, 5)}}  # holds the distal row

CHANGE_POINT = {"crank": 0.02, "coupler": 0.05, "rocker": 0.02, "ground": 0.05, "change_point": "through"}

FACTS: dict[str, Facts] = {
    "Wrist": Facts(
        plain=(("morphology", "constraint", "interaction", "load"), {"start_proximal_angle": 0.3}, 20),
        other_ways=(({"coupling_model": "opensim_half"}, ("morphology", "constraint")), (RIGID, ("morphology", "constraint"))),
        disturbance={"tau_flexion": 0.5, "tau_deviation": 0.3, "distal_torque": 0.1},
        strengths={
            "constraint.stiffness[1]": (OTHERS_CUT | TAUT, 1.0),
            "interaction.stiffness": ({"interaction.flexion_upper": 0.0, "interaction.contact_stiffness": 0.0}, 1e-3),
            "interaction.contact_stiffness": ({"interaction.contact_lower": 0.0, "interaction.stiffness": 0.0}, 1e-3),
            "load.gravity_x": ({}, 1e-4),
            "load.gravity_y": (WEIGHTLESS, 1e-4),
            "load.gravity_z": (WEIGHTLESS, 1e-4),
            **{
                f"load.{n}": (WEIGHTLESS, 1e-3)
                for n in (
                    "flexor_radial",
                    "flexor_ulnar",
                    "extensor_radial",
                    "extensor_ulnar",
                    "tip_force_x",
                    "tip_force_y",
                    "tip_force_z",
                )
            },
        },
        structural=frozenset({"morphology"}),  # finite rotations instead of small ones
        form=frozenset(
            {
                *(f"constraint.{n}" for n in ("kind", "cut", "off_axis", "prestrain", "toe", "damping")),
                "constraint.lunate_extent",
                "constraint.triquetrum_extent",
                *(f"interaction.{what}_{end}" for what in ("flexion", "deviation", "contact") for end in ("lower", "upper")),
                "interaction.dissipation",
                *(f"load.{n}" for n in ("flexion_arm", "deviation_arm", "tool_distance")),
            }
        ),
    ),
    "LigamentBundle": Facts(plain=((), {"damping": 0.1}, 20), other_ways=(({"coupling_model": "opensim_half"}, ()),)),
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
        plain=(
            ("programme", "fibres", "force_velocity", "varying_arms"),
            {"programme.time[2]": 0.1, "programme.ecrl[2]": 1.0},
            20,
        ),
        disturbance={"excitation[1]": 0.6, "flexion": -0.3, "deviation": 0.1, "flexion_rate": 1.0},
        strengths={f"programme.{n}": ({}, 1e-3) for n in ("fcr[16]", "fcu[16]", "ecrl[16]", "ecrb[16]", "ecu[16]")}
        | {"varying_arms.slope[1]": ({f"varying_arms.slope[{i}]": 0.0 for i in range(2, 6)}, 1e-5)},
        structural=frozenset({"fibres", "force_velocity"}),  # vanish with an infinite length or rate
        form=frozenset({"programme.time"}),
    ),
}
