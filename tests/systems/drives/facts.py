"""Motors that turn inertias of their own."""

from cosimo.tests.contract.facts import Facts

FACTS: dict[str, Facts] = {
    "ServoMotor": Facts(
        plain=(("inductance", "saturation", "shaft_friction", "heating"), {}, 20),
        disturbance={"voltage": 6.0, "load_torque": 0.05},
        strengths={
            "shaft_friction.level": ({"shaft_friction.gear_loss": 0.0}, 1e-4),
            "shaft_friction.gear_loss": ({"shaft_friction.level": 0.0}, 1e-4),
            "heating.coefficient": ({"heating.winding_capacity": 1e-4}, 1e-4),
        },
        structural=frozenset({"inductance"}),  # tends to none with the inductance, but in steps that become as short
        form=frozenset(
            {
                "saturation.voltage",
                "saturation.current",
                "shaft_friction.static_ratio",
                "heating.winding_capacity",
                "heating.housing_capacity",
                "heating.winding_to_housing",
                "heating.housing_to_ambient",
                "heating.ambient",
            }
        ),
    )
}
