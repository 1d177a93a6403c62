"""Hard cases of the underwater vehicle: the vertical, added mass above the mass, dead bands, slack and taut tether."""

from __future__ import annotations

import math
from collections.abc import Callable

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
    Reaches,
    Refused,
    jumps,
    outputs,
    sine,
)

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


def _attitude(component: Component) -> np.ndarray:
    return np.array([component[n] for n in ("roll", "pitch", "yaw")])


def _speed_of(mass: float) -> Callable[[float], float]:
    """Of a mass under 10 N, m/s."""
    return lambda t: 10.0 * t / mass


def _commands(component: Component) -> np.ndarray:
    return component.y[:6]


def _through_the_water(t: float) -> float:
    """Surge of a vehicle at rest in a flow of 200 m/s, r' = -(X r + XX r²) / (m + m_A), m/s."""
    r = 4.03 / ((4.03 / 200.0 + 18.18) * math.exp(4.03 * t / 17.0) - 18.18)
    return 200.0 - r


def _falling_curves(effect: str) -> dict[str, HardCase]:
    """Curves that go back, in either column."""
    return {
        f"a curve that falls, {name}": HardCase(
            "More command, less thrust, or the other way about.",
            Refused("do not decrease", accepted={f"{effect}.{name}": accepted}),
            effects=(effect,),
            parameters={f"{effect}.{name}": value},
        )
        for name, value, accepted in (("command[3]", -1.0, -0.5), ("thrust[3]", -50.0, -26.0), ("thrust[16]", 51.0, 51.5))
    }


