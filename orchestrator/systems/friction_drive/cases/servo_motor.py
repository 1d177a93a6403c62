"""Servo motor against closed forms: poles, step response, no load, load, stall, energies, dry friction that stops the shaft."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from ....harness.analysis.signals import accumulated
from ....harness.validation import Runs
from ....run.results import Result
from ....scene.build import unit
from ....scene.scene import Scene
from ... import build_scene

VOLTAGE = 12.0
GEAR, RESISTANCE, CONSTANT = 19.0, 2.3, 23.4e-3
STEP = 1e-4  # s
LOAD = 0.02  # N.m at the shaft of the bare motor
READ = {"rate": (1e-3, 5e-3, 2e-2), "current": (2e-4, 1e-3, 5e-3)}  # s


def scenes() -> dict[str, Scene]:
    """Motors side by side, let go at 12 V with the current of standstill; but those that run out, and that friction holds."""
    fine: dict[str, Any] = {"substep": 1e-5, "voltage": VOLTAGE, "inductance.start_current": VOLTAGE / RESISTANCE}
    bare = partial(unit, "ServoMotor", preset="motor alone", **fine)
    with_friction = partial(unit, "ServoMotor", effects=["shaft_friction"])
    units = {
        "bare": bare(),
        "free": bare(damping=0.0),
        "loaded": bare(damping=0.0, load_torque=LOAD),
        "stalled": bare(damping=0.0, load_torque=CONSTANT * VOLTAGE / RESISTANCE),
        "geared": unit("ServoMotor", voltage=VOLTAGE, damping=0.0, substep=1e-5),
        "running_out": with_friction(constant=0.0, damping=0.0, start_rate=10.0),
        "held": with_friction(voltage=0.999 * _breakaway()),
        "breaking_loose": with_friction(voltage=1.001 * _breakaway()),
    }
    return {"motors": build_scene(units, stop_time=0.5, step=STEP, name="servo-motor")}


def _breakaway() -> float:
    """Voltage whose torque, less the gear's fifth, is the static friction of 0.015 N.m at the wheel."""
    return RESISTANCE * 0.015 / (0.8 * GEAR * CONSTANT)


def poles(result: Result) -> np.ndarray:
    """Of the bare motor, 1/s, the slower first: what multiplies (rate, current) less their last from one sample to the next."""
    n = round(5e-3 / STEP)  # while the fast one still counts
    z = np.array([result[f"bare.{name}"][:n] - result[f"bare.{name}"][-1] for name in ("rate", "current")])
    following = np.linalg.lstsq(z[:, :-1].T, z[:, 1:].T, rcond=None)[0]
    return np.sort(np.log(np.linalg.eigvals(following).real) / STEP)[::-1]


def measure(runs: Runs) -> dict[str, float]:
    """A unit for each closed form."""
    result = runs["motors"]
    slow, fast = poles(result)
    heat = accumulated(result.time, RESISTANCE * result["geared.current"] ** 2)[-1]
    standing = np.flatnonzero(result["running_out.shaft_friction.stuck"])
    measured = {
        "pole.slow": slow,
        "pole.fast": fast,
        **{f"rate.{name}": result[f"{name}.rate"][-1] for name in ("free", "loaded", "stalled")},
        "current.stalled": result["stalled.current"][-1],
        "heat.share": heat / accumulated(result.time, result["geared.electrical_power"])[-1],
        "stop.time": result.time[standing[0]],
        "stop.angle": result["running_out.angle"][-1],
        "held.angle": np.abs(result["held.angle"]).max(),
        "loose.angle": result["breaking_loose.angle"][-1],
    }
    for name, times in READ.items():
        measured |= {f"{name}.{1e3 * t:g}": np.interp(t, result.time, result[f"bare.{name}"]) for t in times}
    return measured
