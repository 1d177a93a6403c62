"""Walking as an application: two published gaits, what slope does to the simplest walker, and a panel that a latch catches."""

from __future__ import annotations

import math

import numpy as np

from ......components.two_axis_joint.walker import PassiveWalker
from .....harness.validation import Evidence, Runs
from .....run.results import Result
from .....scene.build import unit
from .....scene.scene import Scene
from .... import build_scene, load_scene
from .special_case import NAME

SLOPES = (0.001, 0.002, 0.004, 0.008)  # rad, of gaits whose angle is compared
BELOW, ABOVE = 0.014, 0.0165  # rad, on either side of the published end of the stable gait of one step
# Where searches start, of the standing leg behind an impact over the cube root of the slope, and over the slope, rad and rad/s:
ANGLE, RATE = (0.970956, -0.184), (-1.01475, 1.2495)  # fitted to gaits by SciPy; walkers fall from starts farther away
STEP_TIME, LATE = 3.9, 8  # s, of a step, about; steps at the end that are looked at
FINE = 2e-3  # s, internal steps: weight 1, length 1, so 2000 of them in a step


def scenes() -> dict[str, Scene]:
    """The shipped walkers from their published gaits, legs without mass, other slopes, and the panel with its latch."""
    at_gait = load_scene("passive-walkers").with_changes(
        {"compass.start_stance_rate": PassiveWalker.presets["compass gait"].parameters["start_stance_rate"]}
    )
    return {
        "passive-walkers": at_gait.with_changes({"stop_time": 40.0}),
        "slopes": _simplest({f"s{k}": slope for k, slope in enumerate(SLOPES)} | {"limit": 0.009}, 60),
        "below": _simplest({"below": BELOW}, 120),
        "above": _simplest({"above": ABOVE}, 120),
        "satellite-latch": load_scene("satellite-latch"),
    }


def measure(runs: Runs) -> Evidence:
    """States behind impacts, step times, the exponent over slope, steps that alternate, and the hub behind a latch."""
    measured: dict[str, float] = {}
    gaits = runs["passive-walkers"]
    for name in ("simplest", "compass"):
        for what in ("strike_angle", "strike_rate", "step_duration", "step_length"):
            measured[f"{name}.{what}"] = float(gaits[f"{name}.{what}"][-1])
        whole = gaits[f"{name}.mechanical_energy"] + gaits[f"{name}.lost_energy"]
        measured[f"{name}.energy"] = float(np.ptp(whole) / gaits[f"{name}.lost_energy"][-1])
    slopes = runs["slopes"]
    angles = [float(slopes[f"s{k}.strike_angle"][-1]) for k in range(len(SLOPES))]
    measured["exponent"] = float(np.polyfit(np.log(SLOPES), np.log(angles), 1)[0])
    measured["limit.strike_angle"] = float(slopes["limit.strike_angle"][-1])
    measured["limit.strike_rate"] = float(slopes["limit.strike_rate"][-1])
    for name in ("below", "above"):
        measured[f"alternation.{name}"] = _alternation(runs[name], name)
    latch = runs["satellite-latch"]
    measured["hub.latched"] = math.degrees(float(latch["panel.first_angle"][-1]))
    measured["hub.stands"] = float(abs(latch["panel.first_rate"][-1]) / np.abs(latch["panel.first_rate"]).max())
    drawn = {"slopes": np.array(SLOPES), "angles": {"walker": np.array(angles), "cube root": ANGLE[0] * np.cbrt(SLOPES)}}
    return Evidence(measured, data=drawn)


def _simplest(slopes: dict[str, float], steps: int) -> Scene:
    """Walkers with legs of a billionth of the hip's mass, started near their gaits by the cube root of the slope."""
    units = {}
    for name, slope in slopes.items():
        angle, rate = (a * slope ** (1.0 / 3.0) + b * slope for a, b in (ANGLE, RATE))
        units[name] = unit(
            "PassiveWalker",
            preset="simplest walker",
            hip_mass=1.0,
            leg_mass=1e-9,
            slope=slope,
            start_stance_angle=angle,
            start_swing_angle=-angle,
            start_stance_rate=rate,
            start_swing_rate=rate * math.cos(2.0 * angle),
            substep=FINE,
        )
    signals = [f"{name}.{s}" for name in units for s in ("strike_angle", "strike_rate", "steps")]
    title = "Simplest walkers on other slopes"
    return build_scene(units, stop_time=STEP_TIME * steps, step=0.1, name=NAME, title=title, record={"signals": signals})


def _alternation(result: Result, name: str) -> float:
    """Largest difference of the angles behind two impacts that follow each other, rad, late in the run."""
    steps = result[f"{name}.steps"]
    ends = np.flatnonzero(np.diff(steps)) + 1
    return float(np.abs(np.diff(result[f"{name}.strike_angle"][ends][-LATE:])).max())
