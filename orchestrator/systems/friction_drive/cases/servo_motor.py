"""Servo motor against closed forms: poles, step response, no load, load, stall, energies, dry friction that stops the shaft."""

from __future__ import annotations

import numpy as np

from ....harness.analysis.signals import accumulated
from ....harness.charts.chart import Chart, Panel, Series
from ....harness.validation.case import Case, Findings, Options, compare
from ....harness.validation.reference import load_table
from ....results import Result
from ....run import run
from ....scene.scene import Scene
from ... import read_scene

VOLTAGE = 12.0
GEAR, RESISTANCE, CONSTANT = 19.0, 2.3, 23.4e-3
BARE = {"component": "ServoMotor", "preset": "motor alone"}
STEP = 1e-4  # s
LOAD = 0.02  # N.m at the shaft of the bare motor
READ = {"rate": (1e-3, 5e-3, 2e-2), "current": (2e-4, 1e-3, 5e-3)}  # s


def scene() -> Scene:
    """Motors side by side, let go at 12 V with the current of standstill; but those that run out, and that friction holds."""
    fine = {"substep": 1e-5, "voltage": VOLTAGE, "inductance.start_current": VOLTAGE / RESISTANCE}
    shaft = {"effects": ["shaft_friction"]}
    units = {
        "bare": {**BARE, "parameters": fine},
        "free": {**BARE, "parameters": {**fine, "damping": 0.0}},
        "loaded": {**BARE, "parameters": {**fine, "damping": 0.0, "load_torque": LOAD}},
        "stalled": {**BARE, "parameters": {**fine, "damping": 0.0, "load_torque": CONSTANT * VOLTAGE / RESISTANCE}},
        "geared": {"component": "ServoMotor", "parameters": {"voltage": VOLTAGE, "damping": 0.0, "substep": 1e-5}},
        "running_out": {"component": "ServoMotor", **shaft, "parameters": {"constant": 0.0, "damping": 0.0, "start_rate": 10.0}},
        "held": {"component": "ServoMotor", **shaft, "parameters": {"voltage": 0.999 * _breakaway()}},
        "breaking_loose": {"component": "ServoMotor", **shaft, "parameters": {"voltage": 1.001 * _breakaway()}},
    }
    data = {"title": "Servo motors", "stop_time": 0.5, "units": units, "master": {"step": STEP}}
    return read_scene(data, "servo-motor")


def _breakaway() -> float:
    """Voltage whose torque, less the gear's fifth, is the static friction of 0.015 N.m at the wheel."""
    return RESISTANCE * 0.015 / (0.8 * GEAR * CONSTANT)


def poles(result: Result) -> np.ndarray:
    """Of the bare motor, 1/s, the slower first: what multiplies (rate, current) less their last from one sample to the next."""
    n = round(5e-3 / STEP)  # while the fast one still counts
    z = np.array([result[f"bare.{name}"][:n] - result[f"bare.{name}"][-1] for name in ("rate", "current")])
    following = np.linalg.lstsq(z[:, :-1].T, z[:, 1:].T, rcond=None)[0]
    return np.sort(np.log(np.linalg.eigvals(following).real) / STEP)[::-1]


def findings(options: Options) -> Findings:
    """One run, a unit for each case."""
    result = run(scene(), in_process=options.in_process)
    if result.outcome != "done":
        return Findings((), {"motors": result}, notes=(result.message,), complete=False)
    slow, fast = poles(result)
    measured = {"pole.slow": float(slow), "pole.fast": float(fast)}
    for name, times in READ.items():
        measured |= {f"{name}.{1e3 * t:g}": float(np.interp(t, result.time, result[f"bare.{name}"])) for t in times}
    measured |= {f"rate.{name}": float(result[f"{name}.rate"][-1]) for name in ("free", "loaded", "stalled")}
    measured["current.stalled"] = float(result["stalled.current"][-1])
    current, power = result["geared.current"], result["geared.electrical_power"]
    heat = accumulated(result.time, RESISTANCE * current**2)[-1]
    measured["heat.share"] = float(heat / accumulated(result.time, power)[-1])
    standing = np.flatnonzero(result["running_out.shaft_friction.stuck"])
    measured["stop.time"] = float(result.time[standing[0]])
    measured["stop.angle"] = float(result["running_out.angle"][-1])
    measured["held.angle"] = float(np.abs(result["held.angle"]).max())
    measured["loose.angle"] = float(result["breaking_loose.angle"][-1])
    return Findings(compare(load_table("servo-motor").rows, measured), charts=(_chart(result),))


def _chart(result: Result) -> Chart:
    shown = result.time <= 0.03
    time = 1e3 * result.time[shown]
    rates = tuple(Series(n, time, result[f"{n}.rate"][shown]) for n in ("bare", "loaded"))
    currents = tuple(Series(n, time, result[f"{n}.current"][shown]) for n in ("bare", "loaded", "stalled"))
    return Chart("Let go at 12 V", "time, ms", (Panel("rate, rad/s", rates), Panel("current, A", currents)),
                 "The motor alone, without gear and wheel: free, under 0.02 N.m, and under the load that stalls it.")  # fmt: skip


CASE = Case(
    "servo-motor",
    "Servo motor against closed forms",
    "Poles and response of rate and current, steady rates without load and under load, stall, the share of heat in a run-up, "
    "dry friction that brings the shaft to rest and holds it. A check of equations and integration; a real motor's numbers are "
    "not in it.",
    "friction_drive",
    findings,
)
