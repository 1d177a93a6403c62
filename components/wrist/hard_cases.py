"""Hard cases of the wrist: toggle and change points, parallel axes, rigid ligaments, hard limits, torn fibres, no inertia."""

from __future__ import annotations

import math

import numpy as np

from ..core.component import Component
from ..core.hard_cases import AtLeast, AtMost, BoundedEnergy, Ends, Finite, HardCase, Invariant, Refused, jumps, ramp, sine

ROCKER_DRIVES = {"crank": 0.040, "coupler": 0.050, "rocker": 0.020, "ground": 0.055}
TOGGLE = math.acos((0.040**2 + 0.055**2 - 0.070**2) / (2.0 * 0.040 * 0.055))  # rad, where coupler and rocker are in one line
PARALLELOGRAM = {"crank": 0.020, "coupler": 0.050, "rocker": 0.020, "ground": 0.050}
FREE = {"proximal_damping": 0.0, "distal_damping": 0.0}
PARALLEL = 0.0101  # rad, half of the least angle between the axes
ISOMETRIC = {f"constraint.off_axis[{j}]": 0.0 for j in range(1, 6)}
TINY = {**FREE, "hand_mass": 0.0, "transverse_inertia": 1e-9, "axial_inertia": 0.0, "row_inertia": 0.0}
PULLED = {f"excitation[{i}]": 1.0 for i in range(1, 6)}


def _closure(component: Component) -> float:
    """How far the loop of crank, coupler and rocker is from closing, m."""
    p = component.parameters
    tip = p["ground"] + p["rocker"] * np.exp(1j * component["output_angle"]) - p["crank"] * np.exp(1j * component["input_angle"])
    return abs(abs(tip) - p["coupler"])


def _strains(component: Component) -> list[float]:
    return [component[f"constraint.strain[{j}]"] for j in range(1, 6)]


def _tensions(component: Component) -> list[float]:
    return [component[f"tension[{j}]"] for j in range(1, 6)]


def _forces(component: Component) -> list[float]:
    return [component[f"force[{i}]"] for i in range(1, 6)]


def _activations(component: Component) -> list[float]:
    return [component[f"activation[{i}]"] for i in range(1, 6)]


