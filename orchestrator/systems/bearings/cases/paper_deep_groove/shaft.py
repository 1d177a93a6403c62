"""A rigid shaft in one deep groove bearing: the scene that the studies of this paper change, and its scales.

The shaft is a mass that moves in the bearing's plane (a Jeffcott rotor whose shaft has no stiffness) under its weight along -y.
The bearing gets its motion and gives the force. Lengths are in x_s = (W/K)^(2/3), frequencies in f_0 = w_0 / (2 pi) with
w_0 = sqrt(K x_s^0.5 / m): with clearance G = c_r / x_s and the number of balls nothing else enters.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ......components.bearings.deep_groove import DeepGrooveBearing
from ......components.bearings.geometry import BallGeometry
from ......components.bearings.hertz import effective_modulus
from ......components.bearings.motion import DISPLACEMENT
from .....run.results import Result
from .....scene.build import unit
from .....scene.scene import Scene
from .... import build_scene
from ..statics import at_rest

MASS, GRAVITY = 20.0, 9.81
WEIGHT = MASS * GRAVITY
BALLS = 9
DAMPING = 2000.0  # N.s/m: a disturbance falls to 1e-9 in 0.4 s
BEARING: dict[str, Any] = {"balls": BALLS, "ball_diameter": 11.1e-3, "pitch_diameter": 53.5e-3}
SIGNALS = ("rotor.displacement_x", "rotor.displacement_y", "rotor.velocity_x", "rotor.velocity_y", "bearing.force_x",
           "bearing.force_y")  # fmt: skip
MOTION = tuple(f"{kind}_{axis}" for kind in ("displacement", "velocity") for axis in "xy")


def bearing(effects: Sequence[str] = (), **parameters: Any) -> DeepGrooveBearing:
    """The bearing of the studies, initialized."""
    model = DeepGrooveBearing(effects, BEARING | parameters)
    model.initialize(0.0)
    return model


GEOMETRY = BallGeometry(**BEARING)
STIFFNESS = GEOMETRY.stiffness(effective_modulus(2.06e11, 0.3, 2.06e11, 0.3))  # N/m^1.5, of the component's steel
LENGTH = (WEIGHT / STIFFNESS) ** (2.0 / 3.0)  # x_s, m
FREQUENCY = math.sqrt(STIFFNESS * math.sqrt(LENGTH) / MASS) / (2.0 * math.pi)  # f_0, Hz
BALL_PASS, CAGE = (GEOMETRY.defect_frequencies(1.0)[n] for n in ("outer", "cage"))  # per turn of the shaft


def diametral(clearance: float) -> float:
    """Diametral clearance in m of a radial one in x_s; none at all is put as 1e-15 m."""
    return 2.0 * LENGTH * clearance or 1e-15


def stiffness(clearance: float, first_ball: float, balls: int = BALLS) -> np.ndarray:
    """The bearing's linearisation in equilibrium, across and along the load, (2, 2) N/m; no tilt, no axial motion.

    clearance: radial, in x_s.  first_ball: angle of a ball from the line of the load, rad.
    """
    given = {"diametral_clearance": diametral(clearance), "first_ball": first_ball - 0.5 * math.pi}
    model = bearing(["linearisation"], balls=balls, **given, **{"linearisation.idle_stiffness": 0.0})
    rest = at_rest(model, np.array([0.0, -WEIGHT, 0.0, 0.0, 0.0]), ("z", "tilt_x", "tilt_y")).displacement
    for name, value in zip(DISPLACEMENT, rest, strict=True):
        model.set(name, value)
    model.refresh()
    return np.array([[model[f"linearisation.stiffness[{5 * i + j + 1}]"] for j in (0, 1)] for i in (0, 1)])


def over_a_pitch(clearance: float, balls: int = BALLS, angles: int = 24) -> np.ndarray:
    """Frequencies along and across the load over f_0 at evenly spaced cage angles over the pitch of the balls, (angles, 2)."""
    pitch = 2.0 * math.pi / balls
    K = np.array([stiffness(clearance, pitch * (k + 0.5) / angles, balls) for k in range(angles)])
    return np.sqrt(K[:, (1, 0), (1, 0)] / MASS) / (2.0 * math.pi * FREQUENCY)


def scene(
    stop_time: float,
    step: float,
    turns: float,
    effects: Sequence[str] = (),
    *,
    clearance: float = 0.0,
    damping: float = DAMPING,
    gravity: float = GRAVITY,
    axial: float = 0.0,
    interval: float | None = None,
    parameters: Mapping[str, Any] | None = None,
) -> Scene:
    """The shaft at `turns` per second in the bearing.

    clearance: radial, in x_s.  axial: preload in N, by the axial displacement that it has without other loads.
    """
    given = BEARING | {"diametral_clearance": diametral(clearance)} | dict(parameters or {})
    if axial:
        loads = at_rest(bearing(diametral_clearance=diametral(clearance)), np.array([0.0, 0.0, axial, 0.0, 0.0]))
        given["displacement_z"] = float(loads.displacement[2])
    links = [f"rotor.{n} -> bearing.{n}" for n in (*MOTION, "speed")] + [f"bearing.force_{a} -> rotor.force_{a}" for a in "xy"]
    rotor: dict[str, Any] = {"mass": MASS, "stiffness": 0.0, "damping": damping, "start_speed": 2.0 * math.pi * turns,
                             "gravity.acceleration": gravity}  # fmt: skip
    units = {
        "rotor": unit("JeffcottRotor", effects=["gravity"], **rotor),
        "bearing": unit("DeepGrooveBearing", effects=effects, **given),
    }
    return build_scene(
        units,
        links,
        stop_time=stop_time,
        step=step,
        name="shaft-in-bearing",
        title="Rigid shaft in a deep groove bearing",
        master={"algorithm": "gauss-seidel"},
        record={"signals": list(SIGNALS), **({"interval": interval} if interval else {})},
        analysis={"system": "bearings"},
    )


def acceleration(result: Result, axis: str, damping: float = DAMPING, gravity: float = GRAVITY) -> np.ndarray:
    """Acceleration of the shaft, (n,) m/s2, from the forces on it: the bearing's, the damper's and its weight."""
    force = result[f"bearing.force_{axis}"] - damping * result[f"rotor.velocity_{axis}"]
    return force / MASS - (gravity if axis == "y" else 0.0)
