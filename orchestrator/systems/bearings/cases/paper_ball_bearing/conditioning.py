"""What the dimensionless form cures: magnitudes, conditioning, step control and short numbers; and what it does not."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from ......components.bearings.ball_bearing import BallBearing, TwoDofBearing
from ......components.bearings.dimensionless import DimensionlessBallBearing, Scales, dimensionless, scales
from ......components.bearings.two_dof import bearing_derivatives, elastic_force, fill_gaps
from .....harness.validation import Evidence, Runs

RPM = 2.0 * math.pi / 60.0
SPEED = 3000.0 * RPM
LENGTH, TIME = 2.0**-18, 2.0**-10  # m, s: units whose change is exact in binary numbers
SPAN, SAMPLES = 0.05, 400  # s, of the solvers' runs
SAME_STEPS, STEP = 0.1, 5e-5  # s
SHORT = 0.02  # s, of the runs with short numbers
SOLVERS = ("RK45", "LSODA", "Radau", "BDF")
PUSH = 0.94e-6  # m: the shaft swings by some 1.9 um
GAP, WIDE = 0.5e-6, 20e-6  # m, radial
DEFAULT = 1e-6  # absolute tolerance of SciPy's solvers


def bearing(clearance: float) -> BallBearing:
    """The JIS 6306 set, initialized, and pushed from its equilibrium along the load; clearance: radial, m."""
    model = BallBearing(["clearance"], {"clearance.radial_clearance": clearance, "speed": SPEED}, preset="JIS 6306")
    model.initialize(0.0)
    model.x[0] += PUSH
    return model


def scaled_form(metres: BallBearing) -> tuple[DimensionlessBallBearing, Scales]:
    """The same in dimensionless form, in the same place, and the scales."""
    other, by = dimensionless(metres)
    other.initialize(0.0)
    other.x[0] += PUSH / by.length
    return other, by


def measure(runs: Runs) -> Evidence:
    """One motion in metres, in binary units, and dimensionless: at the same steps, by solvers, and in short numbers."""
    measured = {"binary": binary_units(), "same": same_steps()}
    for gap in (0.0, 2.0):
        one, other = conditions(1e-6 * gap)
        measured |= {f"condition.{gap:g}": one, f"condition.{gap:g}.scaled": other, f"condition.{gap:g}.ratio": one / other}
    numbers = magnitudes()
    measured |= {"decades": _decades(numbers.values()), "decades.scaled": _decades(magnitudes(True).values())}
    tables = {gap: by_solvers(gap) for gap in (GAP, WIDE)}
    worse = [errors["metres"][0] / errors["dimensionless"][0] for errors in tables[GAP].values()]
    measured |= {"solvers.worse": float(sum(w >= 1.5 for w in worse)), "solvers.median": float(np.median(worse))}
    rk45 = tables[GAP]["RK45"]
    measured["calls"] = float(rk45["metres, tolerance scaled"][1] - rk45["dimensionless"][1])
    measured["wide"] = tables[WIDE]["RK45"]["metres"][0] / tables[WIDE]["RK45"]["dimensionless"][0]
    for kind, name in ((np.float32, "float32"), (np.float16, "float16")):
        for form, scaled in (("metres", False), ("dimensionless", True)):
            measured[f"{name}.{form}"] = 100.0 * short_numbers(kind, scaled)
    measured["float16.failed"] = float(not math.isfinite(measured["float16.metres"]))
    units, by_scale = ("m", "m/s", "N/m^1.5", "N.s/m", "kg", "N"), magnitudes(True)
    sizes = [
        (f"{name}, {unit}", float(f"{v:.3g}"), float(f"{by_scale[name]:.3g}"))
        for (name, v), unit in zip(numbers.items(), units, strict=True)
    ]
    by_form = {form: [100.0 * tables[GAP][s][form][0] for s in SOLVERS] for form in rk45}
    return Evidence(measured, data={"sizes": sizes, "solvers": SOLVERS, "forms": by_form})


def binary_units() -> float:
    """Largest difference, m, of a trajectory in metres and seconds and the same in binary units."""
    one = bearing(WIDE)
    p: dict[str, Any] = one.parameters
    other = BallBearing(["clearance"], p | {
        "clearance.radial_clearance": WIDE / LENGTH, "contact_stiffness": p["contact_stiffness"] * math.sqrt(LENGTH) * TIME**2,
        "damping": p["damping"] * TIME, "substep": p["substep"] / TIME})  # fmt: skip
    other.set("speed", SPEED * TIME)
    other.set("load", one["load"] * TIME**2 / LENGTH)
    other.initialize(0.0)
    other.x[0] = one.x[0] / LENGTH
    largest = 0.0
    for k in range(round(SAME_STEPS / 1e-3)):
        one.step(k * 1e-3, 1e-3)
        other.step(k * 1e-3 / TIME, 1e-3 / TIME)
        largest = max(largest, float(np.abs(one.x[:2] - other.x[:2] * LENGTH).max()))
    return largest


def same_steps() -> float:
    """Largest difference of the dimensional and the dimensionless component over the swing, at the same steps."""
    one = bearing(2e-6)
    other, by = scaled_form(one)
    rows = []
    for k in range(round(SAME_STEPS / 1e-3)):
        one.step(k * 1e-3, 1e-3)
        other.step(k * 1e-3 / by.time, 1e-3 / by.time)
        rows.append([*one.x[:2], *(other.x[:2] * by.length)])
    away = np.array(rows)
    return float(np.abs(away[:, :2] - away[:, 2:]).max() / np.ptp(away[:, :2], axis=0).max())


def jacobian(model: TwoDofBearing) -> np.ndarray:
    """Derivative of the rates of (x, y, x', y') by them in equilibrium, (4, 4)."""
    model.initialize(0.0)
    s, _, e = model.arguments
    k = s.constants
    fill_gaps(model.x, 0.0, k, s.balls, s.inner_waves, s.outer_waves, e)
    _, _, kxx, kxy, kyy = elastic_force(model.x, s)
    K = np.array([[kxx, kxy], [kxy, kyy]]) / k.mass
    return np.block([[np.zeros((2, 2)), np.eye(2)], [-K, -k.damping / k.mass * np.eye(2)]])


def conditions(clearance: float) -> tuple[float, float]:
    """2-norm condition of the Jacobian in equilibrium, in metres and seconds and dimensionless; clearance: radial, m."""
    one = bearing(clearance)
    other, _ = scaled_form(one)
    return float(np.linalg.cond(jacobian(one))), float(np.linalg.cond(jacobian(other)))


def magnitudes(scaled: bool = False) -> dict[str, float]:
    """Numbers of the equations: those of the set, and the scales of the motion."""
    model = bearing(GAP)
    by = scales(model)
    p: dict[str, Any] = model.parameters
    numbers = {
        "deflection": by.length,
        "velocity": by.of("m/s"),
        "stiffness": p["contact_stiffness"],
        "damping": p["damping"],
        "mass": p["mass"],
        "load": model["load"],
    }
    if not scaled:
        return numbers
    return {**dict.fromkeys(numbers, 1.0), "damping": p["damping"] / by.of("N.s/m")}


def _decades(numbers: Any) -> float:
    return float(np.ptp(np.log10([abs(v) for v in numbers])))


def solved(model: TwoDofBearing, end: float, **options: Any) -> tuple[np.ndarray, int]:
    """Displacements by SciPy on a grid of times, (2, n), and calls of the equations; angles are functions of time."""
    full, dx = model.x.copy(), np.empty(model.x.size)
    speed, start, ratio = model["speed"], model.x[5], model.arguments[0].constants.cage_ratio

    def rates(t: float, x: np.ndarray) -> np.ndarray:
        full[:4], full[4], full[5] = x, speed * t, start + ratio * speed * t
        bearing_derivatives(t, full, model.u[0], dx, *model.arguments)
        return dx[:4].copy()

    solution = solve_ivp(rates, (0.0, end), model.x[:4], t_eval=np.linspace(0.0, end, SAMPLES), **options)
    return solution.y[:2], int(solution.nfev)


def by_solvers(clearance: float) -> dict[str, dict[str, tuple[float, int]]]:
    """(error over the swing, calls) of each solver with SciPy's default tolerances in three forms."""
    metres = bearing(clearance)
    other, by = scaled_form(metres)
    exact, _ = solved(other, SPAN / by.time, method="DOP853", rtol=1e-12, atol=1e-12)
    swing = float(np.ptp(exact, axis=1).max())
    scaled = DEFAULT * np.repeat([by.length, by.of("m/s")], 2)
    table: dict[str, dict[str, tuple[float, int]]] = {}
    for method in SOLVERS:
        runs = {
            "metres": solved(metres, SPAN, method=method),
            "dimensionless": solved(other, SPAN / by.time, method=method),
            "metres, tolerance scaled": solved(metres, SPAN, method=method, atol=scaled),
        }
        table[method] = {
            form: (float(np.abs(x / (1.0 if form == "dimensionless" else by.length) - exact).max() / swing), calls)
            for form, (x, calls) in runs.items()
        }
    return table


