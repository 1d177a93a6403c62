"""Hard cases of bearings: no contact, preload, one ball, short impacts, narrow pits."""

from __future__ import annotations

import math

import numpy as np

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
    jumps,
    outputs,
    sine,
)
from .heat_hard_cases import HEAT_HARD_CASES

START = {"given_start.x": 3e-3, "given_start.y": -2e-3, "given_start.velocity_x": -0.4, "given_start.velocity_y": 0.3}
LIGHT = {"mass": 0.1, "damping": 0.0, "clearance.radial_clearance": 10e-6}
MOVING = {"given_start.velocity_x": 0.1, "given_start.velocity_y": 3e-3}


def _motion(component: Component) -> np.ndarray:
    return component.x[:4]


def _pressed(component: Component) -> float:
    """What the outer race carries beyond a ball's own force."""
    return component["ball_inertia.outer_load"] - component["ball_inertia.centrifugal_force"]


def _forces(component: Component) -> list[float]:
    """Everything that takes a contact."""
    return [component[n] for n in component.outputs if "angle" not in n]


def _mirrored(component: Component) -> np.ndarray:
    return component.x[:4] * (1.0, -1.0, 1.0, -1.0)


def _radius(component: Component) -> float:
    """Distance of the shaft from the middle, m."""
    return math.hypot(*component.x[:2])


def _unit_angles(component: Component) -> np.ndarray:
    """Angles of shaft and cage, from 0 to one turn either way, rad."""
    return np.abs((component.x + math.pi) % (2.0 * math.pi) - math.pi)


def _across(component: Component) -> np.ndarray:
    """Beside the line of the only ball: stiffness, and how many more there are."""
    return np.array([component["linearisation.stiffness[7]"], component["loaded_balls"] - 1.0])


def _left_alone(t: float) -> float:
    """Speed of a cage that oil of 0.1 Pa.s holds at the outer ring, from rolling at 500 rad/s on; the default bearing."""
    rate = math.pi * 0.1 * 3e-3 * 0.06**3 / (4.0 * 2e-4)
    inertia = 0.35 * 9.0 * 7800.0 * math.pi / 6.0 * 11.1e-3**3 * 53.5e-3**2 + 1.4e-5
    return 0.5 * (1.0 - 11.1 / 53.5) * 500.0 * math.exp(-rate / inertia * t)


def _axial_stiffness(component: Component) -> float:
    return component["linearisation.stiffness[13]"]


NEEDED = {  # s, a quarter of the passage of half a wave of 801 at 314.159 rad/s
    ring: 0.25 * math.pi / 801.0 / (0.5 * (1.0 + sign * 11.9 / 52.0) * 314.159)
    for ring, sign in (("inner", 1.0), ("outer", -1.0))
}
PASSED = 2.0 * math.radians(3.0) / (300.0 * 0.4)  # s in which a ball passes two pits at 300 rad/s