HARD_CASES = {
    "FourBar": {
        "through a change point": HardCase(
            "All links in one line, twice a turn: the loop closes and the ratio stays 1.",
            (AtMost(_closure, 1e-15, "open loop, m"), Invariant("ratio", 1e-12, value=1.0)),
            parameters=PARALLELOGRAM | {"change_point": "through"},
            inputs={"input_angle": ramp(2.0 * math.pi, 0.1), "input_rate": 2.0 * math.pi},
            run=(2.0, 0.0125),
        ),
        "folded at a change point": HardCase(
            "It goes on as the antiparallelogram, with a kink and without a gap.",
            (AtMost(_closure, 1e-15, "open loop, m"), Finite()),
            parameters=PARALLELOGRAM | {"change_point": "fold"},
            inputs={"input_angle": ramp(2.0 * math.pi, 0.1)},
            run=(2.0, 0.0125),
        ),
        "into the toggle": HardCase(
            "The ratio grows beyond bounds; the run ends before it.",
            Refused("the toggle, where coupler and rocker", "step", {"input_angle": TOGGLE - 1e-3}),
            parameters=ROCKER_DRIVES,
            inputs={"input_angle": ramp(1.0, TOGGLE - 0.05)},
            run=(0.1, 1e-3),
        ),
        "near the toggle": HardCase(
            "A microradian before it: the loop closes, and torques are finite.",
            (AtMost(_closure, 1e-15, "open loop, m"), Finite(limit=1e6)),
            parameters=ROCKER_DRIVES | {"least_transmission_angle": 1e-6},
            inputs={"input_angle": TOGGLE - 1e-6, "load_torque": 1.0},
        ),
        "a start beyond the toggle": HardCase(
            "Such a pose does not exist.",
            Refused("beyond the toggle", accepted={"input_angle": TOGGLE - 0.01}),
            parameters=ROCKER_DRIVES,
            inputs={"input_angle": TOGGLE + 0.01},
        ),
        "lengths that close nowhere": HardCase(
            "One link is longer than all others together.",
            Refused("the others together 0.06 m", accepted={"ground": 0.059}),
            parameters={"crank": 0.02, "coupler": 0.02, "rocker": 0.02, "ground": 0.07},
            inputs={"input_angle": 0.1},
        ),
        "an unresolved change point": HardCase(
            "It is not known how it goes on.",
            Refused("change point at the crank angle", accepted={"rocker": 0.021}),
            parameters=PARALLELOGRAM,
            inputs={"input_angle": 1.0},
        ),
    },
    "ForearmTendons": {
        "excitations beyond all bounds": HardCase(
            "They count from 0 to 1: activations stay there, forces within the largest.",
            (
                AtMost(_activations, 1.0, "activations"),
                AtLeast(_activations, 0.0, "activations"),
                AtLeast(_forces, 0.0, "forces, N"),
            ),
            inputs={f"excitation[{i}]": sine(1e6, 20.0 + i) for i in range(1, 6)},
            run=(0.5, 0.01),
        ),
        "torn fibres": HardCase(
            "A stretch far beyond what the exponential of their stiffness could bear.",
            (Finite(limit=1e300),),
            effects=("fibres",),
            inputs=PULLED | {"flexion": ramp(-1e5)},
            run=(1.0, 0.05),
        ),
        "shortened faster than they can": HardCase(
            "None pulls beyond its greatest rate, and none pushes.",
            (AtLeast(_forces, 0.0, "forces, N"),),
            effects=("force_velocity", "varying_arms"),
            inputs=PULLED | {"flexion_rate": sine(1e4, 20.0), "flexion": sine(1.0, 20.0)},
            run=(0.5, 0.01),
        ),
        "a rise beyond the substep": HardCase(
            "0.1 ms at 2 ms.", Refused("the limit of RK4", accepted={"substep": 2.6e-4}), parameters={"rise_time": 1e-4}
        ),
    },
    "Wrist": {
        "nearly parallel axes": HardCase(
            "One combination of the rows has 1e4 times the inertia of the other: nothing is lost.",
            (Invariant("energy", 1e-7, share=True),),
            effects=("morphology",),
            parameters=FREE
            | {
                "morphology.proximal_tilt": PARALLEL,
                "morphology.distal_tilt": PARALLEL,
                "morphology.row_offset": 0.0,
                "row_inertia": 0.0,
                "start_proximal_angle": 0.2,
                "start_distal_angle": 0.1,
            },
            run=(0.3, 0.02),
        ),
        "parallel axes": HardCase(
            "One motion instead of two.",
            Refused("one motion instead of two", accepted={"morphology.proximal_tilt": 0.011}),
            effects=("morphology",),
            parameters={"morphology.proximal_tilt": 0.009, "morphology.distal_tilt": 0.01},
        ),
        "thrown at a hard limit": HardCase(
            "20 kN.m/rad: it gives back no more than it got.",
            (BoundedEnergy(limit=1e-5), AtMost("deviation", 0.7)),
            effects=("interaction",),
            parameters={
                "interaction.stiffness": 2e4,
                "substep": 5e-5,
                "start_proximal_rate": 30.0,
                "start_distal_rate": -35.0,
                "interaction.contact_lower": -2.0,
            },
            run=(0.04, 1e-3),
        ),
        "five rigid ligaments without a contradiction": HardCase(
            "Large swings under all of them: strains are rounding.",
            (AtMost(_strains, 1e-14, "strains"),),
            effects=("morphology", "constraint"),
            parameters=FREE
            | ISOMETRIC
            | {"constraint.kind": "rigid", "start_proximal_angle": 0.6, "start_distal_angle": 0.3, "substep": 1e-2},
            run=(3.0, 0.1),
        ),
        "five rigid ligaments that contradict each other": HardCase(
            "They hold both rows.",
            Refused("hold both rows", accepted={"constraint.cut": 2}),
            effects=("morphology", "constraint"),
            parameters={"constraint.kind": "rigid"},
        ),
        "hardly any inertia": HardCase(
            "A hand of a mg.m²: krad/s at a substep of 1 ms.",
            Refused("Reduce substep", accepted={"substep": 8e-5}),
            parameters=TINY,
        ),
        "hardly any inertia, followed": HardCase(
            "A quarter of its period of 0.2 ms: amplitude rate / frequency.",
            (Ends("proximal_angle", 1e-7, value=100.0 * math.sqrt(1e-9), share=True), Invariant("energy", 1e-6, share=True)),
            parameters=TINY | {"substep": 1e-6, "start_proximal_rate": 100.0},
            run=(0.5 * math.pi * math.sqrt(1e-9), 0.5 * math.pi * math.sqrt(1e-9)),
        ),
        "no inertia": HardCase(
            "The mass matrix is singular.",
            Refused("mass matrix is singular", accepted={"transverse_inertia": 1e-3}),
            parameters={"transverse_inertia": 0.0, "axial_inertia": 0.0, "hand_mass": 0.0},
        ),
        "a hand turned too far": HardCase(
            "30 N.m without limits.",
            Refused("Give the effect interaction", "step", {"tau_flexion": 0.3}),
            effects=("morphology",),
            inputs={"tau_flexion": jumps(0.0, (0.0, 30.0))},
            run=(0.5, 0.05),
        ),
    },
    "LigamentBundle": {
        "slack": HardCase(
            "Without prestrain, to and fro: ligaments pull or do nothing.",
            (AtLeast(_tensions, 0.0, "tensions, N"), AtLeast("stored_energy", 0.0), Finite(limit=1e4)),
            inputs={"proximal_angle": sine(1.0, 10.0), "distal_angle": sine(0.8, 17.0)},
            run=(1.0, 0.01),
        ),
        "damping that would push": HardCase(
            "A quick release: the damper takes the tension to 0 and not below.",
            (AtLeast(_tensions, 0.0, "tensions, N"), AtLeast("dissipation", 1e-12)),
            parameters={"damping": 1.0, "prestrain": 0.02},
            inputs={"proximal_angle": sine(0.3, 50.0), "proximal_rate": sine(100.0, 50.0), "distal_rate": sine(50.0, 31.0)},
            run=(0.5, 0.01),
        ),
        "no toe": HardCase(
            "A kink at the slack length instead of a curve.",
            (AtLeast(_tensions, 0.0, "tensions, N"), AtLeast("stored_energy", 0.0)),
            parameters={"toe": 0.0},
            inputs={"proximal_angle": sine(1e-6, 10.0)},
            run=(1.0, 0.01),
        ),
        "parallel axes": HardCase(
            "One motion instead of two.",
            Refused("one motion instead of two", accepted={"proximal_tilt": 0.011}),
            parameters={"proximal_tilt": 0.009, "distal_tilt": 0.01},
        ),
    },
}
