"""Thresholds: the force at which a body at rest breaks loose, the slope and the load at which it turns back or slides."""

from __future__ import annotations

import math

import numpy as np

from ......components.core.errors import StepFailed
from .....harness.charts.chart import Chart, Panel, Series
from .....harness.validation.papers import Evidence
from .....harness.validation.questions import Options
from .....results import Result
from .....run import run
from ...robots import TURN, last_speed, side_by_side
from .balance import Design, breakaway
from .design import NAME, STANDARD

FREQUENCIES = (20.0, 40.0, 60.0, 63.2, 77.5, 100.0, 200.0)  # rad/s
BELOW, ABOVE = 0.98, 1.02  # times the force at which the body breaks loose
MEAN, SEEN = 20, 40  # periods over which a motion is judged; samples a period
SETTLED = 5.0  # s: 25 time constants of the inner mass
HOLDING = (0.99, 1.01)  # times the sine of the steepest slope that holds


def study(options: Options) -> Evidence:
    """Pairs of robots just below and just above each threshold."""
    measured: dict[str, float] = {}
    for w in FREQUENCIES:
        measured |= _pair(w, options)
    weight = STANDARD.at(sine=1.0).load
    turning = (STANDARD.backward - STANDARD.forward) / 2.0
    for name, designs in {
        "slope": [STANDARD.at(sine=f * turning / weight) for f in (0.95, 1.05)],
        "tow": [STANDARD.at(tow=-f * turning) for f in (0.95, 1.05)],
        "slope.strong": [STANDARD.at(sine=f * turning / weight, force=40.0) for f in (0.95, 1.05)],
    }.items():
        up, down = _speeds(designs, options)
        at = 0.95 + 0.1 * up / (up - down)
        measured[f"turns.{name}"] = turning * at
        if name == "slope":
            measured["turns.angle"] = math.degrees(math.asin(turning * at / weight))
    steepest = STANDARD.backward / weight
    still = [STANDARD.at(sine=f * steepest, force=0.0) for f in HOLDING]
    result = _run(still, options, 20)
    measured |= {f"holds.{name}": float(np.ptp(result[f"r{k}.position"])) for k, name in enumerate(("below", "above"))}
    measured["holds.angle"] = math.degrees(math.asin(steepest))
    return Evidence(measured, (_chart(),), claim="F3")


def _pair(frequency: float, options: Options) -> dict[str, float]:
    """Way of a body in the last periods just below and just above the force at which it breaks loose, m; its slips backwards."""
    design = STANDARD.at(frequency=frequency)
    forces = [f * breakaway(design) for f in (BELOW, ABOVE)]
    result = _run([design.at(force=f) for f in forces], options, MEAN)
    below, above = (result[f"r{k}.position"][-MEAN * SEEN :] for k in range(2))
    return {
        f"below.{frequency:g}": float(np.ptp(below)),
        f"above.{frequency:g}": 1e9 * float(above[-1] - above[0]),
        f"back.{frequency:g}": float(-np.minimum(np.diff(above), 0.0).sum()),
    }


def _run(designs: list[Design], options: Options, periods: int) -> Result:
    """Robots side by side over the time that settles them and some periods."""
    frequency = designs[0].frequency
    periods += math.ceil(SETTLED * frequency / TURN)
    robots = {f"r{k}": d.parameters() for k, d in enumerate(designs)}
    scene = side_by_side(NAME, f"Thresholds at {frequency:g} rad/s", robots, TURN / frequency / SEEN, periods * SEEN)
    result = run(scene, in_process=options.in_process)
    if result.outcome != "done":
        raise StepFailed(result.scene.name, 0.0, result.message)
    return result


def _speeds(designs: list[Design], options: Options) -> list[float]:
    result = _run(designs, options, MEAN)
    return [last_speed(result, f"r{k}", MEAN * SEEN) for k in range(len(designs))]


def _chart() -> Chart:
    w = np.geomspace(15.0, 250.0, 300)
    lines = tuple(
        Series(f"{name}, spring {k:g} N/m", w, [f * breakaway(STANDARD.at(frequency=float(x), stiffness=k)) for x in w])
        for k in (1000.0, 2000.0, 4000.0)
        for name, f in (("forwards", 1.0), ("backwards", STANDARD.backward / STANDARD.forward))
    )
    at = Series("tried 2 % below and above", FREQUENCIES, [breakaway(STANDARD.at(frequency=x)) for x in FREQUENCIES], "points")
    panel = Panel("force, N", (*lines, at), logarithmic=True)
    return Chart(
        "Force at which a body at rest breaks loose",
        "exciter, rad/s",
        (panel,),
        "Between both lines of a spring a body steps forwards only. It takes least where the inner mass resonates "
        "against the body at rest.",
    )
