"""Dry friction in a drive: where a controller stands, when it hunts, and the stick-slip of a mass that a spring pulls."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from .....components.core.pulled_mass import IDEAL, LUGRE, SAMPLE, pulled
from ....harness.validation import Evidence, Runs
from ....run.results import Result
from ....scene.build import unit
from ....scene.scene import Scene
from ... import build_scene
from ..records import starts

TARGET, RADIUS = 2e-4, 0.01  # m
GAINS: dict[str, Any] = {"layout": "orthogonal", "feedback": "wheels", "set_feed": TARGET, "rate_integral_gain": 0.0}
KINDS: Mapping[str, tuple[float, float]] = {  # integral gain of the way, 1/s2; static over kinetic friction
    "seeking": (400.0, 1.5),
    "without_drop": (400.0, 1.0),
    "standing": (0.0, 1.5),
}
ERRORS = {"seeking": "integral, friction falls", "without_drop": "integral, no drop", "standing": "no integral"}
LEVEL = 0.01  # N.m at the wheel
SETTLED = 5.0  # s, from when on the cycle is measured
END = 16.0  # s, of the pulled masses
MOVING = 0.01  # m/s, from when on the mass counts as slipping


def slips(rows: np.ndarray, above: float = MOVING) -> np.ndarray:
    """Instants at which the velocity rises above a level, s, straight between the samples."""
    time, _, velocity = rows.T
    before = np.flatnonzero((velocity[:-1] <= above) & (velocity[1:] > above))
    share = (above - velocity[before]) / (velocity[before + 1] - velocity[before])
    return time[before] + share * SAMPLE


def scene(stop: float = 14.0) -> Scene:
    """Three motors, each under a controller of its own: one that seeks, one without a drop of friction, one that stands."""
    units: dict[str, Any] = {}
    links, order = [], []
    for name, (gain, ratio) in KINDS.items():
        friction = {"level": LEVEL, "static_ratio": ratio, "gear_loss": 0.0}
        units[name] = unit("ServoMotor", effects=["shaft_friction"], shaft_friction=friction)
        units[f"{name}_controller"] = unit("ServoController", **GAINS, feed_integral_gain=gain)
        links += [f"{name}.{what} -> {name}_controller.first_{what}" for what in ("angle", "rate")]
        links.append(f"{name}_controller.first_voltage -> {name}.voltage")
        order += [name, f"{name}_controller"]
    of_drive = (".angle", ".shaft_friction.stuck", "_controller.feed_error", "_controller.first_voltage")
    record = {"signals": [f"{name}{signal}" for name in KINDS for signal in of_drive]}
    master = {"extrapolation": 0, "order": order}
    return build_scene(units, links, stop_time=stop, step=1e-3, name="hunting", master=master, record=record)


def scenes() -> dict[str, Scene]:
    """The three drives side by side."""
    return {"drives": scene()}


def standing_errors(result: Result, name: str) -> tuple[np.ndarray, np.ndarray]:
    """(times at which the shaft breaks loose, errors of the feed at which it stood, m), the start left out."""
    left = np.flatnonzero(np.diff(result[f"{name}.shaft_friction.stuck"]) < 0.0)[1:]
    return result.time[left], TARGET - RADIUS * result[f"{name}.angle"][left]


def drives(runs: Runs) -> Evidence:
    """Where three drives stand, and when they break loose."""
    result = runs["drives"]
    times, errors = standing_errors(result, "seeking")
    late = times > SETTLED
    measured = {
        "hunting.period": 2.0 * float(np.mean(np.diff(times[late]))),
        "hunting.amplitude": 1e6 * float(np.mean(np.abs(errors[late]))),
        "hunting.sides": float(np.mean(np.sign(errors[late][1:]) != np.sign(errors[late][:-1]))),
        "standing.starts": float(starts(result["standing.shaft_friction.stuck"])),
        "standing.error": 1e6 * (TARGET - RADIUS * float(result["standing.angle"][-1])),
    }
    _, falling = standing_errors(result, "without_drop")
    measured |= {f"falling.{k + 1}": float(abs(falling[k + 1] / falling[k])) for k in range(min(2, falling.size - 1))}
    return Evidence(
        measured, data={"t": result.time, "errors": {ERRORS[n]: 1e6 * (TARGET - RADIUS * result[f"{n}.angle"]) for n in KINDS}}
    )


def masses(runs: Runs) -> Evidence:
    """Nothing is coupled: first slip, period and greatest velocity of a mass that a spring pulls."""
    measured: dict[str, float] = {}
    bristles, ideal = pulled(LUGRE, END), pulled(IDEAL, END)
    for name, rows, above in (("bristles", bristles, MOVING), ("ideal", ideal, 0.0)):
        begins = slips(rows, above)
        measured |= {f"{name}.first": begins[0], f"{name}.period": begins[1] - begins[0], f"{name}.fastest": rows[:, 2].max()}
    ends = ideal[1:][(ideal[1:, 2] == 0.0) & (ideal[:-1, 2] > 0.0), 0]
    measured["ideal.slip"] = ends[0] - measured["ideal.first"]
    velocities = {text: (rows[:, 0], rows[:, 2]) for text, rows in (("bristles (LuGre)", bristles), ("rigid contact", ideal))}
    return Evidence(measured, data={"velocities": velocities})
