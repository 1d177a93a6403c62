"""Operating points of a wind pump with an inertial converter: runs from standstill against a root found elsewhere."""

from __future__ import annotations

import numpy as np

from ....harness.validation import Evidence, Runs
from ....scene.build import unit
from ....scene.scene import Scene
from ... import build_scene

WINDS = (2.0, 2.5, 3.0, 6.0)  # m/s
MEAN_TORQUE = 13.2435  # N.m, of a piston pump of 60 mm and 150 mm stroke at 20 m
SETTLED = 150.0  # s, more than a dozen of the slowest time constants
SIGNALS = ("wind.speed", "turbine.speed", "turbine.power", "turbine.power_coefficient", "converter.speed",
           "converter.turbine_torque", "converter.driving_torque")  # fmt: skip


def scenes() -> dict[str, Scene]:
    """A run for each wind."""
    return {f"{wind:g} m/s": scene(wind) for wind in WINDS}


def measure(runs: Runs) -> Evidence:
    """Speeds, ratio, power coefficient and power balance at the end of a run a wind."""
    measured: dict[str, float] = {}
    for wind, result in zip(WINDS, runs.values(), strict=True):
        turbine, pump = (float(result[f"{unit}.speed"][-1]) for unit in ("turbine", "converter"))
        measured |= {
            f"turbine_speed.{wind:g}": turbine,
            f"pump_speed.{wind:g}": pump,
            f"ratio.{wind:g}": turbine / pump if pump > 0.0 else float("nan"),
            f"cp.{wind:g}": float(result["turbine.power_coefficient"][-1]),
            f"power_ratio.{wind:g}": MEAN_TORQUE * pump / float(result["turbine.power"][-1]),
        }
    span, least = measured["ratio.2"] / measured["ratio.6"], min(measured[f"cp.{v:g}"] for v in WINDS[1:])
    return Evidence(measured, data={**closed_forms(), "span": span, "least": least})


def scene(wind: float) -> Scene:
    """Turbine and converter of the defaults from standstill in a steady wind, under a load that does not pulsate."""
    return build_scene(
        {
            "wind": unit("Wind", mean_speed=wind),
            "turbine": unit("WindTurbine", preset="farm windmill"),
            "converter": unit("AveragedConverter", load_torque=MEAN_TORQUE),
        },
        {"wind.speed": "turbine.wind", "turbine.speed": "converter.turbine_speed", "converter.turbine_torque": "turbine.torque"},
        stop_time=SETTLED,
        step=0.05,
        name="wind-pump-equilibrium",
        title=f"Wind pump with an averaged inertial converter at {wind:g} m/s",
        record={"signals": SIGNALS, "interval": 0.5},
    )


def closed_forms() -> dict[str, np.ndarray]:
    """The closed form, solved for the wind at given turbine speeds."""
    gear, k1, k2, area = 6.0, 0.2 / np.pi, 0.10125 / np.pi, np.pi * 1.5**2
    crank = gear * np.linspace(2.42, 4.2, 400)
    pump = (k1 * crank**2 - MEAN_TORQUE) / (k2 * crank)
    turbine, torque = crank / gear, gear * MEAN_TORQUE * pump / crank
    # rho/2 A R C_0 (v² - w R v / ratio_0) = T1, the larger root
    half = turbine * 1.5 / (2.0 * 2.4)
    wind = half + np.sqrt(half**2 + torque / (0.5 * 1.225 * area * 1.5 * 0.5))
    cp = torque * turbine / (0.5 * 1.225 * area * wind**3)
    return {"wind": wind, "turbine": turbine, "pump": pump, "speeds": turbine / pump, "coefficient": cp}
