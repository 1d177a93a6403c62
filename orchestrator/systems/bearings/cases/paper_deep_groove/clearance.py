"""Natural frequencies and level of vibration over the clearance: linearisation, free oscillations, and coupled runs."""

from __future__ import annotations

import math

import numpy as np

from .....harness.analysis.signals import amplitude_spectrum
from .....harness.analysis.spectra import peak
from .....harness.validation import Evidence, Runs
from .....run.results import Result
from .....scene.scene import Scene
from .shaft import BALL_PASS, BALLS, FREQUENCY, LENGTH, MASS, acceleration, over_a_pitch, scene, stiffness

TABLE = (-3.0, -1.0, -0.5, 0.0, 0.5, 1.0, 2.0, 3.0)
WIDE = (5.0, 10.0)  # two balls carry, whatever the clearance
FEWER = (7, 8)  # balls, without clearance
PITCH = 2.0 * math.pi / BALLS
NORMAL = (2.5e-6 / LENGTH, 10e-6 / LENGTH)  # radial, of the class CN of a bearing with a bore of 30 mm: 5 to 20 um diametral
RUNS = (-3.0, -1.0, -0.5, 0.0, 0.5, 1.0, 1.5, 2.0, 3.0, 5.0)
PASSES = 25.0  # Hz, of the balls: a fourth of the lower frequency at G = 3
STEP = 2e-5  # s
TRANSIENT, SEEN = 0.8, 0.4  # s; ten balls pass
RINGING = (0.0, 1.0, 3.0)
RING_DAMPING, RING_START, RING_END = 400.0, 0.6, 2.6  # N.s/m, s: by then the fall has become a small oscillation
OFF_LINE = 0.2 * PITCH  # angle of a ball from the load line at rest, so that both directions are excited


def scenes() -> dict[tuple[str, float], Scene]:
    """By clearance: the shaft that falls into the bearing at rest, and at a speed at which balls pass `PASSES` times a second."""
    return {("falling", g): falling(g) for g in RINGING} | {
        ("passing", g): scene(TRANSIENT + SEEN, STEP, PASSES / BALL_PASS, clearance=g) for g in RUNS
    }


def measure(runs: Runs) -> Evidence:
    """Linearisation over cage angle and clearance, its frequencies in free oscillation, vibration at a constant speed."""
    static = {g: over_a_pitch(g).mean(axis=0) for g in (*TABLE, *WIDE, *NORMAL)}
    measured: dict[str, float] = {}
    for g, (along, across) in static.items():
        measured |= {f"along.{g:g}": along, f"across.{g:g}": across}
    for balls in FEWER:
        along, across = over_a_pitch(0.0, balls).mean(axis=0)
        measured |= {f"along.{balls} balls": along, f"across.{balls} balls": across}
    measured |= _falls(static)
    for g in RINGING:
        expected, rung = ringing(g, runs["falling", g])
        measured[f"ringing.{g:g}"] = 100.0 * np.abs(rung / expected - 1.0).max()
    levels = {g: level(runs["passing", g]) for g in RUNS}
    measured |= {f"level.{g:g}": v for g, v in levels.items()}
    measured["level.ratio"] = levels[3.0] / levels[0.0]
    measured["level.preloaded"] = max(levels[g] for g in RUNS if g <= -0.5) / levels[0.0]
    gaps, moving = sorted(static), [g for g in RUNS if g >= 0.0]
    drawn = {
        "gaps": gaps,
        "curves": {n: [static[g][i] for g in gaps] for i, n in enumerate(("along the load", "across the load"))},
        "wide": WIDE,
        "two": {f"two balls, {n}": [v, v] for n, v in zip(("along", "across"), two_balls(BALLS), strict=True)},
        "moving": moving,
        "levels": [levels[g] for g in moving],
        "length": 1e6 * LENGTH,
        "frequency": FREQUENCY,
    }
    return Evidence(measured, data=drawn)


def _falls(static: dict[float, np.ndarray]) -> dict[str, float]:
    """By how much both frequencies fall, %, and the largest rise of the lower one from one clearance to the next."""

    def fall(first: float, last: float) -> np.ndarray:
        return 100.0 * (1.0 - static[last] / static[first])

    across = np.array([static[g][1] for g in TABLE])
    return {
        "fall.play.along": float(fall(0.0, 3.0)[0]),
        "fall.play.across": float(fall(0.0, 3.0)[1]),
        "fall.preload": float(fall(-1.0, 0.0).min()),
        "fall.normal": float(fall(*NORMAL)[1]),
        "rise.across": float(np.diff(across).max()),
    }


def falling(clearance: float) -> Scene:
    """The shaft that falls into the bearing at rest, little damped."""
    parameters = {"first_ball": OFF_LINE - 0.5 * math.pi}
    return scene(RING_END, STEP, 0.0, clearance=clearance, damping=RING_DAMPING, parameters=parameters)


def ringing(clearance: float, result: Result) -> tuple[np.ndarray, np.ndarray]:
    """Both natural frequencies of the linearisation, and of the shaft that fell into the bearing at rest and still oscillates.

    (2,) each, over f_0. The motion is seen along the linearisation's own directions, in which each frequency is alone.
    """
    squares, directions = np.linalg.eigh(stiffness(clearance, OFF_LINE) / MASS)
    kept = result.time >= RING_START
    away = np.stack([result[f"rotor.displacement_{axis}"][kept][1:] for axis in "xy"])
    lines = []
    for x in directions.T @ away:
        f, a = amplitude_spectrum(x, 1.0 / STEP)
        lines.append(peak(f, a, float(f[int(np.argmax(a))]), 3.0)[0])
    return np.sqrt(squares) / (2.0 * math.pi * FREQUENCY), np.array(lines) / FREQUENCY


def level(result: Result) -> float:
    """RMS acceleration in the bearing's plane after the transient, m/s2."""
    kept = result.time > TRANSIENT
    return math.sqrt(sum(float(np.var(acceleration(result, axis)[kept])) for axis in "xy"))


def two_balls(balls: int, angles: int = 2000) -> tuple[float, float]:
    """Frequencies along and across the load over f_0 of two neighbouring balls that carry it, mean over the cage angle.

    Closed form: their loads are sin(b)/sin(pitch) and sin(a)/sin(pitch) at angles a and b to both sides of the load.
    """
    pitch = 2.0 * math.pi / balls
    a = pitch * (np.arange(angles) + 0.5) / angles
    b = pitch - a
    stiffness = [1.5 * np.cbrt(np.sin(other) / math.sin(pitch)) for other in (b, a)]
    squares = (sum(k * f(at) ** 2 for k, at in zip(stiffness, (a, b), strict=True)) for f in (np.cos, np.sin))
    along, across = (float(np.sqrt(s).mean()) for s in squares)
    return along, across
