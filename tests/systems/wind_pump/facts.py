"""Wind pump."""

from cosimo.tests.contract.facts import Facts

FACTS: dict[str, Facts] = {
    "WindTurbine": Facts(
        moving=frozenset({"angle"}),
        small={"curve": "heier"},  # which knows pitch
        plain=(("pitch", "furling", "bearing_friction"), {"curve": "heier", "start_speed": 20.0}, 20),
        other_ways=(
            ({"curve": "farm"}, ("furling", "bearing_friction")),
            ({"curve": "simple", "start_speed": 20.0}, ()),
            ({"curve": "variant", "start_speed": 20.0}, ("pitch",)),
            ({"curve": "farm", "start_speed": 4.0}, ("performance_table",)),
        ),
        disturbance={"wind": 5.0, "torque": 3.0},
        strengths={"bearing_friction.kinetic": ({"bearing_friction.static": 0.1}, 1e-3)},
        structural=frozenset({"pitch", "furling", "performance_table"}),
        form=frozenset({"bearing_friction.static"}),
    ),
    "Wind": Facts(
        moving=frozenset({"*"}),
        plain=(("ramp", "daily", "turbulence", "gusts"), {"gusts.start_time": 0.0, "turbulence.interval": 3e-3}, 20),
        strengths={
            "ramp.rate": ({}, 1e-3),
            "daily.amplitude": ({}, 1e-3),
            "turbulence.intensity": ({}, 1e-3),
            "gusts.amplitude": ({"gusts.start_time": 0.0}, 1e-3),
        },
        form=frozenset(
            {
                "ramp.end_speed",
                "ramp.start_time",
                "ramp.return_time",
                "daily.strongest",
                "turbulence.length",
                "turbulence.interval",
                "turbulence.seed",
                "gusts.start_time",
                "gusts.rise",
                "gusts.stay",
                "gusts.period",
            }
        ),
    ),
    "FixedTransmission": Facts(
        plain=(("mesh_friction",), {"start_speed": 2.0}, 20),
        disturbance={"turbine_speed": 2.0, "load_torque": 5.0},
        strengths={"mesh_friction.coefficient": ({}, 1e-3)},
        form=frozenset({"mesh_friction.width"}),
    ),
    "PlanetaryTransmission": Facts(
        small={"start_speed": 1.0},  # with which the third shaft turns
        moving=frozenset({"*"}),
        plain=(("mesh_friction", "dry_brake", "centrifugal_brake"), {}, 20),
        disturbance={"turbine_speed": 0.1, "load_torque": 1.0},
        step=2e-4,  # the third shaft does not turn over in this time
        strengths={
            "mesh_friction.coefficient": ({}, 1e-3),
            "dry_brake.kinetic": ({"dry_brake.static": 0.1}, 1e-3),
            "centrifugal_brake.coefficient": ({}, 1e-3),
        },
        form=frozenset({"mesh_friction.width", "dry_brake.static", "centrifugal_brake.largest_speed"}),
    ),
    "AveragedConverter": Facts(
        small={"start_speed": 1.0},  # at standstill the turbine feels nothing
        plain=(("mesh_friction",), {}, 20),
        disturbance={"turbine_speed": 4.0, "load_torque": 5.0},
        strengths={"mesh_friction.coefficient": ({}, 1e-3)},
        form=frozenset({"mesh_friction.width"}),
    ),
    "InertialConverter": Facts(
        small={"substep": 2.5e-5},  # what slipping clutches need, for every configuration
        plain=(("mesh_friction", "stresses"), {}, 20),
        disturbance={"turbine_speed": 4.0, "load_torque": 5.0},
        strengths={"mesh_friction.coefficient": ({}, 1e-3)},
        structural=frozenset({"compliant_clutches"}),
        form=frozenset(
            {
                "mesh_friction.width",
                *(
                    f"stresses.{n}"
                    for n in (
                        "shaft_diameter",
                        "driven_shaft_diameter",
                        "lever_arm",
                        "lever_width",
                        "lever_height",
                        "pin_diameter",
                    )
                ),
            }
        ),
    ),
    "PistonPump": Facts(
        moving=frozenset({"angle"}),
        other_ways=(({"action": "double", "rod_diameter": 0.03}, ()), ({"action": "double"}, ("seal_friction", "averaged"))),
        structural=frozenset({"averaged"}),
        plain=(("leakage", "seal_friction"), {"start_angle": 0.5}, 20),
        disturbance={"speed": 5.0, "head": 15.0},
        strengths={"leakage.share": ({}, 1e-3), "seal_friction.force": ({}, 1e-3)},
    ),
    "CentrifugalPump": Facts(
        plain=(("seal_friction",), {}, 20),
        disturbance={"speed": 140.0, "head": 15.0},
        other_ways=(({}, ("curve_table",)),),
        strengths={"seal_friction.torque": ({}, 1e-3)},
        structural=frozenset({"curve_table"}),
    ),
    "WaterPipe": Facts(
        plain=(("friction", "air_vessel", "tank"), {}, 20),
        disturbance={"flow": 1e-3},
        strengths={"friction.coefficient": ({}, 1e3)},
        structural=frozenset({"air_vessel", "tank"}),
    ),
}
