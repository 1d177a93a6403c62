"""Varying compliance of a ball bearing: statics, resonances over speed, repetition over clearance, and the tolerance trap."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from .....components.bearings.ball_bearing import BallBearing, TwoDofBearing
from .....components.bearings.dimensionless import dimensionless
from .....components.bearings.two_dof import bearing_derivatives
from ....harness.analysis.sections import stroboscopic_points
from ....harness.validation import Evidence, Runs

RPM = 2.0 * math.pi / 60.0
MICRO = 1e-6
SPEEDS = tuple(range(500, 6501, 250))  # rpm
GAPS = np.linspace(0.0, 30e-6, 61)  # m
PERIODS = {1000.0: 200, 3000.0: 500}  # rpm -> passages of a ball in which a disturbance decays below 1e-7
PASSAGES = 60  # seen, of a ball
TRANSIENT, SEEN, SAMPLE = 2.0, 1.0, 1e-4  # s; disturbances decay with exp(-5 t)
END = 0.1  # s
ABSOLUTE = 1e-6  # default absolute tolerance of SciPy's solvers
TOLERANCES = tuple(10.0**-k for k in range(3, 11))


def bearing(clearance: float, rpm: float, start_cage_angle: float = 0.0) -> BallBearing:
    """The JIS 6306 set, initialized; clearance: radial, m."""
    parameters = {"clearance.radial_clearance": clearance, "start_cage_angle": start_cage_angle, "speed": rpm * RPM}
    model = BallBearing(["clearance"], parameters, preset="JIS 6306")
    model.initialize(0.0)
    return model


def measure(runs: Runs) -> Evidence:
    """The numbers are those of components that are stepped alone."""
    swept = {gap: np.array([peak_to_peak(gap * MICRO, v) for v in SPEEDS]) for gap in (0, 1)}
    drawn: dict[str, Any] = {"speeds": SPEEDS}
    for axis, name in enumerate(("along", "across")):
        drawn[name] = {f"{gap} µm": rows[:, axis] / MICRO for gap, rows in swept.items()}
    for rpm in PERIODS:
        points = [passages(gap, rpm) / MICRO for gap in GAPS]
        drawn[f"{rpm:g}"] = {f"{rpm:g} rpm": (np.repeat(GAPS / MICRO, PASSAGES), np.concatenate(points))}
    return Evidence(_measured(swept), data={**drawn, **_trap()})


def peak_to_peak(clearance: float, rpm: float) -> tuple[float, float]:
    """Range of the motion along and across the load after the transient, m."""
    model = bearing(clearance, rpm)
    model.step(0.0, TRANSIENT)
    at = model.output_positions(("displacement_x", "displacement_y"))
    rows = []
    for k in range(round(SEEN / SAMPLE)):
        model.step(TRANSIENT + k * SAMPLE, SAMPLE)
        rows.append(model.y[at])
    return tuple(np.ptp(rows, axis=0))


def ball_passage(model: BallBearing) -> float:
    """Time between two balls at one place, s."""
    return 1.0 / model.geometry.defect_frequencies(model["speed"] / (2.0 * math.pi))["outer"]


def off_lines(clearance: float, rpm: float) -> float:
    """Share of the amplitude of the motion across the load that is no multiple of the ball-pass frequency, %."""
    model, passages, samples = bearing(clearance, rpm), 50, 64
    h = ball_passage(model) / samples
    model.step(0.0, 4.0)
    y = []
    for k in range(passages * samples):
        model.step(4.0 + k * h, h)
        y.append(model["displacement_y"])
    power = np.abs(np.fft.rfft(y)[1:]) ** 2
    return 100.0 * math.sqrt(1.0 - power[passages - 1 :: passages].sum() / power.sum())


def _measured(swept: dict[int, np.ndarray]) -> dict[str, float]:
    at = {(gap, v): row / MICRO for gap, rows in swept.items() for v, row in zip(SPEEDS, rows, strict=True)}
    measured = {
        "static.on": bearing(0.0, 0.0)["displacement_x"] / MICRO,
        "static.between": bearing(0.0, 0.0, math.pi / 8.0)["displacement_x"] / MICRO,
        "speed.x": float(SPEEDS[int(np.argmax(swept[0][:, 0]))]),
        "speed.y": float(SPEEDS[int(np.argmax(swept[0][:, 1]))]),
        "0.y.4750": at[0, 4750][1],
        "0.x.6000": at[0, 6000][0],
        "1.y.greatest": max(at[1, v][1] for v in SPEEDS),
        "off.lines": off_lines(2.0 * MICRO, 1000.0),
    }
    return measured | {f"{gap}.y.1000": peak_to_peak(gap * MICRO, 1000.0)[1] / MICRO for gap in (5, 15)}


def passages(clearance: float, rpm: float) -> np.ndarray:
    """Position across the load, (PASSAGES,) m, once for every ball that passes; clearance: radial, m."""
    model = bearing(clearance, rpm)
    return stroboscopic_points(model, ball_passage(model), PASSAGES, ("displacement_y",), transient=PERIODS[rpm])[:, 0]


def _trap() -> dict[str, Any]:
    """What SciPy's LSODA makes of one motion in two forms, its absolute tolerance being the default."""
    metres = bearing(20.0 * MICRO, 3000.0)
    other, by = dimensionless(metres)
    other.initialize(0.0)
    exact = _solved(other, END / by.time, method="DOP853", rtol=1e-12, atol=1e-12)
    swing = np.ptp(exact, axis=1).max()

    def errors(model: TwoDofBearing, end: float, unit: float) -> list[float]:
        return [float(np.abs(_solved(model, end, method="LSODA", rtol=r) / unit - exact).max() / swing) for r in TOLERANCES]

    forms = {"in metres": errors(metres, END, by.length), "dimensionless": errors(other, END / by.time, 1.0)}
    return {
        "asked": np.log10(TOLERANCES),
        "forms": forms,
        "swing": swing * by.length / MICRO,
        "share": swing * by.length / ABSOLUTE,
    }


def _solved(model: TwoDofBearing, end: float, **options: Any) -> np.ndarray:
    """Displacements by SciPy on a fixed grid of times, (2, 400)."""
    dx = np.empty(model.x.size)

    def right_hand_side(t: float, x: np.ndarray) -> np.ndarray:
        bearing_derivatives(t, x, model.u[0], dx, *model.arguments)
        return dx.copy()

    return solve_ivp(right_hand_side, (0.0, end), model.x, t_eval=np.linspace(0.0, end, 400), **options).y[:2]
