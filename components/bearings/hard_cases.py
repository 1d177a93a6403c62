"""Hard cases of bearings and their heat: no contact, preload, one ball, short impacts, narrow pits, no load, no heat."""

from __future__ import annotations

import numpy as np

from ..core.component import Component
from ..core.hard_cases import AtLeast, AtMost, Ends, Finite, HardCase, InputSignal, Invariant, Refused, jumps, sine

START = {"given_start.x": 3e-3, "given_start.y": -2e-3, "given_start.velocity_x": -0.4, "given_start.velocity_y": 0.3}
LIGHT = {"mass": 0.1, "damping": 0.0, "clearance.radial_clearance": 10e-6}
MOVING = {"given_start.velocity_x": 0.1, "given_start.velocity_y": 3e-3}


def _motion(component: Component) -> np.ndarray:
    return component.x[:4]


def _forces(component: Component) -> np.ndarray:
    return component.y[:7]


def _rise(component: Component) -> np.ndarray:
    return component.x[:4] - 293.15


def _balance(component: Component) -> float:
    return component["heat_supplied"] - component["heat_stored"] - component["heat_released"]


def _axial_stiffness(component: Component) -> float:
    return component["linearisation.stiffness[13]"]


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
            (AtMost(_forces, 0.0, "forces, moments, loaded balls"),),
            effects=("damping", "friction"),
            parameters={"diametral_clearance": 2e-5},
            inputs={"displacement_x": sine(9.9e-6, 100.0), "velocity_x": 1.0, "speed": 500.0},
        ),
        "contact angle zero": HardCase(
            "Without play the axial stiffness vanishes in the middle: 2e-8 N/m a nanometre aside.",
            (AtMost(_axial_stiffness, 1e-6, "axial stiffness, N/m"), Finite()),
            effects=("linearisation", "damping"),
            inputs={"displacement_z": sine(1e-9, 100.0)},
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
    },
    "AngularContactConductance": {
        "load over twelve decades": HardCase(
            "Contacts that vanish with the cube root of the load: no division by their size.",
            (AtLeast("conductance", 0.0), Ends("conductance", 1e-4)),
            inputs={"axial_force": InputSignal(lambda t: 10.0 ** (3.0 - t), smooth=False)},
            run=(13.0, 1.0),
        ),
        "balls unload one after the other": HardCase(
            "A radial load beside an axial one, up to ten times as large.",
            (AtLeast("loaded_balls", 0.0, low=1.0), AtLeast("conductance", 0.0), Finite()),
            parameters={"balls": 16},
            inputs={"axial_force": 500.0, "radial_force": InputSignal(lambda t: 5e3 * t)},
            run=(1.0, 0.05),
        ),
        "a load that comes and goes": HardCase(
            "It leaves no trace.",
            (Ends("conductance", 0.0),),
            effects=("ball_bulk",),
            inputs={"axial_force": jumps(0.0, (1.0, 3000.0), (2.0, 1e-9), (3.0, 50.0), (4.0, 0.0))},
            run=(5.0, 1.0),
        ),
        "rings thinner than nothing": HardCase(
            "A bore beyond the race.",
            Refused("walls around", accepted={"ring_walls.bore": 0.045}),
            effects=("ring_walls",),
            parameters={"ring_walls.bore": 0.05},
        ),
    },
    "BearingTemperatures": {
        "no heat": HardCase(
            "Nothing changes, to rounding of 293 K through flows that should be 0.",
            (AtMost(_rise, 1e-9, "rise of the temperatures"), AtMost("clearance_change", 1e-14)),
            effects=("housing", "oil_flow", "radiation", "shaft_heat"),
            parameters={"substep": 500.0},
            inputs={"conductance": 0.7},
            run=(20e3, 1e3),
        ),
        "capacities of nothing": HardCase(
            "Time constants of nanoseconds under steps of a quarter of an hour: the steady state.",
            (
                Ends("inner_temperature", 1e-9, value=293.15 + 350.0 / 11.0),
                Ends("ball_temperature", 1e-9, value=293.15 + 387.5 / 11.0),
                AtMost(_balance, 1e-6, "balance of heat, J"),
            ),
            parameters={f"{part}_capacity": 1e-9 for part in ("inner", "ball", "outer")} | {"substep": 1000.0},
            inputs={"friction_power": 20.0},
            run=(3e3, 1e3),
        ),
        "an infinite conductance": HardCase(
            "1e12 W/K: one mass, P over both ways out.",
            (
                Ends("inner_temperature", 1e-6, value=293.15 + 20.0 / 1.2),
                Ends("ball_temperature", 1e-6, value=293.15 + 20.0 / 1.2),
            ),
            parameters={"substep": 100.0},
            inputs={"friction_power": 20.0, "conductance": 1e12},
            run=(2e4, 1e3),
        ),
        "a negative conductance": HardCase(
            "An extrapolated input may fall below 0: the balls keep what is theirs.",
            (Ends("ball_temperature", 1e-9, value=293.15 + 10.0 * 100.0 / 15.0),),
            inputs={"friction_power": 20.0, "conductance": -0.5},
            run=(100.0, 100.0),
        ),
        "more heat shared out than there is": HardCase(
            "Shares above 1.",
            Refused("at most 1", accepted={"inner_share": 0.5}),
            parameters={"inner_share": 0.6, "outer_share": 0.5},
        ),
    },
}
