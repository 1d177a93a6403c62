"""Hard cases of pipe robots: rest under vibration, switching in every half cycle, grazing, locked bristles, lost contact."""

from __future__ import annotations

import math

from ..core.component import Component
from ..core.hard_cases import (
    AtLeast,
    AtMost,
    Ends,
    Finite,
    HardCase,
    InputSignal,
    Invariant,
    Like,
    Reaches,
    Refused,
    events,
    jumps,
    outputs,
    ramp,
    sine,
)

LEAN = math.atan(1.5 / 0.3)  # rad, bristles that lock backwards with a friction of 0.3
CUBIC = {"cubic_spring.stiffness": 0.0, "cubic_spring.largest_stretch": 1.0}
GRAZING = 0.02 * 60.0 * 0.5 / 1.5  # m/s, swing of the body under the prescribed motion
EDGE = {"friction": 5.0, "rolling_resistance": 0.0}


def _centre(component: Component) -> float:
    """Place of the common centre of mass, m."""
    return component["position"] + 0.5 * component["inner_position"]


def _ice_that_ends(t: float) -> float:
    """No friction for 1 s, and all of it at 2 s."""
    return min(max(t - 1.0, 0.0), 1.0)


def _backwards(component: Component) -> float:
    """How fast it goes backwards, m/s."""
    return max(-component["velocity"], 0.0)


SURVEY = "position [m],diameter [mm]\n0,200\n1,190\n{},200\n"

