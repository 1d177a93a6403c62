"""Which sizes of the converter win against the fixed ratio that suits the site best, and where that ends."""

from __future__ import annotations

import math
from functools import cache
from itertools import pairwise

import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.optimize import minimize_scalar

from .....harness.validation import Evidence, Runs
from .....run.results import Result
from .....scene.scene import Scene
from ..start import FREE
from .plant import AREA, DENSITY, RADIUS, Plant, farm
from .water import BEST, CAP, LOAD, Share, best_fixed, coefficients, energy, side_by_side

MEAN = 4.0  # m/s, mean wind of a site, Rayleigh
GEARS = (2.0, 2.8, 3.2, 6.0, 8.0, 9.0)  # crank over turbine; 6 is the default
MASSES = (10.0, 20.0, 40.0)  # kg, of the lever; 20 is the default
STEP = 0.02  # s: large gears and levers brake the turbine at a rate that 0.05 s does not resolve
POINTS = 20  # winds of a size
BEYOND = CAP * 1.02  # times the mean wind, the last wind of a set: beyond CAP times it the power stays
SITES = (3.0, 4.0, 5.0)  # m/s, mean winds for which each lever gets its best gear
SPAN = (1.5, 14.0)  # gears among which the best one is sought


def scenes() -> dict[tuple[float, ...], Scene]:
    """Sets side by side in winds from the converter's start on, one scene a size; then the best gear of each site and lever."""
    by_size: dict[tuple[float, ...], Scene] = {size: _scene(*size, MEAN) for size in scenes_of()}
    return by_size | {(mean, mass, mean): _scene(best_gear(mean, mass), mass, mean) for mean in SITES for mass in MASSES}


def _scene(gear: float, mass: float, mean: float) -> Scene:
    given = {"gear_ratio": gear, "lever_mass": mass}
    title = f"gear {gear:.3g}, {mass:g} kg, {mean:g} m/s"
    return side_by_side(winds(gear, mass, mean), "AveragedConverter", given, FREE, STEP, title)


@cache
def best_gear(mean: float, mass: float) -> float:
    """The gear with which a converter gives most at a site of a mean wind, m/s, by the equilibria of the averaged equations."""
    ends = tuple(math.log(g) for g in SPAN)
    return math.exp(
        minimize_scalar(lambda g: -gain(math.exp(g), mass, mean), bounds=ends, method="bounded", options={"xatol": 1e-3}).x
    )


def gain(gear: float, mass: float, mean: float) -> float:
    """Water of a year over that of the best fixed ratio, by the equilibria."""
    plant, at = Plant(farm, gear, 2.4, lever=mass), winds(gear, mass, mean)
    powers = [max((plant.turbine_torque(w, v) * w for w, _ in plant.equilibria(v, LOAD)), default=0.0) for v in at.tolist()]
    return _share(at, np.array(powers) / (0.5 * DENSITY * AREA * at**3), mean) / best_fixed(mean)


def winds(gear: float, mass: float, mean: float = MEAN) -> np.ndarray:
    """From 1 % above the wind in which the runaway turbine stalls the converter at the load, v = R sqrt(T / k1) / (n 2.4), m/s."""
    start = RADIUS * math.sqrt(LOAD / Plant(farm, gear, 2.4, lever=mass).k1) / (2.4 * gear)
    return np.geomspace(1.01 * min(start, 0.9 * BEYOND * mean), BEYOND * mean, POINTS)


def measure(runs: Runs) -> Evidence:
    """Water of a year of each size over that of the best fixed ratio, and the gears between which the default lever wins."""
    share = best_fixed(MEAN)
    over = {size: _water(runs[size], winds(*size)) / share for size in scenes_of()}
    lost = [size for size, gain in over.items() if gain < 1.0]
    standard = np.array([over[gear, 20.0] for gear in GEARS])
    low, high = crossings(standard)
    measured = {f"over.{gear:g}.{mass:g}": gain for (gear, mass), gain in over.items()}
    measured |= {"sizes.lost": float(len(lost)), "gear.low": low, "gear.high": high}
    predicted = sum((gain(*size, MEAN) < 1.0) == (over[size] < 1.0) for size in scenes_of())
    sized = {
        (mean, mass): _water(runs[mean, mass, mean], winds(best_gear(mean, mass), mass, mean), mean) / best_fixed(mean)
        for mean in SITES
        for mass in MASSES
    }
    off = [abs(own / gain(best_gear(mean, mass), mass, mean) - 1.0) for (mean, mass), own in sized.items()]
    measured |= {"sizes.told": float(predicted), "sized.least": min(sized.values()), "sized.off": max(off)}
    names = ", ".join(f"gear {gear:g} with {mass:g} kg ({over[gear, mass]:.2f})" for gear, mass in lost)
    levers = {f"lever of {m:g} kg": [over[g, m] for g in GEARS] for m in MASSES}
    return Evidence(measured, data={"names": names, "gears": GEARS, "levers": levers})


def scenes_of() -> list[tuple[float, float]]:
    """The sizes, (gear, mass of the lever in kg)."""
    return [(gear, mass) for gear in GEARS for mass in MASSES]


def crossings(gains: np.ndarray) -> tuple[float, float]:
    """Gears at which a gain over `GEARS` passes 1 upwards and downwards, straight in log gear; NaN where it does not."""
    ends = {True: math.nan, False: math.nan}
    for (g0, y0), (g1, y1) in pairwise(zip(GEARS, gains.tolist(), strict=True)):
        if (y0 < 1.0) != (y1 < 1.0):
            ends[y1 >= 1.0] = math.exp(math.log(g0) + (1.0 - y0) / (y1 - y0) * math.log(g1 / g0))
    return ends[True], ends[False]


def _water(result: Result, at: np.ndarray, mean: float = MEAN) -> float:
    """Energy of a year over the ideal."""
    return _share(at, coefficients(result, at.size), mean)


def _share(at: np.ndarray, coefficient: np.ndarray, mean: float) -> float:
    """Energy of a year of power coefficients in winds, m/s, over the ideal."""
    own = PchipInterpolator(at, coefficient, extrapolate=False)
    share: Share = lambda v: np.nan_to_num(own(v))  # noqa: E731  none below the first wind; the last is beyond the cap
    return energy(share, mean, 2.0, CAP) / energy(lambda v: np.full_like(v, BEST), mean, 2.0, CAP)
