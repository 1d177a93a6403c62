"""The Jeffcott rotor against its closed forms: unbalance response, peak, and the onset of instability by internal damping."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ....harness.validation import Evidence, Runs
from ....run.results import Result
from ....scene.build import unit
from ....scene.scene import Scene
from ... import build_scene

CRITICAL, DAMPING_RATIO, ECCENTRICITY = 100.0, 0.02, 1e-5  # rad/s, of the component's defaults; m
RATIOS = (0.5, 0.9, 1.0, 1.1, 2.0)
PEAK = 1.0 / math.sqrt(1.0 - 2.0 * DAMPING_RATIO**2)
SETTLED = 12.0  # s, 24 time constants of the start
ONSET, AROUND = 2.0 * CRITICAL, 0.03  # internal damping as large as the external: the onset is at twice the critical speed
SAMPLES = 32  # a turn
SIGNALS = ("displacement_x", "displacement_y", "angle")
UNBALANCED = {ratio: f"{ratio:.5g} of the critical speed" for ratio in (*RATIOS, PEAK)}  # labels of the runs
WHIRLING = {speed: f"internal damping, {speed:g} rad/s" for speed in ((1.0 - AROUND) * ONSET, (1.0 + AROUND) * ONSET)}


def scenes() -> dict[str, Scene]:
    """Unbalance at some speeds; internal damping a little below and above the onset speed."""
    damped: dict[str, Any] = {"internal_damping": {"coefficient": 40.0}}
    return {label: scene(ratio * CRITICAL, SETTLED, ["unbalance"]) for ratio, label in UNBALANCED.items()} | {
        label: scene(speed, 6.0, ["unbalance", "internal_damping"], **damped) for speed, label in WHIRLING.items()
    }


def measure(runs: Runs) -> Evidence:
    """Amplitude and phase of the unbalance response; growth of the whirl."""
    measured: dict[str, float] = {}
    for ratio, label in UNBALANCED.items():
        response, name = synchronous(runs[label]), "peak" if ratio == PEAK else f"{ratio:g}"
        measured |= {f"amplitude.{name}": abs(response) / ECCENTRICITY, f"lag.{name}": -math.degrees(np.angle(response))}
    rates = [growth(runs[label]) for label in WHIRLING.values()]
    measured["onset"] = ONSET * (1.0 + AROUND * (rates[0] + rates[1]) / (rates[0] - rates[1]))
    r = np.linspace(0.01, 2.2, 800)
    closed = r**2 / (1.0 - r**2 + 2j * DAMPING_RATIO * r)
    drawn = {"ratio": r, "closed.amplitude": np.abs(closed), "closed.lag": -np.degrees(np.angle(closed))}
    return Evidence(measured, data={**drawn, "decay": -rates[0], "growth": rates[1]})


def scene(speed: float, duration: float, effects: list[str], **parameters: Any) -> Scene:
    """A rotor of the default mass, stiffness and damping at constant speed; whole turns of 32 steps."""
    step = 2.0 * math.pi / (SAMPLES * speed)
    turns = math.ceil(duration / (SAMPLES * step))
    rotor = unit("JeffcottRotor", effects=effects, start_speed=speed, substep=1e-4, **parameters)
    title, record = f"Jeffcott rotor at {speed:g} rad/s", {"signals": [f"rotor.{n}" for n in SIGNALS]}
    stop = turns * SAMPLES * step
    return build_scene({"rotor": rotor}, stop_time=stop, step=step, name="jeffcott", title=title, record=record)


def synchronous(result: Result) -> complex:
    """(x + i y) exp(-i angle), mean of the last turn, m."""
    x, y, angle = (result[f"rotor.{n}"][-SAMPLES:] for n in SIGNALS)
    return complex(np.mean((x + 1j * y) * np.exp(-1j * angle)))


def growth(result: Result) -> float:
    """Growth rate of the free whirl, 1/s: what is left of x + i y when the same a turn before is subtracted."""
    z = result["rotor.displacement_x"] + 1j * result["rotor.displacement_y"]
    t, free = result.time[SAMPLES:], np.abs(z[SAMPLES:] - z[:-SAMPLES])
    late = t > 2.0  # the backward whirl, damped by both, is gone
    return float(np.polyfit(t[late], np.log(free[late]), 1)[0])
