"""Hard cases of pantograph and catenaries: contact lost, hardly any mass, no damping, slack droppers, steps too long."""

from __future__ import annotations

from typing import Any

from ..core.component import Component
from ..core.hard_cases import (
    AtLeast,
    AtMost,
    BoundedEnergy,
    Ends,
    Finite,
    HardCase,
    Invariant,
    Like,
    Reaches,
    Refused,
    jumps,
    ramp,
)

RELEASED = {"contact_force": jumps(200.0, (0.0, 0.0))}
WAVE = (20e3 / 1.35) ** 0.5  # m/s, of the default contact wire
STITCHED = """[[sections]]
contact_wire = { tension = 27000, mass = 1.07 }
messenger = { tension = 21000, mass = 1.06 }
stitch = { half_length = 9.0, tension = 3500, mass = 0.31 }
support.system_height = 1.8
spans = [65, 65, 65]
"""
COMPOUND = """[[sections]]
contact_wire = { tension = 14700, mass = 1.511 }
auxiliary = { tension = 14700, mass = 1.375, height = 0.15 }
messenger = { tension = 24500, mass = 1.45 }
main_droppers.gap = 10.0
support.system_height = 1.5
spans = [50, 50, 50]
"""
COMPOUND_OVERLAP = COMPOUND.replace("[50, 50, 50]", "[50, 50, 50]\nsupports = [0, 0, 0.06, 0.5]") + COMPOUND.replace(
    "[50, 50, 50]", "[50, 50, 50]\nstart = 50\nsupports = [0.5, 0.06, 0, 0]"
)
GRADIENT = "[[sections]]\nspans = [50, 50, 50]\nsupports = [5.0, 5.0, {0}, {0}]\n"
THREE_SPANS = {"spans": 3, "element": 1.0}


def _slack(component: Any) -> float:
    """Number of droppers that are slack: the state ends with which are taut."""
    n = component.mesh.dropper.size
    return n - float(component.x[component.x.size - n :].sum())


def _solutions(component: Component) -> float:
    """Linear systems solved for each internal step; a set of droppers that chatters would need up to 50."""
    return component.work["solves"] / max(component.work["steps"], 1)


