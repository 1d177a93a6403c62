"""Hard cases of the underwater vehicle: the vertical, added mass above the mass, dead bands, slack and taut tether."""

from __future__ import annotations

import math

import numpy as np

from ..core.component import Component
from ..core.hard_cases import AtLeast, AtMost, BoundedEnergy, Ends, Finite, HardCase, Invariant, Refused, jumps, ramp, sine

BALL = {f"inertia_{a}": 0.16 for a in "xyz"} | {"centre_of_gravity_z": 0.0}  # keeps any angular velocity
WATER = ("added_mass", "coriolis", "linear_drag", "quadratic_drag", "restoring")
NEUTRAL = {"restoring.buoyancy": 112.8}
QUATERNION = tuple(f"quaternion_{a}" for a in "wxyz")
TUMBLING = {
    "start_surge": 2.0,
    "start_sway": -2.0,
    "start_heave": 2.0,
    "start_roll_rate": 6.0,
    "start_pitch_rate": -6.0,
    "start_yaw_rate": 6.0,
    "start_roll": 2.0,
}
AXIAL = 6.437e7 * 4.418e-5  # N, modulus and area of the default tether
INERTIA = 12.7  # kg, added in sway


def _norm(component: Component) -> float:
    """Length of the attitude's quaternion."""
    return math.sqrt(sum(component[n] ** 2 for n in QUATERNION))


def _axis(component: Component) -> float:
    """How far the body's y axis, about which it turns, has left its place: 1 - cos of the angle."""
    return 2.0 * (component["quaternion_x"] ** 2 + component["quaternion_z"] ** 2)


def _commands(component: Component) -> np.ndarray:
    return component.y[:6]


def _through_the_water(t: float) -> float:
    """Surge of a vehicle at rest in a flow of 200 m/s, r' = -(X r + XX r²) / (m + m_A), m/s."""
    r = 4.03 / ((4.03 / 200.0 + 18.18) * math.exp(4.03 * t / 17.0) - 18.18)
    return 200.0 - r


