"""Scenes of pipe robots side by side, and what cases measure in them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...run.results import Result
from ...scene.build import unit
from ...scene.scene import Scene
from .. import build_scene

TURN = 2.0 * math.pi
GRAVITY = 9.81  # m/s², of the components
BODY, INNER, STIFFNESS, DAMPING = 1.0, 0.5, 2000.0, 5.0  # kg, kg, N/m, N.s/m, of the defaults
FORWARD, BACKWARD = 2.0, 8.0  # N
FREE = math.sqrt(STIFFNESS * (1.0 / BODY + 1.0 / INNER))  # rad/s, inner mass against the free body
STUCK = math.sqrt(STIFFNESS / INNER)
FORCE = ("harmonic_force", "tow", "route")  # one set of effects for all robots that a force shakes


def side_by_side(case: str, title: str, robots: Mapping[str, Mapping[str, Any]], step: float, steps: int, *,
                 effects: Sequence[str] | Mapping[str, Sequence[str]] = FORCE, signals: Sequence[str] = ("position",),
                 interval: float | None = None) -> Scene:  # fmt: skip
    """Robots that know nothing of each other. robots: unit -> parameters.  effects: of all, or a unit.  signals: of each."""
    units = {
        name: unit("PipeRobot", effects=effects[name] if isinstance(effects, Mapping) else effects, **given)
        for name, given in robots.items()
    }
    record = {"signals": [f"{name}.{s}" for name in units for s in signals], "interval": interval}
    return build_scene(units, stop_time=steps * step, step=step, name=case, title=title, record=record,
                       analysis={"system": "pipe_robot"})  # fmt: skip


def shaken(amplitude: float = 20.0, frequency: float = 60.0, **more: float) -> dict[str, float]:
    """Parameters of a robot with a harmonic force; further ones by name, with __ for the dot."""
    return {"harmonic_force.amplitude": amplitude, "harmonic_force.frequency": frequency,
            **{n.replace("__", "."): v for n, v in more.items()}}  # fmt: skip


def last_speed(result: Result, unit: str, samples: int = 1) -> float:
    """Way over time of the last `samples` intervals, m/s: the mean speed where they are whole periods."""
    x, t = result[f"{unit}.position"], result.time
    return float((x[-1] - x[-1 - samples]) / (t[-1] - t[-1 - samples]))


def component_at(time: np.ndarray, values: np.ndarray, frequency: float) -> complex:
    """c of Re(c exp(i w t)) in values (n,) at a frequency w in rad/s; even samples of whole periods, the end left out."""
    return complex(2.0 * np.mean(values * np.exp(-1j * frequency * time)))
