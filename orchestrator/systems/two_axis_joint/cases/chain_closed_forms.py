"""The two-link chain and the single link against closed forms: small motion, damping, invariants, periods, dry friction."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from .....components.two_axis_joint.chain import TwoLinkChain
from .....components.two_axis_joint.closed_forms import damped_motion, friction_turning_points, small_motion
from ....harness.analysis.sections import swing_frequency
from ....harness.validation import Evidence, Runs
from ....run.results import Result
from ....scene.build import unit
from ....scene.scene import Scene
from ... import build_scene

ANGLES = ("first_angle", "second_angle")
MOTION = (*ANGLES, "first_rate", "second_rate")
STARTS = tuple(f"start_{n}" for n in MOTION)
SMALL = 1e-5  # rad and rad/s: what is left of the sines' curvature is below 1e-9 of it
ROOT = math.sqrt(7.0)
SHAPES = {
    "equal point masses": ((1.0, math.sqrt(2.0)), (1.0, -math.sqrt(2.0))),
    "equal rods": ((1.0, (2.0 * ROOT - 1.0) / 3.0), (1.0, -(2.0 * ROOT + 1.0) / 3.0)),
}
FREE: dict[str, Any] = {"first_mass": 1.3, "first_length": 0.8, "first_centre": 0.5, "first_inertia": 0.04, "second_mass": 0.6,
                        "second_length": 0.7, "second_centre": 0.4, "second_inertia": 0.03}  # fmt: skip
AMPLITUDES = {"small": 0.1, "quarter": math.pi / 2.0, "high": 3.0}  # rad
FRICTION, MOMENT = 0.8, 9.81  # N.m
OVER = 0.25  # s, over which the propagator of small motion is taken: below half a turn of either mode
DAMPED = {"viscous.first": 0.1, "viscous.second": 0.05}
LARGE = (0.1, -0.2, 0.3, 0.1)  # start of the damped motions that are shown, in units of SMALL


def measure(runs: Runs) -> Evidence:
    """One run for each closed form; what needs no connection shares one."""
    measured: dict[str, float] = {}
    modes = runs["modes of small motion"]
    for k, (preset, mode) in enumerate((p, m) for p in SHAPES for m in (1, 2)):
        angle = modes[f"mode{k + 1}.first_angle"]
        measured[f"frequency.{preset.split()[-1]}.{mode}"] = swing_frequency(modes.time, angle)
    values = propagated(runs["damped, one start each"], "hanging")
    for mode, value in enumerate(sorted(values[values.imag > 0.0], key=lambda v: v.imag), 1):
        measured |= {f"damped.frequency.{mode}": value.imag, f"damped.decay.{mode}": -value.real}
    values = np.sort(propagated(runs["damped, one start each"], "coasting").real)
    measured |= {"coasting.decay.2": -values[0], "coasting.decay.1": -values[1]}
    exact = runs["damped, exact solution"]
    measured |= {f"exact.{n}": float(np.abs(motion_of(exact, n) - solution(n, exact.time)).max()) / SMALL for n in EXACT}
    free = runs["free motion"]
    for name in ("mechanical_energy", "angular_momentum"):
        values = np.asarray(free[f"chain.{name}"])
        measured[f"drift.{name}"] = float(np.abs(values / values[0] - 1.0).max())
    swings = runs["large swings"]
    for name in AMPLITUDES:
        frequency = swing_frequency(swings.time, swings[f"{name}.angle"])
        measured[f"period.{name}"] = math.sqrt(1.5 * 9.81) / frequency  # against small swings of a uniform rod of 1 m
    rubbed = runs["swings with dry friction"]
    turning_points, closed = turns(rubbed), friction_turning_points(1.0, FRICTION, MOMENT)
    measured["turns"] = len(turning_points)
    same = min(len(turning_points), len(closed))
    measured["turn"] = float(np.abs(np.abs(turning_points[:same]) - np.abs(closed[:same])).max())
    measured |= {"rest": rubbed["chain.first_angle"][-1], "rest.rate": abs(rubbed["chain.first_rate"][-1])}
    drawn = {
        f"{n}.{which}": x / SMALL for n in EXACT for which, x in zip(("first", "second"), solution(n, exact.time), strict=True)
    }
    turned = {"closed": np.abs(closed), "turned": np.abs(turning_points)}
    counts = {"closed.count": np.arange(len(closed)), "turned.count": np.arange(len(turning_points))}
    return Evidence(measured, data={"t": exact.time, **drawn, **turned, **counts})


def scenes() -> dict[str, Scene]:
    """Every run by its name."""
    modes = {}
    for k, (preset, shape) in enumerate((p, s) for p, shapes in SHAPES.items() for s in shapes):
        first, second = shape
        start: dict[str, Any] = {"start_first_angle": SMALL * first, "start_second_angle": SMALL * second}
        modes[f"mode{k + 1}"] = unit("TwoLinkChain", preset=preset, **start)
    starts = {}
    for k, name in enumerate(STARTS):
        given: dict[str, Any] = {**DAMPED, name: SMALL}
        starts[f"hanging{k + 1}"] = unit("TwoLinkChain", effects=["gravity", "viscous"], substep=2e-4, **given)
        starts[f"coasting{k + 1}"] = unit("TwoLinkChain", effects=["viscous"], **given)
    large = {name: SMALL * value for name, value in zip(STARTS, LARGE, strict=True)}
    exact = {}
    for name, (effects, damping) in EXACT.items():
        given = {**damping, **large}
        exact[name] = unit("TwoLinkChain", effects=effects, **given)
    moved: dict[str, Any] = dict(zip(STARTS, (0.3, 2.0, 5.0, -7.0), strict=True))
    free = unit("TwoLinkChain", **FREE, **moved, substep=1e-4)
    swings = {n: unit("PlanarLink", effects=["pinned", "gravity"], start_angle=a) for n, a in AMPLITUDES.items()}
    rubbed = unit("TwoLinkChain", effects=["gravity", "stick_friction"], second_mass=0.0, second_inertia=1.0, start_first_angle=1.0,
                  stick_friction={"first_level": FRICTION, "second_level": 0.0})  # fmt: skip
    return {
        "modes of small motion": _scene(modes, 40.0, 0.005, ["first_angle"]),
        "damped, one start each": _scene(starts, OVER, OVER, MOTION),
        "damped, exact solution": _scene(exact, 10.0, 0.02, ANGLES),
        "free motion": _scene({"chain": free}, 20.0, 0.02, [*MOTION, "tip_x", "tip_y", "angular_momentum", "mechanical_energy"]),
        "large swings": _scene(swings, 60.0, 0.002, ["angle", "rate"]),
        "swings with dry friction": _scene({"chain": rubbed}, 12.0, 0.002, MOTION),
    }


def _scene(units: Mapping[str, Any], stop: float, step: float, signals: Sequence[str]) -> Scene:
    record = {"signals": [f"{u}.{s}" for u in units for s in signals]}
    return build_scene(units, stop_time=stop, step=step, name="chain", title="Chain of two links", record=record)


EXACT: dict[str, tuple[list[str], dict[str, float]]] = {
    "proportional": (["gravity", "viscous"], {"viscous.first": 0.3, "viscous.second": 0.3}),
    "strong": (["gravity", "viscous"], {"viscous.first": 6.0, "viscous.second": 6.0}),
    "coasting": (["viscous"], DAMPED),
}


def solution(name: str, t) -> np.ndarray:
    """Exact small motion of one of the damped chains, both angles, rad, (2, n)."""
    effects, parameters = EXACT[name]
    start = SMALL * np.array(LARGE)
    return damped_motion(small_motion(TwoLinkChain(effects, parameters)), start[:2], start[2:], t)[0]


def motion_of(result: Result, unit: str) -> np.ndarray:
    """Both angles of one unit, rad, (2, n)."""
    return np.array([result[f"{unit}.{n}"] for n in ANGLES])


def propagated(result: Result, unit: str) -> np.ndarray:
    """Eigenvalues of small motion, 1/s, (4,): logarithms of those of what four starts become over the run."""
    ends = np.array([[result[f"{unit}{k}.{n}"][-1] for k in range(1, 5)] for n in MOTION]) / SMALL
    return np.log(np.linalg.eigvals(ends).astype(complex)) / OVER


def turns(result: Result) -> np.ndarray:
    """Angles of rest between half swings, rad: the start, then the extreme of every stretch without change of direction."""
    angle, rate = np.asarray(result["chain.first_angle"]), np.sign(result["chain.first_rate"])
    moving = np.flatnonzero(rate)
    ends = np.append(moving[:-1][rate[moving[:-1]] != rate[moving[1:]]], moving[-1])
    last = len(angle) - 1
    return np.array([angle[0], *(max(angle[k], angle[min(k + 1, last)], key=abs) for k in ends[:-1]), angle[-1]])