HARD_CASES = {
    "Pantograph": {
        "contact lost and regained": HardCase(
            "The wire rises out of reach for 0.3 s and returns: a flight between two contacts.",
            (AtLeast("contact_force", 0.0), Finite()),
            effects=("contact_loss",),
            parameters={"frame_stiffness": 0.0, "frame_damping": 0.0, "head_damping": 0.0},
            inputs={"wire_height": jumps(0.0, (0.2, 1.0), (0.5, 0.0))},
            run=(1.0, 1e-3),
        ),
        "no force at all": HardCase(
            "A drive without force leaves the wire exactly at rest.",
            (AtMost("contact_force", 0.0), AtMost("head_height", 0.0)),
            effects=("contact_loss",),
            parameters={"static_force": 0.0},
        ),
        "a head of a tenth of a gram": HardCase(
            "Its frequency is far beyond the substep.",
            Refused("the limit of RK4", accepted={"substep": 2.5e-5}),
            effects=("contact_loss",),
            parameters={"head_mass": 1e-4},
        ),
        "a stiff contact at the stable step": HardCase(
            "Half of the contact force taken away at 0.99 of the limit: it swings, and does not grow.",
            (AtMost("contact_force", 190.0),),
            effects=("contact_loss",),
            parameters={"contact_stiffness": 1e9, "substep": 2.18e-4},
            inputs={"wire_height": jumps(0.0, (2e-3, 0.6e-7))},
        ),
        "bump stops under a blow": HardCase(
            "The frame is driven into its stops and out again: no energy comes from there.",
            (Finite(), AtLeast("contact_force", 0.0)),
            effects=("contact_loss", "bump_stops"),
            parameters={"bump_stops.stiffness": 1e6},
            inputs={"wire_height": jumps(0.0, (0.02, -0.3), (0.1, 0.3), (0.2, 0.0))},
            run=(0.4, 1e-3),
        ),
        "one strip off the wire": HardCase(
            "The wire leaves the rear strip for 0.2 s: the head tips, and nothing pulls.",
            (AtLeast("contact_force", 0.0), AtLeast("two_strips.contact_force", 0.0), Finite()),
            effects=("contact_loss", "two_strips"),
            parameters={"two_strips.friction": 0.3},
            inputs={"two_strips.wire_height": jumps(0.0, (0.1, 0.5), (0.3, 0.0))},
            run=(0.5, 1e-3),
        ),
        "strips of a gram": HardCase(
            "Their frequency on contact and suspension is beyond the substep.",
            Refused("the limit of RK4", accepted={"substep": 1e-4}),
            effects=("contact_loss", "two_strips"),
            parameters={"two_strips.mass": 1e-3},
        ),
        "waves as short as a step": HardCase(
            "200 m/s over an unevenness of 5 cm: several waves within an internal step.",
            (AtLeast("contact_force", 0.0), Finite()),
            effects=("contact_loss", "wire_unevenness"),
            parameters={"speed": 200.0, "wire_unevenness.shortest": 0.05, "wire_unevenness.deviation": 3e-3},
            run=(0.2, 1e-3),
        ),
        "braking to a stop within a step": HardCase(
            "The train stands after 0.1005 s at 1.005²/20 m, and stays there.",
            (Ends("contact_position", 1e-12, value=30.05050125),),
            effects=("acceleration",),
            parameters={"speed": 1.005, "acceleration.rate": -10.0, "acceleration.final_speed": 0.0},
            run=(0.3, 1e-3),
        ),
        "a command beyond all limits": HardCase(
            "1 MN are asked for: the actuator gives its limit and no more.",
            (AtMost("actuator.force", 100.0), Finite()),
            effects=("contact_loss", "actuator"),
            parameters={"actuator.time_constant": 1e-3},
            inputs={"actuator.command": jumps(0.0, (0.01, 1e6), (0.05, -1e6))},
        ),
    },
    "Catenary": {
        "undamped, explicit": HardCase(
            "Released from 200 N: Verlet's energy swings by (w h)²/8 of the modes that take part.",
            (Invariant("energy", 2e-3, share=True),),
            parameters=THREE_SPANS,
            inputs=RELEASED | {"contact_position": 90.0},
            run=(0.2, 2e-3),
        ),
        "undamped, implicit": HardCase(
            "The midpoint rule conserves a quadratic energy exactly, at any step.",
            (Invariant("energy", 1e-12, share=True),),
            parameters=THREE_SPANS | {"method": "implicit"},
            inputs=RELEASED | {"contact_position": 90.0},
            run=(0.2, 2e-3),
        ),
        **{
            f"slack droppers around a blow of {force:g} N": HardCase(
                "It lifts the wire off its droppers: the set settles in every step.",
                (AtMost(_solutions, 2.0, "solutions per step"), Finite(limit=1e4), Reaches(_slack, high=slack)),
                effects=("dropper_slackening", "gravity_sag"),
                parameters={"spans": 2, "method": "implicit"},
                inputs={"contact_position": 60.0, "contact_force": jumps(0.0, (2e-3, force))},
                run=(0.1, 2e-3),
            )
            for force, slack in ((500.0, 1.0), (3e3, 4.0), (1e4, 4.0))
        },
        **{
            f"undamped with slack droppers, {method}": HardCase(
                "A dropper that changes within a step costs or gains k (v h)²/2.",
                (Invariant("energy", 2e-3, share=True),),
                effects=("dropper_slackening",),
                parameters=THREE_SPANS | {"method": method},
                inputs=RELEASED | {"contact_position": 90.0},
                run=(0.2, 2e-3),
            )
            for method in ("explicit", "implicit")
        },
        **{
            f"one span, {method}": HardCase(
                "The equilibrium is kept, to rounding.",
                (Like("wire_height", 1e-12, instead={"run": (1e-3, 1e-3)}), Reaches("wire_height", high=1e-3)),
                effects=("dropper_slackening", "gravity_sag"),
                parameters={"spans": 1, "method": method},
                inputs={"contact_force": 120.0},
                run=(0.1, 1e-3),
            )
            for method in ("explicit", "implicit")
        },
        "off the end of the wire, implicit": HardCase(
            "The contact point leaves the last span.",
            Refused("left the range", "step", {"contact_position": 50.0}),
            parameters={"spans": 1, "method": "implicit"},
            inputs={"contact_position": ramp(80.0, 59.0)},
            run=(0.1, 5e-3),
        ),
        "a force at the wave speed": HardCase(
            "It piles up the wire before it, no quicker than on a bare string: F t / (2 m_l c), m_l: mass of a metre.",
            (AtMost("wire_height", 120.0 * 0.3 / (2.0 * 1.35 * WAVE)),),
            parameters={"spans": 2, "element": 1.0},
            inputs={"contact_position": ramp(WAVE, 10.0), "contact_force": jumps(0.0, (0.0, 120.0))},
            run=(0.3, 2e-3),
        ),
        "a dropper that would push at rest": HardCase(
            "Too much sag for so light a wire.",
            Refused("N at rest", accepted={"pre_sag.depth": 0.03}),
            effects=("dropper_slackening", "pre_sag"),
            parameters={"spans": 2, "pre_sag.depth": 0.3, "contact_wire_mass": 0.3},
        ),
        "an explicit step above the limit": HardCase(
            "Elements of 0.1 m ask for steps shorter than 1 ms.",
            Refused("at most", accepted={"substep": 4e-4}),
            parameters={"spans": 2, "element": 0.1},
        ),
        "an undamped stitched line": HardCase(
            "Two tensions in one messenger, rigid clamps: Verlet's energy swings and does not grow.",
            (Invariant("energy", 5e-3, share=True),),
            effects=("line_table",),
            parameters={"line_table.table": STITCHED, "element": 1.0},
            inputs=RELEASED | {"contact_position": 98.0},
            run=(0.2, 2e-3),
        ),
        "a change of gradient that a dropper cannot bear": HardCase(
            "20 per mille at once take 400 N off the droppers there.",
            Refused("at rest", accepted={"line_table.table": GRADIENT.format(5.05)}),
            effects=("dropper_slackening", "line_table"),
            parameters={"line_table.table": GRADIENT.format(6.0)},
        ),
        "a stitch that takes all tension": HardCase(
            "The messenger inside would carry nothing.",
            Refused("a positive one", accepted={"line_table.table": STITCHED}),
            effects=("line_table",),
            parameters={"line_table.table": STITCHED.replace("3500", "21000")},
        ),
        "ice that falls off an undamped overlap of compound lines": HardCase(
            "2 kN downwards on either section are gone at once: six wires fly up, droppers of both rows are slack, nothing gives energy.",
            (Invariant("energy", 2e-3, share=True),),
            effects=("dropper_slackening", "line_table", "second_wire"),
            parameters={"line_table.table": COMPOUND_OVERLAP, "element": 1.0},
            inputs={"contact_position": 90.0}
            | dict.fromkeys(("contact_force", "second_wire.contact_force[1]"), jumps(-2000.0, (0.0, 0.0))),
            run=(0.2, 2e-3),
        ),
        "an auxiliary wire above its messenger": HardCase(
            "The messenger hangs below the height at which the droppers are to hold the auxiliary wire.",
            Refused("an upper wire above the lower one", accepted={"line_table.table": COMPOUND}),
            effects=("line_table",),
            parameters={"line_table.table": COMPOUND.replace("0.15", "1.45")},
        ),
        "a mean wind that lifts the wire off its droppers": HardCase(
            "64 N/m against a weight of 13 N/m.",
            Refused("slack at rest", accepted={"gusts.lift_coefficient": 0.1}),
            effects=("dropper_slackening", "gusts"),
            parameters={"spans": 2, "element": 1.0, "gusts.speed": 60.0, "gusts.lift_coefficient": 2.0},
        ),
        "air that damps beyond the explicit limit": HardCase(
            "A density of 1e6 kg/m³: the substep of 1 ms would be unstable.",
            Refused("at most", accepted={"gusts.density": 1.2}),
            effects=("gusts",),
            parameters={"spans": 2, "element": 1.0, "gusts.density": 1e6},
        ),
        "off the end of the wire": HardCase(
            "The contact point leaves the last span.",
            Refused("left the range", "step", {"contact_position": 50.0}),
            parameters={"spans": 1},
            inputs={"contact_position": ramp(80.0, 59.0)},
            run=(0.1, 5e-3),
        ),
        "a start off the wire": HardCase(
            "The contact point stands behind the last span: no equilibrium is sought there.",
            Refused("left the range", accepted={"contact_position": 50.0}),
            parameters={"spans": 1},
            inputs={"contact_position": 80.0},
        ),
    },
    "LumpedCatenary": {
        "undamped": HardCase(
            "Released from 200 N without damping: RK4 loses (w h)^6/72 of the energy in a step.",
            (Invariant("energy", 1e-8, share=True),),
            parameters={"damping": 0.0},
            inputs=RELEASED,
            run=(2.0, 0.01),
        ),
        "undamped at the stable step": HardCase(
            "0.95 of the limit: RK4 damps, and never feeds.",
            (BoundedEnergy(limit=0.0),),
            parameters={"damping": 0.0, "mass": 0.03, "harmonic[1]": 0.0},
            inputs=RELEASED,
            run=(1.0, 0.01),
        ),
        "a stiffness that changes quickly": HardCase(
            "A span passed in 0.2 s, its stiffness going up and down by half.",
            (Finite(),),
            effects=("inerter",),
            inputs={"contact_position": ramp(300.0), "contact_force": 120.0},
            run=(2.0, 5e-3),
        ),
        "no stiffness somewhere": HardCase(
            "Harmonics that take all of it away.",
            Refused("a positive one everywhere", accepted={"harmonic[1]": 0.8}),
            parameters={"harmonic[1]": 1.2},
        ),
        "a mass of a gram": HardCase(
            "Far beyond the substep.", Refused("the limit of RK4", accepted={"substep": 7.5e-6}), parameters={"mass": 1e-3}
        ),
    },
}
