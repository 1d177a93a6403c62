"""Creep of rolling wheels under load, heat of the motors, and the seal's breakaway along and around the sleeve."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from ......components.drives.servo_motor import Heating
from .....harness.validation import Evidence, Runs
from .....run.results import Result
from .....scene.build import unit
from .....scene.scene import Scene
from .... import build_scene
from .drive import CONSTANT, FRICTION, GEAR, NORMAL, RESISTANCE, SLEEVE, VOLTAGE, WHEEL, side_by_side

BEARS = 2.0 * FRICTION * NORMAL  # N, both contacts
FULL = 0.05  # creepage of full slip, default
RATES, SHARES = (2.0, 20.0), (0.25, 0.75)  # rad/s of the wheels; of what both contacts bear
POINTS = 3.0  # power of the law of points of contact
SEAL, SEAL_STATIC, NEAR = 2.0, 2.6, 0.02  # N; share by which a load is below or above
SETTLES = 0.02  # s, damping over stiffness of the seal: a load put on at once does not swing
WINDING = 155.0 + 273.15  # K, class F of insulation
HOLDS = 600.0  # s
LAW = {"carter": 2.0, "points": POINTS}


def scenes() -> dict[str, Scene]:
    """Sleeves on rolling wheels, sleeves in a seal, motors that stand under voltage."""
    rolling = {
        f"{law}_{i}_{j}": unit(
            "FrictionWheels",
            effects=["rolling_slip"],
            angle=0.0,
            first_rate=rate,
            second_rate=rate,
            external_force=-share * BEARS,
            rolling_slip={"power": power},
        )
        for law, power in LAW.items()
        for i, rate in enumerate(RATES)
        for j, share in enumerate(SHARES)
    }
    sealed = {
        f"{way}_{name}": unit(
            "FrictionWheels",
            effects=["exact_slip", "trocar_friction"],
            normal_force=1e-9,
            trocar_friction={"damping_time": SETTLES},
            **dict[str, Any]({f"external_{kind}": share * SEAL_STATIC * arm}),
        )
        for way, kind, arm in (("along", "force", 1.0), ("around", "torque", SLEEVE))
        for name, share in (("below", 1.0 - NEAR), ("above", 1.0 + NEAR))
    }
    motors = {"holds": _motor(voltage=held_current() * RESISTANCE), "stalled": _motor(voltage=VOLTAGE)}
    record = {"signals": [f"{name}.heating.winding_temperature" for name in motors]}
    return {
        "rolling": side_by_side(rolling, 3.0, ["feed", "first_slip_axial"]),
        "sealed": side_by_side(sealed, 0.5, ["feed", "rotation"]),
        "motors": build_scene(motors, stop_time=HOLDS, step=0.1, name="friction_drive", record=record),
    }


def measure(runs: Runs) -> Evidence:
    """Creepages over their laws and over each other, loads at which the seal gives way, temperatures."""
    measured: dict[str, float] = {}
    rolling, drawn = runs["rolling"], {}
    for law, power in LAW.items():
        for j, share in enumerate(SHARES):
            slow, quick = (_creepage(rolling, f"{law}_{i}_{j}", rate) for i, rate in enumerate(RATES))
            measured[f"{law}.{j}"] = quick / creepage(share, power)
            measured[f"{law}.speed.{j}"] = slow / quick
        shares = np.linspace(0.0, 0.99, 100)
        drawn[law] = np.array([100.0 * creepage(float(f), power) for f in shares])
    sealed = runs["sealed"]
    for way, signal, unit_of in (("along", "feed", 1e3), ("around", "rotation", 1e3 * SLEEVE)):
        for name in ("below", "above"):
            measured[f"seal.{way}.{name}"] = unit_of * abs(float(sealed[f"{way}_{name}.{signal}"][-1]))
    motors = runs["motors"]
    ambient = Heating.ambient.start
    warm = motors["holds.heating.winding_temperature"]
    measured["holds.rise"] = float(warm[-1] - ambient)
    measured["holds.share"] = measured["holds.rise"] / heated(held_current() * RESISTANCE, HOLDS)
    hot = motors["stalled.heating.winding_temperature"]
    k = int(np.argmax(hot >= WINDING))
    measured["stalled.time"] = float(np.interp(WINDING, hot[k - 1 : k + 1], motors.time[k - 1 : k + 1]))
    measured["stalled.share"] = measured["stalled.time"] / time_to(WINDING - ambient, VOLTAGE)
    return Evidence(measured, data={"load": 100.0 * np.linspace(0.0, 0.99, 100), "laws": drawn})


def creepage(share: float, power: float) -> float:
    """Slip over speed at a share of the friction: of full slip 1 - (1 - share)^(1 / power)."""
    return FULL * (1.0 - (1.0 - share) ** (1.0 / power))


def held_current() -> float:
    """Current, A, with which a motor holds half of what both contacts bear, without losses of the gear."""
    return 0.5 * BEARS * WHEEL / (GEAR * CONSTANT)


def heated(voltage: float, seconds: float) -> float:
    """Rise of the winding, K, of a motor that stands, by SciPy."""
    return float(_rise(voltage, seconds).y[0, -1])


def time_to(rise: float, voltage: float) -> float:
    """When the winding of a motor that stands has risen so far, s, by SciPy."""

    def reached(t: float, x: np.ndarray) -> float:
        return float(x[0]) - rise

    reached.terminal = True  # type: ignore[attr-defined]
    return float(_rise(voltage, HOLDS, reached).t[-1])


def _rise(voltage: float, seconds: float, event: Any = None) -> Any:
    heat = {n: getattr(Heating, n).start for n in ("coefficient", "winding_capacity", "housing_capacity")}
    passing, leaving = Heating.winding_to_housing.start, Heating.housing_to_ambient.start

    def rates(t: float, x: np.ndarray) -> list[float]:
        power, passed = voltage**2 / (RESISTANCE * (1.0 + heat["coefficient"] * x[0])), (x[0] - x[1]) / passing
        return [(power - passed) / heat["winding_capacity"], (passed - x[1] / leaving) / heat["housing_capacity"]]

    return solve_ivp(rates, (0.0, seconds), [0.0, 0.0], events=event, rtol=1e-10, atol=1e-10)


def _creepage(result: Result, name: str, rate: float) -> float:
    return -float(result[f"{name}.first_slip_axial"][-1]) / (WHEEL * rate)


def _motor(**parameters: Any) -> Mapping[str, Any]:
    """A motor that cannot turn."""
    return unit("ServoMotor", effects=["heating"], wheel_inertia=1e9, substep=0.05, **parameters)
