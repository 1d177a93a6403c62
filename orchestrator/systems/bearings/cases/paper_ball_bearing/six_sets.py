"""Order and chaos at three speeds and two loads: exponents, orbits with their multipliers, and recurrence by one rule of sampling.

The rule was fixed with the first set, 1000 rpm and 196 N: states once in `NATURAL` of dimensionless time. Clearances are the same in
the group G = c_r / x_s for both loads, as lengths grow with W^(2/3).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from scipy.stats import spearmanr

from ......components.bearings.ball_bearing import BallBearing
from ......components.core.errors import BadInput
from .....derivatives.continuation import orbits
from .....derivatives.orbit import Forcing
from .....harness.analysis.lyapunov import lyapunov_spectrum
from .....harness.analysis.recurrence import quantify
from .....harness.validation import Evidence, Runs
from .....scene.scene import Scene
from .... import load_scene
from ..lyapunov_sum import INTERVAL, SCALES, STATES, TRANSIENT
from .transition import CHAOS, GAPS, ORDER, PER_PASSAGE, SAMPLES, SIGNALS, WAIT, recurrence

SPEEDS, LOADS = (500.0, 1000.0, 2000.0), (98.0, 196.0)  # rpm, N
LOAD, MASS, DAMPING, STIFFNESS, BALLS = 196.0, 20.0, 200.0, 1.334e10, 8  # N, kg, N.s/m, N/m^1.5
INTERVALS = 1000  # of 4 ms
STEPS = 400  # of an orbit


def natural_time(load: float) -> float:
    """1 / w0 with w0 = sqrt(K x_s^(1/2) / m), s; load: N."""
    return math.sqrt(MASS / (STIFFNESS * (load / STIFFNESS) ** (1.0 / 3.0)))


def passage(speed: float) -> float:
    """From one ball to the next, s; speed: rpm."""
    return 1.0 / BallBearing().geometry.defect_frequencies(speed / 60.0)["outer"]


NATURAL = passage(1000.0) / PER_PASSAGE["coarse"] / natural_time(LOAD)  # 7.5: a natural period of small clearance


def measure(runs: Runs) -> Evidence:
    """Components stepped alone, each from equilibrium, and their orbits of one passing ball; clearances are those at 196 N."""
    measured: dict[str, float] = {}
    drawn: dict[str, Any] = {"gaps": GAPS}
    for load in LOADS:
        for speed in SPEEDS:
            name = f"{speed:g} rpm, {load:g} N"
            kinds = [kind_of(speed, load, (load / LOAD) ** (2.0 / 3.0) * gap) for gap in GAPS]
            largest, sizes, products, determinism, divergence = (np.array(column) for column in zip(*kinds, strict=True))
            ordered, chaotic, known = largest < ORDER, largest > CHAOS, np.isfinite(sizes)
            rate = np.log(sizes) / passage(speed)
            attracting = ordered & known & (sizes < 1.0)
            measured |= {
                f"{name}.order": float(ordered.sum()),
                f"{name}.chaos": float(chaotic.sum()),
                f"{name}.orbits": float(known.sum()),
                f"{name}.product": float(np.abs(products[known] / contraction(speed) - 1.0).max()),
                f"{name}.unstable": float(sizes[chaotic & known].min(initial=math.inf)),
                f"{name}.apart": float(np.abs(rate - largest)[attracting].max() if attracting.any() else math.inf),
                f"{name}.determinism": float(determinism[chaotic].mean() / determinism[ordered].mean()),
                f"{name}.divergence": float(divergence[chaotic].mean() / divergence[ordered].mean()),
                f"{name}.rank": float(spearmanr(largest, determinism).statistic),
            }
            drawn[name] = {"largest exponent": largest, "orbit of one passing ball": rate}
            drawn[f"{name}.from"] = float(GAPS[chaotic][0]) if chaotic.any() else math.inf
    return Evidence(measured, data=drawn)


def contraction(speed: float) -> float:
    """Of a volume of states in the passage of a ball, exp(-2 c T / m): the product of an orbit's multipliers (Liouville)."""
    return math.exp(-2.0 * DAMPING / MASS * passage(speed))


def kind_of(speed: float, load: float, clearance: float) -> tuple[float, float, float, float, float]:
    """Largest exponent in 1/s; size of the largest multiplier of the orbit of one passing ball, and their product; DET; DIV.

    speed: rpm.  load: N.  clearance: radial, um. Multipliers are no numbers where no orbit is reached from the motion.
    """
    model = bearing(speed, load, clearance)
    spectrum = lyapunov_spectrum(model, STATES, SCALES, interval=INTERVAL, intervals=INTERVALS, transient=TRANSIENT, count=1)
    multipliers = np.array([math.nan])
    try:
        forcing = Forcing(angle="bearing.cage_angle", turns=BALLS)
        multipliers = orbits(scene(speed, load, clearance), forcing, steps=STEPS).branches[0].points[0].multipliers
    except BadInput:
        pass  # counted as one orbit less
    interval = NATURAL * natural_time(load)
    window = math.ceil(passage(speed) / interval)
    plot = quantify(recurrence(states(speed, load, clearance, interval), window), theiler=window)
    return spectrum.largest, float(np.abs(multipliers).max()), float(np.prod(multipliers).real), plot.determinism, plot.divergence


def scene(speed: float, load: float, clearance: float) -> Scene:
    """The bearing alone; speed: rpm, load: N, clearance: radial, um."""
    given = {"speed": speed * math.pi / 30.0, "load": load, "clearance.radial_clearance": 1e-6 * clearance}
    return load_scene("ball-bearing-clearance").with_changes({f"bearing.{name}": value for name, value in given.items()})


def bearing(speed: float, load: float, clearance: float) -> BallBearing:
    """The component of `scene`, initialized."""
    parameters = {"clearance.radial_clearance": 1e-6 * clearance, "speed": speed * math.pi / 30.0}
    model = BallBearing(["clearance"], parameters)
    model.set("load", load)
    model.initialize(0.0)
    return model


def states(speed: float, load: float, clearance: float, interval: float) -> np.ndarray:
    """Positions and velocities after the transient, every so many seconds, (SAMPLES, 4)."""
    model = bearing(speed, load, clearance)
    model.step(0.0, WAIT)
    at, rows = model.output_positions(SIGNALS), np.empty((SAMPLES, len(SIGNALS)))
    for k in range(SAMPLES):
        model.step(WAIT + k * interval, interval)
        rows[k] = model.y[at]
    return rows
