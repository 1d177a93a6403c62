"""Hard cases of the friction drive: both wheels stuck, parallel wheels, no preload, stiff contacts, far set points."""

from __future__ import annotations

import math

import numpy as np

from ..core.component import Component
from ..core.hard_cases import AtMost, BoundedEnergy, Ends, Finite, HardCase, InputSignal, Refused, jumps, ramp, sine

STIFFNESS = 2.0 * 0.4 * 15.0 / 1e-4  # N/m, both default contacts
FULL = ("exact_slip", "trocar_friction", "gravity", "preload_loss")
NEUTRAL = {"trocar_friction.level": 0.0, "gravity.acceleration": 0.0, "preload_loss.first": 0.0}
LOST = {
    "preload_loss.first": 1.0 - 1e-9,
    "preload_loss.second": 1.0 - 1e-9,
    "preload_loss.start": 0.0,
    "preload_loss.duration": 1e-6,
}
UPRIGHT = {"gravity.acceleration": 9.81, "gravity.inclination": 0.5 * math.pi}


def _events(component: Component) -> float:
    return float(component.work["events"])


def _tractions(component: Component) -> np.ndarray:
    """Magnitudes of the tractions of both contacts, N."""
    wheels = (f"{wheel}_traction" for wheel in ("first", "second"))
    return np.array([math.hypot(component[f"{name}_axial"], component[f"{name}_around"]) for name in wheels])


def _voltages(component: Component) -> np.ndarray:
    return component.y[:2]


def _there_and_back(t: float) -> float:
    """6 N within 0.2 s, held for half as long, and back."""
    return -6.0 * max(min(5.0 * t, 2.5 - 5.0 * t, 1.0), 0.0)