def short_numbers(kind: type, scaled: bool) -> float:
    """Error over the swing of classical Runge-Kutta steps in numbers of a short type, against those in double."""
    ends = [classical(k, scaled) for k in (kind, np.float64)]
    swing = float(np.ptp(ends[1], axis=0).max())
    return float(np.abs(ends[0].astype(float) - ends[1]).max() / swing) if np.isfinite(ends[0]).all() else math.inf


def classical(kind: type, scaled: bool) -> np.ndarray:
    """Displacements at the ends of steps, (n, 2), of equations written out here, all numbers of one type."""
    metres = bearing(GAP)
    by = scales(metres)
    p: dict[str, Any] = metres.parameters
    length, time = (by.length, by.time) if scaled else (1.0, 1.0)
    stiffness, mass = (1.0, 1.0) if scaled else (p["contact_stiffness"], p["mass"])
    damping = p["damping"] / (by.of("N.s/m") if scaled else 1.0)
    load = 1.0 if scaled else metres["load"]
    with np.errstate(over="ignore"):
        k, m, c, w, gap, h = (kind(v) for v in (stiffness, mass, damping, load, GAP / length, STEP / time))
    turn, at = metres.geometry.cage_ratio * SPEED * time, 2.0 * math.pi * np.arange(p["balls"]) / p["balls"]

    def rates(t: float, x: np.ndarray) -> np.ndarray:
        angle = at + turn * t  # in double: the angle is given, and no part of what is asked
        cosine, sine = np.cos(angle).astype(kind), np.sin(angle).astype(kind)
        delta = np.maximum(x[0] * cosine + x[1] * sine - gap, kind(0.0))
        each = k * delta * np.sqrt(delta)
        along, across = (each * cosine).sum(), (each * sine).sum()
        return np.array([x[2], x[3], (w - c * x[2] - along) / m, (-c * x[3] - across) / m], dtype=kind)

    x = (metres.x[:4] / np.array([length, length, length / time, length / time])).astype(kind)
    rows, half, sixth = [], kind(0.5), kind(1.0 / 6.0)
    with np.errstate(all="ignore"):
        for n in range(round(SHORT / STEP)):
            t, d = n * float(STEP / time), float(STEP / time)
            a = rates(t, x)
            b = rates(t + 0.5 * d, x + half * h * a)
            e = rates(t + 0.5 * d, x + half * h * b)
            f = rates(t + d, x + h * e)
            x = x + h * sixth * (a + kind(2.0) * b + kind(2.0) * e + f)
            rows.append(x[:2].copy())
    return np.array(rows)
