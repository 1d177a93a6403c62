"""Pipe robot."""

from cosimo.tests.contract.facts import Facts

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
        form=frozenset(
            {"harmonic_force.frequency", "cubic_spring.largest_stretch", "route.friction_factor", "route.largest_factor"}
        ),
    ),
    "RollingPipeRobot": Facts(
        small={"start_velocity": 0.3, "start_stretch": 1e-3},
        moving=frozenset({"*"}),
        other_ways=(({"start_velocity": 0.0, "friction": 0.02}, ("harmonic_force", "tow", "route")),),
        plain=(("harmonic_force", "tow", "route"), {}, 20),
        disturbance={"diameter": 0.2005, "taper": 1e-3},
        strengths={
            "harmonic_force.amplitude": ({}, 1e-3),
            "tow.force": ({}, 1e-3),
            "route.slope": ({}, 1e-5),
            "route.acceleration": ({"route.slope": 0.1}, 1e-3),
        },
        form=frozenset({"harmonic_force.frequency", "route.friction_factor"}),
    ),
    "PipeRoute": Facts(
        small={"slope_table[2]": 0.1, "diameter_table[2]": 0.19, "diameter_table[3]": 0.18, "factor_table[1]": 0.8},
        plain=((), {}, 5),
        structural=frozenset({"route_table"}),
    ),
    "TowCoupling": Facts(
        small={"length": 0.55},  # the bar pushes, the rope is slack
        plain=(("slack",), {"length": 0.4}, 5),
        disturbance={"front_position": 0.6, "rear_velocity": 0.1},
        structural=frozenset({"slack"}),
    ),
    "ExciterProgram": Facts(small={"start_amplitude": 10.0}, moving=frozenset({"*"}), plain=((), {"start_amplitude": 10.0}, 20)),
}
