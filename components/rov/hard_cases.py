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
    "RovHull": {
        "a loop through both verticals": HardCase(
            "Euler's angles have no value there; the quaternion keeps length and axis.",
            (Invariant(_norm, 1e-15, "length of the quaternion", value=1.0), AtMost(_axis, 1e-12, "axis of the turn")),
            parameters=BALL | {"start_pitch_rate": 1.0},
            run=(7.0, 0.05),
        ),
        "a start in the vertical": HardCase(
            "Nose up: roll and yaw are what was given, and no number is lost.",
            (Invariant("attitude_valid", 0.0, value=0.0), Invariant("yaw", 1e-12, value=0.5)),
            parameters=BALL | {"start_pitch": 0.5 * math.pi, "start_yaw": 0.5, "start_roll": 0.3},
        ),
        "added mass a million times the mass": HardCase(
            "In one unit there is no limit on their ratio: F = (m + m_A) a.",
            (Invariant("heave", 1e-15, value=lambda t: 10.0 * t / (11.5 * (1.0 + 1e6))),),
            effects=("added_mass", "coriolis", "restoring", "external"),
            parameters=NEUTRAL | {"added_mass.heave": 11.5e6},
            inputs={"external.force_z": 10.0},
            run=(10.0, 1.0),
        ),
        "tumbling in still water": HardCase(
            "All axes at once, far from upright: drag only takes.",
            (BoundedEnergy(limit=1e-12), Ends("surge", 1e-2)),
            effects=WATER,
            parameters=NEUTRAL | TUMBLING,
            run=(10.0, 0.5),
        ),
        "a flow of 200 m/s, followed": HardCase(
            "Quadratic drag against its closed form.",
            (Invariant("surge", 1e-6, value=_through_the_water),),
            effects=(*WATER, "current"),
            parameters=NEUTRAL | {"substep": 1e-4, "centre_of_gravity_z": 0.0},
            inputs={"current.velocity_north": 200.0},
            run=(0.1, 0.01),
        ),
        "a flow of 200 m/s, too fast for the step": HardCase(
            "Drag far beyond RK4's limit at the default step.",
            Refused("not finite", "step", {"substep": 1e-3}),
            effects=(*WATER, "current"),
            inputs={"current.velocity_north": 200.0},
            run=(0.5, 0.1),
        ),
        "inertia that no body has": HardCase(
            "Given about the centre of gravity by mistake.",
            Refused("about the origin", accepted={"centre_of_gravity_z": 0.11}),
            parameters={"centre_of_gravity_z": 0.2},
        ),
        "a thruster without direction": HardCase(
            "All three of its components are 0.",
            Refused("thruster 3 with the direction", accepted={"thruster_direction_z[3]": 1.0}),
            parameters={f"thruster_direction_{a}[3]": 0.0 for a in "xyz"},
        ),
    },
    "AddedMassForce": {
        "a jump of the acceleration": HardCase(
            "A massless law: the force is that of the instant, without a memory.",
            (AtMost(lambda c: c["force_y"] + INERTIA * c["acceleration_y"], 0.0, "force and inertia, N"),),
            inputs={"acceleration_y": jumps(0.0, (0.02, 1e6), (0.04, -1e6), (0.06, 0.0))},
        ),
        "no added mass": HardCase(
            "Nothing, whatever the acceleration.",
            (AtMost("force_z", 0.0),),
            parameters={"heave": 0.0},
            inputs={"acceleration_z": sine(1e9, 100.0)},
        ),
    },
    "Thruster": {
        "full reversal through standstill": HardCase(
            "|n| n and |n| u_a have a corner at rest: full astern at 1 m/s ahead.",
            (Finite(limit=50.0),),
            effects=("propeller", "inductance"),
            inputs={"command": jumps(1.0, (0.0, -1.0)), "propeller.advance_speed": 1.0},
            run=(0.3, 0.02),
        ),
        "within the dead band": HardCase(
            "No command below a tenth moves the water.",
            (AtMost("thrust", 0.0),),
            effects=("static_curve", "lag"),
            inputs={"command": sine(0.02, 10.0)},
            run=(0.5, 0.02),
        ),
        "commands beyond the range": HardCase(
            "Ten times full: no more than full.",
            (AtMost("thrust", 52.0),),
            effects=("static_curve",),
            inputs={"command": sine(10.0, 10.0)},
            run=(0.5, 0.02),
        ),
        "a curve that falls": HardCase(
            "More command, less thrust.",
            Refused("do not decrease", accepted={"static_curve.command[3]": -0.5}),
            effects=("static_curve",),
            parameters={"static_curve.command[3]": -1.0},
        ),
        "a lag the step cannot follow": HardCase(
            "A pole at 85 1/s and a substep of 50 ms.",
            Refused("substep", accepted={"substep": 0.02}),
            effects=("motor_lag",),
            parameters={"substep": 0.05},
        ),
        "a propeller that is a source of power": HardCase(
            "More thrust power than the shaft gives.",
            Refused("thrust power"),
            effects=("propeller",),
            parameters={"propeller.torque_bollard": 0.01},
        ),
    },
    "WaterCurrent": {
        "a gust of a millisecond": HardCase(
            "5 m/s and back within four steps: the value is that of the instant.",
            (AtMost("velocity_north", 5.3), Ends("velocity_north", 0.0, value=0.3)),
            effects=("gust",),
            parameters={"gust.amplitude": 5.0, "gust.start_time": 0.05, "gust.duration": 1e-3},
            run=(0.1, 2.5e-4),
        ),
        "a tide over ten years": HardCase(
            "Its phase after 7000 turns: sums of times that are rounded once.",
            (AtMost("velocity_north", 0.5), Ends("velocity_north", 1e-11, value=0.3)),
            effects=("tide",),
            run=(7000 * 44714.0, 7e2 * 44714.0),
        ),
        "short waves over the deep sea": HardCase(
            "k h of 4e5, where cosh is no number; a diver far above and below the water.",
            (AtMost("velocity_north", 0.3 + 0.16), AtMost("velocity_down", 0.16), AtMost("acceleration_down", 0.99)),
            effects=("waves",),
            parameters={"waves.height": 0.05, "waves.period": 1.0, "waves.water_depth": 1e5},
            inputs={"waves.depth": sine(2e5, 1.0)},
            run=(10.0, 0.05),
        ),
        "a wave over ten years": HardCase(
            "Its phase after 10⁸ periods: a product that is rounded once.",
            (AtMost("waves.elevation", 0.25), Ends("waves.elevation", 1e-6, value=0.25)),
            effects=("waves",),
            run=(4e8, 4e7),
        ),
        "a wave that has broken": HardCase(
            "4 m high at a period of 4 s.",
            Refused("break at this period", "initialize", {"waves.height": 3.4}),
            effects=("waves",),
            parameters={"waves.height": 4.0},
        ),
        "a ramp of no time": HardCase(
            "It is refused to divide by it.",
            Refused("ramp.duration", "construction", {"ramp.duration": 1e-3}),
            effects=("ramp",),
            parameters={"ramp.duration": 0.0},
        ),
    },
    "RovController": {
        "a target a hundred kilometres away": HardCase(
            "Within their reach the commands keep their proportion, and full is full.",
            (AtMost(_commands, 1.0, "commands"), AtLeast("scale", 0.0)),
            parameters={"set_north": 1e5, "set_depth": 5e4},
            run=(5.0, 0.1),
        ),
        "every thruster failed": HardCase(
            "Nothing to command with: no division by what is available.",
            (AtMost(_commands, 1.0, "commands"), Finite(limit=10.0)),
            parameters={"set_north": 1.0},
            inputs={f"available[{k}]": 0.0 for k in range(1, 7)},
            run=(1.0, 0.1),
        ),
        "upside down": HardCase(
            "The error of the attitude is half a turn, and has a direction.",
            (AtMost(_commands, 1.0, "commands"), AtMost("error_roll", math.pi)),
            inputs={"quaternion_w": 0.0, "quaternion_x": 1.0},
            run=(1.0, 0.1),
        ),
        "an attitude that is none": HardCase(
            "All four numbers of the quaternion are 0.",
            Refused("not finite", "step", {"quaternion_w": 1.0}),
            inputs={"quaternion_w": jumps(1.0, (0.0, 0.0)), "position_north": 1.0},
            run=(0.1, 0.1),
        ),
        "a thruster without direction": HardCase(
            "The fourth one has none.",
            Refused("thruster 4", accepted={"thruster_direction_z[4]": 1e-3}),
            parameters={"thruster_direction_z[4]": 0.0},
        ),
    },
    "Tether": {
        "slack, taut and slack": HardCase(
            "Pulled beyond its length and back within seconds: it never pushes.",
            (AtLeast("tension", 0.0), AtLeast("anchor_tension", 0.0), AtMost("tension", 2.5 * AXIAL / 35.0 * 4.0)),
            effects=("internal_damping", "drag"),
            parameters={"mass_per_length": 0.06, "segments": 5, "substep": 5e-4},
            inputs={"position_north": ramp(9.0, 10.0), "velocity_north": 9.0},
            run=(1.0, 0.02),
        ),
        "taut, at the stable step": HardCase(
            "Its end is moved by a micrometre at 0.99 of the limit: tension E A / L times that.",
            (Invariant("tension", 2.0 * 1e-6 * AXIAL / 35.0),),
            effects=("internal_damping",),
            parameters={"segments": 5, "substep": 1.95e-3},
            inputs={"position_north": jumps(20.0, (0.0, 20.0 + 1e-6))},
            run=(2.0, 0.1),
        ),
        "a cable of steel": HardCase(
            "1 TPa at a substep of half a millisecond.",
            Refused("substep", accepted={"substep": 5e-6}),
            parameters={"youngs_modulus": 1e12},
            run=(0.1, 1e-4),
        ),
    },
}
