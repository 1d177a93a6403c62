"""Hard cases of rotors: nothing that holds them, infinite bearing forces, no damping at a critical speed, rest and reversal."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..core.component import Component
from ..core.hard_cases import AtMost, Ends, HardCase, Invariant, Like, Refused, jumps

RIGID = 1e12  # N/m
LONG = {"substep": 1e-3, "element": 0.25}  # of an implicit method: any step is stable


def _mirrored(component: Component) -> np.ndarray:
    return np.array([component["displacement_x"], -component["displacement_y"]])


def _place(component: Component) -> np.ndarray:
    return np.array([component["displacement_x"], component["displacement_y"]])


def _fall(component: Any) -> np.ndarray:
    """Heights of all nodes, m, and what the shaft bends, rad."""
    return np.concatenate(
        (
            component.x[1 : 4 * component.nodes.size : 4],
            -0.5 * 9.81 * component.t**2 + component.x[2 : 4 * component.nodes.size : 4],
        )
    )


def _orbit(component: Component) -> float:
    """Distance of the watched point from the axis, m."""
    return math.hypot(component["displacement_x"], component["displacement_y"])


def _turning(speed: float, phase: str) -> dict[str, float]:
    return {"start_speed": speed, phase: math.copysign(0.5, speed), "start_angle": math.copysign(0.2, speed)}


def _backwards(speed: float, phase: str, **steps: float) -> tuple[Like, Like]:
    """It ends as the mirror image of itself turned the other way."""
    other = {"parameters": _turning(-speed, phase) | steps}
    return (
        Like(_place, 1e-9, "mirrored displacement", instead=other, mirror=_mirrored, share=True),
        Like("angle", 1e-12, instead=other, mirror=lambda c: 2.0 * math.pi - c["angle"]),
    )


SOFT = {f"linear_supports.stiffness_{axis}[{k}]": 0.0 for axis in "xy" for k in (1, 2)}


BORED = "length [m],outer_diameter [mm],inner_diameter [mm]\n1.5,50,{}\n"

SUPPORTS = "position [m],kxx [N/m],cxx [N.s/m]\n"
DISKS = "position [m],mass [kg],Ip [kg.m2],Id [kg.m2]\n"

HARD_CASES = {
    "JeffcottRotor": {
        "undamped at the critical speed": HardCase(
            "The amplitude e w t / 2 grows with the time, and no faster.",
            (AtMost(_orbit, 2.6e-4, "orbit, m"), Ends(_orbit, 1.2e-5, "orbit, m", value=2.5e-4)),
            effects=("unbalance",),
            parameters={"damping": 0.0, "start_speed": 100.0},
            run=(0.5, 1e-3),
        ),
        "near the onset of instability": HardCase(
            "Internal damping at nine tenths of the speed at which it wins: a blow dies away.",
            (AtMost("displacement_x", 2e-3), Ends(_orbit, 0.65e-3, "orbit, m")),
            effects=("internal_damping",),
            parameters={"start_speed": 450.0, "substep": 1e-3},
            inputs={"force_x": jumps(0.0, (0.0, 100.0), (0.01, 0.0))},
            run=(3.0, 1e-2),
        ),
        "backwards": HardCase(
            "The mirror image, to rounding: 2 pi - angle is not -angle to the last bit.",
            _backwards(130.0, "unbalance.phase"),
            effects=("unbalance", "internal_damping"),
            parameters=_turning(130.0, "unbalance.phase"),
            run=(0.2, 1e-3),
        ),
        "at rest": HardCase(
            "No unbalance force, and no angle.",
            (AtMost(_place, 0.0, "displacement, m"), AtMost("angle", 0.0)),
            effects=("unbalance", "internal_damping"),
            parameters={"start_speed": 0.0},
            run=(0.1, 0.1),
        ),
        "down through standstill": HardCase(
            "The run-up's ramp leads to the opposite speed: 12.5 rad forth, as many back, and 25 more.",
            (
                Ends("speed", 0.0, value=-50.0),
                AtMost("displacement_x", 1e-3),
                Ends("angle", 1e-10, value=-25.0 % (2.0 * math.pi)),
            ),
            effects=("run_up", "unbalance"),
            parameters={"start_speed": 50.0, "run_up.acceleration": 100.0, "run_up.end_speed": -50.0, "substep": 1e-3},
            run=(1.5, 0.01),
        ),
        "a shaft too stiff for the substep": HardCase(
            "1 GN/m on 10 kg.",
            Refused("the limit of RK4", accepted={"substep": 2.6e-4}),
            parameters={"stiffness": 1e9, "substep": 1e-3},
        ),
    },
    "BeamRotor": {
        **{
            f"nothing holds it, {name}": HardCase(
                "It falls by g t²/2; bending forces of 1e8 N/m a metre stay below rounding.",
                (
                    Invariant("displacement_y", limit, value=lambda t: -0.5 * 9.81 * t**2),
                    Invariant(_fall, 1e-7, "all nodes, m; their bending, rad", value=lambda t: -0.5 * 9.81 * t**2),
                ),
                effects=("gravity", *effects),
                parameters=given,
                run=(0.1, 0.01),
            )
            for name, effects, given, limit in (
                ("a shaft", (), LONG, 1e-12),
                ("disks", ("disks", "gyroscopic"), LONG, 1e-8),
                ("supports without stiffness", ("disks", "linear_supports"), LONG | SOFT, 1e-8),
            )
        },
        "backwards": HardCase(
            "The mirror image, to rounding.",
            _backwards(130.0, "unbalance.phase[1]", element=0.25, substep=5e-5),
            effects=("unbalance", "internal_damping", "disks", "gyroscopic", "linear_supports"),
            parameters=_turning(130.0, "unbalance.phase[1]") | {"element": 0.25, "substep": 5e-5},
            run=(0.05, 1e-3),
        ),
        "at rest": HardCase(
            "No unbalance force, and no angle.",
            (AtMost(_place, 0.0, "displacement, m"), AtMost("angle", 0.0)),
            effects=("unbalance", "internal_damping", "disks", "linear_supports"),
            parameters=LONG | {"start_speed": 0.0},
            run=(0.1, 0.1),
        ),
        "down through standstill": HardCase(
            "The run-up's ramp leads to the opposite speed.",
            (Ends("speed", 0.0, value=-50.0), Ends("angle", 1e-10, value=-25.0 % (2.0 * math.pi))),
            effects=("run_up",),
            parameters=LONG | {"start_speed": 50.0, "run_up.acceleration": 100.0, "run_up.end_speed": -50.0},
            run=(1.5, 0.1),
        ),
        "one element": HardCase(
            "It is enough to run: half of the weight on each support.",
            (Invariant("displacement_y", 1e-9, value=-7810.0 * math.pi / 4.0 * 0.05**2 * 1.5 * 9.81 / 2e6, share=True),),
            effects=("gravity", "linear_supports"),
            parameters={"element": 10.0, "watched_position": 1.5, "substep": 1e-3},
            run=(0.01, 0.01),
        ),
        "infinite bearing forces": HardCase(
            "1e12 N/m through the ports, steps of 0.1 s: the ends stay where they are held.",
            (AtMost("bearing_a.displacement_y", 1e-9), AtMost("displacement_y", 2e-3)),
            effects=("disks", "gravity", "bearing_a", "bearing_b"),
            parameters=LONG,
            inputs={f"bearing_{end}.stiffness[{k}]": RIGID for end in "ab" for k in (1, 7)},
            run=(0.4, 0.1),
        ),
        "undamped": HardCase(
            "A blow on a rotor that stands, on springs: the midpoint rule keeps the energy of each mode.",
            (Invariant("energy", 1e-10, share=True),),
            effects=("disks", "linear_supports"),
            parameters=LONG | {"start_speed": 0.0},
            inputs={"force_y": jumps(1000.0, (0.0, 0.0))},
            run=(0.2, 5e-3),
        ),
        "an infinite force": HardCase(
            "Infinite.",
            Refused("not finite", "step", {"force_x": 1.0}),
            effects=("linear_supports",),
            parameters=LONG,
            inputs={"force_x": jumps(0.0, (0.0, math.inf))},
        ),
        "a disk beside the shaft": HardCase(
            "Its place is beyond the end.",
            Refused("a place on the shaft", accepted={"disks.position[1]": 1.5}),
            effects=("disks",),
            parameters={"disks.position[1]": 1.6},
        ),
        "sections thinner than a millionth": HardCase(
            "A collar of a tenth of a micrometre shares a node with its neighbours, and the shaft is as if it were not there.",
            (Ends("displacement_x", 1e-7, value=0.0),),
            effects=("shaft_table", "linear_supports"),
            parameters={"shaft_table.table": "length [m],outer_diameter [m]\n0.75,0.05\n1e-7,0.5\n0.7499999,0.05\n"},
            run=(2e-3, 1e-4),
        ),
        "a section without a wall": HardCase(
            "Bored as wide as it is thick.",
            Refused("and a wall", accepted={"shaft_table.table": BORED.format(49)}),
            effects=("shaft_table",),
            parameters={"shaft_table.table": BORED.format(50)},
        ),
        "a table of supports without stiffness": HardCase(
            "It falls by g t²/2.",
            (Invariant("displacement_y", 1e-8, value=lambda t: -0.5 * 9.81 * t**2),),
            effects=("gravity", "support_table"),
            parameters=LONG | {"support_table.table": f"{SUPPORTS}0,0,0\n1.5,0,0\n"},
            run=(0.1, 0.01),
        ),
        "a run-up beyond the rows of a support": HardCase(
            "Rows to 150 rad/s, a run-up to 151.",
            Refused("within the rows", accepted={"run_up.end_speed": 150.0}),
            effects=("support_table", "run_up"),
            parameters={
                "support_table.table": SUPPORTS.replace("position [m]", "position [m],speed [rad/s]")
                + "0,0,1e6,0\n0,150,2e6,0\n",
                "run_up.end_speed": 151.0,
            },
        ),
        "a table of disks with nothing in a row": HardCase(
            "Neither mass nor inertia.",
            Refused("a mass or an inertia", accepted={"disk_table.table": f"{DISKS}0.5,1e-9,0,0\n"}),
            effects=("disks", "disk_table"),
            parameters={"disk_table.table": f"{DISKS}0.5,0,0,0\n"},
        ),
        "steel that shrinks sideways": HardCase(
            "A shear modulus with which Poisson's ratio has no value.",
            Refused("Poisson's ratio", accepted={"shear_modulus": 7.1e10}),
            parameters={"shear_modulus": 7e10},
        ),
    },
}
