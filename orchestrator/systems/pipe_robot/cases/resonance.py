"""Resonance of a pipe robot: response without friction and with a body that sticks, mean speed, and a motor caught there."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ....harness.validation import Evidence, Runs
from ....run.results import Result
from ....scene.build import unit
from ....scene.scene import Scene
from ... import build_scene, load_scene
from ..robots import BODY, DAMPING, FREE, INNER, STIFFNESS, STUCK, TURN, component_at, last_speed, shaken, side_by_side

NAME = "pipe-robot-resonance"
FREQUENCIES = (30.0, 40.0, 50.0, 60.0, 70.0, 77.46, 85.0, 95.0, 110.0, 130.0)  # rad/s
NEAR = (74.0, 76.0, 78.0)  # rad/s, for the largest amplitude of the free robot
REDUCED = BODY * INNER / (BODY + INNER)  # kg
QUIET = 0.3  # N: below the threshold of motion at every frequency
PERIODS, SEEN = 120, 8
FRICTIONLESS: dict[str, Any] = {"forward_friction": 0.0, "backward_friction": 0.0}
# motor-driven unbalance: kg m, kg m², and the motor's Ohm, N.m/A; V
UNBALANCE, INERTIA, BEARING, RESISTANCE, CONSTANT = 0.1 * 0.02, 1e-3 + 0.1 * 0.02**2, 1e-5, 8.0, 0.1
VOLTAGES = (12.0, 14.4, 15.0, 16.0)
SETTLED, MEAN = 40.0, 10.0  # s, of a start; of the mean of a speed at its end
STEP = 2e-3  # s


def scenes() -> dict[str, Scene]:
    """Every run by its name."""
    steady = {f"{w:g} rad/s": _at(w) for w in (*FREQUENCIES, *NEAR, STUCK)}
    return {**steady, "motors": _motors(), "motor start": load_scene("pipe-robot-motor-start")}


def measure(runs: Runs) -> Evidence:
    """Amplitudes at steady frequencies, mean speeds, and where motors of several voltages end up."""
    measured: dict[str, float] = {}
    for w in (*FREQUENCIES, *NEAR, STUCK):
        measured |= _response(runs[f"{w:g} rad/s"], w)
    # 1 / amplitude² is a parabola in w²
    squares, inverse = [w * w for w in NEAR], [measured[f"free.{w:g}"] ** -2 for w in NEAR]
    bend, slope, _ = np.polyfit(squares, inverse, 2)
    measured["peak"] = math.sqrt(-slope / (2.0 * bend))
    measured |= {f"motor.{v:g}": _mean_rate(runs["motors"], f"robot_{_name(v)}") for v in VOLTAGES}
    measured |= {f"mean.{v:g}": measured[f"motor.{v:g}"] for v in VOLTAGES}
    start = runs["motor start"]
    late = start.time >= 0.5 * start.time[-1]
    measured |= {f"start.{n}": float(start[f"{n}.unbalance.rate"][late].mean()) for n in ("caught", "passing")}
    speeds = {f"{n}.speed": float(np.ptp(start[f"{n}.position"][late]) / np.ptp(start.time[late])) for n in ("caught", "passing")}
    fine, rates, at = np.linspace(25.0, 135.0, 400), np.linspace(50.0, 160.0, 600), (*FREQUENCIES, *NEAR)
    drawn = {
        "frequency": fine,
        "closed.free": 1e3 * _amplitude(fine),
        "closed.stuck": QUIET * 1e3 / np.abs(STIFFNESS - INNER * fine * fine + 1j * DAMPING * fine),
        "at": at,
        **{f"runs.{n}": [1e3 * measured[f"{n}.{v:g}"] for v in at] for n in ("free", "stuck")},
        "frequencies": FREQUENCIES,
        "speeds": [measured[f"speed.{v:g}"] for v in FREQUENCIES],
        "resonances": ((FREE, "free"), (STUCK, "stuck")),
        "steady": {"steady speeds": (rates, _voltage(rates))},
        "barrier": _voltage(np.linspace(70.0, 85.0, 3001)).max(),
    }
    return Evidence(measured, data={**drawn, **speeds})


def _name(value: float) -> str:
    return f"{value:g}".replace(".", "_")


def _at(frequency: float) -> Scene:
    """Robots without friction, with a body that stays at rest, and with the friction of the defaults."""
    robots = {"free": shaken(20.0, frequency, **FRICTIONLESS), "stuck": shaken(QUIET, frequency),
              "rubbing": shaken(20.0, frequency)}  # fmt: skip
    return side_by_side(NAME, f"Force of {frequency:g} rad/s", robots, TURN / frequency / SEEN, PERIODS * SEEN,
                        signals=("position", "velocity", "inner_position"))  # fmt: skip


def _response(result: Result, frequency: float) -> dict[str, float]:
    measured = {"speed": last_speed(result, "rubbing", SEEN)}
    last = slice(-1 - SEEN, -1)
    for name in ("free", "stuck"):
        stretch = result[f"{name}.inner_position"] - result[f"{name}.position"]
        measured[name] = abs(component_at(result.time[last], stretch[last], frequency))
    measured["rest"] = float(np.ptp(result["stuck.position"]))
    return {f"{n}.{frequency:g}": v for n, v in measured.items()}


def _motors() -> Scene:
    """Frictionless robots, whose unbalances motors of several voltages start."""
    units, connections = {}, []
    for v in VOLTAGES:
        robot, motor = f"robot_{_name(v)}", f"motor_{_name(v)}"
        units[robot] = unit("PipeRobot", effects=["unbalance"], unbalance={"inertia": 1e-3}, **FRICTIONLESS)
        units[motor] = unit("TorqueMotor", resistance=RESISTANCE, constant=CONSTANT, voltage=v)
        connections += [f"{robot}.unbalance.rate -> {motor}.rate", f"{motor}.torque -> {robot}.unbalance.torque"]
    record = {"interval": 0.1, "signals": [f"robot_{_name(v)}.unbalance.{n}" for v in VOLTAGES for n in ("rate", "angle")]}
    title = "Motors of several voltages"
    return build_scene(units, connections, stop_time=SETTLED, step=STEP, name=NAME, title=title, record=record)


def _mean_rate(result: Result, unit: str) -> float:
    first = int(np.searchsorted(result.time, SETTLED - MEAN - 1e-9))
    angle = result[f"{unit}.unbalance.angle"]
    return float((angle[-1] - angle[first]) / (result.time[-1] - result.time[first]))


def _amplitude(w: np.ndarray) -> np.ndarray:
    """Of the spring's stretch, without friction, under the force of 20 N, m."""
    return 20.0 / np.abs(STIFFNESS - REDUCED * w * w + 1j * DAMPING * w)


def _voltage(w: np.ndarray) -> np.ndarray:
    """Voltage that holds the unbalance at a speed, in the mean over a turn, V: damper and bearing take what the motor gives."""
    stretch = UNBALANCE * w * w * REDUCED / INNER / np.abs(STIFFNESS - REDUCED * w * w + 1j * DAMPING * w)
    torque = BEARING * w + 0.5 * DAMPING * w * stretch**2
    return CONSTANT * w + RESISTANCE / CONSTANT * torque