HARD_CASES = {
    "RovHull": (
        HardCase(
            "a loop through both verticals",
            "Euler's angles have no value there; the quaternion keeps length and axis.",
            (Invariant(_norm, 1e-15, "length of the quaternion", value=1.0), AtMost(_axis, 1e-12, "axis of the turn")),
            (),
            BALL | {"start_pitch_rate": 1.0},
            duration=7.0,
            step=0.05,
        ),
        HardCase(
            "a start in the vertical",
            "Nose up: roll and yaw are what was given, and no number is lost.",
            (Invariant("attitude_valid", 0.0, value=0.0), Invariant("yaw", 1e-12, value=0.5)),
            (),
            BALL | {"start_pitch": 0.5 * math.pi, "start_yaw": 0.5, "start_roll": 0.3},
        ),
        HardCase(
            "added mass a million times the mass",
            "In one unit there is no limit on their ratio: F = (m + m_A) a.",
            (Invariant("heave", 1e-15, value=lambda t: 10.0 * t / (11.5 * (1.0 + 1e6))),),
            ("added_mass", "coriolis", "restoring", "external"),
            NEUTRAL | {"added_mass.heave": 11.5e6},
            {"external.force_z": 10.0},
            duration=10.0,
            step=1.0,
        ),
        HardCase(
            "tumbling in still water",
            "All axes at once, far from upright: drag only takes.",
            (BoundedEnergy(limit=1e-12), Ends("surge", 1e-2)),
            WATER,
            NEUTRAL | TUMBLING,
            duration=10.0,
            step=0.5,
        ),
        HardCase(
            "a flow of 200 m/s, followed",
            "Quadratic drag against its closed form.",
            (Invariant("surge", 1e-6, value=_through_the_water),),
            (*WATER, "current"),
            NEUTRAL | {"substep": 1e-4, "centre_of_gravity_z": 0.0},
            {"current.velocity_north": 200.0},
            duration=0.1,
            step=0.01,
        ),
        HardCase(
            "a flow of 200 m/s, too fast for the step",
            "Drag far beyond RK4's limit at the default step.",
            Refused("not finite", "step", {"substep": 1e-3}),
            (*WATER, "current"),
            {},
            {"current.velocity_north": 200.0},
            duration=0.5,
            step=0.1,
        ),
        HardCase(
            "inertia that no body has",
            "Given about the centre of gravity by mistake.",
            Refused("about the origin", accepted={"centre_of_gravity_z": 0.11}),
            (),
            {"centre_of_gravity_z": 0.2},
        ),
        HardCase(
            "a thruster without direction",
            "All three of its components are 0.",
            Refused("thruster 3 with the direction", accepted={"thruster_direction_z[3]": 1.0}),
            (),
            {f"thruster_direction_{a}[3]": 0.0 for a in "xyz"},
        ),
    ),
    "AddedMassForce": (
        HardCase(
            "a jump of the acceleration",
            "A massless law: the force is that of the instant, without a memory.",
            (AtMost(lambda c: c["force_y"] + INERTIA * c["acceleration_y"], 0.0, "force and inertia, N"),),
            (),
            {},
            {"acceleration_y": jumps(0.0, (0.02, 1e6), (0.04, -1e6), (0.06, 0.0))},
        ),
        HardCase(
            "no added mass",
            "Nothing, whatever the acceleration.",
            (AtMost("force_z", 0.0),),
            (),
            {"heave": 0.0},
            {"acceleration_z": sine(1e9, 100.0)},
        ),
    ),
    "Thruster": (
        HardCase(
            "full reversal through standstill",
            "|n| n and |n| u_a have a corner at rest: full astern at 1 m/s ahead.",
            (Finite(limit=50.0),),
            ("propeller", "inductance"),
            {},
            {"command": jumps(1.0, (0.0, -1.0)), "propeller.advance_speed": 1.0},
            duration=0.3,
            step=0.02,
        ),
        HardCase(
            "within the dead band",
            "No command below a tenth moves the water.",
            (AtMost("thrust", 0.0),),
            ("static_curve", "lag"),
            {},
            {"command": sine(0.02, 10.0)},
            duration=0.5,
            step=0.02,
        ),
        HardCase(
            "commands beyond the range",
            "Ten times full: no more than full.",
            (AtMost("thrust", 52.0),),
            ("static_curve",),
            {},
            {"command": sine(10.0, 10.0)},
            duration=0.5,
            step=0.02,
        ),
        HardCase(
            "a curve that falls",
            "More command, less thrust.",
            Refused("do not decrease", accepted={"static_curve.command[3]": -0.5}),
            ("static_curve",),
            {"static_curve.command[3]": -1.0},
        ),
        HardCase(
            "a lag the step cannot follow",
            "A pole at 85 1/s and a substep of 50 ms.",
            Refused("substep", accepted={"substep": 0.02}),
            ("motor_lag",),
            {"substep": 0.05},
        ),
        HardCase(
            "a propeller that is a source of power",
            "More thrust power than the shaft gives.",
            Refused("thrust power"),
            ("propeller",),
            {"propeller.torque_bollard": 0.01},
        ),
    ),
    "WaterCurrent": (
        HardCase(
            "a gust of a millisecond",
            "5 m/s and back within four steps: the value is that of the instant.",
            (AtMost("velocity_north", 5.3), Ends("velocity_north", 0.0, value=0.3)),
            ("gust",),
            {"gust.amplitude": 5.0, "gust.start_time": 0.05, "gust.duration": 1e-3},
            duration=0.1,
            step=2.5e-4,
        ),
        HardCase(
            "a tide over ten years",
            "Its phase after 7000 turns: sums of times that are rounded once.",
            (AtMost("velocity_north", 0.5), Ends("velocity_north", 1e-11, value=0.3)),
            ("tide",),
            {},
            duration=7000 * 44714.0,
            step=7e2 * 44714.0,
        ),
        HardCase(
            "short waves over the deep sea",
            "k h of 4e5, where cosh is no number; a diver far above and below the water.",
            (AtMost("velocity_north", 0.3 + 0.16), AtMost("velocity_down", 0.16), AtMost("acceleration_down", 0.99)),
            ("waves",),
            {"waves.height": 0.05, "waves.period": 1.0, "waves.water_depth": 1e5},
            {"waves.depth": sine(2e5, 1.0)},
            duration=10.0,
            step=0.05,
        ),
        HardCase(
            "a wave over ten years",
            "Its phase after 10^8 periods: a product that is rounded once.",
            (AtMost("waves.elevation", 0.25), Ends("waves.elevation", 1e-6, value=0.25)),
            ("waves",),
            {},
            {},
            duration=4e8,
            step=4e7,
        ),
        HardCase(
            "a wave that has broken",
            "4 m high at a period of 4 s.",
            Refused("break at this period", "initialize", {"waves.height": 3.4}),
            ("waves",),
            {"waves.height": 4.0},
        ),
        HardCase(
            "a ramp of no time",
            "It is refused to divide by it.",
            Refused("ramp.duration", "construction", {"ramp.duration": 1e-3}),
            ("ramp",),
            {"ramp.duration": 0.0},
        ),
    ),
    "RovController": (
        HardCase(
            "a target a hundred kilometres away",
            "Within their reach the commands keep their proportion, and full is full.",
            (AtMost(_commands, 1.0, "commands"), AtLeast("scale", 0.0)),
            (),
            {"set_north": 1e5, "set_depth": 5e4},
            duration=5.0,
            step=0.1,
        ),
        HardCase(
            "every thruster failed",
            "Nothing to command with: no division by what is available.",
            (AtMost(_commands, 1.0, "commands"), Finite(limit=10.0)),
            (),
            {"set_north": 1.0},
            {f"available[{k}]": 0.0 for k in range(1, 7)},
            duration=1.0,
            step=0.1,
        ),
        HardCase(
            "upside down",
            "The error of the attitude is half a turn, and has a direction.",
            (AtMost(_commands, 1.0, "commands"), AtMost("error_roll", math.pi)),
            (),
            {},
            {"quaternion_w": 0.0, "quaternion_x": 1.0},
            duration=1.0,
            step=0.1,
        ),
        HardCase(
            "an attitude that is none",
            "All four numbers of the quaternion are 0.",
            Refused("not finite", "step", {"quaternion_w": 1.0}),
            (),
            {},
            {"quaternion_w": jumps(1.0, (0.0, 0.0)), "position_north": 1.0},
            step=0.1,
        ),
        HardCase(
            "a thruster without direction",
            "The fourth one has none.",
            Refused("thruster 4", accepted={"thruster_direction_z[4]": 1e-3}),
            (),
            {"thruster_direction_z[4]": 0.0},
        ),
    ),
    "Tether": (
        HardCase(
            "slack, taut and slack",
            "Pulled beyond its length and back within seconds: it never pushes.",
            (AtLeast("tension", 0.0), AtLeast("anchor_tension", 0.0), AtMost("tension", 2.5 * AXIAL / 35.0 * 4.0)),
            ("internal_damping", "drag"),
            {"mass_per_length": 0.06, "segments": 5, "substep": 5e-4},
            {"position_north": ramp(9.0, 10.0), "velocity_north": 9.0},
            duration=1.0,
            step=0.02,
        ),
        HardCase(
            "taut, at the stable step",
            "Its end is moved by a micrometre at 0.99 of the limit: tension E A / L times that.",
            (Invariant("tension", 2.0 * 1e-6 * AXIAL / 35.0),),
            ("internal_damping",),
            {"segments": 5, "substep": 1.95e-3},
            {"position_north": jumps(20.0, (0.0, 20.0 + 1e-6))},
            duration=2.0,
            step=0.1,
        ),
        HardCase(
            "a cable of steel",
            "1 TPa at a substep of half a millisecond.",
            Refused("substep", accepted={"substep": 5e-6}),
            (),
            {"youngs_modulus": 1e12},
            step=1e-4,
        ),
    ),
}
