"""Friction-wheel drive: wheels with sleeve, and the whole drive."""

from cosimo.tests.contract.facts import Facts

LAW = frozenset({"lugre_slip", "exact_slip", "smoothed_slip", "rolling_slip"})  # laws of friction in place of creep
FORM = frozenset(
    {
        "trocar_friction.static_ratio",
        "trocar_friction.deflection",
        "trocar_friction.damping_time",
        "gravity.inclination",
        "preload_loss.start",
        "preload_loss.duration",
    }
)
SLIDING = {
    "preload_loss.start": 0.01,
    "normal_force": 0.1,
    "exact_slip.deflection": 1e-6,
    "trocar_friction.level": 0.1,
    "trocar_friction.deflection": 1e-5,
}  # so that contacts and seal break loose within the 20 ms
LOST = {"preload_loss.start": 0.0, "preload_loss.duration": 0.01}
STRENGTHS = {
    "trocar_friction.level": ({}, 1e-4),
    "gravity.acceleration": ({}, 1e-3),
    "preload_loss.first": ({**LOST, "preload_loss.second": 0.0}, 1e-4),
    "preload_loss.second": ({**LOST, "preload_loss.first": 0.0}, 1e-4),
}

FACTS: dict[str, Facts] = {
    "FrictionWheels": Facts(
        plain=(("exact_slip", "trocar_friction", "gravity", "preload_loss"), SLIDING, 20),
        disturbance={"first_rate": 5.0, "second_rate": 3.0, "external_force": 1.0, "external_torque": 0.002},
        strengths=STRENGTHS,
        structural=LAW,
        form=FORM,
    ),
    "FrictionDrive": Facts(
        plain=(
            ("inductance", "shaft_friction", "exact_slip", "trocar_friction", "gravity", "preload_loss"),
            SLIDING | {"shaft_friction.level": 1e-4},
            20,
        ),
        disturbance={"first_voltage": 6.0, "second_voltage": 3.0, "external_force": 1.0, "external_torque": 0.002},
        strengths={
            **STRENGTHS,
            "shaft_friction.level": ({"shaft_friction.gear_loss": 0.0}, 1e-5),
            "shaft_friction.gear_loss": ({"shaft_friction.level": 0.0}, 1e-5),
        },
        structural=LAW | {"inductance"},  # with the inductance the steps would become as short
        form=FORM | {"shaft_friction.static_ratio"},
    ),
    "ServoController": Facts(
        plain=(("quantisation", "reference"), {"feed_integral_gain": 100.0}, 20),
        other_ways=(({"feedback": "wheels", "layout": "orthogonal"}, ()),),
        disturbance={"feed": 1e-3, "rotation": -0.02, "first_rate": 0.1},
        strengths={
            "reference.feed[2]": ({"reference.rotation[2]": 0.0}, 1e-5),
            "reference.rotation[2]": ({"reference.feed[2]": 0.0}, 1e-4),
        },
        structural=frozenset({"quantisation"}),  # rates are differences of counts, however small the steps
        form=frozenset({"reference.time"}),
    ),
}
