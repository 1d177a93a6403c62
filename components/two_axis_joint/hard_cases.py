"""Hard cases of gimbal, chain, links and their joint: gimbal lock, chaos, no inertia, friction at its level, hard stops."""

from __future__ import annotations

import math

import numpy as np

from ..core.component import Component
from ..core.hard_cases import AtMost, BoundedEnergy, Ends, Finite, HardCase, Invariant, Reaches, Refused, events, jumps, sine

SLENDER = {"cross_inertia": 0.05, "inner_inertia": 0.05, "axial_inertia": 0.0}
HIGH = {"start_first_angle": 2.5, "start_second_angle": 2.9}
GYRO = {
    "frame_inertia": 0.005,
    "cross_inertia": 0.015,
    "inner_inertia": 0.015,
    "axial_inertia": 0.015,
    "axis_orientation": "horizontal",
    "start_inner_angle": 0.0,
}
LEVELS = {"stick_friction.outer_level": 0.1, "stick_friction.inner_level": 0.05}
FAST = {"start_inner_angle": 1.0, "start_inner_rate": -8.0, "start_outer_rate": 0.02, "frame_inertia": 1e-7}
NARROW = {"stops.lower": -1e-3, "stops.upper": 1e-3, "stops.dissipation": 0.0, "stops.stiffness": 1e5}


SIMPLEST = {
    "hip_mass": 1000.0,
    "leg_mass": 1.0,
    "leg_centre": 1.0,
    "gravity": 1.0,
    "slope": 0.009,
    "start_stance_angle": 0.200161072169750,
    "start_swing_angle": -0.200161072169762,
    "start_stance_rate": -0.199906060087682,
    "start_swing_rate": -0.184100586859717,
}


def _walked(component: Component) -> float:
    """Energy and what impacts have taken, J."""
    return component["mechanical_energy"] + component["lost_energy"]


def _integrals(component: Component) -> np.ndarray:
    """Integrals of the controller, V."""
    return component.x[3:5]


def _balance(component: Component) -> np.ndarray:
    """Sum of the forces on both ends, N."""
    return component.y[:2] + component.y[2:4]


