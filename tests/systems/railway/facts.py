"""Railway."""

from cosimo.tests.contract.facts import Facts

PUSHED = {"contact_position": 52.0, "contact_force": 100.0}

FACTS = {
    "Pantograph": Facts(
        moving=frozenset({"contact_position"}),
        plain=(("contact_loss", "bump_stops", "frame_friction", "lower_frame"), {"bump_stops.travel": 0.001}, 100),
        disturbance={"wire_height": 0.003},
        strengths={
            "aerodynamic_uplift.coefficient": ({}, 1e-4),
            "bump_stops.stiffness": ({"bump_stops.travel": 0.0}, 1.0),
            "frame_friction.level": ({}, 1e-3),
            "base_excitation.height": ({}, 1e-4),
            "strip_lift.front": ({"strip_lift.rear": 0.0}, 1e-4),
            "strip_lift.rear": ({"strip_lift.front": 0.0}, 1e-4),
            "lift_fluctuation.intensity": ({}, 1e-3),
            "wire_unevenness.deviation": ({}, 1e-6),
            "acceleration.rate": ({}, 1e-2),
            "actuator.command": ({}, 1.0),
        },
        structural=frozenset(
            {"second_wire", "contact_loss", "lower_frame", "outer_contact", "two_strips", "measured_unevenness"}
        ),
        form=frozenset(
            {
                "bump_stops.travel",
                "frame_friction.width",
                "base_excitation.velocity",
                "acceleration.final_speed",
                "actuator.time_constant",
                "actuator.limit",
                *(f"lift_fluctuation.{n}" for n in ("lowest", "highest", "components", "seed")),
                *(f"wire_unevenness.{n}" for n in ("longest", "shortest", "exponent", "components", "seed")),
            }
        ),
    ),
    "LumpedCatenary": Facts(plain=(("inerter",), {}, 100), disturbance=PUSHED, strengths={"inerter.reference_force": ({}, 1.0)}),
    "Catenary": Facts(
        small={"spans": 2, "element": 5.0},
        other_ways=(({"method": "implicit"}, ("dropper_slackening", "gravity_sag", "damping")),),
        plain=(("dropper_slackening", "damping", "bending_stiffness"), {"spans": 1, "element": 5.0}, 20),
        disturbance=PUSHED,
        strengths={
            "damping.alpha": ({"damping.beta": 0.0}, 1e-3),
            "damping.beta": ({"damping.alpha": 0.0}, 1e-7),
            "bending_stiffness.contact_wire": ({"bending_stiffness.messenger": 0.0}, 1e-2),
            "bending_stiffness.messenger": ({"bending_stiffness.contact_wire": 0.0}, 1e-2),
            "steady_arm.stiffness": ({}, 10.0),
            "pre_sag.depth": ({}, 1e-4),
            "gusts.density": ({"gusts.lift_coefficient": 0.3}, 1e-3),
            "second_pantograph.contact_force": ({"second_pantograph.contact_position": 50.0}, 1.0),
            "further_pantographs.contact_force[1]": ({"further_pantographs.contact_position[1]": 70.0}, 1.0),
        },
        structural=frozenset(
            {
                "dropper_slackening",
                "gravity_sag",
                "level_support",
                "moving_window",
                "wire_profile",
                "line_profile",
                "line_table",
                "second_wire",
                "stagger",
                "temperature",
                "wear",
                "scatter",
                "blow_off",
            }
        ),
        # a kink under a force is rounded over sqrt(EI / T)
        roots=frozenset({"bending_stiffness.contact_wire", "bending_stiffness.messenger"}),
        form=frozenset(
            {
                "steady_arm.mass",
                "second_pantograph.contact_position",
                "further_pantographs.count",
                "further_pantographs.contact_position",
                *(
                    f"gusts.{n}"
                    for n in (
                        "speed",
                        "intensity",
                        "vertical_intensity",
                        "length",
                        "vertical_length",
                        "decay",
                        "contact_wire_diameter",
                        "messenger_diameter",
                        "drag_coefficient",
                        "lift_coefficient",
                        "lift_slope",
                        "lowest",
                        "highest",
                        "shortest",
                        "components",
                        "seed",
                    )
                ),
            }
        ),
    ),
}
