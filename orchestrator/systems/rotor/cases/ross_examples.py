"""Rotors from tables beside ROSS: whirl and unbalance response of the coupled step's linear system, against an independent program."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ....harness.validation import Evidence, Runs
from ....scene.build import unit
from ....scene.scene import Scene
from ....session.session import Session
from ... import build_scene

STEP = 1e-5  # s; one internal step in each macro step, so that a held force lags by half of it
FORCES = ("rotor.force_x", "rotor.force_y")
PLACES = ("rotor.displacement_x", "rotor.displacement_y")

# m, m: shafts of the functions `rotor_example` and `rotor_example_with_damping`, a section for each of their elements
UNIFORM = ((0.25,) * 6, 0.05)
RIG = (  # mm, places of its nodes
    *(0, 25, 64, 104, 124, 143, 175, 207, 239, 271, 303, 335, 345, 355, 380, 408, 436),
    *(466, 496, 526, 556, 586, 614, 647, 657, 667, 702, 737, 772, 807, 842, 862, 881, 914),
)
DISKS = "position [m],m [kg],Id [kg.m2],Ip [kg.m2]\n"
TWO_DISKS = DISKS + "".join(f"{z},32.58972765304033,0.17808928257067666,0.32956362089137037\n" for z in (0.5, 1.0))
RIG_DISKS = DISKS + "".join(f"{z},2.6375,0.003844540885417,0.0075132484375\n" for z in (0.345, 0.657))
JOURNALS = (  # rad/s, then the coefficients of the left support, MN/m and kN.s/m; the right one has twice as much
    (100.0, 6.0, 1.0, -1.5, 8.0, 30.0, -2.0, -2.0, 40.0),
    (200.0, 5.0, 1.8, -2.6, 7.2, 20.0, -1.5, -1.5, 28.0),
    (400.0, 4.2, 2.8, -3.8, 6.5, 14.0, -1.0, -1.0, 19.0),
)
COUPLED = (
    "position [m],speed [rad/s],kxx [MN/m],kxy [MN/m],kyx [MN/m],kyy [MN/m],cxx [kN.s/m],cxy [kN.s/m],cyx [kN.s/m],cyy [kN.s/m]\n"
) + "".join(",".join(map(str, (z, w, *(f * c for c in row)))) + "\n" for z, f in ((0.0, 1.0), (1.5, 2.0)) for w, *row in JOURNALS)


class Example(NamedTuple):
    """A rotor from three tables, where its unbalance is, m, and how large, kg.m; the steel's modulus, Pa, and density, kg/m3."""

    lengths: Any
    diameter: float
    disks: str
    supports: str
    place: float
    unbalance: float
    steel: tuple[float, float]
    speeds: tuple[float, ...]


EXAMPLES = {
    "springs": Example(
        *UNIFORM, TWO_DISKS, "position [m],kxx [N/m],kyy [N/m],cxx [N.s/m]\n0,1e6,0.8e6,0\n1.5,1e6,0.8e6,0\n",
        0.5, 1e-3, (211e9, 7810.0), (200.0, 400.0),
    ),
    "rig": Example(
        np.diff(RIG) / 1e3, 0.019, RIG_DISKS,
        "position [m],kxx [N/m],kyy [N/m],cxx [N.s/m],cyy [N.s/m]\n0.124,4.4e5,4.6114e5,27.4,2.505\n0.862,9.5e5,1.09e8,50.4,100.4553\n",
        0.345, 1e-4, (217e9, 7850.0), (100.0, 400.0),
    ),
    "journals": Example(*UNIFORM, TWO_DISKS, COUPLED, 0.5, 1e-3, (211e9, 7810.0), (100.0, 200.0, 400.0)),
}  # fmt: skip


def measure(runs: Runs) -> Evidence:
    """`name.speed.frequency.k` and `.decay.k` of its whirls; `.amplitude.x` and `.y` of the response to the unbalance."""
    measured: dict[str, float] = {}
    for name, example in EXAMPLES.items():
        for speed in example.speeds:
            with Session(scene(example, speed)) as session:
                session.initialize()
                linear = session.linearize(FORCES, PLACES)
            whirls = sorted((m.rate for m in linear.modes() if m.rate.imag > 1.0), key=lambda rate: rate.imag)
            force = example.unbalance * speed**2 * np.array([1.0, -1j])
            response = linear.response([speed / (2.0 * math.pi)])[0] @ force / np.sinc(0.5 * speed * STEP / math.pi)
            label = f"{name}.{speed:g}"
            measured |= {f"{label}.frequency.{k}": rate.imag for k, rate in enumerate(whirls, 1)}
            measured |= {f"{label}.decay.{k}": -rate.real for k, rate in enumerate(whirls, 1)}
            measured |= {f"{label}.amplitude.{axis}": float(abs(z)) for axis, z in zip("xy", response, strict=True)}
    return Evidence(measured)


def scene(example: Example, speed: float) -> Scene:
    """One of the rotors at a constant speed."""
    young, density = example.steel
    shaft = "length [m],outer_diameter [m]\n" + "".join(
        f"{length!r},{example.diameter}\n" for length in map(float, example.lengths)
    )
    given: dict[str, Any] = {"youngs_modulus": young, "density": density, "element": 1.0, "start_speed": speed, "substep": STEP}
    tables = {"shaft_table": shaft, "disk_table": example.disks, "support_table": example.supports}
    given |= {name: {"table": table} for name, table in tables.items()}
    rotor = unit("BeamRotor", effects=["gyroscopic", "disks", *tables], watched_position=example.place, **given)
    title = f"A rotor from tables at {speed:g} rad/s"
    return build_scene({"rotor": rotor}, stop_time=100 * STEP, step=STEP, name="ross-examples", title=title)