HARD_CASES = {
    "GimbalBody": {
        "a slender body near gimbal lock": HardCase(
            "Momentum about an axis of hardly any inertia is a wall, 280 rad/s for some ms.",
            (Invariant("energy", 1e-8, share=True), Invariant("outer_momentum", 1e-8, share=True)),
            parameters=SLENDER
            | {
                "frame_inertia": 1e-5,
                "start_inner_angle": 1.0,
                "start_inner_rate": -2.0,
                "start_outer_rate": 0.02,
                "substep": 2e-4,
            },
            run=(1.0, 0.01),
        ),
        "gimbal lock": HardCase(
            "Nothing resists turning about the body's own axis.",
            Refused("gimbal lock", accepted={"frame_inertia": 1e-6}),
            parameters=SLENDER | {"frame_inertia": 0.0},
        ),
        "through gimbal lock without momentum": HardCase(
            "It passes as if nothing were there.",
            (Ends("inner_angle", 1e-12, value=-1.0), AtMost("outer_angle", 0.0)),
            parameters=SLENDER | {"frame_inertia": 1e-10, "start_inner_angle": 1.0, "start_inner_rate": -2.0},
            run=(1.0, 0.1),
        ),
        "a wall that the substep does not see": HardCase(
            "An axis turns by radians within a substep.",
            Refused("over a radian within a substep", "step", {"substep": 5e-5}),
            parameters=SLENDER | FAST,
            run=(0.2, 0.01),
        ),
        "friction at its very level": HardCase(
            "The outer torque is exactly the level while the inner axis comes to rest.",
            (AtMost("outer_rate", 0.0), Ends("inner_angle", 1e-13, value=0.5 - 0.125), AtMost(events, 1.0, "events")),
            effects=("stick_friction",),
            parameters=LEVELS | {"start_inner_rate": -0.5},
            inputs={"outer_torque": 0.1},
            run=(1.0, 0.125),
        ),
        "many turning points under friction": HardCase(
            "Both axes shaken about the level: it stays bounded, and energy is taken.",
            (Finite(limit=10.0),),
            effects=("gravity", "stick_friction"),
            parameters={"stick_friction.static_ratio": 1.5},
            inputs={"outer_torque": sine(0.12, 7.0), "inner_torque": sine(0.1, 17.0)},
            run=(2.0, 0.01),
        ),
        "fast nutation under slow precession": HardCase(
            "1155 rad/s against 15 mrad/s: the mean motion stays -T / h.",
            (Ends("outer_angle", 2.0 * 0.3 * 0.02 / 400.0, value=-0.3 / 20.0), AtMost("inner_angle", 0.9 * 1e-4)),
            effects=("rotor",),
            parameters=GYRO | {"rotor.spin_momentum": 20.0, "substep": 1e-3},
            inputs={"inner_torque": 0.3},
            run=(1.0, 0.1),
        ),
        "nutation beyond the substep": HardCase(
            "100 N.m.s on 0.02 kg m².",
            Refused("limit of RK4", accepted={"substep": 4e-4}),
            effects=("rotor",),
            parameters=GYRO | {"rotor.spin_momentum": 100.0},
        ),
        "thrown into a stop": HardCase(
            "The stop gives back no more than it got.",
            (BoundedEnergy(limit=1e-9),),
            effects=("stops",),
            parameters={"start_inner_rate": 5.0, "start_outer_rate": 3.0},
            run=(2.0, 0.01),
        ),
    },
    "GimbalController": {
        "an error that stays": HardCase(
            "A stuck axis: voltages end at their limit, and the integral does not wind up.",
            (AtMost("outer_voltage", 24.0), AtMost(_integrals, 660.0, "integrals, V")),
            parameters={"set_outer_angle": 1.0},
            run=(10.0, 0.01),
        ),
        "steps between samples and across many": HardCase(
            "A macro step of 250 samples that swing: finite, within the limits.",
            (AtMost("outer_voltage", 24.0), AtMost("inner_voltage", 24.0)),
            effects=("scan",),
            inputs={"outer_angle": sine(1.0, 3.0), "inner_rate": sine(5.0, 7.0)},
            run=(5.0, 0.5),
        ),
        "an angle that is no number": HardCase(
            "The run ends instead of going on with it.",
            Refused("not finite", "step", {"outer_angle": 0.1}),
            inputs={"outer_angle": jumps(0.0, (0.0, math.nan))},
            run=(0.1, 0.01),
        ),
    },
    "TwoLinkChain": {
        "chaos": HardCase(
            "From nearly upright: no trajectory means anything for long, the energy does.",
            (Invariant("energy", 1e-6, share=True),),
            effects=("gravity",),
            parameters=HIGH | {"substep": 1e-3},
            run=(3.0, 0.05),
        ),
        "upright with dry friction": HardCase(
            "Rounding tips it without friction; a joint that stands bears it.",
            (Invariant("first_angle", 0.0), AtMost(events, 0.0, "events")),
            effects=("gravity", "stick_friction"),
            parameters={"start_first_angle": math.pi, "start_second_angle": math.pi + 1e-9},
            run=(2.0, 0.1),
        ),
        "friction at many turning points": HardCase(
            "Both joints stop and start again: the energy never grows.",
            (BoundedEnergy(limit=1e-9),),
            effects=("gravity", "stick_friction"),
            parameters=HIGH | {"substep": 5e-4, "stick_friction.first_level": 0.5, "stick_friction.second_level": 0.5},
            run=(2.0, 0.05),
        ),
        **{
            f"links without inertia, {' '.join(nothing)}": HardCase(
                "Stretched, the elbow has no equation of motion.",
                Refused("singular", accepted={"first_inertia": 1e-3, "second_inertia": 1e-3}),
                effects=("gravity",),
                parameters=dict.fromkeys(nothing, 0.0),
            )
            for nothing in (("first_mass",), ("first_centre",), ("second_mass",), ("first_mass", "second_mass"))
        },
        "upright without friction": HardCase(
            "A nanoradian tips it.",
            (Reaches(lambda c: abs(c["first_angle"] - math.pi), high=0.5), Invariant("energy", 1e-6, share=True)),
            effects=("gravity",),
            parameters={"start_first_angle": math.pi, "start_second_angle": math.pi + 1e-9},
            run=(10.0, 0.1),
        ),
        **{
            f"too stiff for the substep, {effect}": HardCase(
                "Beyond the limit of the method.",
                Refused("limit of RK4", accepted={name: soft}),
                effects=("gravity", effect),
                parameters={name: stiff},
            )
            for effect, name, stiff, soft in (
                ("lugre_friction", "lugre_friction.stiffness", 1e7, 1e4),
                ("smoothed_friction", "smoothed_friction.width", 1e-6, 1e-2),
                ("viscous", "viscous.first", 1e4, 1.0),
            )
        },
        **{
            f"stops that cannot be, {' '.join(map(str, given.values()))}": HardCase(
                "One above the other, or a start beyond them.",
                Refused(words, accepted=accepted),
                effects=("stops",),
                parameters=given,
            )
            for words, given, accepted in (
                ("below the upper", {"stops.lower": 1.0, "stops.upper": 0.5}, {"stops.lower": -0.5}),
                ("below the upper", {"stops.lower": 0.5, "stops.upper": 0.5}, {"stops.lower": -0.5}),
                ("between its stops", {"start_second_angle": 2.0}, {"start_second_angle": 0.5}),
            )
        },
        "a rigid end that is hit again and again": HardCase(
            "A spring drives a panel against it: every rebound takes energy until it is caught, exactly at its place.",
            (
                BoundedEnergy(limit=1e-9),
                Ends("latch.latched", 0.0, value=1.0),
                Ends("relative_angle", 1e-12, value=0.5 * math.pi),
            ),
            effects=("springs", "latch"),
            parameters={"springs.second_rest": 3.0, "springs.second_stiffness": 20.0, "latch.restitution": 0.9},
            run=(10.0, 0.05),
        ),
        "hit while the first joint sticks": HardCase(
            "No friction bears an impact: the first joint slides on, and rests again; the latch holds.",
            (BoundedEnergy(limit=1e-9), Ends("latch.latched", 0.0, value=1.0), Ends("first_rate", 0.0, value=0.0)),
            effects=("stick_friction", "latch"),
            parameters={"stick_friction.second_level": 0.0, "stick_friction.first_level": 3.0, "start_second_rate": 1.5},
            run=(10.0, 0.05),
        ),
        "caught, and turning": HardCase(
            "A start that cannot be.",
            Refused("no rate between them", accepted={"start_second_rate": 0.0}),
            effects=("latch",),
            parameters={"latch.angle": 0.0, "start_second_rate": 1.0},
        ),
        "an elbow of a milligram": HardCase(
            "A string: krad/s at a substep of 1 ms.",
            Refused("substep = 0.001 s", accepted={"substep": 1e-5}),
            effects=("gravity",),
            parameters={"first_mass": 1e-6, "start_first_angle": 0.3, "start_second_angle": 0.3},
        ),
        "a lossless bounce between narrow stops": HardCase(
            "200 bounces a second and more, each of them located.",
            (Invariant("energy", 1e-5, share=True), Reaches(events, high=300.0)),
            effects=("stops",),
            parameters=NARROW | {"substep": 1e-4, "start_second_rate": 1.0},
            run=(1.0, 0.1),
        ),
        "stops too stiff for the substep": HardCase(
            "1 GN.m/rad.",
            Refused("limit of RK4", accepted={"substep": 3.6e-5}),
            effects=("gravity", "stops"),
            parameters={"stops.stiffness": 1e9},
        ),
        "a torque that is no number": HardCase(
            "The state before the step can be taken back.",
            Refused("not finite", "step", {"first_torque": 1.0}),
            effects=("gravity",),
            parameters=HIGH,
            inputs={"first_torque": jumps(0.0, (0.0, math.nan))},
        ),
    },
    "PassiveWalker": {
        "legs of hardly any mass": HardCase(
            "Feet of a billionth of the hip: energy and what impacts take make a whole.",
            (Invariant(_walked, 1e-10, share=True), Reaches("steps", high=4.5)),
            parameters=SIMPLEST | {"hip_mass": 1.0, "leg_mass": 1e-9},
            run=(20.0, 0.1),
        ),
        "a leg that does not swing": HardCase(
            "A leg without inertia about the hip.",
            Refused("without inertia about the hip", accepted={"leg_inertia": 0.1}),
            parameters={"leg_centre": 0.0},
        ),
        "several steps in one macro step": HardCase(
            "Impacts within a macro step of 10 s are where they are.",
            (Ends("strike_angle", 1e-9, value=SIMPLEST["start_stance_angle"]), Reaches("steps", high=4.5)),
            parameters=SIMPLEST,
            run=(20.0, 10.0),
        ),
        "on the level": HardCase(
            "Nothing makes up for what impacts take: ever shorter steps, and energy and what impacts take make a whole.",
            (Invariant(_walked, 1e-10, share=True), Reaches("steps", high=12.5), AtMost("step_length", 0.3, "step length, m")),
            parameters={"slope": 0.0},
            run=(20.0, 0.05),
        ),
        "pushed too hard": HardCase(
            "The hip flies: the ground would have to pull.",
            Refused("leaves the ground", "step", {"start_stance_rate": -1.1}),
            parameters={"start_stance_rate": -4.0},
            run=(2.0, 0.05),
        ),
        "lying at the start": HardCase(
            "A hip under the ground.",
            Refused("above the ground", accepted={"start_stance_angle": 0.3}),
            parameters={"start_stance_angle": 2.0},
        ),
    },
    "PlanarLink": {
        "upright": HardCase(
            "A pinned link on top of its joint, 1 nrad aside: it falls as exp(w t), and keeps its energy.",
            (
                Invariant("energy", 1e-13, share=True),
                AtMost(lambda c: c["angle"] - math.pi, 1.001e-9 * math.cosh(3.836 * 3.0), "angle from the top, rad"),
            ),
            effects=("pinned", "gravity"),
            parameters={"start_angle": math.pi + 1e-9},
            run=(3.0, 0.05),
        ),
        "thrown and spinning": HardCase(
            "Free: the centre of mass follows its parabola, the rate stays, whatever the spin.",
            (
                Invariant("rate", 0.0),
                Invariant("energy", 1e-13, share=True),
                Ends(lambda c: c["base_y"] - 0.5 * math.cos(c["angle"]), 1e-11, "height of the centre, m", value=-0.5 + 4.905),
            ),
            effects=("gravity",),
            parameters={"start_rate": 200.0, "start_velocity_x": -100.0, "start_velocity_y": 9.81},
            run=(1.0, 0.05),
        ),
        "no inertia about the joint": HardCase(
            "A pinned point in its own joint.",
            Refused("without inertia", accepted={"inertia": 1e-6}),
            effects=("pinned",),
            parameters={"inertia": 0.0, "centre": 0.0},
        ),
        "a pinned base that moves": HardCase(
            "A start that cannot be.",
            Refused("at a pinned base", accepted={"start_velocity_x": 0.0}),
            effects=("pinned",),
            parameters={"start_velocity_x": 1.0},
        ),
    },
    "CompliantJoint": {
        "play of no size and ends in one place": HardCase(
            "Directions of nothing: no division by their distance.",
            (AtMost("second_force_x", 0.0), AtMost(_balance, 0.0, "sum of the forces, N")),
            effects=("clearance",),
            parameters={"clearance.radius": 0.0},
        ),
        "through the play and back": HardCase(
            "No force within the play; action is exactly reaction, everywhere.",
            (AtMost(_balance, 0.0, "sum of the forces, N"), AtMost("second_force_x", 1e5 * 1e-4 + 100.0 * 0.02)),
            effects=("clearance", "rotation"),
            inputs={"second_x": sine(2e-4, 100.0), "second_velocity_x": 0.02},
        ),
        "steel in the joint": HardCase(
            "1e12 N/m at a micrometre.",
            (AtMost("second_force_y", 1e6), Finite(limit=2e5)),
            parameters={"stiffness": 1e12, "damping": 0.0},
            inputs={"second_y": sine(1e-6, 100.0)},
        ),
    },
}
