"""Hard cases of the friction drive: both wheels stuck, parallel wheels, no preload, stiff contacts, far set points."""

from __future__ import annotations

import math

import numpy as np

from ..core.component import Component
from ..core.hard_cases import (
    AtLeast,
    AtMost,
    BoundedEnergy,
    Ends,
    Finite,
    HardCase,
    InputSignal,
    Invariant,
    Like,
    Refused,
    events,
    jumps,
    outputs,
    ramp,
    sine,
)

STIFFNESS = 2.0 * 0.4 * 15.0 / 1e-4  # N/m, both default contacts
FULL = ("exact_slip", "trocar_friction", "gravity", "preload_loss")
NEUTRAL = {"trocar_friction.level": 0.0, "gravity.acceleration": 0.0, "preload_loss.first": 0.0}
LOST = {"preload_loss.start": 0.0, "preload_loss.duration": 1e-6, "substep": 2e-4}
LAWS = ("exact_slip", "lugre_slip", "smoothed_slip")
FAST = 2.0 * math.sin(math.pi / 6.0) * 6.0 * 0.01  # N.s around the sleeve, of sliding friction in 10 ms
UPRIGHT = {"gravity.acceleration": 9.81, "gravity.inclination": 0.5 * math.pi}


def _tractions(component: Component) -> np.ndarray:
    """Magnitudes of the tractions of both contacts, N."""
    wheels = (f"{wheel}_traction" for wheel in ("first", "second"))
    return np.array([math.hypot(component[f"{name}_axial"], component[f"{name}_around"]) for name in wheels])


def _given(component: Component) -> np.ndarray:
    """Tractions of both contacts under 6 N and 0.01 N.m, N: along 3, around -1."""
    return np.array([component[f"{wheel}_traction_{way}"] for wheel in ("first", "second") for way in ("axial", "around")])


def _let_go(component: Component) -> np.ndarray:
    """What wheels without preload give."""
    return np.array([component[n] for n in ("margin", "first_torque", "contact_power")])


def _turned(component: Component) -> float:
    """Momentum around the sleeve, N.s."""
    return 1.875e-6 / 0.005 * component["rotation_rate"]


def _voltages(component: Component) -> np.ndarray:
    return component.y[:2]


def _there_and_back(t: float) -> float:
    """6 N within 0.2 s, held for half as long, and back."""
    return -6.0 * max(min(5.0 * t, 2.5 - 5.0 * t, 1.0), 0.0)


