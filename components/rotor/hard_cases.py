"""Hard cases of rotors: nothing that holds them, infinite bearing forces, no damping at a critical speed, rest and reversal."""

from __future__ import annotations

import math

from ..core.component import Component
from ..core.hard_cases import AtMost, Ends, HardCase, Invariant, Refused, jumps

RIGID = 1e12  # N/m
LONG = {"substep": 1e-3, "element": 0.25}  # of an implicit method: any step is stable


def _orbit(component: Component) -> float:
    """Distance of the watched point from the axis, m."""
    return math.hypot(component["displacement_x"], component["displacement_y"])


HARD_CASES = {
    "JeffcottRotor": (
        HardCase(
            "undamped at the critical speed",
            "The amplitude e w t / 2 grows with the time, and no faster.",
            (AtMost(_orbit, 2.6e-4, "orbit, m"), Ends(_orbit, 1.2e-5, "orbit, m", value=2.5e-4)),
            ("unbalance",),
            {"damping": 0.0, "start_speed": 100.0},
            duration=0.5,
        ),
        HardCase(
            "near the onset of instability",
            "Internal damping at nine tenths of the speed at which it wins: a blow dies away.",
            (AtMost("displacement_x", 2e-3), Ends(_orbit, 0.65e-3, "orbit, m")),
            ("internal_damping",),
            {"start_speed": 450.0, "substep": 1e-3},
            {"force_x": jumps(0.0, (0.0, 100.0), (0.01, 0.0))},
            duration=3.0,
            step=1e-2,
        ),
        HardCase(
            "down through standstill",
            "The run-up's ramp leads to the opposite speed.",
            (Ends("speed", 0.0, value=-50.0), AtMost("displacement_x", 1e-3)),
            ("run_up", "unbalance"),
            {"start_speed": 50.0, "run_up.acceleration": 100.0, "run_up.end_speed": -50.0, "substep": 1e-3},
            duration=1.5,
            step=0.01,
        ),
        HardCase(
            "a shaft too stiff for the substep",
            "1 GN/m on 10 kg.",
            Refused("the limit of RK4", accepted={"substep": 2.6e-4}),
            (),
            {"stiffness": 1e9, "substep": 1e-3},
        ),
    ),
    "BeamRotor": (
        HardCase(
            "nothing holds it",
            "It falls by g t²/2; bending forces of 1e8 N/m a metre stay below rounding.",
            (Invariant("displacement_y", 1e-12, value=lambda t: -0.5 * 9.81 * t**2),),
            ("gravity",),
            LONG,
            duration=0.1,
            step=0.01,
        ),
        HardCase(
            "infinite bearing forces",
            "1e12 N/m through the ports, steps of 0.1 s: the ends stay where they are held.",
            (AtMost("bearing_a.displacement_y", 1e-9), AtMost("displacement_y", 2e-3)),
            ("disks", "gravity", "bearing_a", "bearing_b"),
            LONG,
            {f"bearing_{end}.stiffness[{k}]": RIGID for end in "ab" for k in (1, 7)},
            duration=0.4,
            step=0.1,
        ),
        HardCase(
            "undamped",
            "A blow on a rotor that stands, on springs: the midpoint rule keeps the energy of each mode.",
            (Invariant("energy", 1e-10, share=True),),
            ("disks", "linear_supports"),
            LONG | {"start_speed": 0.0},
            {"force_y": jumps(1000.0, (0.0, 0.0))},
            duration=0.2,
            step=5e-3,
        ),
        HardCase(
            "an infinite force",
            "Infinite.",
            Refused("not finite", "step", {"force_x": 1.0}),
            ("linear_supports",),
            LONG,
            {"force_x": jumps(0.0, (0.0, math.inf))},
        ),
        HardCase(
            "a disk beside the shaft",
            "Its place is beyond the end.",
            Refused("a place on the shaft", accepted={"disks.position[1]": 1.5}),
            ("disks",),
            {"disks.position[1]": 1.6},
        ),
        HardCase(
            "steel that shrinks sideways",
            "A shear modulus with which Poisson's ratio has no value.",
            Refused("Poisson's ratio", accepted={"shear_modulus": 7.1e10}),
            (),
            {"shear_modulus": 7e10},
        ),
    ),
}
