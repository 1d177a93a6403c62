"""Steps of feed and rotation: the linear part against its closed form, both axes at once against each alone."""

from __future__ import annotations

import numpy as np

from .....harness.validation import Evidence, Runs
from .....scene.scene import Scene
from .drive import CONSTANT, FULL, GEAR, RESISTANCE, ROLLERS, controlled, wheel_inertia

SMALL = {"feed": 2e-3, "rotation": np.radians(18.0)}  # m, rad: no limit is reached
LARGE = {"feed": 0.01, "rotation": np.radians(90.0)}
GAIN, RATE_GAIN, PERIOD = 20.0, 0.4, 1e-3  # 1/s, V.s/rad, s
BACK_EMF = GEAR * CONSTANT  # V.s/rad at the wheel
LINEAR = {"rate_integral_gain": 0.0, "feed_forward": BACK_EMF}
STOP = 0.5  # s
BAND = 0.05
ALONE = {"both": ("feed", "rotation"), "feed": ("feed",), "rotation": ("rotation",)}


def scenes() -> dict[tuple[str, str], Scene]:
    """Small steps of the linear drive and of both layouts, 10 mm and 90 degrees of the whole one; both ways and each alone."""
    without_friction = {"trocar_friction.level": 0.0, "shaft_friction.level": 0.0}
    steps = {}
    for name, ways in ALONE.items():
        small, large = ({f"set_{way}": sizes[way] for way in ways} for sizes in (SMALL, LARGE))
        steps["linear", name] = controlled(STOP, ROLLERS, (), {}, LINEAR | small)
        steps["skewed", name] = controlled(STOP, "skewed", FULL, without_friction, LINEAR | small)
        steps["whole", name] = controlled(STOP, ROLLERS, FULL, {}, large)
    return steps


def measure(runs: Runs) -> Evidence:
    """How the axes disturb one another, how near the linear drive is to the design model, how fast the whole one is."""
    measured: dict[str, float] = {}
    for way in SMALL:
        for kind in ("linear", "skewed"):
            alone, both = runs[kind, way][f"drive.{way}"], runs[kind, "both"][f"drive.{way}"]
            measured[f"coupling.{kind}.{way}"] = float(np.abs(both - alone).max() / SMALL[way])
        result = runs["linear", way]
        measured[f"linear.{way}"] = float(np.abs(result[f"drive.{way}"] / SMALL[way] - closed_form(result.time, way)).max())
        whole = runs["whole", way]
        limit = 4.0 * (time_constant(way) + 1.0 / GAIN)
        measured[f"response.{way}"] = response_time(whole.time, whole[f"drive.{way}"] / LARGE[way]) / limit
    result = runs["whole", "both"]
    measured["response.both"] = max(response_time(result.time, result[f"drive.{w}"] / LARGE[w]) for w in LARGE) / limit
    t = runs["linear", "feed"].time
    return Evidence(measured, data={"t": t, **{f"closed.{way}": closed_form(t, way) for way in SMALL}})


def time_constant(way: str) -> float:
    """Time constant of a wheel under its rate loop, s."""
    return wheel_inertia(way) * RESISTANCE / (BACK_EMF * (BACK_EMF + RATE_GAIN))


def closed_form(t: np.ndarray, way: str) -> np.ndarray:
    """Step response of the design model: T z'' + z' + K z = K, half a period of the sampling late."""
    T, late = time_constant(way), np.maximum(np.asarray(t) - 0.5 * PERIOD, 0.0)
    root = np.sqrt(complex(1.0 - 4.0 * GAIN * T))
    fast, slow = (-1.0 - root) / (2.0 * T), (-1.0 + root) / (2.0 * T)
    return (1.0 - (fast * np.exp(slow * late) - slow * np.exp(fast * late)) / (fast - slow)).real


def response_time(t: np.ndarray, share: np.ndarray) -> float:
    """Time from which on a response stays within 5 % of its step, s; NaN if it does not."""
    outside = np.flatnonzero(np.abs(share - 1.0) > BAND)
    return float(t[outside[-1] + 1]) if outside.size and outside[-1] + 1 < t.size else float("nan")
