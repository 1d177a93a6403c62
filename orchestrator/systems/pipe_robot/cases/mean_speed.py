"""Mean speed of pipe robots: exact and averaged for a prescribed motion, by an independent solution for a force."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from scipy.integrate import solve_ivp

from ....harness.validation import Evidence, Runs
from ....run.results import Result
from ....scene.scene import Scene
from ..robots import BACKWARD, BODY, FORWARD, GRAVITY, INNER, TURN, last_speed, shaken, side_by_side

NAME = "pipe-robot-mean-speed"
AMPLITUDE, FREQUENCY, MASS = 0.02, 100.0, 2.0  # m, rad/s, kg: two equal masses, whose velocities swing by b
B = 0.5 * AMPLITUDE * FREQUENCY  # m/s
WEAK = {"forward_friction": 0.1 * MASS * GRAVITY, "backward_friction": 0.3 * MASS * GRAVITY}  # N, at the first of SCALES
SCALES = (1.0, 0.5, 0.25, 0.125)  # of the friction
SINES = (0.02, 0.05, 0.098, 0.102, 0.12)  # of the pipe's slope
FORCED = (0.05, 0.1, 0.15, 0.25, 0.3)
TURNS = (BACKWARD - FORWARD) / (2.0 * (BODY + INNER) * GRAVITY)  # sine of the slope at which a robot of the defaults turns back
FROM_REST, SLOW = (4.0, 1.0, 0.25), 3.0  # of the friction; end of the slow time F+ t / (M b)
PRESCRIBED = ("prescribed_motion", "route")
SEEN = 200  # samples a period


def scenes() -> dict[str, Scene]:
    """Every run by its name."""
    shown = ("position", "velocity", "inner_position", "inner_velocity", "friction_force", "mode", "exciter_power", "dissipation")
    return {
        "weak friction": side_by_side(NAME, "Prescribed motion, weak friction", {_name(s): _weak(s) for s in SCALES},
                                      TURN / FREQUENCY, 1000, effects=PRESCRIBED),
        "slope": side_by_side(NAME, "Prescribed motion on slopes", {_name(s): _weak(1.0, s) for s in SINES},
                              TURN / FREQUENCY, 200, effects=PRESCRIBED),
        "from rest": _from_rest(),
        "force": side_by_side(NAME, "Harmonic force", _forced(), TURN / 60.0, 150),
        "two robots": side_by_side(NAME, "Pipe robots with a force of 20 N and of 1.5 N", {
            "strong": shaken(20.0), "weak": shaken(1.5)}, TURN / 60.0 / SEEN, 30 * SEEN, signals=shown),
    }  # fmt: skip


def measure(runs: Runs) -> Evidence:
    """Mean speeds over whole periods of robots side by side, and how they approach their limits."""
    measured = _prescribed(runs) | _by_force(runs)
    distances = _distances(runs["from rest"])
    measured["averaging order"] = _slope(FROM_REST, distances)
    per_scale = 0.1 * GRAVITY / (AMPLITUDE * FREQUENCY**2)
    limit, fine, sines = B * math.cos(0.25 * math.pi), np.geomspace(min(SCALES), max(SCALES), 40), np.linspace(0.0, 0.13, 60)
    at_slopes = {0.0: measured["force.level"], TURNS: measured["force.turns"], **{s: measured[f"force.{s:g}"] for s in FORCED}}
    drawn = {
        "exact": {"exact": (per_scale * fine, [limit - _exact(s) for s in fine])},
        "runs": {"runs": ([per_scale * s for s in SCALES], [limit - measured[f"weak.{s:g}"] for s in SCALES])},
        "distances": {"runs": ([per_scale * s for s in FROM_REST], distances)},
        "slopes": {"exact": (sines, [_exact(1.0, s) for s in sines])},
        "forced": {"runs": tuple(zip(*sorted(at_slopes.items()), strict=True))},
        "turning": ((TURNS, "turns back"),),
    }
    return Evidence(measured, data=drawn)


def exact_speed(forward: float, backward: float, weight: float = 0.0) -> float:
    """Mean speed of the periodic motion without rest, m/s; weight: down the pipe, N.

    The mean momentum over the mass is a line down while the body goes forwards, for p of the period, and one up while it goes
    backwards; forces balance if p = (F- - G) / (F+ + F-), and the body turns where b cos(w t) and the lines add up to zero.
    """
    p = (backward - weight) / (forward + backward)
    d = (forward + weight) * math.pi * p / (MASS * B * FREQUENCY * math.sin(math.pi * p))
    return -B * math.cos(math.pi * p) * math.sqrt(1.0 - d * d)


def _exact(scale: float, sine: float = 0.0) -> float:
    return exact_speed(scale * WEAK["forward_friction"], scale * WEAK["backward_friction"], MASS * GRAVITY * sine)


def _weak(scale: float, sine: float = 0.0) -> dict[str, float]:
    levels = {n: scale * v for n, v in WEAK.items()}
    start = _exact(scale, sine) - B
    return {"body_mass": 0.5 * MASS, "inner_mass": 0.5 * MASS, "prescribed_motion.amplitude": AMPLITUDE,
            "prescribed_motion.frequency": FREQUENCY, "start_velocity": start, "route.slope": math.asin(sine),
            **levels}  # fmt: skip


def _name(value: float) -> str:
    return f"r{value:g}".replace(".", "_")


def _from_rest() -> Scene:
    """The mean velocity, that of the mean momentum, starts at zero."""
    robots = {_name(s): {**_weak(s), "start_velocity": -B} for s in FROM_REST}
    longest = SLOW * B / (WEAK["forward_friction"] * min(FROM_REST) / MASS)
    step = TURN / FREQUENCY / 40.0
    return side_by_side(NAME, "Prescribed motion from rest", robots, step, math.ceil(longest / step), effects=PRESCRIBED,
                        signals=("velocity",))  # fmt: skip


def _distances(result: Result) -> list[float]:
    """Largest distance of the mean velocity from that of the averaged equation, over b, for every friction of FROM_REST.

    b w' = (1 + F- / F+) acos(w) / pi - 1 over the slow time, w over b: forces in the mean over a period of b cos(w t) + w.
    """
    ratio = WEAK["backward_friction"] / WEAK["forward_friction"]
    averaged = solve_ivp(lambda s, w: (1.0 + ratio) * np.arccos(w) / np.pi - 1.0, (0.0, SLOW), [0.0], rtol=1e-10, atol=1e-12,
                         dense_output=True).sol  # fmt: skip
    distances = []
    for scale in FROM_REST:
        slow = WEAK["forward_friction"] * scale / MASS / B * result.time
        kept = slow <= SLOW
        velocity = result[f"{_name(scale)}.velocity"] + B * np.cos(FREQUENCY * result.time)
        distances.append(float(np.abs(velocity[kept] / B - averaged(slow[kept])[0]).max()))
    return distances


def _slope(scales: tuple[float, ...], sizes: list[float]) -> float:
    return float(np.polyfit(np.log(scales), np.log(sizes), 1)[0])


def _forced() -> dict[str, dict[str, float]]:
    robots = {"level": shaken(20.0), "weak": shaken(1.5), "turns": shaken(20.0, route__slope=math.asin(TURNS)),
              "stronger": shaken(40.0, route__slope=math.asin(TURNS)), "towing": shaken(20.0, tow__force=-1.0)}  # fmt: skip
    return robots | {_name(s): shaken(20.0, route__slope=math.asin(s)) for s in FORCED}


def _prescribed(runs: Mapping[str, Result]) -> dict[str, float]:
    speeds = [last_speed(runs["weak friction"], _name(s), 100) for s in SCALES]
    measured = {f"weak.{s:g}": v for s, v in zip(SCALES, speeds, strict=True)}
    measured["limit"] = speeds[-1] + (speeds[-1] - speeds[-2]) / 3.0  # Richardson, second order
    limit = B * math.cos(0.25 * math.pi)
    measured["order"] = _slope(SCALES, [limit - v for v in speeds])
    on_slopes = {s: last_speed(runs["slope"], _name(s), 50) for s in SINES}
    measured |= {f"slope.{s:g}": v for s, v in on_slopes.items()}
    low, high = 0.098, 0.102
    measured["turns"] = low + (high - low) * on_slopes[low] / (on_slopes[low] - on_slopes[high])
    return measured


def _by_force(runs: Mapping[str, Result]) -> dict[str, float]:
    measured = {f"force.{n}": last_speed(runs["force"], n) for n in ("level", "weak", "turns", "stronger", "towing")}
    measured |= {f"force.{s:g}": last_speed(runs["force"], _name(s)) for s in FORCED}
    late = slice(-10 * SEEN, None)
    modes = np.round(runs["two robots"]["weak.mode"][late])
    measured |= {"rest": float(np.mean(modes == 0.0)), "backwards": float(np.mean(modes < 0.0))}
    strong = np.round(runs["two robots"]["strong.mode"][late])
    measured["switches"] = float(np.count_nonzero(np.diff(strong))) / 10.0
    return measured
