"""Which sizes of the converter win against the fixed ratio that suits the site best, and where that ends."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
from scipy.interpolate import PchipInterpolator

from .....harness.validation import Evidence, Runs
from .....run.results import Result
from .....scene.scene import Scene
from ..start import FREE
from .plant import K1, RADIUS
from .water import BEST, CAP, LOAD, Share, best_fixed, coefficients, energy, side_by_side

MEAN = 4.0  # m/s, mean wind of a site, Rayleigh
GEARS = (2.0, 2.8, 3.2, 6.0, 8.0, 9.0)  # crank over turbine; 6 is the default
MASSES = (10.0, 20.0, 40.0)  # kg, of the lever; 20 is the default
STEP = 0.02  # s: large gears and levers brake the turbine at a rate that 0.05 s does not resolve
POINTS = 20  # winds of a size
LAST = CAP * MEAN * 1.02  # m/s: beyond CAP times the mean wind the power stays


def scenes() -> dict[tuple[float, float], Scene]:
    """Sets side by side in winds from the converter's start on, one scene a size."""
    return {
        (gear, mass): side_by_side(
            winds(gear, mass),
            "AveragedConverter",
            {"gear_ratio": gear, "lever_mass": mass},
            FREE,
            STEP,
            f"gear {gear:g}, {mass:g} kg",
        )
        for gear in GEARS
        for mass in MASSES
    }


def winds(gear: float, mass: float) -> np.ndarray:
    """From 1 % above the wind in which the runaway turbine stalls the converter at the load, v = R sqrt(T / k1) / (n 2.4), m/s."""
    start = RADIUS * math.sqrt(LOAD / (K1 * mass / 20.0)) / (2.4 * gear)
    return np.geomspace(1.01 * min(start, 0.9 * LAST), LAST, POINTS)


def measure(runs: Runs) -> Evidence:
    """Water of a year of each size over that of the best fixed ratio, and the gears between which the default lever wins."""
    share = best_fixed(MEAN)
    over = {size: _water(runs[size], winds(*size)) / share for size in scenes_of()}
    lost = [size for size, gain in over.items() if gain < 1.0]
    standard = np.array([over[gear, 20.0] for gear in GEARS])
    low, high = crossings(standard)
    measured = {f"over.{gear:g}.{mass:g}": gain for (gear, mass), gain in over.items()}
    measured |= {"sizes.lost": float(len(lost)), "gear.low": low, "gear.high": high}
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


def _water(result: Result, at: np.ndarray) -> float:
    """Energy of a year over the ideal."""
    own = PchipInterpolator(at, coefficients(result, at.size), extrapolate=False)
    share: Share = lambda v: np.nan_to_num(own(v))  # noqa: E731  none below the first wind; the last is beyond the cap
    return energy(share, MEAN, 2.0, CAP) / energy(lambda v: np.full_like(v, BEST), MEAN, 2.0, CAP)
