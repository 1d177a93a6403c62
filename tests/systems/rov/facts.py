"""Underwater vehicle."""

from cosimo.tests.contract.facts import Facts

AXES = ("surge", "sway", "heave", "roll", "pitch", "yaw")
WAYS = ("north", "east", "depth", "roll", "pitch", "yaw")
PUSHED = {"thrust[1]": 3.0, "thrust[2]": -5.0, "thrust[4]": 8.0, "thrust[5]": 2.0}
NO_WEIGHT = {"restoring.weight": 0.0, "restoring.buoyancy": 0.0}


def each_alone(effect: str, value: float) -> dict[str, tuple[dict[str, float], float]]:
    """Each coefficient of an effect with one number an axis, the others at 0."""
    none = {f"{effect}.{axis}": 0.0 for axis in AXES}
    return {name: ({k: v for k, v in none.items() if k != name}, value) for name in none}


SENSED = ("usbl", "depth", "dvl", "rate", "attitude")
ERRORS = {
    "noise": [f"noise.{axis}" for axis in SENSED],
    "bias": [f"bias.{axis}{walk}" for axis in SENSED for walk in ("", "_walk")],
}
FACTS: dict[str, Facts] = {
    "RovHull": Facts(
        moving=frozenset({"*"}),  # no published vehicle is neutral: it rises or sinks from the start
        plain=(
            ("added_mass", "coriolis", "linear_drag", "quadratic_drag", "restoring", "current", "tether", "external"),
            {},
            100,
        ),
        disturbance=PUSHED,
        step=0.01,
        strengths={
            **each_alone("added_mass", 1e-3),
            **each_alone("linear_drag", 1e-3),
            **each_alone("quadratic_drag", 1e-4),
            "restoring.weight": (NO_WEIGHT, 1e-3),
            "restoring.buoyancy": (NO_WEIGHT | {"restoring.centre_of_buoyancy_z": -0.01}, 1e-3),
            **{f"current.velocity_{way}": ({}, 1e-3) for way in ("north", "east", "down")},
            **{f"tether.force_{way}": ({}, 1e-4) for way in ("north", "east", "down")},
            "pressure_gradient.displaced_mass": ({"current.acceleration_north": 0.1}, 1e-3),
            "further_thrusters.thrust[1]": ({}, 1e-4),
            **{f"external.{what}_{axis}": ({}, 1e-4) for what in ("force", "moment") for axis in "xyz"},
            "added_mass_coupling.force[2]": ({}, 1e-3),
            "linear_drag_coupling.force_by_speed[2]": ({}, 1e-3),
            "quadratic_drag_coupling.force_by_speed[2]": ({}, 1e-4),
        },
        structural=frozenset({"coriolis"}),
        # the water's acceleration acts on added mass only, which the effect alone has not
        form=frozenset(
            {f"restoring.centre_of_buoyancy_{axis}" for axis in "xyz"}
            | {f"current.acceleration_{way}" for way in ("north", "east", "down")}
            | {f"tether.attachment_{axis}" for axis in "xyz"}
            | {f"pressure_gradient.centre_{axis}" for axis in "xyz"}
            | {f"added_mass_coupling.{name}" for name in ("force", "mixed", "moment")}
            | {
                f"{kind}_drag_coupling.{load}_by_{way}"
                for kind in ("linear", "quadratic")
                for load in ("force", "moment")
                for way in ("speed", "rate")
            }
            | {f"further_thrusters.thruster_{axis}" for axis in "xyz"}
            | {f"further_thrusters.thruster_direction_{axis}" for axis in "xyz"}
        ),
    ),
    "AddedMassForce": Facts(),
    "Thruster": Facts(
        plain=(("propeller", "inductance"), {}, 20),
        other_ways=(({}, ("polynomial_curve", "motor_lag")), ({}, ("static_curve", "lag"))),
        structural=frozenset({"static_curve", "polynomial_curve", "lag", "motor_lag", "propeller", "inductance", "status"}),
    ),
    "WaterCurrent": Facts(
        moving=frozenset({"*"}),
        plain=(("tide", "ramp", "gust"), {"gust.start_time": 0.0}, 20),
        step=0.2,
        strengths={"tide.amplitude": ({}, 1e-3), "gust.amplitude": ({}, 1e-3), "waves.height": ({}, 1e-3)},
        structural=frozenset({"ramp", "spectrum"}),
        form=frozenset(
            {
                "tide.period",
                "tide.phase",
                "tide.direction",
                "gust.start_time",
                "gust.duration",
                "gust.direction",
                "waves.period",
                "waves.direction",
                "waves.phase",
                "waves.water_depth",
                "waves.position_north",
                "waves.position_east",
                "waves.depth",
            }
        ),
    ),
    "RovController": Facts(
        plain=(("inverse_curve", "manoeuvre"), {"period": 2e-3, "manoeuvre.time[2]": 10.0, "manoeuvre.pitch[2]": 1.0}, 20),
        disturbance={"position_north": 0.3, "depth": -0.2, "quaternion_x": 0.1, "yaw_rate": 0.05},
        step=0.02,
        strengths={f"manoeuvre.{way}[2]": ({"manoeuvre.time[2]": 2.0}, 1e-4) for way in WAYS},
        structural=frozenset({"inverse_curve", "further_thrusters"}),
        form=frozenset({"manoeuvre.time"}),
    ),
    "RovSensors": Facts(
        plain=(("noise", "bias", "dropout"), {"period": 2e-3, "usbl_every": 5, "dvl_every": 2}, 20),
        disturbance={"position_north": 0.3, "surge": 0.2, "quaternion_x": 0.1, "yaw_rate": 0.05},
        step=0.02,
        strengths={
            f"{effect}.{axis}": ({n: 0.0 for n in ERRORS[effect] if n != f"{effect}.{axis}"}, 1e-4)
            for effect in ("noise", "bias")
            for axis in SENSED
        },
        structural=frozenset({"dropout"}),
        form=frozenset({"noise.seed", "bias.seed"} | {f"bias.{axis}_walk" for axis in SENSED}),
    ),
    "Tether": Facts(
        small={"segments": 3},
        plain=(("internal_damping", "drag", "current"), {"segments": 3}, 20),
        disturbance={"velocity_north": 1.0, "velocity_east": 0.5},
        strengths={
            "internal_damping.coefficient": ({}, 1e-3),
            "drag.normal_coefficient": ({"drag.tangential_coefficient": 0.0}, 1e-4),
            "drag.tangential_coefficient": ({"drag.normal_coefficient": 0.0}, 1e-4),
            **{f"current.velocity_{way}": ({}, 1e-4) for way in ("north", "east", "down")},
        },
    ),
}
