"""Hard cases of pantograph and catenaries: contact lost, hardly any mass, no damping, slack droppers, steps too long."""

from __future__ import annotations

from ..core.component import Component
from ..core.hard_cases import AtLeast, AtMost, BoundedEnergy, Ends, Finite, HardCase, Invariant, Refused, jumps, ramp

RELEASED = {"contact_force": jumps(200.0, (0.0, 0.0))}
WAVE = (20e3 / 1.35) ** 0.5  # m/s, of the default contact wire
STITCHED = """[[sections]]
contact_wire = { tension = 27000, mass = 1.07 }
messenger = { tension = 21000, mass = 1.06 }
stitch = { half_length = 9.0, tension = 3500, mass = 0.31 }
support.system_height = 1.8
spans = [65, 65, 65]
"""
GRADIENT = "[[sections]]\nspans = [50, 50, 50]\nsupports = [5.0, 5.0, {0}, {0}]\n"
THREE_SPANS = {"spans": 3, "element": 1.0}


def _solutions(component: Component) -> float:
    """Linear systems solved for each internal step; a set of droppers that chatters would need up to 50."""
    return component.work["solves"] / max(component.work["steps"], 1)


HARD_CASES = {
    "Pantograph": (
        HardCase(
            "contact lost and regained",
            "The wire rises out of reach for 0.3 s and returns: a flight between two contacts.",
            (AtLeast("contact_force", 0.0), Finite()),
            ("contact_loss",),
            {"frame_stiffness": 0.0, "frame_damping": 0.0, "head_damping": 0.0},
            {"wire_height": jumps(0.0, (0.2, 1.0), (0.5, 0.0))},
            duration=1.0,
        ),
        HardCase(
            "no force at all",
            "A drive without force leaves the wire exactly at rest.",
            (AtMost("contact_force", 0.0), AtMost("head_height", 0.0)),
            ("contact_loss",),
            {"static_force": 0.0},
        ),
        HardCase(
            "a head of a tenth of a gram",
            "Its frequency is far beyond the substep.",
            Refused("the limit of RK4", accepted={"substep": 2.5e-5}),
            ("contact_loss",),
            {"head_mass": 1e-4},
        ),
        HardCase(
            "a stiff contact at the stable step",
            "Half of the contact force taken away at 0.99 of the limit: it swings, and does not grow.",
            (AtMost("contact_force", 190.0),),
            ("contact_loss",),
            {"contact_stiffness": 1e9, "substep": 2.18e-4},
            {"wire_height": jumps(0.0, (2e-3, 0.6e-7))},
        ),
        HardCase(
            "bump stops under a blow",
            "The frame is driven into its stops and out again: no energy comes from there.",
            (Finite(), AtLeast("contact_force", 0.0)),
            ("contact_loss", "bump_stops"),
            {"bump_stops.stiffness": 1e6},
            {"wire_height": jumps(0.0, (0.02, -0.3), (0.1, 0.3), (0.2, 0.0))},
            duration=0.4,
        ),
        HardCase(
            "one strip off the wire",
            "The wire leaves the rear strip for 0.2 s: the head tips, and nothing pulls.",
            (AtLeast("contact_force", 0.0), AtLeast("two_strips.contact_force", 0.0), Finite()),
            ("contact_loss", "two_strips"),
            {"two_strips.friction": 0.3},
            {"two_strips.wire_height": jumps(0.0, (0.1, 0.5), (0.3, 0.0))},
            duration=0.5,
        ),
        HardCase(
            "strips of a gram",
            "Their frequency on contact and suspension is beyond the substep.",
            Refused("the limit of RK4", accepted={"substep": 1e-4}),
            ("contact_loss", "two_strips"),
            {"two_strips.mass": 1e-3},
        ),
        HardCase(
            "waves as short as a step",
            "200 m/s over an unevenness of 5 cm: several waves within an internal step.",
            (AtLeast("contact_force", 0.0), Finite()),
            ("contact_loss", "wire_unevenness"),
            {"speed": 200.0, "wire_unevenness.shortest": 0.05, "wire_unevenness.deviation": 3e-3},
            duration=0.2,
        ),
        HardCase(
            "braking to a stop within a step",
            "The train stands after 0.1005 s at 1.005²/20 m, and stays there.",
            (Ends("contact_position", 1e-12, value=30.05050125),),
            ("acceleration",),
            {"speed": 1.005, "acceleration.rate": -10.0, "acceleration.final_speed": 0.0},
            duration=0.3,
        ),
        HardCase(
            "a command beyond all limits",
            "1 MN are asked for: the actuator gives its limit and no more.",
            (AtMost("actuator.force", 100.0), Finite()),
            ("contact_loss", "actuator"),
            {"actuator.time_constant": 1e-3},
            {"actuator.command": jumps(0.0, (0.01, 1e6), (0.05, -1e6))},
        ),
    ),
    "Catenary": (
        HardCase(
            "undamped, explicit",
            "Released from 200 N: Verlet's energy swings by (w h)²/8 of the modes that take part.",
            (Invariant("energy", 2e-3, share=True),),
            (),
            THREE_SPANS,
            RELEASED | {"contact_position": 90.0},
            duration=0.2,
            step=2e-3,
        ),
        HardCase(
            "undamped, implicit",
            "The midpoint rule conserves a quadratic energy exactly, at any step.",
            (Invariant("energy", 1e-12, share=True),),
            (),
            THREE_SPANS | {"method": "implicit"},
            RELEASED | {"contact_position": 90.0},
            duration=0.2,
            step=2e-3,
        ),
        HardCase(
            "slack droppers around a blow",
            "10 kN lift most of the wire off its droppers: the set settles in every step.",
            (AtMost(_solutions, 2.0, "solutions per step"), Finite(limit=1e4)),
            ("dropper_slackening", "gravity_sag"),
            {"spans": 2, "method": "implicit"},
            {"contact_position": 60.0, "contact_force": jumps(0.0, (2e-3, 1e4))},
            duration=0.1,
            step=2e-3,
        ),
        HardCase(
            "a force at the wave speed",
            "It piles up the wire before it, no quicker than on a bare string: F t / (2 m' c).",
            (AtMost("wire_height", 120.0 * 0.3 / (2.0 * 1.35 * WAVE)),),
            (),
            {"spans": 2, "element": 1.0},
            {"contact_position": ramp(WAVE, 10.0), "contact_force": jumps(0.0, (0.0, 120.0))},
            duration=0.3,
            step=2e-3,
        ),
        HardCase(
            "a dropper that would push at rest",
            "Too much sag for so light a wire.",
            Refused("at rest", accepted={"pre_sag.depth": 0.03}),
            ("dropper_slackening", "pre_sag"),
            {"spans": 2, "pre_sag.depth": 0.3, "contact_wire_mass": 0.3},
        ),
        HardCase(
            "an explicit step above the limit",
            "Elements of 0.1 m ask for steps shorter than 1 ms.",
            Refused("at most", accepted={"substep": 4e-4}),
            (),
            {"spans": 2, "element": 0.1},
        ),
        HardCase(
            "an undamped stitched line",
            "Two tensions in one messenger, rigid clamps: Verlet's energy swings and does not grow.",
            (Invariant("energy", 5e-3, share=True),),
            ("line_table",),
            {"line_table.table": STITCHED, "element": 1.0},
            RELEASED | {"contact_position": 98.0},
            duration=0.2,
            step=2e-3,
        ),
        HardCase(
            "a change of gradient that a dropper cannot bear",
            "20 per mille at once take 400 N off the droppers there.",
            Refused("at rest", accepted={"line_table.table": GRADIENT.format(5.05)}),
            ("dropper_slackening", "line_table"),
            {"line_table.table": GRADIENT.format(6.0)},
        ),
        HardCase(
            "a stitch that takes all tension",
            "The messenger inside would carry nothing.",
            Refused("a positive one", accepted={"line_table.table": STITCHED}),
            ("line_table",),
            {"line_table.table": STITCHED.replace("3500", "21000")},
        ),
        HardCase(
            "a mean wind that lifts the wire off its droppers",
            "64 N/m against a weight of 13 N/m.",
            Refused("slack at rest", accepted={"gusts.lift_coefficient": 0.1}),
            ("dropper_slackening", "gusts"),
            {"spans": 2, "element": 1.0, "gusts.speed": 60.0, "gusts.lift_coefficient": 2.0},
        ),
        HardCase(
            "air that damps beyond the explicit limit",
            "A density of 1e6 kg/m³: the substep of 1 ms would be unstable.",
            Refused("at most", accepted={"gusts.density": 1.2}),
            ("gusts",),
            {"spans": 2, "element": 1.0, "gusts.density": 1e6},
        ),
        HardCase(
            "off the end of the wire",
            "The contact point leaves the last span.",
            Refused("left the range", "step", {"contact_position": 50.0}),
            (),
            {"spans": 1},
            {"contact_position": ramp(80.0, 59.0)},
            duration=0.1,
            step=5e-3,
        ),
    ),
    "LumpedCatenary": (
        HardCase(
            "undamped",
            "Released from 200 N without damping: RK4 loses (w h)^6/72 of the energy in a step.",
            (Invariant("energy", 1e-8, share=True),),
            (),
            {"damping": 0.0},
            RELEASED,
            duration=2.0,
            step=0.01,
        ),
        HardCase(
            "undamped at the stable step",
            "0.95 of the limit: RK4 damps, and never feeds.",
            (BoundedEnergy(limit=0.0),),
            (),
            {"damping": 0.0, "mass": 0.03, "harmonic[1]": 0.0},
            RELEASED,
            duration=1.0,
            step=0.01,
        ),
        HardCase(
            "a stiffness that changes quickly",
            "A span passed in 0.2 s, its stiffness going up and down by half.",
            (Finite(),),
            ("inerter",),
            {},
            {"contact_position": ramp(300.0), "contact_force": 120.0},
            duration=2.0,
            step=5e-3,
        ),
        HardCase(
            "no stiffness somewhere",
            "Harmonics that take all of it away.",
            Refused("a positive one everywhere", accepted={"harmonic[1]": 0.8}),
            (),
            {"harmonic[1]": 1.2},
        ),
        HardCase(
            "a mass of a gram",
            "Far beyond the substep.",
            Refused("the limit of RK4", accepted={"substep": 7.5e-6}),
            (),
            {"mass": 1e-3},
        ),
    ),
}
