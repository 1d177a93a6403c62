"""Thresholds: the force at which a body at rest breaks loose, the slope and the load at which it turns back or slides."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from .....harness.validation import Evidence, Runs
from .....run.results import Result
from .....scene.scene import Scene
from ...robots import TURN, last_speed, side_by_side
from .balance import Design, breakaway
from .design import NAME, STANDARD

FREQUENCIES = (20.0, 40.0, 60.0, 63.2, 77.5, 100.0, 200.0)  # rad/s
BELOW, ABOVE = 0.98, 1.02  # times the force at which the body breaks loose
MEAN, SEEN = 20, 40  # periods over which a motion is judged; samples a period
SETTLED = 5.0  # s: 25 time constants of the inner mass
HOLDING = (0.99, 1.01)  # times the sine of the steepest slope that holds
WEIGHT = STANDARD.at(sine=1.0).load  # N
TURNING = (STANDARD.backward - STANDARD.forward) / 2.0  # N, down the pipe, at which a robot turns back
STEEPEST = STANDARD.backward / WEIGHT  # sine of the steepest slope that holds
TURNS = {
    "slope": [STANDARD.at(sine=f * TURNING / WEIGHT) for f in (0.95, 1.05)],
    "tow": [STANDARD.at(tow=-f * TURNING) for f in (0.95, 1.05)],
    "slope.strong": [STANDARD.at(sine=f * TURNING / WEIGHT, force=40.0) for f in (0.95, 1.05)],
}


def scenes() -> dict[Any, Scene]:
    """Pairs of robots just below and just above each threshold."""
    pairs: dict[Any, list[Design]] = {}
    for w in FREQUENCIES:
        design = STANDARD.at(frequency=w)
        pairs[w] = [design.at(force=f * breakaway(design)) for f in (BELOW, ABOVE)]
    still = [STANDARD.at(sine=f * STEEPEST, force=0.0) for f in HOLDING]
    return {name: _scene(designs) for name, designs in {**pairs, **TURNS, "holds": still}.items()}


def measure(runs: Runs) -> Evidence:
    """Ways, mean speeds and standstill on both sides of every threshold."""
    measured: dict[str, float] = {}
    for w in FREQUENCIES:
        measured |= _pair(runs[w], w)
    for name in TURNS:
        up, down = (last_speed(runs[name], f"r{k}", MEAN * SEEN) for k in range(2))
        at = 0.95 + 0.1 * up / (up - down)
        measured[f"turns.{name}"] = TURNING * at
        if name == "slope":
            measured["turns.angle"] = math.degrees(math.asin(TURNING * at / WEIGHT))
    holds = runs["holds"]
    measured |= {f"holds.{name}": float(np.ptp(holds[f"r{k}.position"])) for k, name in enumerate(("below", "above"))}
    measured["holds.angle"] = math.degrees(math.asin(STEEPEST))
    return Evidence(measured, data=_breaking())


def _pair(result: Result, frequency: float) -> dict[str, float]:
    """Way of a body in the last periods just below and just above the force at which it breaks loose, m; its slips backwards."""
    below, above = (result[f"r{k}.position"][-MEAN * SEEN :] for k in range(2))
    return {
        f"below.{frequency:g}": float(np.ptp(below)),
        f"above.{frequency:g}": 1e9 * float(above[-1] - above[0]),
        f"back.{frequency:g}": float(-np.minimum(np.diff(above), 0.0).sum()),
    }


def _scene(designs: Sequence[Design]) -> Scene:
    """Robots side by side over the time that settles them and some periods."""
    frequency = designs[0].frequency
    periods = MEAN + math.ceil(SETTLED * frequency / TURN)
    robots = {f"r{k}": d.parameters() for k, d in enumerate(designs)}
    return side_by_side(NAME, f"Thresholds at {frequency:g} rad/s", robots, TURN / frequency / SEEN, periods * SEEN)


def _breaking() -> dict[str, Any]:
    """Forces at which a body breaks loose forwards and backwards, for three springs, and where it was tried."""
    w = np.geomspace(15.0, 250.0, 300)
    forces = {
        f"{name}, spring {k:g} N/m": [f * breakaway(STANDARD.at(frequency=float(x), stiffness=k)) for x in w]
        for k in (1000.0, 2000.0, 4000.0)
        for name, f in (("forwards", 1.0), ("backwards", STANDARD.backward / STANDARD.forward))
    }
    return {
        "frequency": w,
        "forces": forces,
        "tried": FREQUENCIES,
        "at": [breakaway(STANDARD.at(frequency=x)) for x in FREQUENCIES],
    }
