"""What must balance in a pipe robot, and what must stand: momentum and energy over a period, thresholds, rest on a slope."""

from __future__ import annotations

import math

import numpy as np

from ....harness.analysis.signals import accumulated
from ....harness.validation import Evidence, Runs
from ....run.results import Result
from ....scene.scene import Scene
from ..robots import BACKWARD, DAMPING, FORWARD, INNER, STUCK, TURN, last_speed, shaken, side_by_side

NAME = "pipe-robot-balance"
FREQUENCY = 60.0  # rad/s
SEEN, BALANCED = 500, 40  # samples a period; the period that is balanced
SETTLED = 120  # periods
SLOPE, PULL = math.asin(0.1), -1.0  # rad; N, of a load in tow
THRESHOLD = FORWARD / (INNER * FREQUENCY**2 / abs(complex(INNER * (STUCK**2 - FREQUENCY**2), DAMPING * FREQUENCY)))  # N
BELOW, ABOVE = 0.99, 1.05  # of the threshold
STEEP, MILD = 0.3, 0.5  # rad; N: with them the load stays 1.1 N below what would break the body loose
LAWS = {"exact": (), "smoothed": ("smoothed_friction",), "lugre": ("lugre_friction",)}
REST = 60.0  # s
CASES = {"level": (0.0, 0.0), "slope": (SLOPE, 0.0), "load": (0.0, PULL)}
SIGNALS = ("position", "velocity", "inner_position", "inner_velocity", "friction_force", "exciter_power", "mechanical_energy",
           "route.weight_power", "mode")  # fmt: skip


def scenes() -> dict[str, Scene]:
    """Every run by its name."""
    period = TURN / FREQUENCY
    robots = {n: shaken(frequency=FREQUENCY, route__slope=slope, tow__force=pull) for n, (slope, pull) in CASES.items()}
    quiet = {"below": shaken(BELOW * THRESHOLD), "above": shaken(ABOVE * THRESHOLD),
             "alike": shaken(20.0, forward_friction=5.0, backward_friction=5.0)}  # fmt: skip
    steep = dict.fromkeys(LAWS, shaken(MILD, route__slope=STEEP))
    laws = {n: ("harmonic_force", "route", *law) for n, law in LAWS.items()}
    return {
        "a period": side_by_side(NAME, "Balances over a period", robots, period / SEEN, BALANCED * SEEN, signals=SIGNALS),
        "threshold": side_by_side(NAME, "Below and above the threshold, and friction alike", quiet, period, SETTLED),
        "rest on a slope": side_by_side(NAME, "A minute on a slope of 0.3 rad, shaken below the threshold", steep, 0.01,
                                        round(REST / 0.01), effects=laws, signals=("position", "velocity", "friction_force")),
    }  # fmt: skip


def measure(runs: Runs) -> Evidence:
    """Balances of a period, ways below and above the threshold, and what creeps on a slope in a minute."""
    measured: dict[str, float] = {}
    for name in CASES:
        measured |= _balances(runs["a period"], name)
    half = SETTLED // 2
    measured["way.below"] = float(np.ptp(runs["threshold"]["below.position"][half:]))
    measured |= {f"speed.{n}": last_speed(runs["threshold"], n) for n in ("above", "alike")}
    creep = runs["rest on a slope"]
    measured |= {f"creep.{n}": float(creep[f"{n}.position"][-1] - creep[f"{n}.position"][0]) for n in LAWS}
    measured["largest.exact"] = float(np.abs(creep["exact.position"]).max())
    last, period = slice(-1 - SEEN, None), runs["a period"]
    stretches = {n: 1e3 * (period[f"{n}.inner_position"][last] - period[f"{n}.position"][last]) for n in CASES}
    drawn = {"phases": {n: (stretch, period[f"{n}.velocity"][last]) for n, stretch in stretches.items()}}
    return Evidence(measured, data={**drawn, **{f"down.{n}": -1e3 * measured[f"creep.{n}"] for n in ("smoothed", "lugre")}})


def _balances(result: Result, name: str) -> dict[str, float]:
    """Mean friction over the last period, and the shares of the exciter's work that friction, damper and weight took."""
    last = slice(-1 - SEEN, None)
    t = result.time[last]
    own = {s: np.asarray(result[f"{name}.{s}"][last]) for s in SIGNALS}
    v = own["velocity"]
    friction = own["friction_force"]
    share = np.full(SEEN, 0.5)  # of an interval, at its first friction
    for k in np.flatnonzero(v[2:-1] * v[3:] < 0.0) + 2:
        share[k] = _until_zero(v[k - 2 : k + 1])
    impulse = float(np.sum(np.diff(t) * (share * friction[:-1] + (1.0 - share) * friction[1:])))
    steps = np.diff(own["position"])
    forwards, backwards = (float(np.sum(np.where(sign * steps > 0.0, np.abs(steps), 0.0))) for sign in (1.0, -1.0))
    rubbed = FORWARD * forwards + BACKWARD * backwards
    damped = DAMPING * float(accumulated(t, (own["inner_velocity"] - v) ** 2)[-1])
    given, lifted = (float(accumulated(t, own[n])[-1]) for n in ("exciter_power", "route.weight_power"))
    pulled = CASES[name][1] * float(own["position"][-1] - own["position"][0])
    kept = float(own["mechanical_energy"][-1] - own["mechanical_energy"][0])
    return {f"friction.{name}": impulse / float(t[-1] - t[0]), f"work.{name}": (rubbed + damped - lifted - pulled + kept) / given}


def _until_zero(before: np.ndarray) -> float:
    """Intervals from the last of three samples to the zero of the parabola through them; friction jumps at the zero itself."""
    bend = 0.5 * (before[2] - 2.0 * before[1] + before[0])
    slope = before[2] - before[1] + bend
    return float(-2.0 * before[2] / (slope + math.copysign(math.sqrt(slope**2 - 4.0 * bend * before[2]), slope)))
