"""Hard cases of gimbal, chain, links and their joint: gimbal lock, chaos, no inertia, friction at its level, hard stops."""

from __future__ import annotations

import math

import numpy as np

from ..core.component import Component
from ..core.hard_cases import AtMost, BoundedEnergy, Ends, Finite, HardCase, Invariant, Refused, jumps, sine

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


def _events(component: Component) -> float:
    return float(component.work["events"])


def _integrals(component: Component) -> np.ndarray:
    """Integrals of the controller, V."""
    return component.x[3:5]


def _balance(component: Component) -> np.ndarray:
    """Sum of the forces on both ends, N."""
    return component.y[:2] + component.y[2:4]


HARD_CASES = {
    "GimbalBody": (
        HardCase(
            "a slender body near gimbal lock",
            "Momentum about an axis of hardly any inertia is a wall, 280 rad/s for some ms.",
            (Invariant("energy", 1e-8, share=True), Invariant("outer_momentum", 1e-8, share=True)),
            (),
            SLENDER
            | {
                "frame_inertia": 1e-5,
                "start_inner_angle": 1.0,
                "start_inner_rate": -2.0,
                "start_outer_rate": 0.02,
                "substep": 2e-4,
            },
            duration=1.0,
            step=0.01,
        ),
        HardCase(
            "gimbal lock",
            "Nothing resists turning about the body's own axis.",
            Refused("gimbal lock", accepted={"frame_inertia": 1e-6}),
            (),
            SLENDER | {"frame_inertia": 0.0},
        ),
        HardCase(
            "through gimbal lock without momentum",
            "It passes as if nothing were there.",
            (Ends("inner_angle", 1e-12, value=-1.0), AtMost("outer_angle", 0.0)),
            (),
            SLENDER | {"frame_inertia": 1e-10, "start_inner_angle": 1.0, "start_inner_rate": -2.0},
            duration=1.0,
            step=0.1,
        ),
        HardCase(
            "a wall that the substep does not see",
            "An axis turns by radians within a substep.",
            Refused("over a radian within a substep", "step", {"substep": 5e-5}),
            (),
            SLENDER | FAST,
            duration=0.2,
            step=0.01,
        ),
        HardCase(
            "friction at its very level",
            "The outer torque is exactly the level while the inner axis comes to rest.",
            (AtMost("outer_rate", 0.0), Ends("inner_angle", 1e-13, value=0.5 - 0.125), AtMost(_events, 1.0, "events")),
            ("stick_friction",),
            LEVELS | {"start_inner_rate": -0.5},
            {"outer_torque": 0.1},
            duration=1.0,
            step=0.125,
        ),
        HardCase(
            "many turning points under friction",
            "Both axes shaken about the level: it stays bounded, and energy is taken.",
            (Finite(limit=10.0),),
            ("gravity", "stick_friction"),
            {"stick_friction.static_ratio": 1.5},
            {"outer_torque": sine(0.12, 7.0), "inner_torque": sine(0.1, 17.0)},
            duration=2.0,
            step=0.01,
        ),
        HardCase(
            "fast nutation under slow precession",
            "1155 rad/s against 15 mrad/s: the mean motion stays -T / h.",
            (Ends("outer_angle", 2.0 * 0.3 * 0.02 / 400.0, value=-0.3 / 20.0), AtMost("inner_angle", 0.9 * 1e-4)),
            ("rotor",),
            GYRO | {"rotor.spin_momentum": 20.0, "substep": 1e-3},
            {"inner_torque": 0.3},
            duration=1.0,
            step=0.1,
        ),
        HardCase(
            "nutation beyond the substep",
            "100 N.m.s on 0.02 kg m².",
            Refused("limit of RK4", accepted={"substep": 4e-4}),
            ("rotor",),
            GYRO | {"rotor.spin_momentum": 100.0},
        ),
        HardCase(
            "thrown into a stop",
            "The stop gives back no more than it got.",
            (BoundedEnergy(limit=1e-9),),
            ("stops",),
            {"start_inner_rate": 5.0, "start_outer_rate": 3.0},
            duration=2.0,
            step=0.01,
        ),
    ),
    "GimbalController": (
        HardCase(
            "an error that stays",
            "A stuck axis: voltages end at their limit, and the integral does not wind up.",
            (AtMost("outer_voltage", 24.0), AtMost(_integrals, 660.0, "integrals, V")),
            (),
            {"set_outer_angle": 1.0},
            duration=10.0,
            step=0.01,
        ),
        HardCase(
            "steps between samples and across many",
            "A macro step of 250 samples that swing: finite, within the limits.",
            (AtMost("outer_voltage", 24.0), AtMost("inner_voltage", 24.0)),
            ("scan",),
            {},
            {"outer_angle": sine(1.0, 3.0), "inner_rate": sine(5.0, 7.0)},
            duration=5.0,
            step=0.5,
        ),
        HardCase(
            "an angle that is no number",
            "The run ends instead of going on with it.",
            Refused("not finite", "step", {"outer_angle": 0.1}),
            (),
            {},
            {"outer_angle": jumps(0.0, (0.0, math.nan))},
            step=0.01,
        ),
    ),
    "TwoLinkChain": (
        HardCase(
            "chaos",
            "From nearly upright: no trajectory means anything for long, the energy does.",
            (Invariant("energy", 1e-6, share=True),),
            ("gravity",),
            HIGH | {"substep": 1e-3},
            duration=3.0,
            step=0.05,
        ),
        HardCase(
            "upright with dry friction",
            "Rounding tips it without friction; a joint that stands bears it.",
            (Invariant("first_angle", 0.0), AtMost(_events, 0.0, "events")),
            ("gravity", "stick_friction"),
            {"start_first_angle": math.pi, "start_second_angle": math.pi + 1e-9},
            duration=2.0,
            step=0.1,
        ),
        HardCase(
            "friction at many turning points",
            "Both joints stop and start again: the energy never grows.",
            (BoundedEnergy(limit=1e-9),),
            ("gravity", "stick_friction"),
            HIGH | {"substep": 5e-4, "stick_friction.first_level": 0.5, "stick_friction.second_level": 0.5},
            duration=2.0,
            step=0.05,
        ),
        HardCase(
            "links without mass",
            "Stretched, the elbow has no equation of motion.",
            Refused("singular", accepted={"first_inertia": 1e-3}),
            ("gravity",),
            {"first_mass": 0.0},
        ),
        HardCase(
            "an elbow of a milligram",
            "A string: krad/s at a substep of 1 ms.",
            Refused("substep = 0.001 s", accepted={"substep": 1e-5}),
            ("gravity",),
            {"first_mass": 1e-6, "start_first_angle": 0.3, "start_second_angle": 0.3},
        ),
        HardCase(
            "a lossless bounce between narrow stops",
            "200 bounces a second and more, each of them located.",
            (Invariant("energy", 1e-5, share=True),),
            ("stops",),
            NARROW | {"substep": 1e-4, "start_second_rate": 1.0},
            duration=0.1,
            step=0.01,
        ),
        HardCase(
            "stops too stiff for the substep",
            "1 GN.m/rad.",
            Refused("limit of RK4", accepted={"substep": 3.6e-5}),
            ("gravity", "stops"),
            {"stops.stiffness": 1e9},
        ),
        HardCase(
            "a torque that is no number",
            "The state before the step can be taken back.",
            Refused("not finite", "step", {"first_torque": 1.0}),
            ("gravity",),
            HIGH,
            {"first_torque": jumps(0.0, (0.0, math.nan))},
        ),
    ),
    "PlanarLink": (
        HardCase(
            "upright",
            "A pinned link on top of its joint, 1 nrad aside: it falls as exp(w t), and keeps its energy.",
            (
                Invariant("energy", 1e-13, share=True),
                AtMost(lambda c: c["angle"] - math.pi, 1.001e-9 * math.cosh(3.836 * 3.0), "angle from the top, rad"),
            ),
            ("pinned", "gravity"),
            {"start_angle": math.pi + 1e-9},
            duration=3.0,
            step=0.05,
        ),
        HardCase(
            "thrown and spinning",
            "Free: the centre of mass follows its parabola, the rate stays, whatever the spin.",
            (
                Invariant("rate", 0.0),
                Invariant("energy", 1e-13, share=True),
                Ends(lambda c: c["base_y"] - 0.5 * math.cos(c["angle"]), 1e-11, "height of the centre, m", value=-0.5 + 4.905),
            ),
            ("gravity",),
            {"start_rate": 200.0, "start_velocity_x": -100.0, "start_velocity_y": 9.81},
            duration=1.0,
            step=0.05,
        ),
        HardCase(
            "no inertia about the joint",
            "A pinned point in its own joint.",
            Refused("without inertia", accepted={"inertia": 1e-6}),
            ("pinned",),
            {"inertia": 0.0, "centre": 0.0},
        ),
        HardCase(
            "a pinned base that moves",
            "A start that cannot be.",
            Refused("at a pinned base", accepted={"start_velocity_x": 0.0}),
            ("pinned",),
            {"start_velocity_x": 1.0},
        ),
    ),
    "CompliantJoint": (
        HardCase(
            "play of no size and ends in one place",
            "Directions of nothing: no division by their distance.",
            (AtMost("second_force_x", 0.0), AtMost(_balance, 0.0, "sum of the forces, N")),
            ("clearance",),
            {"clearance.radius": 0.0},
        ),
        HardCase(
            "through the play and back",
            "No force within the play; action is exactly reaction, everywhere.",
            (AtMost(_balance, 0.0, "sum of the forces, N"), AtMost("second_force_x", 1e5 * 1e-4 + 100.0 * 0.02)),
            ("clearance", "rotation"),
            {},
            {"second_x": sine(2e-4, 100.0), "second_velocity_x": 0.02},
        ),
        HardCase(
            "steel in the joint",
            "1e12 N/m at a micrometre.",
            (AtMost("second_force_y", 1e6), Finite(limit=2e5)),
            (),
            {"stiffness": 1e12, "damping": 0.0},
            {"second_y": sine(1e-6, 100.0)},
        ),
    ),
}
