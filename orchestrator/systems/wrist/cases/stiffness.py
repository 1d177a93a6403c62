"""Passive stiffness of the wrist in 24 directions against cadaver data."""

from __future__ import annotations

import math

import numpy as np

from ....harness.validation import Evidence, Runs
from ....run.results import Result
from ....scene.build import unit
from ....scene.scene import Scene
from ... import build_scene

DEGREES = 180.0 / math.pi
MOMENT, COUNT = 2.0, 24  # N.m; directions of it, every 15 degrees
SETTLED = 1.5  # s


def scenes() -> dict[str, Scene]:
    """A smooth wrist and one of two rows for each direction of the moment."""
    return {"small angles": scene(()), "two rows": scene(("morphology",))}


def measure(runs: Runs) -> Evidence:
    """The wrists are held until they rest; both kinds must agree. 24 wrists that come to rest are no picture: none is shown."""
    ranges = {name: displacements(result) for name, result in runs.items()}
    way = ranges["small angles"]
    size = np.hypot(*way.T)
    softest = int(np.argmax(size[: COUNT // 2]))  # opposite directions are the same
    values, vectors = np.linalg.eigh(way.T @ way)
    moments = MOMENT * directions()
    compliance, *_ = np.linalg.lstsq(moments, way / DEGREES, rcond=None)
    measured = {
        "orientation": DEGREES * math.atan(abs(vectors[1, 1] / vectors[0, 1])),
        "orientation.sign": -math.copysign(1.0, vectors[0, 1] * vectors[1, 1]),
        "softest.direction": _acute(softest),
        "softest.stiffness": MOMENT / math.sqrt(values[1] / (COUNT / 2)),
        "stiffest.stiffness": MOMENT / math.sqrt(values[0] / (COUNT / 2)),
        "symmetry": compliance[0, 1] / compliance[1, 0],
        "rows": float(np.abs(ranges["two rows"] - way).max()),
    }
    angles = np.radians((-26.6, -26.6 - 4.4, -26.6 + 4.4))
    reach = 1.3 * float(np.abs(way).max())
    orientation = np.array([(-v, v, math.nan) for f in (np.cos, np.sin) for v in reach * f(angles)]).reshape(2, -1)
    drawn = {
        "orientation": {"measured orientation, mean and deviation": tuple(orientation)},
        "small": {"small angles": tuple(np.append(way, way[:1], axis=0).T)},
        "two": {"two rows": tuple(ranges["two rows"].T)},
        "range": 2.0 * size[softest],
    }
    return Evidence(measured, data=drawn)


def directions() -> np.ndarray:
    """Unit vectors of the moments, (24, 2): flexion and radial deviation."""
    angle = 2.0 * math.pi / COUNT * np.arange(COUNT)
    return np.stack((np.cos(angle), np.sin(angle)), axis=1)


def scene(effects: tuple[str, ...]) -> Scene:
    """24 wrists with the preset's stiffness, each with its moment; more damping than theirs brings them to rest sooner."""
    units = {}
    for i, (flexion, deviation) in enumerate((MOMENT * directions()).tolist()):
        parameters = {"tau_flexion": flexion, "tau_deviation": deviation, "proximal_damping": 0.2, "distal_damping": 0.2}
        units[_name(i)] = unit("Wrist", preset="cadaver", effects=effects, **parameters)
    title, signals = (
        "Wrists under moments in 24 directions",
        [f"{wrist}.{n}" for wrist in units for n in ("flexion", "deviation")],
    )
    return build_scene(units, stop_time=SETTLED, step=0.05, name="wrist-stiffness", title=title, record={"signals": signals})


def displacements(result: Result) -> np.ndarray:
    """Flexion and radial deviation at the end, degrees, (24, 2)."""
    return DEGREES * np.array([[float(result[f"{_name(i)}.{n}"][-1]) for n in ("flexion", "deviation")] for i in range(COUNT)])


def _name(direction: int) -> str:
    return f"at_{round(360 / COUNT) * direction}"


def _acute(direction: int) -> float:
    """Angle in degrees between a direction of the moment and the axis of pure flexion and extension."""
    angle = 360.0 / COUNT * direction
    return min(angle % 180.0, 180.0 - angle % 180.0)
