"""Hard cases of motors: stall, friction at its level, no inductance to speak of, voltages beyond every limit."""

from __future__ import annotations

from ..core.hard_cases import AtMost, Ends, HardCase, Refused, jumps, sine

HOLD = 1.5 * 0.01  # N.m, static friction of the default shaft

HARD_CASES = {
    "TorqueMotor": {
        "a voltage beyond every limit": HardCase(
            "A kilovolt either way: the amplifier gives 24 V and 5 A.",
            (AtMost("current", 5.0), AtMost("torque", 0.5)),
            effects=("saturation",),
            inputs={"voltage": sine(1e3, 50.0)},
        ),
        "driven backwards under full voltage": HardCase(
            "Induced voltage and the amplifier's add up: within its current.",
            (AtMost("current", 5.0),),
            effects=("saturation", "inductance"),
            inputs={"rate": sine(200.0, 20.0), "voltage": 24.0},
        ),
        "hardly any inductance": HardCase(
            "1 uH and 2 Ohm settle in half a microsecond.",
            Refused("the limit of RK4", accepted={"inductance.substep": 1.3e-6}),
            effects=("inductance",),
            parameters={"inductance.inductance": 1e-6},
        ),
    },
    "ServoMotor": {
        "stall": HardCase(
            "A load above what 4 A give: it stands, within its current, and is not driven back.",
            (AtMost("rate", 0.0), Ends("current", 1e-8, value=4.0)),
            effects=("saturation", "shaft_friction", "inductance"),
            parameters={"inductance.start_current": 4.0},
            inputs={"voltage": 12.0, "load_torque": 2.0},
            run=(0.05, 1e-3),
        ),
        "a load at the static level": HardCase(
            "Just below what friction holds the shaft does not move by a bit.",
            (AtMost("angle", 0.0),),
            effects=("shaft_friction",),
            parameters={"shaft_friction.gear_loss": 0.0},
            inputs={"load_torque": jumps(0.0, (0.01, 0.999999 * HOLD), (0.05, -0.999999 * HOLD))},
        ),
        "no voltage and no load": HardCase(
            "Rest, whatever the effects.",
            (AtMost("angle", 0.0), AtMost("current", 0.0)),
            effects=("inductance", "saturation", "shaft_friction"),
            parameters={"shaft_friction.level": 0.0},
        ),
        "a rotor of a nanogram": HardCase(
            "Beyond the substep.",
            Refused("the limit of RK4", accepted={"substep": 1e-5}),
            parameters={"rotor_inertia": 1e-9, "wheel_inertia": 1e-9},
        ),
    },
}