HARD_CASES = {
    "FrictionWheels": {
        "both wheels stuck": HardCase(
            "Rigid contacts would leave the tractions open; these share the load, and lose nothing.",
            (Ends("feed", 1e-15), AtMost("feed", 6.0 / STIFFNESS * 1.01), AtMost(events, 0.0, "events")),
            effects=("exact_slip",),
            parameters={"substep": 2e-4},
            inputs={"external_force": InputSignal(_there_and_back)},
            run=(0.6, 0.02),
        ),
        "rolling contacts, turned back and forth": HardCase(
            "Creep in both directions through standstill: friction bounds it, but for the dashpot of a deflection that grows.",
            (AtMost(_tractions, 6.0 * 1.25, "tractions, dashpots included, N"), Finite(limit=10.0)),
            effects=("rolling_slip",),
            parameters={"substep": 5e-5},
            inputs={"first_rate": sine(20.0, 11.0), "second_rate": sine(20.0, 11.0), "external_force": sine(9.0, 7.0)},
            run=(2.0, 0.01),
        ),
        "a rolling contact at rest": HardCase(
            "A load that friction bears is held: what stands does not creep.",
            (AtMost(lambda c: c["feed"], 1e-4, "feed, m"), Ends("feed_rate", 1e-9, value=0.0)),
            effects=("rolling_slip",),
            inputs={"external_force": -9.0},
            run=(3.0, 0.05),
        ),
        "held under vibration": HardCase(
            "5 N with 3 N at 40 Hz on top of 14 N that hold: it is back where it was.",
            (Ends("feed", 1e-15, value=5.0 / STIFFNESS), AtMost(events, 0.0, "events")),
            effects=("exact_slip",),
            parameters={"substep": 2e-4},
            inputs={
                "external_force": InputSignal(
                    lambda t: 5.0 * min(10.0 * t, 1.0) + (3.0 * math.sin(80.0 * math.pi * t) if 0.2 < t < 0.4 else 0.0)
                )
            },
            run=(0.5, 2e-3),
        ),
        "parallel free rollers": HardCase(
            "They lose the rotation: it is left to the load, M t / J.",
            (Ends("rotation_rate", 1e-12, value=1e-4 * 0.5 / 1.875e-6, share=True), Ends("feed_rate", 1e-6, value=0.2)),
            effects=("exact_slip",),
            parameters={"layout": "skewed_free_rollers", "angle": 0.0, "substep": 2e-4},
            inputs={"first_rate": 20.0, "second_rate": 20.0, "external_force": -1.0, "external_torque": 1e-4},
            run=(0.5, 0.01),
        ),
        "no preload": HardCase(
            "An upright sleeve whose wheels let go falls as a stone.",
            (Ends("feed_rate", 1e-5, value=-9.81 * 0.2), Ends(_let_go, 1e-15, "margin, torque, power")),
            effects=FULL,
            parameters=NEUTRAL
            | UPRIGHT
            | {
                "preload_loss.first": 1.0,
                "preload_loss.second": 1.0,
                "preload_loss.start": 0.0,
                "preload_loss.duration": 1e-6,
                "substep": 2e-4,
            },
            run=(0.2, 0.01),
        ),
        **{
            f"hardly any preload, {left:g}": HardCase(
                "No stiffer than with all, and not faster than the wheels.",
                (AtMost("feed_rate", 0.1733), AtLeast("feed_rate", 0.0), AtMost(events, 20.0, "events")),
                effects=FULL,
                parameters=NEUTRAL | {f"preload_loss.{wheel}": 1.0 - left for wheel in ("first", "second")} | LOST,
                inputs={"first_rate": 20.0, "second_rate": 20.0},
                run=(0.5, 0.01),
            )
            for left in (1e-3, 1e-9, 1e-15)
        },
        "both wheels share a load and a moment": HardCase(
            "It grows slowly, is held, and goes: half each, and nothing is lost.",
            (
                Ends(_given, 1e-9, "tractions, N", value=np.array([3.0, -1.0, 3.0, -1.0])),
                Ends("feed", 1e-13, value=-6.0 / STIFFNESS),
            ),
            effects=("exact_slip",),
            parameters={"substep": 2e-4},
            inputs={
                "external_force": InputSignal(lambda t: -6.0 * min(5.0 * t, 1.0)),
                "external_torque": InputSignal(lambda t: 0.01 * min(5.0 * t, 1.0)),
            },
            run=(0.6, 0.02),
        ),
        "parallel plain wheels": HardCase(
            "They hold the rotation.",
            (Ends("rotation_rate", 1e-9), Ends("feed_rate", 1e-9, value=0.2)),
            effects=("exact_slip",),
            parameters={"angle": 0.0},
            inputs={"first_rate": 20.0, "second_rate": 20.0, "external_force": -1.0, "external_torque": 1e-4},
            run=(0.5, 0.01),
        ),
        "hardly any friction": HardCase(
            "A billionth: it is followed, 2 mu N cos / m.",
            (Ends("feed_rate", 1e-3, value=2.0 * 1e-9 * 15.0 * math.cos(math.pi / 6.0) / 0.15, share=True),),
            effects=("exact_slip",),
            parameters={"friction": 1e-9},
            inputs={"first_rate": 20.0, "second_rate": 20.0},
            run=(1.0, 0.05),
        ),
        **{
            f"a stiff contact, {name}, {' '.join(effects) or 'no effect'}": HardCase(
                "Beyond the substep.",
                Refused("the limit of RK4", accepted={name: soft}),
                effects=effects,
                parameters={name: stiff},
            )
            for effects, name, stiff, soft in (
                (("lugre_slip",), "lugre_slip.stiffness", 1e10, 6e4),
                (("lugre_slip",), "lugre_slip.damping", 1e4, 1e2),
                (("smoothed_slip",), "creep", 1e5, 900.0),
                ((), "creep", 1e5, 900.0),
            )
        },
        **{
            f"{law}, one long step": HardCase(
                "It is many short ones.",
                (Like(outputs, 1e-8, "all outputs after short steps", instead={"run": (0.5, 1e-3)}),),
                effects=(law,),
                inputs={"first_rate": 20.0, "second_rate": 5.0, "external_force": -3.0, "external_torque": 0.01},
                run=(0.5, 0.5),
            )
            for law in LAWS
        },
        **{
            f"{law}, no slip at all": HardCase(
                "It has no direction and no force.",
                (AtMost(lambda c: c.x[:6], 0.0, "motion"), Invariant("margin", 0.0, value=1.0)),
                effects=(law,),
                run=(0.01, 0.01),
            )
            for law in LAWS
        },
        **{
            f"{law}, rims at 1 km/s": HardCase(
                "What turns the sleeve is friction, and what dashpots and bristles give on their way.",
                (Ends(_turned, 0.5 * (more + 0.02 * FAST), "momentum around, N.s", value=FAST + 0.5 * (more - 0.02 * FAST)),),
                effects=(law,),
                parameters=given,
                inputs={"first_rate": 1e5, "second_rate": -1e5},
                run=(0.01, 0.01),
            )
            for law, given, more in (
                ("exact_slip", {}, 60.0 * 1.2e-4),
                ("lugre_slip", {"lugre_slip.viscous": 0.0}, 60.0 * 1.2e-4),
                ("smoothed_slip", {}, 1e-15),
            )
        },
        "stick and slip at every half cycle": HardCase(
            "A force beyond the contacts swings: tractions within what friction bears.",
            (AtMost(_tractions, 2.0 * 1.2 * 6.0, "tractions, dashpots included, N"), Finite()),
            effects=("exact_slip",),
            parameters={"substep": 2e-4},
            inputs={"external_force": sine(16.0, 10.0 * math.pi)},
            run=(0.4, 2e-3),
        ),
        "a contact beyond the substep": HardCase(
            "A hundredth of a micrometre of deflection.",
            Refused("the limit of RK4", accepted={"exact_slip.deflection": 1e-5}),
            effects=("exact_slip",),
            parameters={"exact_slip.deflection": 1e-8},
        ),
        "creep at the stable step": HardCase(
            "A blow at 0.97 of the limit dies away.",
            (BoundedEnergy(limit=1e-12),),
            parameters={"substep": 1.58e-4, "start_feed_rate": 1e-4, "start_rotation_rate": 0.01},
            run=(0.2, 5e-3),
        ),
    },
    "FrictionDrive": {
        "held by two standing motors": HardCase(
            "No voltage and 5 N on the sleeve: contacts and shafts stick.",
            (AtMost("feed_rate", 1e-3), AtMost("first_rate", 0.0), Ends("feed", 1e-12, value=(5.0 - 50.0 * 1e-3) / STIFFNESS)),
            effects=("shaft_friction", "exact_slip"),
            parameters={"shaft_friction.level": 0.05},
            inputs={"external_force": ramp(50.0)},
            run=(0.1, 2e-3),
        ),
        "wheels against one another": HardCase(
            "Both motors at full voltage, in opposite directions: tractions within friction.",
            (AtMost(_tractions, 2.0 * 1.2 * 6.0, "tractions, dashpots included, N"), Finite()),
            effects=("exact_slip",),
            inputs={"first_voltage": 12.0, "second_voltage": -12.0},
            run=(0.1, 2e-3),
        ),
        "a reversal under full voltage": HardCase(
            "Ten times a second, with dry shafts: tractions within friction.",
            (AtMost(_tractions, 2.0 * 1.2 * 6.0, "tractions, dashpots included, N"), Finite()),
            effects=("shaft_friction", "exact_slip"),
            inputs={
                "first_voltage": jumps(12.0, (0.05, -12.0), (0.1, 12.0)),
                "second_voltage": jumps(12.0, (0.05, -12.0), (0.1, 12.0)),
            },
            run=(0.15, 2e-3),
        ),
        "hardly any inductance": HardCase(
            "Its pole at 2e5 1/s is beyond the substep.",
            Refused("the limit of RK4", accepted={"inductance.inductance": 1e-4}),
            effects=("inductance",),
            parameters={"inductance.inductance": 1e-5},
        ),
    },
    "ServoController": {
        "an infinite set point": HardCase(
            "1e200 m: voltages at their limit, no number lost.",
            (AtMost(_voltages, 12.0, "voltages, V"),),
            parameters={"set_feed": 1e200},
            run=(1.0, 0.01),
        ),
        "a stuck sleeve": HardCase(
            "An error that stays for 10 s: the integrals do not wind up.",
            (AtMost(_voltages, 12.0, "voltages, V"), AtMost(lambda c: c.x[3:5], 12.0 + 20.0 * 10.0 * 0.02, "integrals, V")),
            parameters={"set_feed": 1e-3, "feed_integral_gain": 50.0},
            run=(10.0, 0.1),
        ),
        "counts at rest": HardCase(
            "Half a count to and fro is a rate of 0.165 rad/s and back: the voltage is what a count is worth.",
            (AtMost(_voltages, 0.1, "voltages, V"),),
            effects=("quantisation",),
            parameters={"feedback": "wheels"},
            inputs={"first_angle": sine(0.9e-4, 700.0)},
            run=(0.5, 1e-3),
        ),
        "parallel wheels": HardCase(
            "The inverse kinematics has no answer for the rotation.",
            Refused("The rotation is lost", accepted={"angle": 2e-3}),
            parameters={"angle": 5e-4},
        ),
        "a table that goes back": HardCase(
            "Times that decrease.",
            Refused("do not decrease", accepted={"reference.time[3]": 0.5}),
            effects=("reference",),
            parameters={"reference.time[3]": 0.4, "reference.feed[3]": 0.01},
        ),
        "a set point that is no number": HardCase(
            "Infinite.",
            Refused("finite", "construction", {"set_feed": 1e200}),
            parameters={"set_feed": math.inf},
            run=(0.01, 0.01),
        ),
    },
}
