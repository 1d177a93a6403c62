"""What the contacts give at the patient: force at the tip, slip against load, a built-in limit, a wet wheel."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from .....harness.validation import Evidence, Runs
from .....scene.build import unit
from .....scene.scene import Scene
from .drive import COSINE, FRICTION, GRAVITY, MASS, NORMAL, SINE, WHEEL, side_by_side

RATE = 20.0  # rad/s of both wheels
BEARS = 2.0 * FRICTION * NORMAL  # N, both contacts
TROCAR = 3.0  # N, in motion: the worst of a 5 mm shaft
UPWARDS = 0.5 * math.pi  # rad
LOADS = (1.0, 3.0, 5.0, 8.0)  # N
SHARES = np.round(np.arange(0.95, 1.0501, 0.01), 3)  # of the expected force at the tip
OVER = {"below": 0.99, "above": 1.01}  # of what both contacts bear
WET, WORST_TROCAR = 0.15, 8.0  # 1; N
TURNING = {"first_rate": RATE, "second_rate": RATE}
TIP = BEARS * COSINE - TROCAR - MASS * GRAVITY  # N


def scenes() -> dict[str, Scene]:
    """Many sleeves side by side, each moved by two wheels."""
    level = {"trocar_friction.level": 0.0, "gravity.inclination": 0.0}
    units = {f"load_{i}": _wheels({**TURNING, **level, "external_force": -F}) for i, F in enumerate(LOADS)}
    raised = {**TURNING, "trocar_friction.level": TROCAR, "trocar_friction.static_ratio": 1.0, "gravity.inclination": UPWARDS}
    units |= {f"tip_{i}": _wheels({**raised, "external_force": -s * TIP}) for i, s in enumerate(SHARES)}
    units |= {
        f"over_{n}": _wheels({**level, "exact_slip.static_ratio": 1.0, "external_force": s * BEARS}) for n, s in OVER.items()
    }
    units["wet"] = _wheels({**TURNING, "friction": WET, "trocar_friction.level": WORST_TROCAR, "gravity.inclination": 0.0})
    return {"sleeves": side_by_side(units, 1.0, ["feed", "feed_rate"])}


def measure(runs: Runs) -> Evidence:
    """Speed of every sleeve in the second half of its run, and which of them move at all."""
    result = runs["sleeves"]
    rolled = WHEEL * RATE * COSINE  # m/s, as the wheels' encoders tell
    late = result.time >= 0.5
    rates = {u: float(np.polyfit(result.time[late], result[f"{u}.feed"][late], 1)[0]) for u in result.scene.units}
    lost = np.array([1.0 - rates[f"load_{i}"] / rolled for i in range(len(LOADS))])
    moved = [s for i, s in enumerate(SHARES) if rates[f"tip_{i}"] > 1e-4 * rolled]
    measured = {f"lost.{F:g}": 100.0 * lost[i] for i, F in enumerate(LOADS)}
    measured |= {f"metre.{F:g}": float(1e3 * lost[i] / (1.0 - lost[i]) / per_metre(F)) for i, F in enumerate(LOADS)}
    measured |= {
        "tip.force": float(max(moved, default=math.nan)) * TIP,
        "wet.rate": 1e3 * rates["wet"],
        **{f"over.{n}": 1e3 * rates[f"over_{n}"] for n in OVER},
        "wet.bears": 2.0 * WET * NORMAL,
    }
    f = np.linspace(0.0, 0.86, 200) * BEARS
    drawn = {
        "load": f,
        "closed.lost": [100.0 * share_lost(F) for F in f],
        "closed.slip": [per_metre(F) for F in f],
        "slip": 1e3 * lost / (1.0 - lost),
        "tip": TIP,
    }
    return Evidence(measured, data=drawn)


def share_lost(force: float) -> float:
    """Share of the wheels' speed that slip across takes at a load in N: sin a / cos a f / sqrt(1 - f²), f = F / (2 mu N)."""
    f = force / BEARS
    return SINE / COSINE * f / math.sqrt(1.0 - f * f)


def per_metre(force: float) -> float:
    """Slip for a metre of travel of the sleeve, mm."""
    return 1e3 * share_lost(force) / (1.0 - share_lost(force))


def _wheels(parameters: Mapping[str, Any]) -> dict[str, Any]:
    return unit("FrictionWheels", effects=["exact_slip", "trocar_friction", "gravity"], **parameters)
