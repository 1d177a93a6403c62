"""The dimensionless groups: equal groups, equal motion; and how each of them acts on the response."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ......components.bearings.ball_bearing import BallBearing
from ......components.bearings.dimensionless import DimensionlessBallBearing, scales
from .....harness.analysis.lyapunov import lyapunov_spectrum
from .....harness.analysis.signals import amplitude_at, amplitude_spectrum
from .....harness.analysis.spectra import peak
from .....harness.validation import Evidence, Runs

BASE = {"balls": 8, "diameter_ratio": 11.9 / 52.0, "damping_ratio": 0.05}  # ten times the set's damping: transients die out
SPEED, GAP = 0.05, 0.3  # Om, G
STEP, SAMPLES, WAIT = 0.5, 8192, 400.0  # of tau
OTHER = {"mass": 3.0, "contact_stiffness": 5e9, "load": 57.0}  # a second bearing with the groups of the first
GAPS, BALLS, EXCENTRICITIES = (0.0, 1.0, 3.0), (7, 8, 9), (0.2, 0.4)
SMALL = 1e-3  # of x_s, a push whose oscillation is linear


def measure(runs: Runs) -> Evidence:
    """Pairs of dimensional bearings, and the dimensionless one with one group changed at a time."""
    measured = {"equal": equal_groups()}
    light, heavy = (free_oscillation(load) for load in (196.0, 392.0))
    measured |= {"load.deflection": heavy[0] / light[0], "load.frequency": heavy[1] / light[1]}
    lines = {}
    for balls in BALLS:
        model = response({"balls": balls}, {"clearance.radial_clearance": GAP}, ["clearance"])
        f, a = model
        expected = balls * 0.5 * (1.0 - BASE["diameter_ratio"]) * SPEED / (2.0 * math.pi)
        measured[f"line.{balls}"] = peak(f, a, expected, 0.2 * expected)[0] / expected
        lines[f"Z = {balls}"] = model
    unbalanced = [shaft_line(eps) for eps in EXCENTRICITIES]
    measured["eccentricity"] = unbalanced[1] / unbalanced[0]
    for zeta in (0.005, 0.02):
        measured[f"exponents.{zeta:g}"] = exponent_sum(zeta) / (-4.0 * zeta)
    curves = {f"G = {g:g}": response({}, {"clearance.radial_clearance": g}, ["clearance"]) for g in GAPS}
    return Evidence(measured, data={"balls": _drawn(lines), "clearances": _drawn(curves)})


def _drawn(curves: dict[str, tuple[np.ndarray, np.ndarray]]) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Responses over the speed of the shaft, up to twelve times it."""
    cut = {name: 2.0 * math.pi * f <= 12.0 * SPEED for name, (f, _) in curves.items()}
    return {n: (2.0 * math.pi * f[cut[n]] / SPEED, np.maximum(a[cut[n]], 1e-8)) for n, (f, a) in curves.items()}


def equal_groups() -> float:
    """Largest difference over the swing, in the scales, of two dimensional bearings with equal groups; periodic motion."""
    one = BallBearing(["clearance"], {"clearance.radial_clearance": 2e-6}, preset="JIS 6306")
    first = scales(one)
    p: dict[str, Any] = one.parameters
    length = (OTHER["load"] / OTHER["contact_stiffness"]) ** (2.0 / 3.0)
    time = math.sqrt(OTHER["mass"] / (OTHER["contact_stiffness"] * math.sqrt(length)))
    other = BallBearing(["clearance"], {
        "mass": OTHER["mass"], "contact_stiffness": OTHER["contact_stiffness"],
        "damping": p["damping"] * OTHER["mass"] / p["mass"] * first.time / time,
        "clearance.radial_clearance": 2e-6 * length / first.length, "substep": p["substep"] * time / first.time})  # fmt: skip
    other.set("load", OTHER["load"])
    other.set("speed", one["speed"] * first.time / time)
    rows = []
    for model in (one, other):
        model.initialize(0.0)
    for k in range(100):
        one.step(k * 1e-3, 1e-3)
        other.step(k * 1e-3 * time / first.time, 1e-3 * time / first.time)
        rows.append([*(one.x[:2] / first.length), *(other.x[:2] / length)])
    away = np.array(rows)
    return float(np.abs(away[:, :2] - away[:, 2:]).max() / np.ptp(away[:, :2], axis=0).max())


def free_oscillation(load: float) -> tuple[float, float]:
    """(deflection in m, frequency along the load in Hz) of the bearing at rest without clearance, load in N."""
    model = BallBearing(["clearance"], {"clearance.radial_clearance": 0.0, "speed": 0.0, "damping": 20.0}, preset="JIS 6306")
    model.set("load", load)
    model.initialize(0.0)
    deflection = float(model.x[0])
    model.x[0] *= 1.0 + SMALL
    h, x = 1e-4, []
    for k in range(SAMPLES):
        model.step(k * h, h)
        x.append(model.x[0])
    f, a = amplitude_spectrum(np.array(x), 1.0 / h)
    return deflection, peak(f, a, float(f[int(np.argmax(a))]), 5.0)[0]


def steady(parameters: dict[str, Any], given: dict[str, Any], effects: list[str]) -> np.ndarray:
    """Position across the load after the transient, (SAMPLES,), in the scales."""
    model = DimensionlessBallBearing(effects, {**BASE, **parameters, **given, "speed": SPEED})
    model.initialize(0.0)
    model.step(0.0, WAIT)
    y = []
    for k in range(SAMPLES):
        model.step(WAIT + k * STEP, STEP)
        y.append(model.x[1])
    return np.array(y)


def response(parameters: dict[str, Any], given: dict[str, Any], effects: list[str]) -> tuple[np.ndarray, np.ndarray]:
    """(frequency per unit of tau, amplitude) of the motion across the load."""
    return amplitude_spectrum(steady(parameters, given, effects), 1.0 / STEP)


def shaft_line(eccentricity: float) -> float:
    """Amplitude at the speed of the shaft with an unbalance; no clearance, so that small motion is linear."""
    y = steady({}, {"unbalance.eccentricity": eccentricity}, ["unbalance"])
    return amplitude_at(y, 1.0 / STEP, SPEED / (2.0 * math.pi))


def exponent_sum(zeta: float) -> float:
    """Sum of the Lyapunov exponents, per unit of tau."""
    model = DimensionlessBallBearing(
        ["clearance"], {**BASE, "damping_ratio": zeta, "speed": SPEED, "clearance.radial_clearance": GAP}
    )
    model.initialize(0.0)
    return lyapunov_spectrum(model, (0, 1, 2, 3), (1.0, 1.0, 1.0, 1.0), interval=5.0, intervals=150, transient=10).sum
