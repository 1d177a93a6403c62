"""Whether the boundary between order and chaos of one line holds at other parameters: speed, damping and load halved and doubled."""

from __future__ import annotations

import numpy as np

from ......components.bearings.ball_bearing import BallBearing
from .....harness.analysis.lyapunov import lyapunov_spectrum
from .....harness.validation import Evidence, Runs
from ..lyapunov_sum import INTERVAL, SCALES, SPEED, STATES, TRANSIENT

GAPS = (5.0, 15.0, 19.0, 21.0, 24.0, 27.0, 30.0)  # um, radial
BOUNDARY = 20.0  # um: order below and chaos above at 1000 rpm, 200 N.s/m and 196 N
SET = {"speed": SPEED, "damping": 200.0, "load": 196.0}  # rad/s, N.s/m, N
SETS = {
    f"{word} {name}": {name: factor * value} for name, value in SET.items() for word, factor in (("half", 0.5), ("twice", 2.0))
}
INTERVALS = 750  # of 4 ms: a sign is asked for, and no value


def measure(runs: Runs) -> Evidence:
    """Signs of the largest exponent over the clearance, components stepped alone, each from equilibrium."""
    largest = {name: np.array([largest_exponent(gap, given) for gap in GAPS]) for name, given in SETS.items()}
    beyond = np.array(GAPS) > BOUNDARY
    measured: dict[str, float] = {f"sets.{name}": float(((e > 0.0) == beyond).sum()) for name, e in largest.items()}
    held = [name for name in SETS if measured[f"sets.{name}"] == len(GAPS)]
    measured["sets.held"] = float(len(held))
    measured["sets.both"] = float(sum((e > 0.0).any() and (e < 0.0).any() for e in largest.values()))
    by_set_in_words = "; ".join(_chaos(n, e) for n, e in largest.items())
    by_set = {what: {name: e for name, e in largest.items() if name.endswith(what)} for what in SET}
    return Evidence(measured, data={"names": ", ".join(held) or "none", "chaos": by_set_in_words, "gaps": GAPS, **by_set})


def largest_exponent(clearance: float, given: dict[str, float]) -> float:
    """Largest Lyapunov exponent, 1/s; clearance: radial, um; given: of `SET`, what is other there."""
    values = SET | given
    parameters = {"clearance.radial_clearance": 1e-6 * clearance, "speed": values["speed"], "damping": values["damping"]}
    model = BallBearing(["clearance"], parameters)
    model.set("load", values["load"])
    model.initialize(0.0)
    return lyapunov_spectrum(model, STATES, SCALES, interval=INTERVAL, intervals=INTERVALS, transient=TRANSIENT, count=1).largest


def _chaos(name: str, exponents: np.ndarray) -> str:
    at = [f"{gap:g}" for gap, e in zip(GAPS, exponents, strict=True) if e > 0.0]
    return f"{name}: chaos at {', '.join(at)} um" if at else f"{name}: none up to {GAPS[-1]:g} um"