HARD_CASES = {
    "FrictionWheels": (
        HardCase(
            "both wheels stuck",
            "Rigid contacts would leave the tractions open; these share the load, and lose nothing.",
            (Ends("feed", 1e-15), AtMost("feed", 6.0 / STIFFNESS * 1.01), AtMost(_events, 0.0, "events")),
            ("exact_slip",),
            {"substep": 2e-4},
            {"external_force": InputSignal(_there_and_back)},
            duration=0.6,
            step=0.02,
        ),
        HardCase(
            "held under vibration",
            "5 N with 3 N at 40 Hz on top of 14 N that hold: it is back where it was.",
            (Ends("feed", 1e-15, value=5.0 / STIFFNESS), AtMost(_events, 0.0, "events")),
            ("exact_slip",),
            {"substep": 2e-4},
            {
                "external_force": InputSignal(
                    lambda t: 5.0 * min(10.0 * t, 1.0) + (3.0 * math.sin(80.0 * math.pi * t) if 0.2 < t < 0.4 else 0.0)
                )
            },
            duration=0.5,
            step=2e-3,
        ),
        HardCase(
            "parallel free rollers",
            "They lose the rotation: it is left to the load, M t / J.",
            (Ends("rotation_rate", 1e-12, value=1e-4 * 0.5 / 1.875e-6, share=True), Ends("feed_rate", 1e-6, value=0.2)),
            ("exact_slip",),
            {"layout": "skewed_free_rollers", "angle": 0.0, "substep": 2e-4},
            {"first_rate": 20.0, "second_rate": 20.0, "external_force": -1.0, "external_torque": 1e-4},
            duration=0.5,
            step=0.01,
        ),
        HardCase(
            "no preload",
            "An upright sleeve whose wheels let go falls as a stone.",
            (Ends("feed_rate", 1e-5, value=-9.81 * 0.2),),
            FULL,
            NEUTRAL
            | UPRIGHT
            | {
                "preload_loss.first": 1.0,
                "preload_loss.second": 1.0,
                "preload_loss.start": 0.0,
                "preload_loss.duration": 1e-6,
                "substep": 2e-4,
            },
            duration=0.2,
            step=0.01,
        ),
        HardCase(
            "hardly any preload",
            "A billionth of it: no stiffer than with all, and not faster than the wheels.",
            (AtMost("feed_rate", 0.1733), AtMost(_events, 20.0, "events")),
            FULL,
            NEUTRAL | LOST | {"substep": 2e-4},
            {"first_rate": 20.0, "second_rate": 20.0},
            duration=0.3,
            step=0.01,
        ),
        HardCase(
            "stick and slip at every half cycle",
            "A force beyond the contacts swings: tractions within what friction bears.",
            (AtMost(_tractions, 2.0 * 1.2 * 6.0, "tractions, dashpots included, N"), Finite()),
            ("exact_slip",),
            {"substep": 2e-4},
            {"external_force": sine(16.0, 10.0 * math.pi)},
            duration=0.4,
            step=2e-3,
        ),
        HardCase(
            "a contact beyond the substep",
            "A hundredth of a micrometre of deflection.",
            Refused("the limit of RK4", accepted={"exact_slip.deflection": 1e-5}),
            ("exact_slip",),
            {"exact_slip.deflection": 1e-8},
        ),
        HardCase(
            "creep at the stable step",
            "A blow at 0.97 of the limit dies away.",
            (BoundedEnergy(limit=1e-12),),
            (),
            {"substep": 1.58e-4, "start_feed_rate": 1e-4, "start_rotation_rate": 0.01},
            duration=0.2,
            step=5e-3,
        ),
    ),
    "FrictionDrive": (
        HardCase(
            "held by two standing motors",
            "No voltage and 5 N on the sleeve: contacts and shafts stick.",
            (AtMost("feed_rate", 1e-3), AtMost("first_rate", 0.0), Ends("feed", 1e-12, value=(5.0 - 50.0 * 1e-3) / STIFFNESS)),
            ("shaft_friction", "exact_slip"),
            {"shaft_friction.level": 0.05},
            {"external_force": ramp(50.0)},
            duration=0.1,
            step=2e-3,
        ),
        HardCase(
            "wheels against one another",
            "Both motors at full voltage, in opposite directions: tractions within friction.",
            (AtMost(_tractions, 2.0 * 1.2 * 6.0, "tractions, dashpots included, N"), Finite()),
            ("exact_slip",),
            {},
            {"first_voltage": 12.0, "second_voltage": -12.0},
            duration=0.1,
            step=2e-3,
        ),
        HardCase(
            "a reversal under full voltage",
            "Ten times a second, with dry shafts: tractions within friction.",
            (AtMost(_tractions, 2.0 * 1.2 * 6.0, "tractions, dashpots included, N"), Finite()),
            ("shaft_friction", "exact_slip"),
            {},
            {"first_voltage": jumps(12.0, (0.05, -12.0), (0.1, 12.0)), "second_voltage": jumps(12.0, (0.05, -12.0), (0.1, 12.0))},
            duration=0.15,
            step=2e-3,
        ),
        HardCase(
            "hardly any inductance",
            "Its pole at 2e5 1/s is beyond the substep.",
            Refused("the limit of RK4", accepted={"inductance.inductance": 1e-4}),
            ("inductance",),
            {"inductance.inductance": 1e-5},
        ),
    ),
    "ServoController": (
        HardCase(
            "an infinite set point",
            "1e200 m: voltages at their limit, no number lost.",
            (AtMost(_voltages, 12.0, "voltages, V"),),
            (),
            {"set_feed": 1e200},
            duration=1.0,
            step=0.01,
        ),
        HardCase(
            "a stuck sleeve",
            "An error that stays for 10 s: the integrals do not wind up.",
            (AtMost(_voltages, 12.0, "voltages, V"), AtMost(lambda c: c.x[3:5], 12.0 + 20.0 * 10.0 * 0.02, "integrals, V")),
            (),
            {"set_feed": 1e-3, "feed_integral_gain": 50.0},
            duration=10.0,
            step=0.1,
        ),
        HardCase(
            "counts at rest",
            "Half a count to and fro is a rate of 0.165 rad/s and back: the voltage is what a count is worth.",
            (AtMost(_voltages, 0.1, "voltages, V"),),
            ("quantisation",),
            {"feedback": "wheels"},
            {"first_angle": sine(0.9e-4, 700.0)},
            duration=0.5,
        ),
        HardCase(
            "parallel wheels",
            "The inverse kinematics has no answer for the rotation.",
            Refused("The rotation is lost", accepted={"angle": 2e-3}),
            (),
            {"angle": 5e-4},
        ),
        HardCase(
            "a table that goes back",
            "Times that decrease.",
            Refused("do not decrease", accepted={"reference.time[3]": 0.5}),
            ("reference",),
            {"reference.time[3]": 0.4, "reference.feed[3]": 0.01},
        ),
    ),
}
