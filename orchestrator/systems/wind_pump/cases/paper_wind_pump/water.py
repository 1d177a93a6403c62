"""Water of a year by a wind distribution: the converter against the fixed ratio that suits the same site best.

The units run to their operating points in winds side by side; what they give is weighted with a Weibull distribution of the
wind. Energies are shares of the ideal: the turbine's largest power coefficient in every wind.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.optimize import minimize_scalar
from scipy.special import gamma

from .....harness.validation import Evidence, Runs
from .....run.results import Result
from .....scene.build import unit
from .....scene.scene import Scene
from .... import build_scene
from ..start import FREE, scene, turning_point
from .plant import AREA, DENSITY, RADIUS

BEST = 0.3  # largest power coefficient of the farm windmill
LOAD = 13.2435  # N.m, mean torque of the pump
LIFT = 1000.0 * 9.81 * 20.0  # Pa, of the water
YEAR = 365.25 * 86400.0  # s
RATIOS = (0.7, 1.0, 1.4)  # of the fixed gear, pump over turbine
SITES = (3.0, 4.0, 5.0)  # m/s, mean wind
SHAPES = (1.5, 2.0, 2.5, 3.0)  # of the Weibull distribution; 2 is Rayleigh's
CAP = 2.0  # times the mean wind, above which the power stays what it is there
CONVERTER_WINDS = np.concatenate((np.linspace(1.52, 3.0, 16), np.linspace(3.2, 10.0, 18)))  # m/s
OVER = np.geomspace(1.003, 5.5, 24)  # wind over the wind that balances the mean torque
Share = Callable[[np.ndarray], np.ndarray]


def scenes() -> dict[Any, Scene]:
    """Sets side by side in many winds, of the converter and of each fixed ratio; stop and start of a fixed ratio."""
    adapting = side_by_side(CONVERTER_WINDS, "AveragedConverter", {}, FREE, 0.05)
    fixed = {
        ratio: side_by_side(OVER * _balanced(ratio), "FixedTransmission", {"gear_ratio": ratio}, 0.8 * FREE, 0.02)
        for ratio in RATIOS
    }
    return {"converter": adapting, **fixed, "stop": scene("fixed", "stop"), "start": scene("fixed", "start")}


def measure(runs: Runs) -> Evidence:
    """Power coefficients over the wind by runs of both transmissions, and the water of a year at several sites."""
    winds, over = CONVERTER_WINDS, OVER
    converter = coefficients(runs["converter"], winds.size)
    fixed = {ratio: coefficients(runs[ratio], over.size) for ratio in RATIOS}
    u = over**-2.0
    measured = {"curve": max(float(np.abs(c / BEST - 4.0 * u * (1.0 - u)).max()) for c in fixed.values())}
    stop, start = (turning_point(runs[what], what) for what in ("stop", "start"))
    measured["start"] = start / stop
    running = PchipInterpolator(np.concatenate(([1.0], over)), np.concatenate(([0.0], fixed[1.0])), extrapolate=False)

    def of_fixed(balanced: float, first: float) -> Share:
        return lambda v: np.where(v > first * balanced, np.nan_to_num(running(v / balanced)), 0.0)

    adapted = PchipInterpolator(winds, converter, extrapolate=False)

    def of_converter(v: np.ndarray) -> np.ndarray:
        return np.where(v > winds[-1], converter[-1], np.nan_to_num(adapted(v)))

    for shape in SHAPES:
        best, share = _best(lambda b: of_fixed(b, 1.0), 1.0, shape, None)
        late, late_share = _best(lambda b: of_fixed(b, start / stop), 1.0, shape, None)
        measured |= {
            f"balance.{shape:g}": best,
            f"share.{shape:g}": share,
            f"gain.{shape:g}": 1.0 / share,
            f"late.balance.{shape:g}": late,
            f"late.share.{shape:g}": late_share,
            f"late.gain.{shape:g}": 1.0 / late_share,
        }
    for mean in SITES:
        ideal = energy(lambda v: np.full_like(v, BEST), mean, 2.0, CAP)
        own = energy(of_converter, mean, 2.0, CAP)
        best, share = _best(lambda b: of_fixed(b, 1.0), mean, 2.0, CAP)
        late, late_share = _best(lambda b: of_fixed(b, start / stop), mean, 2.0, CAP)
        measured |= {
            f"ideal.{mean:g}": ideal * YEAR / LIFT,
            f"water.{mean:g}": own * YEAR / LIFT,
            f"converter.{mean:g}": own / ideal,
            f"capped.{mean:g}": 1.0 / share,
            f"over.{mean:g}": own / ideal / share,
            f"late.over.{mean:g}": own / ideal / late_share,
        }
    seen = {r: over * _balanced(r) for r in RATIOS}
    closed = BEST * 4.0 * over**-2.0 * (1.0 - over**-2.0)
    kinds = (("best fixed ratio, always running", "over"), ("best fixed ratio that starts against the peak", "late.over"))
    drawn = {
        "converter.curve": {"converter": (winds, converter)},
        "fixed.curves": {f"fixed ratio {r:g}": (seen[r], c) for r, c in fixed.items()},
        "closed.curves": {f"closed form, {r:g}": (seen[r], closed) for r in RATIOS},
        "fixed.water": {text: [measured[f"water.{m:g}"] / measured[f"{key}.{m:g}"] for m in SITES] for text, key in kinds},
    }
    return Evidence(measured, data=drawn)


def _balanced(ratio: float) -> float:
    """Wind, m/s, that balances the mean torque behind a fixed ratio at standstill."""
    return math.sqrt(ratio * LOAD / (0.5 * DENSITY * AREA * RADIUS * 0.5))


def side_by_side(
    winds: np.ndarray, component: str, parameters: Mapping[str, Any], speed: float, step: float, title: str = ""
) -> Scene:
    """Turbines and transmissions, one set a wind, under the mean torque. speed: of the turbine at the start over wind, 1/m."""
    units, connections = {}, {}
    fixed = component == "FixedTransmission"
    for k, wind in enumerate(winds.tolist()):
        begin = parameters.get("gear_ratio", 1.0) * speed * wind if fixed else 1.0
        units[f"turbine_{k}"] = unit("WindTurbine", preset="farm windmill", wind=wind, start_speed=speed * wind)
        units[f"drive_{k}"] = unit(component, **parameters, start_speed=begin, load_torque=LOAD)
        connections[f"turbine_{k}.speed"] = f"drive_{k}.turbine_speed"
        connections[f"drive_{k}.turbine_torque"] = f"turbine_{k}.torque"
    return build_scene(
        units,
        connections,
        stop_time=60.0,
        step=step,
        name="paper-wind-pump",
        master={"extrapolation": 1},
        title=f"{component}{title and ', '}{title} in steady winds",
        record={"signals": [f"turbine_{k}.power_coefficient" for k in range(winds.size)], "interval": 60.0},
    )


def coefficients(result: Result, winds: int) -> np.ndarray:
    """Power coefficients of the turbines at the end of a run, (winds,)."""
    return np.array([result[f"turbine_{k}.power_coefficient"][-1] for k in range(winds)])


def energy(coefficient: Share, mean: float, shape: float, cap: float | None) -> float:
    """Mean power, W, of a power coefficient over the wind in a Weibull distribution of a mean wind, m/s.

    cap: times the mean wind, above which the power stays the same; None: it goes on with the cube.
    """
    scale = mean / float(gamma(1.0 + 1.0 / shape))
    v = np.linspace(1e-6, 10.0 * mean, 30001)
    density = shape / scale * (v / scale) ** (shape - 1.0) * np.exp(-((v / scale) ** shape))
    reached = v if cap is None else np.minimum(v, cap * mean)
    return float(np.trapezoid(density * 0.5 * DENSITY * AREA * reached**3 * coefficient(reached), v))


def _best(of_fixed: Callable[[float], Share], mean: float, shape: float, cap: float | None) -> tuple[float, float]:
    """(wind over mean wind at which the best fixed ratio balances the mean torque, its share of the ideal energy)."""
    ideal = energy(lambda v: np.full_like(v, BEST), mean, shape, cap)
    best = minimize_scalar(
        lambda b: -energy(of_fixed(b * mean), mean, shape, cap), bounds=(0.4, 1.6), method="bounded", options={"xatol": 1e-3}
    )
    return float(best.x), -float(best.fun) / ideal


def best_fixed(mean: float) -> float:
    """Share of the ideal energy of the fixed ratio that is best for a site of a mean wind, m/s, by its closed form 4 u (1 - u)."""

    def of_fixed(balanced: float) -> Share:
        return lambda v: BEST * 4.0 * (u := np.minimum(balanced / v, 1.0) ** 2) * (1.0 - u)

    return _best(of_fixed, mean, 2.0, CAP)[1]
