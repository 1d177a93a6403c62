"""Wrist: the two rows, and what moves and holds them."""

from __future__ import annotations

from cosimo.tests.contract.families import Facts

WEIGHTLESS = {"load.gravity_x": 0.0}
TAUT = {"constraint.prestrain": 0.05}
OTHERS_CUT = {f"constraint.stiffness[{j}]": 0.0 for j in range(1, 6)}

RIGID = {"constraint.kind": "rigid", **{f"constraint.off_axis[{j}]": 0.0 for j in (1, 3, 4, 5)}}  # holds the distal row

FACTS: dict[str, Facts] = {
    "Wrist": Facts(
        plain=(("morphology", "constraint", "interaction", "load"), {"start_proximal_angle": 0.3}, 20),
        other_ways=(
            ({"coupling_model": "opensim_half"}, ("morphology", "constraint")),
            (RIGID, ("morphology", "constraint")),
        ),
        disturbance={"tau_flexion": 0.5, "tau_deviation": 0.3, "distal_torque": 0.1},
        strengths={
            "constraint.stiffness[1]": (OTHERS_CUT | TAUT, 1.0),
            "interaction.stiffness": ({"interaction.flexion_upper": 0.0, "interaction.contact_stiffness": 0.0}, 1e-3),
            "interaction.contact_stiffness": ({"interaction.contact_lower": 0.0, "interaction.stiffness": 0.0}, 1e-3),
            "load.gravity_x": ({}, 1e-4),
            "load.gravity_y": (WEIGHTLESS, 1e-4),
            "load.gravity_z": (WEIGHTLESS, 1e-4),
            **{f"load.{n}": (WEIGHTLESS, 1e-3) for n in ("flexor_radial", "flexor_ulnar", "extensor_radial", "extensor_ulnar",
                                                         "tip_force_x", "tip_force_y", "tip_force_z")},
        },
        structural=frozenset({"morphology"}),  # finite rotations instead of small ones
        form=frozenset({
            *(f"constraint.{n}" for n in ("kind", "cut", "off_axis", "prestrain", "toe", "damping")),
            "constraint.lunate_extent", "constraint.triquetrum_extent",
            *(f"interaction.{what}_{end}" for what in ("flexion", "deviation", "contact") for end in ("lower", "upper")),
            "interaction.dissipation",
            *(f"load.{n}" for n in ("flexion_arm", "deviation_arm", "tool_distance")),
        }),
    ),
    "LigamentBundle": Facts(
        plain=((), {"damping": 0.1}, 20),
        other_ways=(({"coupling_model": "opensim_half"}, ()),),
    ),
}