HARD_CASES = {
    "BallBearing": {
        "free flight": HardCase(
            "No ball in contact: x0 + v t + W t²/2m, which the method integrates exactly.",
            (
                Invariant("displacement_x", 1e-12, value=lambda t: 3e-3 - 0.4 * t + 4.9 * t**2),
                Invariant("displacement_y", 1e-12, value=lambda t: -2e-3 + 0.3 * t),
            ),
            effects=("clearance", "given_start"),
            parameters={"clearance.radial_clearance": 2.0, "damping": 0.0} | START,
            inputs={"speed": 314.0},
        ),
        "preload without a load": HardCase(
            "All balls carry K c^1.5 in balance; nothing moves the shaft out of the middle.",
            (Invariant("max_ball_load", 1e-11, value=1.334e10 * 5e-6**1.5, share=True), AtMost("displacement_x", 1e-14 * 50e-6)),
            effects=("clearance",),
            parameters={"clearance.radial_clearance": -5e-6},
            inputs={"speed": 314.0, "load": 0.0},
            run=(0.02, 1e-3),
        ),
        "no load in clearance": HardCase(
            "No force and no support: the shaft stays exactly where it is.",
            (AtMost(_motion, 0.0, "motion"),),
            effects=("clearance",),
            parameters={"clearance.radial_clearance": 20e-6},
            inputs={"load": 0.0},
            run=(0.02, 1e-3),
        ),
        "impacts": HardCase(
            "0.1 kg between stiff balls without damping, some 26 impacts: energy stays.",
            (Invariant("energy", 2e-3, share=True),),
            effects=("clearance", "given_start"),
            parameters=LIGHT | MOVING | {"substep": 5e-6},
            inputs={"speed": 0.0, "load": 0.0},
            run=(0.01, 1e-3),
        ),
        "impacts too short for the step": HardCase(
            "With 50 us most of the energy would be gone, and the run stay finite.",
            Refused("what the impacts that may come need", accepted={"substep": 1.9e-5}),
            effects=("clearance", "given_start"),
            parameters=LIGHT | MOVING,
            inputs={"speed": 0.0, "load": 0.0},
        ),
        "a load that comes later": HardCase(
            "Nothing is known of it at the start; the contact it closes is too stiff.",
            Refused("a ball is pressed in by", "step", {"substep": 5e-6}),
            effects=("clearance",),
            parameters=LIGHT | {"damping": 1.0},
            inputs={"speed": 0.0, "load": jumps(1e-3, (2e-3, 1e3))},
            run=(5e-3, 1e-3),
        ),
        "a pit narrower than a step": HardCase(
            "A ball would step over it.",
            Refused("a quarter of the passage of a ball", accepted={"substep": 2e-6}),
            effects=("outer_defect",),
            parameters={"outer_defect.width": 1e-3},
            inputs={"speed": 314.159},
        ),
        **{
            f"preload of {depth:g} m": HardCase(
                "Nothing moves the shaft, whether rounding is near the deformation or far from it.",
                (
                    Invariant("max_ball_load", 1e-9, value=1.334e10 * depth**1.5, share=True),
                    AtMost("displacement_x", 1e-12 * 50e-6),
                    Invariant("loaded_balls", 0.0, value=8.0),
                ),
                effects=("clearance",),
                parameters={"clearance.radial_clearance": -depth},
                inputs={"speed": 314.0, "load": 0.0},
                run=(0.1, 1e-3),
            )
            for depth in (1e-9, 50e-6)
        },
        "clearance of nothing": HardCase(
            "It is no clearance, to the last bit.",
            (Like(outputs, 0.0, "all outputs without clearance", instead={"effects": (), "parameters": {}}),),
            effects=("clearance",),
            parameters={"clearance.radial_clearance": 0.0},
            inputs={"speed": 104.72},
        ),
        "one ball below the load": HardCase(
            "It carries all: (W / K)^(2/3) beyond the clearance, no stiffness across, and nothing that pushes.",
            (
                Invariant("displacement_x", 1e-12, value=10e-6 + (196.0 / 1.334e10) ** (2.0 / 3.0), share=True),
                AtMost("displacement_y", 0.0),
            ),
            effects=("clearance",),
            parameters={"balls": 1},
            inputs={"speed": 0.0},
        ),
        **{
            f"no ball below the load, of {balls}": HardCase(
                "No equilibrium: the shaft starts in the middle and falls.",
                (Invariant("displacement_x", 1e-12, value=lambda t: 4.9 * t**2),),
                effects=("clearance",),
                parameters={
                    "balls": balls,
                    "start_cage_angle": 0.5 * math.pi,
                    "damping": 0.0,
                    "clearance.radial_clearance": 0.01,
                },
                run=(0.02, 1e-3),
            )
            for balls in (1, 2)
        },
        "one turning ball": HardCase(
            "It hits and lets go.",
            (AtMost("loaded_balls", 1.0), Reaches("loaded_balls", high=1.0), Reaches(lambda c: -c["loaded_balls"], high=0.0)),
            effects=("clearance",),
            parameters={"balls": 1, "damping": 2e4},
            inputs={"speed": 314.159},
            run=(0.2, 1e-3),
        ),
        "a pit in the inner ring narrower than a step": HardCase(
            "At rest nothing passes it.",
            Refused("Reduce substep or widen the defect", accepted={"speed": 0.0}),
            effects=("inner_defect",),
            parameters={"inner_defect.width": 1e-3},
            inputs={"speed": 314.159},
        ),
        "a pit in a ball narrower than a step": HardCase(
            "Backwards, too.",
            Refused("substep = 5e-05", accepted={"substep": 1e-7}),
            effects=("ball_defect",),
            parameters={"ball_defect.width": 1e-3},
            inputs={"speed": -314.159},
            run=(1e-4, 1e-4),
        ),
        **{
            f"a wave of the {ring} ring shorter than a step": HardCase(
                "A hundredth longer than the step that sees half a wave: it would see other waves instead.",
                Refused(f"half a wave of {ring}_waviness of order 801", accepted=accepted),
                effects=(f"{ring}_waviness",),
                parameters={
                    f"{ring}_waviness.order[2]": 801,
                    f"{ring}_waviness.amplitude[2]": 1e-7,
                    "substep": 1.01 * NEEDED[ring],
                },
                inputs={"speed": 314.159},
            )
            for ring, accepted in (
                ("inner", {"substep": 0.99 * NEEDED["inner"]}),
                ("outer", {"outer_waviness.amplitude[2]": 0.0}),
            )
        },
        "a strong contact damper": HardCase(
            "At 196 N it decays with 1.5 k Q / m = 1.5e5 1/s, seven times within a step of 50 us.",
            Refused("substep = 5e-05, expected at most", accepted={"contact_damping.coefficient": 1e2}),
            effects=("contact_damping",),
            parameters={"contact_damping.coefficient": 1e4},
        ),
        "a load that comes later on a strong damper": HardCase(
            "At rest nothing is pressed in.",
            Refused("Reduce substep", "step", {"load": 0.0}),
            effects=("clearance", "contact_damping"),
            parameters={"contact_damping.coefficient": 1e4},
            inputs={"load": jumps(0.0, (0.0, 196.0))},
        ),
        "rest": HardCase(
            "Without speed nothing turns and nothing moves.",
            (Invariant(_motion, 1e-12, "motion"), AtMost("inner_angle", 0.0), AtMost("cage_angle", 0.0)),
            effects=("clearance",),
            parameters={"clearance.radial_clearance": 20e-6},
            inputs={"speed": 0.0},
            run=(0.5, 1e-3),
        ),
        "backwards": HardCase(
            "The mirror image: across the load all changes its sign; sums of the balls' loads are taken in another order.",
            (
                Like(_motion, 1e-10, "mirrored motion", instead={"inputs": {"speed": -104.72}}, mirror=_mirrored, share=True),
                Like(
                    "inner_angle",
                    1e-12,
                    instead={"inputs": {"speed": -104.72}},
                    mirror=lambda c: 2.0 * math.pi - c["inner_angle"],
                ),
            ),
            effects=("clearance",),
            parameters={"clearance.radial_clearance": 2e-6},
            inputs={"speed": 104.72},
        ),
        "chaos": HardCase(
            "It stays between the races: a fall through the whole clearance, 2/5 K d^2.5 <= W (d + 2 c_r).",
            (AtMost(_radius, 30e-6 + (2.5 * 196.0 / 1.334e10 * (60e-6 + 20e-6)) ** 0.4, "distance from the middle, m"),),
            effects=("clearance",),
            parameters={"clearance.radial_clearance": 30e-6},
            inputs={"speed": 104.72},
            run=(0.5, 1e-3),
        ),
        "an infinite load": HardCase(
            "The run ends.",
            Refused("not finite", "step", {"load": 196.0}),
            effects=("clearance",),
            inputs={"load": jumps(196.0, (0.0, math.inf))},
        ),
    },
    "DimensionlessBallBearing": {
        "free flight": HardCase(
            "No ball in contact: t²/2 under the load of 1.",
            (Invariant("displacement_x", 1e-10, value=lambda t: 0.5 * t**2),),
            effects=("clearance", "given_start"),
            parameters={"clearance.radial_clearance": 1e6, "damping_ratio": 0.0},
            run=(60.0, 1.0),
        ),
        "preload without a load": HardCase(
            "All balls carry 1.",
            (Invariant("max_ball_load", 1e-12, value=1.0),),
            effects=("clearance",),
            parameters={"clearance.radial_clearance": -1.0},
            inputs={"load": 0.0},
            run=(60.0, 1.0),
        ),
        "a load that comes later": HardCase(
            "A contact six decades too stiff for the step.",
            Refused("a ball is pressed in by", "step", {"substep": 0.01}),
            effects=("clearance",),
            inputs={"load": jumps(1.0, (5.0, 1e6))},
            run=(10.0, 1.0),
        ),
        "a pit narrower than a step": HardCase(
            "A ball would step over it.",
            Refused("a quarter of the passage of a ball", accepted={"outer_defect.width": 0.01}),
            effects=("outer_defect",),
            parameters={"outer_defect.width": 1e-3},
            run=(1.0, 1.0),
        ),
    },
    "DeepGrooveBearing": {
        "free flight": HardCase(
            "A ring that swings within its play: no force, no tangent, no power.",
            (AtMost(_forces, 0.0, "forces, tangent, power"),),
            effects=("damping", "linearisation", "friction"),
            parameters={"diametral_clearance": 2e-5, "linearisation.idle_stiffness": 0.0},
            inputs={"displacement_x": sine(9.9e-6, 100.0), "velocity_x": 1.0, "speed": 500.0},
        ),
        "contact angle zero": HardCase(
            "Without play the axial stiffness vanishes in the middle: 2e-8 N/m a nanometre aside.",
            (AtMost(_axial_stiffness, 1e-6, "axial stiffness, N/m"), Finite()),
            effects=("linearisation", "damping"),
            inputs={"displacement_z": sine(1e-9, 100.0)},
        ),
        "a life without load": HardCase(
            "Nothing passes of it while no ball is loaded, and the factor stays at its bound.",
            (AtMost("rating_life.rate", 0.0), AtMost("life_factor.a_iso", 50.0)),
            effects=("rating_life", "life_factor"),
            parameters={"diametral_clearance": 2e-5},
            inputs={"displacement_x": sine(9.9e-6, 100.0), "speed": 500.0},
        ),
        "balls between both races": HardCase(
            "Balls with inertia leave the inner race and come back, from standstill to 20 000 rpm; the outer one carries their force.",
            (AtLeast(_pressed, 0.0, "load beyond the centrifugal force, N"), Finite()),
            effects=("ball_inertia", "linearisation", "damping"),
            parameters={"diametral_clearance": 2e-5, "linearisation.idle_stiffness": 0.0},
            inputs={"displacement_x": sine(1.2e-5, 100.0), "displacement_z": sine(1e-4, 70.0), "speed": sine(2100.0, 50.0)},
        ),
        "oil from frost to boiling": HardCase(
            "The viscosity falls by three decades and more, the friction takes in both directions.",
            (AtLeast("friction.power", 0.0), AtLeast("oil_friction.viscosity", 1e-6), Finite()),
            effects=("friction", "oil_friction"),
            inputs={"displacement_x": 1e-5, "speed": sine(50.0, 100.0), "oil_friction.temperature": sine(70.0, 50.0, 320.0)},
        ),
        "catalogue's friction from frost to boiling": HardCase(
            "Radial and axial loads come and go with the film, in both directions of the speed.",
            (AtLeast("friction.power", 0.0), Finite()),
            effects=("friction", "oil_friction", "skf_friction"),
            parameters={"diametral_clearance": 1e-5},
            inputs={
                "displacement_x": sine(2e-5, 100.0),
                "displacement_z": sine(5e-5, 70.0),
                "speed": sine(500.0, 50.0),
                "oil_friction.temperature": sine(70.0, 50.0, 320.0),
            },
        ),
        "oil at 60 K, meant as degrees Celsius": HardCase(
            "Its viscosity would have dozens of digits.",
            Refused("oil_friction.temperature = 60 K", "step", {"oil_friction.temperature": 300.0}),
            effects=("friction", "oil_friction"),
            inputs={"speed": 100.0, "oil_friction.temperature": jumps(300.0, (0.01, 60.0))},
        ),
        "oil that thickens as it warms": HardCase(
            "Two columns of a data sheet, exchanged.",
            Refused("viscosity_100 = 6.8e-05 m2/s", "initialize", {"oil_friction.viscosity_100": 8e-6}),
            effects=("friction", "oil_friction"),
            parameters={"oil_friction.viscosity_40": 8.7e-6, "oil_friction.viscosity_100": 6.8e-5},
        ),
        "a cage without load": HardCase(
            "Petroff's drag stops it, exponentially.",
            (Invariant("cage_slip.cage_speed", 1e-6, value=_left_alone, share=True), AtMost("cage_slip.drive", 0.0)),
            effects=("ball_inertia", "cage_slip"),
            parameters={"diametral_clearance": 2e-5, "cage_slip.drag_density": 0.0},
            inputs={"speed": 500.0, "cage_slip.viscosity": 0.1},
            run=(0.2, 1e-3),
        ),
        "a cage in a bearing that turns back": HardCase(
            "Loads come and go, the oil thickens and thins: all heat is positive.",
            (AtLeast("cage_slip.power", 0.0), Finite()),
            effects=("ball_inertia", "cage_slip", "ball_defect"),
            parameters={"diametral_clearance": 1e-5, "cage_slip.guide": "inner", "ball_defect.width": 1.0},
            inputs={
                "displacement_x": sine(8e-6, 100.0),
                "displacement_z": sine(4e-5, 70.0),
                "speed": sine(300.0, 50.0),
                "cage_slip.viscosity": sine(0.05, 30.0, 0.05),
            },
            run=(0.1, 2.5e-4),
        ),
        "a start from rest with hardly any sliding": HardCase(
            "A traction that has its limit at a picometre a second, in steps of a millisecond: the cage follows.",
            (AtMost("cage_slip.slip", 1e-9), AtLeast("cage_slip.power", 0.0)),
            effects=("ball_inertia", "cage_slip"),
            parameters={"cage_slip.sliding": 1e-12},
            inputs={"displacement_z": 8e-5, "speed": InputSignal(lambda t: 2e4 * t)},
            run=(0.05, 1e-3),
        ),
        "a cage in pitch": HardCase(
            "Viscosity of 1e6 Pa.s: it stands while the balls slide.",
            (AtMost("cage_slip.cage_speed", 1e-3), AtLeast("cage_slip.power", 0.0)),
            effects=("ball_inertia", "cage_slip"),
            parameters={"cage_slip.start_slip": 1.0},
            inputs={"displacement_z": 3e-5, "speed": 500.0, "cage_slip.viscosity": 1e6},
            run=(0.05, 1e-3),
        ),
        "oil with a negative viscosity": HardCase(
            "It would drive the cage.",
            Refused("cage_slip.viscosity = -0.01 Pa.s", "step", {"cage_slip.viscosity": 0.0}),
            effects=("ball_inertia", "cage_slip"),
            inputs={"speed": 100.0, "cage_slip.viscosity": jumps(0.01, (0.01, -0.01))},
        ),
        "a static rating in kN": HardCase(
            "The catalogue's contact angle would be beyond 90 degrees.",
            Refused("skf_friction.static_rating = 15.3 N", "step", {"skf_friction.static_rating": 15.3e3}),
            effects=("friction", "oil_friction", "skf_friction"),
            parameters={"skf_friction.static_rating": 15.3},
            inputs={"displacement_z": jumps(0.0, (1e-3, 1.5e-4)), "speed": 100.0},
            run=(5e-3, 1e-3),
        ),
        "film through standstill": HardCase(
            "The film's slope over the speed has no bound at 0; friction takes, in both directions.",
            (AtLeast("friction.power", 0.0), Finite()),
            effects=("film", "friction"),
            inputs={"displacement_x": 1e-5, "speed": sine(50.0, 100.0)},
        ),
        "a pit passed within a step": HardCase(
            "It may be missed.",
            Refused("may miss it", "step", {"speed": 110.0}),
            effects=("outer_defect",),
            inputs={"displacement_x": 1e-5, "speed": 300.0},
        ),
        "a ring that has left the grooves": HardCase(
            "Contacts longer than a ball's radius.",
            Refused("left the range", "step", {"displacement_x": 5e-5}),
            inputs={"displacement_x": jumps(0.0, (0.0, 1e-3))},
        ),
        "preload beyond the balls": HardCase(
            "The preload alone makes the contacts longer than a ball's radius.",
            Refused("the preload alone", accepted={"diametral_clearance": -1e-4}),
            parameters={"diametral_clearance": -5e-3},
        ),
        "touch-down": HardCase(
            "A picometre around the first contact: 1e-8 N of the contact, and 4e-4 N of the damper at 1 mm/s.",
            (AtMost("force_x", 1e-3),),
            effects=("damping",),
            parameters={"diametral_clearance": 2e-5},
            inputs={"displacement_x": sine(1e-12, 100.0, 1e-5), "velocity_x": 1e-3},
        ),
        "one ball in contact": HardCase(
            "It holds along its line only.",
            (AtMost(_across, 0.0, "stiffness across, N/m, and further balls"), Reaches("linearisation.stiffness[1]", high=1e7)),
            effects=("linearisation",),
            parameters={"diametral_clearance": 4e-5, "linearisation.idle_stiffness": 0.0},
            inputs={"displacement_x": 2.2e-5},
            run=(1e-3, 1e-3),
        ),
        "film at reversed speed": HardCase(
            "It does not know the direction.",
            (
                Like("force_x", 1e-12, instead={"inputs": {"displacement_x": 1e-5, "speed": -500.0}}, share=True),
                AtLeast("friction.power", 0.0),
            ),
            effects=("film", "friction", "linearisation"),
            inputs={"displacement_x": 1e-5, "speed": 500.0},
            run=(1e-3, 1e-3),
        ),
        "there and back": HardCase(
            "The angles end where they began, to 400 roundings below one turn.",
            (Ends(_unit_angles, 1e-12, "angles of shaft and cage, rad"), AtLeast(lambda c: c.x, 0.0)),
            effects=("ball_defect",),
            parameters={"ball_defect.width": 1.0},
            inputs={"displacement_x": 1e-5, "speed": jumps(50.0, (0.2, -50.0))},
            run=(0.4, 1e-3),
        ),
        "a pit passed at the speed of the step's end": HardCase(
            "At rest when it begins.",
            Refused("outer_defect", "step", {"speed": 0.0}),
            effects=("outer_defect",),
            inputs={"speed": InputSignal(lambda t: 3e5 * t)},
            run=(1e-2, 1e-2),
        ),
        "a pit passed between the step's ends": HardCase(
            "A parabola: 300 rad/s in the middle, none at either end.",
            Refused("outer_defect", "step", {"speed": 0.0}),
            effects=("outer_defect",),
            inputs={"speed": InputSignal(lambda t: 1200.0 * t / PASSED * (1.0 - t / PASSED))},
            run=(PASSED, PASSED),
        ),
        **{
            f"{name} that is no number": HardCase(
                "The run ends.",
                Refused("not finite", "step", {name: 0.0}),
                effects=("damping", "film"),
                inputs={"displacement_z": 3e-5, "speed": 10.0, name: jumps(0.0, (0.0, math.nan))},
                run=(1e-4, 1e-4),
            )
            for name in ("displacement_x", "tilt_y", "velocity_z")
        },
    },
} | HEAT_HARD_CASES