HARD_CASES = {
    "PipeRobot": {
        "held on a slope under vibration": HardCase(
            "Of 8 N that friction bears the weight takes 4.3 N, and 1.1 N come and go.",
            (AtMost("position", 0.0), AtMost(events, 0.0, "events")),
            effects=("harmonic_force", "route"),
            parameters={"substep": 4e-3},
            inputs={"route.slope": 0.3, "harmonic_force.amplitude": 10.0, "harmonic_force.frequency": 20.0},
            run=(5.0, 0.1),
        ),
        "switching in every half cycle": HardCase(
            "19 switches a second at 60 rad/s, none missed and none doubled.",
            (Ends(events, 3.0, "events", value=57.5), Finite()),
            effects=("harmonic_force",),
            parameters={"substep": 2e-3},
            run=(3.0, 0.1),
        ),
        **{
            f"sliding that grazes rest, {more:+g} N": HardCase(
                "v = b (1 - cos wt) touches zero once a period: x = b (t - sin(wt) / w).",
                (
                    Invariant("position", 1e-5, value=lambda t: GRAZING * (t - math.sin(60.0 * t) / 60.0)),
                    AtMost(events, 2.0 * 50.0, "events"),
                ),
                effects=("prescribed_motion", "tow"),
                parameters={"substep": 2e-3},
                inputs={"tow.force": 2.0 + more},
                run=(50 * 2.0 * math.pi / 60.0, 5 * 2.0 * math.pi / 60.0),
            )
            for more in (-1e-6, 0.0, 1e-6)
        },
        "ice that ends": HardCase(
            "Friction that comes back brings the body to rest.",
            (AtMost("friction_force", 8.0), Ends("mode", 0.0), Reaches("position", high=1e-6)),
            effects=("harmonic_force", "route"),
            inputs={"route.friction_factor": InputSignal(_ice_that_ends), "harmonic_force.amplitude": jumps(5.0, (1.0, 0.0))},
            run=(3.0, 0.05),
        ),
        "thrown backwards with locked bristles": HardCase(
            "It stops at once, and only the spring slows down the mass within.",
            (AtLeast("position", 1e-6), AtMost("position", 1e-6), Ends("inner_velocity", 0.02, value=-1.0)),
            effects=("bristles",),
            parameters={"bristles.angle": 1.4, "start_velocity": -1.0},
            run=(1e-3, 1e-3),
        ),
        **{
            f"{name} out of range, {value:g}": HardCase(
                "Too much of a turn within a substep, or a factor that friction cannot have.",
                Refused("factor of friction left its range", "step", {name: within}),
                effects=effects,
                parameters={name: value} if effects != ("route",) else {},
                inputs={name: value} if effects == ("route",) else {},
                run=(2e-3, 2e-3),
            )
            for effects, name, value, within in (
                (("prescribed_motion",), "prescribed_motion.frequency", 2500.0, 60.0),
                (("unbalance",), "unbalance.start_rate", -2500.0, -60.0),
                (("route",), "route.friction_factor", 1.51, 1.49),
                (("route",), "route.friction_factor", -0.01, 0.0),
            )
        },
        "one long step": HardCase(
            "It is many short ones.",
            (Like(outputs, 1e-10, "all outputs after short steps", instead={"run": (2.0, 0.01)}),),
            effects=("harmonic_force",),
            run=(2.0, 2.0),
        ),
        "ice": HardCase(
            "No friction at all: the common centre stays.",
            (AtMost(_centre, 1e-12, "common centre, m"),),
            effects=("harmonic_force", "route"),
            inputs={"route.friction_factor": 0.0},
            run=(1.0, 0.05),
        ),
        **{
            f"bristles that lean by {lean:.12g} in a vertical pipe": HardCase(
                "Of what locks them, and beyond: friction backwards without bound, a ratchet.",
                (AtMost(_backwards, 1e-6, "velocity backwards, m/s"), AtLeast("position", 1e-6), Reaches("position", high=0.3)),
                effects=("harmonic_force", "bristles", "cubic_spring", "route"),
                parameters=CUBIC
                | {"bristles.angle": math.atan(lean / 0.3), "bristles.moment": 0.038 * math.cos(math.atan(lean / 0.3))},
                inputs={"route.slope": 0.5 * math.pi, "harmonic_force.amplitude": 60.0},
                run=(1.0, 0.02),
            )
            for lean in (0.99999, 1.0, 1.0 + 1e-12, 1.5)
        },
        "locked bristles with bristles of LuGre": HardCase(
            "What bears without bound has no stiffness that follows.",
            Refused("locked backwards", accepted={"bristles.angle": 1.2}),
            effects=("bristles", "lugre_friction"),
            parameters={"bristles.angle": LEAN},
        ),
        "a softening spring that tears": HardCase(
            "Its stretch leaves the range.",
            Refused("stretch of a cubic spring", "step", {"harmonic_force.amplitude": 0.5}),
            effects=("harmonic_force", "cubic_spring"),
            parameters={"cubic_spring.stiffness": -2e6},
            inputs={"harmonic_force.amplitude": 60.0},
            run=(1.0, 0.05),
        ),
        "an excitation beyond the substep": HardCase(
            "More than a radian within it.",
            Refused("over a radian within a substep", "step", {"harmonic_force.frequency": 1900.0}),
            effects=("harmonic_force",),
            inputs={"harmonic_force.frequency": 2500.0},
            run=(0.01, 1e-3),
        ),
        "a spring beyond the substep": HardCase(
            "50 ms against 77 rad/s of both masses.",
            Refused("the limit of RK4", accepted={"substep": 0.03}),
            parameters={"substep": 0.05},
        ),
    },
    "RollingPipeRobot": {
        "rollers that chatter": HardCase(
            "A force too weak to slide backwards, at 400 rad/s: it only goes forwards.",
            (
                AtMost(_backwards, 1e-12, "velocity backwards, m/s"),
                AtLeast("position", 0.0),
                AtMost(events, 4.0 * 400.0 / (2.0 * math.pi) + 4.0, "events"),
            ),
            effects=("harmonic_force",),
            parameters=EDGE,
            inputs={"harmonic_force.amplitude": 5.0, "harmonic_force.frequency": 400.0},
            run=(1.0, 0.02),
        ),
        "nothing to overcome": HardCase(
            "Rollers without resistance, no force: it stays exactly at rest.",
            (AtMost("position", 0.0), AtMost(events, 0.0, "events")),
            effects=("tow",),
            parameters={"rolling_resistance": 0.0},
            run=(0.5, 0.05),
        ),
        "a pipe wider than the rings": HardCase(
            "No contact is left.",
            Refused("lost contact with the pipe", "step", {"diameter": 0.2035}),
            inputs={"diameter": jumps(0.2, (2e-3, 0.205))},
            run=(5e-3, 1e-3),
        ),
        "a pipe that narrows and widens": HardCase(
            "Rings that give and take energy as they pass: within what they can store.",
            (Finite(), AtLeast("pressing_force", 0.0)),
            effects=("harmonic_force", "route"),
            inputs={"diameter": sine(1e-3, 5.0, 0.2), "taper": sine(0.02, 7.0), "route.slope": 0.2},
            run=(1.0, 0.01),
        ),
        "rollers that chatter, by half the substep": HardCase(
            "The way does not depend on the substep.",
            (
                Like("position", 1e-3, instead={"parameters": EDGE | {"substep": 2.5e-4}}, share=True),
                Reaches("position", high=1e-4),
            ),
            effects=("harmonic_force",),
            parameters=EDGE,
            inputs={"harmonic_force.amplitude": 5.0, "harmonic_force.frequency": 60.0},
            run=(1.0, 0.02),
        ),
        "a micronewton without resistance": HardCase(
            "Rollers let it go.",
            (Ends("mode", 0.0, value=1.0), Reaches("position", high=1e-8)),
            effects=("tow",),
            parameters={"rolling_resistance": 0.0},
            inputs={"tow.force": 1e-6},
            run=(1.0, 0.05),
        ),
    },
    "PipeRoute": {
        "beyond both ends": HardCase(
            "A kilometre before and behind the table: the values of its ends, without a slope of them.",
            (AtMost("taper", 0.0), Finite()),
            parameters={"diameter_table[1]": 0.3},
            inputs={"position": InputSignal(lambda t: -1e3 if t < 0.05 else 1e3, smooth=False)},
        ),
        "a step of the diameter": HardCase(
            "Within a micrometre, between two even pipes: the cubic does not overshoot.",
            (AtLeast("diameter", 1e-15, low=0.2), AtMost("diameter", 0.3 + 1e-15)),
            parameters={
                "place[5]": 3.000001,
                **{f"place[{k}]": k - 1.0 for k in (6, 7, 8)},
                **{f"diameter_table[{k}]": 0.3 for k in (5, 6, 7, 8)},
            },
            inputs={"position": ramp(1e-5, 2.9999995)},
            run=(0.2, 1e-3),
        ),
        "a survey out of order": HardCase(
            "A file that goes back.",
            Refused("a position that rises", accepted={"route_table.table": SURVEY.format(2)}),
            effects=("route_table",),
            parameters={"route_table.table": SURVEY.format(1)},
        ),
        "places out of order": HardCase(
            "A table that goes back.", Refused("ascending order", accepted={"place[3]": 1.001}), parameters={"place[3]": 1.0}
        ),
    },
    "TowCoupling": {
        "a rope that tightens and goes slack": HardCase(
            "It never pushes, and action is exactly reaction.",
            (AtLeast("rear_force", 0.0), AtMost(lambda c: c["rear_force"] + c["front_force"], 0.0, "sum of the forces, N")),
            effects=("slack",),
            inputs={"front_position": sine(0.1, 30.0, 0.5), "front_velocity": sine(3.0, 40.0)},
            run=(0.5, 1e-3),
        ),
        "a rope that runs together": HardCase(
            "Ends that pass one another at 1 km/s: nothing.",
            (AtMost("rear_force", 0.0),),
            effects=("slack",),
            inputs={"front_position": ramp(-1e3, 0.4), "front_velocity": -1e3},
        ),
        "a bar without length": HardCase(
            "Both ends at one place: no direction is needed along one line.",
            (AtMost("stretch", 0.0), AtMost("rear_force", 0.0)),
            parameters={"length": 0.0},
            inputs={"rear_position": 1e6, "front_position": 1e6},
        ),
    },
    "ExciterProgram": {
        "a change within a nanosecond": HardCase(
            "A step for every master: the values before and after, nothing beyond.",
            (AtMost("frequency", 120.0), AtLeast("frequency", 0.0, low=30.0), Ends("frequency", 0.0, value=120.0)),
            parameters={"duration": 1e-9, "start_time": 0.0123},
        ),
        "there and back": HardCase(
            "The way back ends where it began, to rounding of the times.",
            (Ends("voltage", 1e-9), AtMost("voltage", 24.0)),
            parameters={"duration": 0.03, "return_time": 0.05},
        ),
        "back before it is there": HardCase(
            "The way back begins while the change goes on.",
            Refused("when the change ends", accepted={"return_time": 30.0}),
            parameters={"return_time": 29.0},
        ),
    },
}
