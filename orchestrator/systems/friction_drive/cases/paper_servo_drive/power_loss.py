"""Loss of power: what the sleeve bears without voltage before it gives way; the windings are short-circuited and brake it."""

from __future__ import annotations

from typing import Any

import numpy as np

from .....harness.validation import Evidence, Runs
from .....scene.build import unit
from .....scene.scene import Scene
from .drive import CONSTANT, COSINE, FRICTION, FULL, GEAR, NORMAL, RESISTANCE, ROLLERS, SHAFT, SHAFT_STATIC, WHEEL, side_by_side

SEAL, SEAL_STATIC = 2.0, 2.6  # N
GRIP = 2.0 * FRICTION * NORMAL * COSINE  # N, what wheels with free rollers bear along the axis
TIGHT = 0.2  # N.m, shafts that a load cannot turn back
NEAR = 0.02  # share by which a load is below or above a limit
STOP, LAST = 5.0, 0.5  # s: of the run, and at its end; the seal gives way against the motors' brake in 0.3 s
LOADS = np.round(np.arange(3.0, 5.41, 0.1), 3)  # N
STANDS = 1e-3  # mm/s
EVEN = {"shaft_friction.static_ratio": 1.0, "exact_slip.static_ratio": 1.0, "trocar_friction.static_ratio": 1.0}


def limits() -> dict[str, tuple[float, dict[str, float]]]:
    """What gives way first -> (load at which it does, N; parameters of such a drive)."""
    return {
        "shafts": (backdrive(SHAFT), {"trocar_friction.level": 0.0}),
        "seal": (backdrive(SHAFT) + SEAL, {}),
        "grip": (GRIP, {"trocar_friction.level": 0.0, "shaft_friction.level": TIGHT}),
    }


def scenes() -> dict[str, Scene]:
    """Drives without voltage under loads about each limit, with friction that does not fall; then with friction that does."""
    units = {
        f"{name}_{way}": _drive({**EVEN, **values, "external_force": -share * limit})
        for name, (limit, values) in limits().items()
        for way, share in (("below", 1.0 - NEAR), ("above", 1.0 + NEAR))
    }
    units |= {f"load_{i}": _drive({"external_force": -F}) for i, F in enumerate(LOADS)}
    return {"drives": side_by_side(units, STOP, ["feed"])}


def measure(runs: Runs) -> Evidence:
    """Which drives still move at the end."""
    result = runs["drives"]
    late = result.time >= STOP - LAST
    speed = {u: 1e3 * float(np.ptp(result[f"{u}.feed"][late])) / LAST for u in result.scene.units}
    held = [F for i, F in enumerate(LOADS) if speed[f"load_{i}"] < STANDS]
    limit = float(max(held, default=np.nan))
    measured = {f"{name}.{way}": speed[f"{name}_{way}"] for name in limits() for way in ("below", "above")}
    measured |= {"sudden.limit": limit, "sudden.share": limit / (backdrive(SHAFT_STATIC) + SEAL_STATIC)}
    drawn = {
        "loads": LOADS,
        "speeds": [speed[f"load_{i}"] for i in range(LOADS.size)],
        "marks": ((backdrive(SHAFT) + SEAL, "all in motion"), (backdrive(SHAFT_STATIC) + SEAL_STATIC, "all at rest")),
        "brake": brake(),
        "creep": 1e3 / brake(),
    }
    return Evidence(measured, data=drawn)


def backdrive(torque: float) -> float:
    """Force along the sleeve that turns both shafts back, N; free rollers, friction at a wheel in N.m.

    Without current the motors pass no torque on, so that the gear's share adds nothing.
    """
    return 2.0 * torque * COSINE / WHEEL


def brake() -> float:
    """Force per speed of the sleeve against two short-circuited motors, N.s/m, without losses of the gear."""
    return 2.0 * (GEAR * CONSTANT) ** 2 / RESISTANCE * (COSINE / WHEEL) ** 2


def _drive(parameters: dict[str, Any]) -> dict[str, Any]:
    return unit("FrictionDrive", effects=FULL, layout=ROLLERS, **parameters)
