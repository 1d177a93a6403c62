"""The design chart: mean speed over friction ratio, frequency, slope and stiffness; closed form beside runs of the component."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from ......components.pipe_robot.rolling import RING
from .....harness.validation import Evidence, Runs
from .....run.results import Result
from .....scene.build import unit
from .....scene.scene import Scene
from .... import build_scene
from ...robots import TURN, last_speed, side_by_side
from .balance import Design, balance, breakaway
from .matching import matched_speed

NAME = "paper-pipe-robots"
STANDARD = Design()
EXAMPLES = {
    "standard": STANDARD, "resonance": STANDARD.at(frequency=77.46), "fast": STANDARD.at(frequency=100.0),
    "slow": STANDARD.at(frequency=40.0), "half force": STANDARD.at(force=10.0), "quarter force": STANDARD.at(force=5.0),
    "rough forwards": STANDARD.at(forward=4.0), "slope 0.2": STANDARD.at(sine=math.sin(0.2)),
    "slope 0.4": STANDARD.at(sine=math.sin(0.4)), "damped": STANDARD.at(damping=20.0, frequency=77.46),
}  # fmt: skip
FREQUENCIES = (0.22, 0.3, 0.4, 0.5, 0.7, 0.85, 1.0, 1.2, 1.5, 2.0, 3.0)  # over the resonance
RATIOS = (1.0, 1.5, 2.0, 3.0, 4.5, 6.0)  # of friction, backwards over forwards
SINES = (0.0, 0.05, 0.1, 0.15, 0.2039, 0.25, 0.3, 0.4)
STIFFNESSES = (500.0, 1000.0, 1500.0, 2000.0, 3000.0, 4000.0)  # N/m
SCALES = (1.0, 0.5, 0.25, 0.125)  # of the friction, for the order of the balance
GOOD = 0.6  # largest epsilon for which the balance is meant
SETTLED = 8.0  # s at least
Key = tuple[float, float]  # place in a map
FIRST = {(r, q): STANDARD.at(ratio=r, backward=q * STANDARD.forward) for r in FREQUENCIES for q in RATIOS}
SECOND = {(s, k): STANDARD.at(sine=s, stiffness=k) for s in SINES for k in STIFFNESSES}
WEAKER = [STANDARD.at(forward=s * STANDARD.forward, backward=s * STANDARD.backward) for s in SCALES]


def scenes() -> dict[Any, Scene]:
    """Robots of one frequency side by side: a frequency of the first map, the second map, each example, weaker friction; rings."""
    return {
        **{r: _side_by_side([d for key, d in FIRST.items() if key[0] == r]) for r in FREQUENCIES},
        "slopes": _side_by_side(SECOND.values()),
        **{name: _side_by_side([design]) for name, design in EXAMPLES.items()},
        "weaker friction": _side_by_side(WEAKER, 60.0),
        "rolling": _rings(),
    }


def measure(runs: Runs) -> Evidence:
    """Two maps, ten designs, the order of the closed form, and the robot on rolling rings."""
    speeds: dict[Key, float] = {}
    for r in FREQUENCIES:
        speeds |= _speeds(runs[r], [key for key in FIRST if key[0] == r])
    speeds_second = _speeds(runs["slopes"], SECOND)
    measured = _judged("map", FIRST, speeds) | _judged("slopes", SECOND, speeds_second)
    for name, design in EXAMPLES.items():
        measured[f"speed.{name}"] = last_speed(runs[name], "r0", 10)
        measured[f"chart.{name}"] = balance(design).speed
        measured[f"matched.{name}"] = _off({name: measured[f"speed.{name}"]}, {name: design})
        measured[f"share.{name}"] = abs(measured[f"speed.{name}"] - measured[f"chart.{name}"]) / balance(design).error
    even = [abs(speeds[r, 1.0]) / b for r in FREQUENCIES for b in [balance(FIRST[r, 1.0]).amplitude] if math.isfinite(b)]
    measured |= {"even": max(even), "stands": max(abs(speeds[FREQUENCIES[0], q]) for q in RATIOS)}
    measured |= {"map.matched": _off(speeds, FIRST), "slopes.matched": _off(speeds_second, SECOND)}
    measured |= _order(runs["weaker friction"]) | _rolling(runs["rolling"])
    bad = sum(not balance(d).epsilon < GOOD for d in (*FIRST.values(), *SECOND.values()))
    return Evidence(measured, data={"bad": bad, **_maps(speeds, speeds_second), **_lines(speeds)})


def _maps(first: Mapping[Key, float], second: Mapping[Key, float]) -> dict[str, Any]:
    """Both design charts: speeds of the balance, places and speeds of the runs, and the limits that do not depend on them."""
    ratios, frictions, sines, springs = (
        np.linspace(*ends) for ends in ((0.2, 3.0, 113), (1.0, 6.0, 41), (0.0, 0.4, 81), (500.0, 4000.0, 71))
    )
    designs = [[STANDARD.at(ratio=float(r), backward=float(q) * STANDARD.forward) for r in ratios] for q in frictions]
    slopes = [[STANDARD.at(sine=float(s), stiffness=float(k)) for s in sines] for k in springs]
    limit = next(r for r in np.linspace(0.1, 1.0, 4000).tolist() if breakaway(STANDARD.at(ratio=r)) < STANDARD.force)
    return {
        "first": (ratios, frictions, _field(designs)),
        "second": (sines, springs, _field(slopes)),
        **{f"{n}.runs": {"runs": tuple(zip(*keys, strict=True))} for n, keys in (("first", first), ("second", second))},
        **{f"{n}.labels": [f"{v:.4f} m/s" for v in of.values()] for n, of in (("first", first), ("second", second))},
        "loose": ((limit, "breaks loose"),),
        "turning": (((STANDARD.backward - STANDARD.forward) / 2.0 / STANDARD.at(sine=1.0).load, "turns back"),),
    }


def _field(rows: Sequence[Sequence[Design]]) -> np.ndarray:
    return np.nan_to_num(np.array([[balance(d).speed for d in row] for row in rows]))


def _lines(speeds: Mapping[Key, float]) -> dict[str, Any]:
    """Two lines of the first chart, with the runs."""
    x = np.linspace(0.2, 3.0, 281)
    drawn: dict[str, Any] = {"ratios": x, "tried": FREQUENCIES}
    for q in (2.0, 4.5):
        drawn[f"balance.{q:g}"] = [balance(STANDARD.at(ratio=float(r), backward=q * STANDARD.forward)).speed for r in x]
        drawn[f"runs.{q:g}"] = [speeds[r, q] for r in FREQUENCIES]
    return drawn


def _side_by_side(designs: Iterable[Design], least: float = SETTLED) -> Scene:
    """Robots r0, r1 ... of one frequency, for `least` s and twenty periods."""
    robots = {f"r{k}": design.parameters() for k, design in enumerate(designs)}
    frequency = robots["r0"]["harmonic_force.frequency"]
    periods = math.ceil(least * frequency / TURN) + 20
    return side_by_side(NAME, f"Designs at {frequency:.4g} rad/s", robots, TURN / frequency, periods)


def _speeds(result: Result, keys: Iterable[Key]) -> dict[Key, float]:
    """Mean speeds over the last ten periods, m/s, of the robots by their places in a map."""
    return {key: last_speed(result, f"r{k}", 10) for k, key in enumerate(keys)}


def _judged(name: str, designs: Mapping[Key, Design], speeds: Mapping[Key, float]) -> dict[str, float]:
    """How many runs are within the error of the balance, and the largest difference over that error."""
    shares = [abs(speeds[key] - answer.speed) / answer.error for key, design in designs.items()
              for answer in [balance(design)] if answer.epsilon < GOOD]  # fmt: skip
    inside = 100.0 * float(np.mean(np.array(shares) <= 1.0))
    return {f"{name}.runs": len(shares), f"{name}.inside": inside, f"{name}.worst": max(shares)}


def _off(speeds: Mapping[Any, float], designs: Mapping[Any, Design]) -> float:
    """Largest difference of runs from the matched pieces, over the largest rate that the exciter gives the body, F0 / (m1 w)."""
    return max(
        abs(speeds[key] - matched_speed(design)) * design.body * design.frequency / design.force
        for key, design in designs.items()
    )


def _order(result: Result) -> dict[str, float]:
    """Slope of the relative difference over epsilon, as the friction gets weaker."""
    answers = [balance(d) for d in WEAKER]
    errors = [abs(last_speed(result, f"r{k}", 10) / a.speed - 1.0) for k, a in enumerate(answers)]
    return {"order": float(np.polyfit(np.log([a.epsilon for a in answers]), np.log(errors), 1)[0])}


def _rings() -> Scene:
    """A robot on rings whose rollers turn one way."""
    frequency = 60.0  # rad/s
    robot = unit("RollingPipeRobot", preset="two steel rings", roller_inertia=1e-9)
    record = {"signals": ["robot.position", "robot.pressing_force"]}
    title = "Robot on elastic rings"
    return build_scene(
        {"robot": robot}, stop_time=90 * TURN / frequency, step=TURN / frequency, name=NAME, title=title, record=record
    )


def _rolling(result: Result) -> dict[str, float]:
    """The robot on rings: nearly all of a period forwards, so nearly b."""
    normal = 4.0 * float(result["robot.pressing_force"][-1])
    design = STANDARD.at(forward=0.03 * normal, backward=0.4 * normal)
    answer, speed = balance(design), last_speed(result, "robot", 10)
    ring = float(result["robot.pressing_force"][-1]) * 0.102**3 / (0.2 * 0.004)  # force R³ / (EI times 4 mm pressed in)
    return {
        "rolling.matched": _off({"": speed}, {"": design}),
        "rolling.share": abs(speed - answer.speed) / answer.error,
        "rolling.speed": speed / answer.amplitude,
        "ring": ring,
        "ring.closed": RING,
    }
