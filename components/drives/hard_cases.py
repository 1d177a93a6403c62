"""Hard cases of motors: stall, friction at its level, no inductance to speak of, voltages beyond every limit."""

from __future__ import annotations

from ..core.hard_cases import AtMost, Ends, HardCase, Refused, jumps, sine

HOLD = 1.5 * 0.01  # N.m, static friction of the default shaft

HARD_CASES = {
    "TorqueMotor": (
        HardCase(
            "a voltage beyond every limit",
            "A kilovolt either way: the amplifier gives 24 V and 5 A.",
            (AtMost("current", 5.0), AtMost("torque", 0.5)),
            ("saturation",),
            {},
            {"voltage": sine(1e3, 50.0)},
        ),
        HardCase(
            "driven backwards under full voltage",
            "Induced voltage and the amplifier's add up: within its current.",
            (AtMost("current", 5.0),),
            ("saturation", "inductance"),
            {},
            {"rate": sine(200.0, 20.0), "voltage": 24.0},
        ),
        HardCase(
            "hardly any inductance",
            "1 uH and 2 Ohm settle in half a microsecond.",
            Refused("the limit of RK4", accepted={"inductance.substep": 1.3e-6}),
            ("inductance",),
            {"inductance.inductance": 1e-6},
        ),
    ),
    "ServoMotor": (
        HardCase(
            "stall",
            "A load above what 4 A give: it stands, within its current, and is not driven back.",
            (AtMost("rate", 0.0), Ends("current", 1e-8, value=4.0)),
            ("saturation", "shaft_friction", "inductance"),
            {"inductance.start_current": 4.0},
            {"voltage": 12.0, "load_torque": 2.0},
            duration=0.05,
        ),
        HardCase(
            "a load at the static level",
            "Just below what friction holds the shaft does not move by a bit.",
            (AtMost("angle", 0.0),),
            ("shaft_friction",),
            {"shaft_friction.gear_loss": 0.0},
            {"load_torque": jumps(0.0, (0.01, 0.999999 * HOLD), (0.05, -0.999999 * HOLD))},
        ),
        HardCase(
            "no voltage and no load",
            "Rest, whatever the effects.",
            (AtMost("angle", 0.0), AtMost("current", 0.0)),
            ("inductance", "saturation", "shaft_friction"),
            {"shaft_friction.level": 0.0},
        ),
        HardCase(
            "a rotor of a nanogram",
            "Beyond the substep.",
            Refused("the limit of RK4", accepted={"substep": 1e-5}),
            (),
            {"rotor_inertia": 1e-9, "wheel_inertia": 1e-9},
        ),
    ),
}
