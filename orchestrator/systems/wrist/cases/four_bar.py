"""The planar four-bar linkage against closed forms: extremes, toggle, change points, closure of the loop, virtual work."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ....harness.validation import Evidence, Runs
from ....run.results import Result
from ....scene.build import unit
from ....scene.scene import Scene
from ... import build_scene

CRANK_ROCKER = {"crank": 0.020, "coupler": 0.050, "rocker": 0.040, "ground": 0.055}  # m
ROCKER_DRIVES = {"crank": 0.040, "coupler": 0.050, "rocker": 0.020, "ground": 0.055}
EQUAL_PAIRS = {"crank": 0.020, "coupler": 0.050, "rocker": 0.020, "ground": 0.050, "change_point": "through"}
TURN = 2.0 * math.pi
FLYWHEEL, LOAD, DAMPING = 0.1, 0.5, 0.01  # kg.m2 on the crank, N.m at the rocker, N.m.s/rad a pin
DEGREES = 180.0 / math.pi
SIGNALS = ("crank.angle", "crank.rate", "crank.mechanical_energy", "bar.output_angle", "bar.output_rate", "bar.input_torque",
           "bar.ratio", "bar.transmission_angle")  # fmt: skip


TOGGLE = "driven by its rocker"  # the run that fails on purpose


def measure(runs: Runs) -> Evidence:
    """A flywheel turns the crank of each linkage; one run fails on purpose, where its linkage comes to the toggle."""
    turning, loaded, damped, parallel, crossed, stopped = runs.values()
    angle, rocker = turning["crank.angle"], turning["bar.output_angle"]
    tip = np.hypot(turning["bar.coupler_point.x"] - CRANK_ROCKER["ground"], turning["bar.coupler_point.y"])
    transmission = DEGREES * turning["bar.transmission_angle"]
    taken, given = loaded["bar.input_torque"] * loaded["crank.rate"], LOAD * loaded["bar.output_rate"]
    work = LOAD * (loaded["bar.output_angle"] - loaded["bar.output_angle"][0])
    lost = loaded["crank.mechanical_energy"][0] - loaded["crank.mechanical_energy"]
    heat = _integral(damped, damped["bar.pin_damping.dissipation"])
    slowed = damped["crank.mechanical_energy"][0] - damped["crank.mechanical_energy"][-1]
    half = crossed["crank.angle"] / 2.0
    apart = np.abs(np.sin(2.0 * half)) > 0.1
    quotient = np.tan(crossed["bar.output_angle"] / 2.0)[apart] / np.tan(half)[apart]
    measured = {
        "rocker.low": 180.0 - DEGREES * float(rocker.max()),
        "rocker.high": 180.0 - DEGREES * float(rocker.min()),
        "transmission.low": float(transmission.min()),
        "transmission.high": float(transmission.max()),
        "closure.equation": float(np.abs(freudenstein(angle, rocker)).max()),
        "closure.length": float(np.abs(tip / CRANK_ROCKER["rocker"] - 1.0).max()),
        "ratio.turn": _integral(turning, turning["bar.output_rate"]),
        "toggle": DEGREES * float(stopped["crank.angle"][-1]) if "toggle" in stopped.message else math.nan,
        "work.rate": float(np.abs(taken - given).max() / np.abs(given).max()),
        "work.energy": float(np.abs(lost - work).max() / np.abs(work).max()),
        "work.pins": heat / slowed,
        "parallelogram": float(np.abs(parallel["bar.output_angle"] - parallel["crank.angle"]).max()),
        "antiparallelogram.low": float(quotient.min()),
        "antiparallelogram.high": float(quotient.max()),
    }
    return Evidence(measured, data={"message": stopped.message})


def freudenstein(crank: np.ndarray, rocker: np.ndarray) -> np.ndarray:
    """K1 cos psi - K2 cos phi + K3 - cos(phi - psi) of the crank-rocker; 0 where the loop closes."""
    a, b, c, d = CRANK_ROCKER.values()
    k3 = (a * a - b * b + c * c + d * d) / (2.0 * a * c)
    return d / a * np.cos(rocker) - d / c * np.cos(crank) + k3 - np.cos(crank - rocker)


def scenes() -> dict[str, Scene]:
    """By name: the crank-rocker free, loaded, with damped pins; parallelogram; antiparallelogram; driven by its rocker."""
    end_of_coupler = {"coupler_point": {"along": CRANK_ROCKER["coupler"], "across": 0.0}}
    return {
        "crank-rocker": _scene(CRANK_ROCKER | end_of_coupler, ("coupler_point",), 1.0, TURN),
        "crank-rocker, loaded": _scene(CRANK_ROCKER | {"load_torque": LOAD}, (), 1.0, TURN),
        "crank-rocker, damped": _scene(CRANK_ROCKER | {"pin_damping": {"coefficient": DAMPING}}, ("pin_damping",), 1.0, TURN),
        "parallelogram": _scene(EQUAL_PAIRS, (), 2.0, TURN),
        "antiparallelogram": _scene(EQUAL_PAIRS | {"assembly": "crossed"}, (), 2.0, TURN),
        TOGGLE: _scene(ROCKER_DRIVES, (), 1.0, 1.0, 1.0),
    }


def _scene(parameters: dict[str, Any], effects: tuple[str, ...], stop: float, rate: float, start: float = 0.0) -> Scene:
    own = {"coupler_point": ("bar.coupler_point.x", "bar.coupler_point.y"), "pin_damping": ("bar.pin_damping.dissipation",)}
    return build_scene(
        {
            "crank": unit("PlanarLink", effects=["pinned"], inertia=FLYWHEEL, centre=0.0, start_angle=start, start_rate=rate),
            "bar": unit("FourBar", effects=effects, **parameters),
        },
        [
            "crank.angle -> bar.input_angle",
            "crank.rate -> bar.input_rate",
            {"source": "bar.input_torque", "target": "crank.base_torque", "factor": -1.0},
        ],
        stop_time=stop,
        step=1e-3,
        name="four-bar",
        title="Four-bar linkage turned by a flywheel",
        master={"extrapolation": 1},
        record={"signals": [*SIGNALS, *(n for e in effects for n in own[e])]},
        analysis={"system": "wrist"},
    )


def _integral(result: Result, values: np.ndarray) -> float:
    """Integral over the run by trapezoids."""
    return float(np.sum(0.5 * (values[1:] + values[:-1]) * np.diff(result.time)))