HARD_CASES = {
    "RovHull": {
        "a loop through both verticals": HardCase(
            "Euler's angles have no value there; the quaternion keeps length and axis.",
            (Invariant(_norm, 1e-15, "length of the quaternion", value=1.0), AtMost(_axis, 1e-12, "axis of the turn")),
            parameters=BALL | {"start_pitch_rate": 1.0},
            run=(7.0, 0.05),
        ),
        **{
            f"a start in the vertical, {roll:g} {pitch:+.0f} {yaw:g}": HardCase(
                "Nose up or down: roll and yaw are what was given, and no number is lost.",
                (
                    Invariant("attitude_valid", 0.0, value=0.0),
                    Invariant(
                        _attitude,
                        1e-12,
                        "angles given, rad",
                        value=[math.remainder(a, 2.0 * math.pi) for a in (roll, pitch, yaw)],
                    ),
                ),
                parameters=BALL | {"start_pitch": pitch, "start_yaw": yaw, "start_roll": roll},
                run=(0.01, 0.01),
            )
            for roll, yaw in ((0.3, 0.5), (0.0, 0.0), (-2.0, 3.0), (7.0, -4.0))
            for pitch in (0.5 * math.pi, -0.5 * math.pi)
        },
        "a start beyond the vertical": HardCase(
            "The same attitude in other words.",
            (
                Invariant("roll", 1e-14, value=0.2 - math.pi),
                Invariant("pitch", 1e-14, value=math.radians(60.0)),
                Invariant("yaw", 1e-14, value=0.1 - math.pi),
            ),
            parameters=BALL | {"start_roll": 0.2, "start_pitch": math.radians(120.0), "start_yaw": 0.1},
            run=(0.01, 0.01),
        ),
        "macro steps of any length": HardCase(
            "Rounding, which tumbling amplifies.",
            (
                Like(outputs, 1e-9, "all outputs after 4 steps", instead={"run": (10.0, 2.5)}),
                Like(outputs, 1e-9, "all outputs after 100 steps", instead={"run": (10.0, 0.1)}),
            ),
            effects=("added_mass", "coriolis", "restoring"),
            parameters={"start_roll_rate": 2.0, "start_pitch_rate": -1.5, "start_yaw_rate": 1.0, "start_surge": 1.0},
            run=(10.0, 10.0),
        ),
        "a start too fast for the step": HardCase(
            "40 m/s through the water.",
            Refused("at most 0.0", accepted={"substep": 0.01}),
            effects=WATER,
            parameters={"start_surge": 40.0, "substep": 0.05},
        ),
        "a step too long for the drag": HardCase(
            "A second.", Refused("Reduce substep", accepted={"substep": 0.05}), effects=WATER, parameters={"substep": 1.0}
        ),
        **{
            f"added mass {share:g} times the mass": HardCase(
                "In one unit there is no limit on their ratio: F = (m + m_A) a.",
                (
                    Invariant("heave", 1e-9, value=_speed_of(11.5 * (1.0 + share)), share=True),
                    Invariant("external.acceleration_z", 1e-12, value=10.0 / (11.5 * (1.0 + share)), share=True),
                ),
                effects=("added_mass", "coriolis", "restoring", "external"),
                parameters=NEUTRAL | {"added_mass.heave": 11.5 * share},
                inputs={"external.force_z": 10.0},
                run=(10.0, 1.0),
            )
            for share in (1.0, 1e3, 1e6)
        },
        "tumbling in still water": HardCase(
            "All axes at once, far from upright: drag only takes.",
            (BoundedEnergy(limit=1e-12), Ends("surge", 1e-2), Ends("roll", 1e-2), Ends("pitch", 1e-2)),
            effects=WATER,
            parameters=NEUTRAL | TUMBLING,
            run=(60.0, 1.0),
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
        "added mass of a kinetic energy below zero": HardCase(
            "Surge and sway share more than either has.",
            Refused("negative kinetic energy", accepted={"added_mass_coupling.force[1]": 8.3}),
            effects=("added_mass", "added_mass_coupling"),
            parameters={"added_mass_coupling.force[1]": 8.4},
        ),
        "drag that drives": HardCase(
            "Quadratic drag of surge by pitch: at the velocity that the message names it gives energy.",
            Refused("W from the water", accepted={"quadratic_drag_coupling.force_by_rate[2]": 4.0}),
            effects=("quadratic_drag", "quadratic_drag_coupling"),
            parameters={"quadratic_drag_coupling.force_by_rate[2]": 40.0},
        ),
        "tumbling with drag between all axes": HardCase(
            "Every number beside the diagonal: drag only takes.",
            (BoundedEnergy(limit=1e-12), Ends("surge", 1e-2), Ends("yaw_rate", 1e-2)),
            effects=("added_mass", "added_mass_coupling", "linear_drag", "linear_drag_coupling"),
            parameters=TUMBLING
            | {f"added_mass_coupling.mixed[{i}]": 0.2 for i in range(1, 10)}
            | {f"linear_drag_coupling.force_by_rate[{i}]": 0.1 for i in range(1, 10)}
            | {f"linear_drag_coupling.moment_by_speed[{i}]": -0.1 for i in range(1, 10)},
            run=(60.0, 1.0),
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
            (
                Finite(limit=50.0),
                Like("thrust", 1e-6, instead={"run": (0.5, 7e-3)}),
                Like("thrust", 1e-6, instead={"run": (0.5, 0.5)}),
                Reaches(lambda c: -c["thrust"], high=50.0),
            ),
            effects=("propeller", "inductance"),
            inputs={"command": jumps(1.0, (0.0, -1.0)), "propeller.advance_speed": 1.0},
            run=(0.5, 0.02),
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
        **_falling_curves("static_curve"),
        "a lag the step cannot follow": HardCase(
            "A pole at 85 1/s and a substep of 50 ms.",
            Refused("substep", accepted={"substep": 0.02}),
            effects=("motor_lag",),
            parameters={"substep": 0.05},
        ),
        "a propeller whose thrust does not fall with the advance": HardCase(
            "More thrust power than the shaft gives.",
            Refused("thrust power"),
            effects=("propeller",),
            parameters={"propeller.thrust_advance": 0.0},
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
        **_falling_curves("inverse_curve"),
    },
    "RovSensors": {
        "sensors that are lost nearly always": HardCase(
            "The first sample of each arrives, and holds: no value is made up.",
            (AtMost(lambda c: abs(c["measured_depth"] - 5.0), 0.0, "what was never measured, m"),),
            effects=("dropout",),
            parameters={"dropout.depth": 0.99, "dropout.depth_length": 99.0},
            inputs={"depth": jumps(5.0, (0.02, 50.0))},
            run=(0.4, 0.02),
        ),
        "an attitude error of many turns": HardCase(
            "Noise of 100 rad: the quaternion keeps its length.",
            (Invariant(lambda c: math.sqrt(sum(c[f"measured_{n}"] ** 2 for n in QUATERNION)), 1e-15, "length", value=1.0),),
            effects=("noise",),
            parameters={"noise.attitude": 100.0},
            run=(2.0, 0.02),
        ),
        "bursts that no chain has": HardCase(
            "Three of five samples lost, and no two in a row.",
            Refused("Lengthen the bursts", accepted={"dropout.imu_length": 2.0}),
            effects=("dropout",),
            parameters={"dropout.imu": 0.6},
        ),
    },
    "Tether": {
        "slack, taut and slack": HardCase(
            "Pulled beyond its length and back within seconds: it never pushes.",
            (
                AtLeast("tension", 0.0),
                AtLeast("anchor_tension", 0.0),
                AtMost("tension", 2.5 * AXIAL / 35.0 * 4.0),
                Reaches("tension", high=AXIAL / 35.0 * 4.0),
                Ends("tension", 30.0),
            ),
            effects=("internal_damping", "drag"),
            parameters={"mass_per_length": 0.06, "segments": 5},
            inputs={
                "position_north": InputSignal(lambda t: 10.0 + 3.0 * min(t, 6.0 - t)),
                "velocity_north": InputSignal(lambda t: 3.0 if t < 3.0 else -3.0, smooth=False),
            },
            run=(6.0, 0.02),
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
        "damping beyond the substep": HardCase(
            "5 ms.", Refused("substep", accepted={"substep": 5e-4}), effects=("internal_damping",), parameters={"substep": 5e-3}
        ),
    },
}
