"""Two-axis joint, and the motors that drive it."""

from cosimo.tests.contract.facts import Facts

TORQUES = {"first_torque": 0.3, "second_torque": 0.2}
AT_THE_STOP = {"stops.upper": 0.0}

FACTS: dict[str, Facts] = {
    "GimbalBody": Facts(
        structural=frozenset({"high_order"}),
        plain=(("gravity", "rotor", "viscous", "stick_friction", "stops", "base_motion", "payload", "reactions"), {}, 20),
        disturbance={"outer_torque": 0.3, "inner_torque": 0.2},
        strengths={
            "gravity.mass": ({}, 1e-3),
            "rotor.spin_momentum": ({}, 1e-4),
            "viscous.outer_coefficient": ({"viscous.inner_coefficient": 0.0}, 1e-4),
            "viscous.inner_coefficient": ({"viscous.outer_coefficient": 0.0}, 1e-4),
            "smoothed_friction.outer_level": ({"smoothed_friction.inner_level": 0.0}, 1e-4),
            "smoothed_friction.inner_level": ({"smoothed_friction.outer_level": 0.0}, 1e-4),
            "stick_friction.outer_level": ({"stick_friction.inner_level": 0.0}, 1e-4),
            "stick_friction.inner_level": ({"stick_friction.outer_level": 0.0}, 1e-4),
            "lugre_friction.stiffness": ({"lugre_friction.damping": 0.0}, 1e-2),
            "lugre_friction.damping": ({"lugre_friction.stiffness": 0.0}, 1e-4),
            "stops.stiffness": ({"stops.outer_upper": 0.0, "stops.inner_upper": 0.5}, 1e-2),
            **{
                f"base_motion.{n}": ({}, 1e-4)
                for n in ("rate", "acceleration", "acceleration_x", "acceleration_y", "acceleration_z")
            },
            **{f"payload.moment_{axis}": ({}, 1e-4) for axis in "xyz"},
        },
        form=frozenset(
            {
                "gravity.distance",
                "gravity.acceleration",
                "smoothed_friction.width",
                "stick_friction.static_ratio",
                "stops.outer_lower",
                "stops.inner_lower",
                "stops.outer_upper",
                "stops.inner_upper",
                "stops.dissipation",
                *(f"lugre_friction.{n}" for n in ("outer_level", "inner_level", "static_ratio", "stribeck_rate")),
            }
        ),
    ),
    "TorqueMotor": Facts(
        plain=(("inductance", "saturation"), {}, 20),
        disturbance={"voltage": 6.0, "rate": 2.0},
        structural=frozenset({"inductance"}),  # tends to none with the inductance, but in steps that become as short
        form=frozenset({"saturation.voltage", "saturation.current"}),
    ),
    "GimbalController": Facts(
        plain=(("scan",), {}, 20),
        disturbance={"outer_angle": 1e-3, "inner_angle": -2e-3, "outer_rate": 0.01},
        strengths={
            f"scan.{axis}_amplitude": ({f"scan.{other}_amplitude": 0.0}, 1e-5)
            for axis, other in (("outer", "inner"), ("inner", "outer"))
        },
        form=frozenset(f"scan.{axis}_{what}" for axis in ("outer", "inner") for what in ("frequency", "phase")),
    ),
    "TwoLinkChain": Facts(
        released=frozenset({"satellite panel"}),
        plain=(("gravity", "viscous", "stick_friction", "stops", "reactions"), {"start_second_angle": 0.3}, 20),
        disturbance=TORQUES,
        strengths={
            "gravity.acceleration": ({}, 1e-3),
            "viscous.first": ({"viscous.second": 0.0}, 1e-4),
            "viscous.second": ({"viscous.first": 0.0}, 1e-4),
            "springs.first_stiffness": ({"springs.second_stiffness": 0.0}, 1e-4),
            "springs.second_stiffness": ({}, 1e-4),
            "smoothed_friction.first_level": ({"smoothed_friction.second_level": 0.0}, 1e-4),
            "smoothed_friction.second_level": ({"smoothed_friction.first_level": 0.0}, 1e-4),
            "stick_friction.first_level": ({"stick_friction.second_level": 0.0}, 1e-4),
            "stick_friction.second_level": ({"stick_friction.first_level": 0.0}, 1e-4),
            "stops.stiffness": (AT_THE_STOP, 1e-3),
            "lugre_friction.stiffness": ({"lugre_friction.damping": 0.0}, 1e-2),
            "lugre_friction.damping": ({"lugre_friction.stiffness": 0.0}, 1e-4),
        },
        structural=frozenset({"high_order", "reactions", "latch"}),
        form=frozenset(
            {
                "smoothed_friction.width",
                "stick_friction.static_ratio",
                "springs.first_rest",
                "springs.second_rest",
                *(f"stops.{n}" for n in ("lower", "upper", "dissipation")),
                *(f"lugre_friction.{n}" for n in ("first_level", "second_level", "static_ratio", "stribeck_rate")),
            }
        ),
    ),
    "PassiveWalker": Facts(moving=frozenset({"*"}), plain=((), {"start_swing_rate": -0.2}, 20), disturbance={"hip_torque": 1.0}),
    "PlanarLink": Facts(
        plain=(("pinned", "gravity"), {"start_angle": 0.3}, 20),
        disturbance={"tip_force_x": 1.0, "base_torque": 0.2},
        strengths={"gravity.acceleration": ({}, 1e-3)},
        structural=frozenset({"pinned"}),
    ),
    "CompliantJoint": Facts(
        plain=(("rotation", "clearance"), {}, 5),
        disturbance={"second_x": 1e-4, "second_velocity_y": 1e-3},
        strengths={"clearance.radius": ({}, 1e-7)},
        structural=frozenset({"rotation"}),
    ),
}
