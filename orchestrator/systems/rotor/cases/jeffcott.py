"""The Jeffcott rotor against its closed forms: unbalance response, peak, and the onset of instability by internal damping."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ....harness.charts.chart import Chart, Panel, Series
from ....harness.validation.case import Findings, compare, function_case
from ....harness.validation.questions import Options
from ....harness.validation.reference import load_table
from ....results import Result
from ....run import run
from ....scene.scene import Scene
from ... import read_scene

CRITICAL, DAMPING_RATIO, ECCENTRICITY = 100.0, 0.02, 1e-5  # rad/s, of the component's defaults; m
RATIOS = (0.5, 0.9, 1.0, 1.1, 2.0)
PEAK = 1.0 / math.sqrt(1.0 - 2.0 * DAMPING_RATIO**2)
SETTLED = 12.0  # s, 24 time constants of the start
ONSET, AROUND = 2.0 * CRITICAL, 0.03  # internal damping as large as the external: the onset is at twice the critical speed
SAMPLES = 32  # a turn


def findings(options: Options) -> Findings:
    """Amplitude and phase at some speeds; growth of the whirl a little below and above the onset speed."""
    measured: dict[str, float] = {}
    runs: dict[str, Result] = {}
    for ratio in (*RATIOS, PEAK):
        result = run(scene(ratio * CRITICAL, SETTLED, ["unbalance"]), in_process=options.in_process)
        if result.outcome != "done":
            return Findings((), {f"{ratio:g}": result}, notes=(result.message,), complete=False)
        response = synchronous(result)
        name = "peak" if ratio == PEAK else f"{ratio:g}"
        measured |= {f"amplitude.{name}": abs(response) / ECCENTRICITY, f"lag.{name}": -math.degrees(np.angle(response))}
        runs[f"{ratio:.4g} of the critical speed"] = result
    rates = []
    for speed in ((1.0 - AROUND) * ONSET, (1.0 + AROUND) * ONSET):
        effects, parameters = ["unbalance", "internal_damping"], {"internal_damping": {"coefficient": 40.0}}
        result = run(scene(speed, 6.0, effects, **parameters), in_process=options.in_process)
        rates.append(growth(result))
        runs[f"internal damping, {speed:g} rad/s"] = result
    measured["onset"] = ONSET * (1.0 + AROUND * (rates[0] + rates[1]) / (rates[0] - rates[1]))
    notes = (f"Free whirl decays by {-rates[0]:.3f} 1/s at {1.0 - AROUND:g} and grows by {rates[1]:.3f} 1/s at {1.0 + AROUND:g} "
             "of the onset speed; the onset is where the line through both is zero.",)  # fmt: skip
    return Findings(compare(load_table("jeffcott").rows, measured), runs, (_chart(measured),), notes)


def scene(speed: float, duration: float, effects: list[str], **parameters: Any) -> Scene:
    """A rotor of the default mass, stiffness and damping at constant speed; whole turns of 32 steps."""
    step = 2.0 * math.pi / (SAMPLES * speed)
    turns = math.ceil(duration / (SAMPLES * step))
    rotor = {
        "component": "JeffcottRotor",
        "effects": effects,
        "parameters": {"start_speed": speed, "substep": 1e-4, **parameters},
    }
    data = {
        "title": f"Jeffcott rotor at {speed:g} rad/s",
        "stop_time": turns * SAMPLES * step,
        "units": {"rotor": rotor},
        "master": {"step": step},
        "record": {"signals": ["rotor.displacement_x", "rotor.displacement_y", "rotor.angle"]},
    }
    return read_scene(data, "jeffcott")


def synchronous(result: Result) -> complex:
    """(x + i y) exp(-i angle), mean of the last turn, m."""
    c = {n: np.asarray(result.columns[f"rotor.{n}"][-SAMPLES:]) for n in ("displacement_x", "displacement_y", "angle")}
    return complex(np.mean((c["displacement_x"] + 1j * c["displacement_y"]) * np.exp(-1j * c["angle"])))


def growth(result: Result) -> float:
    """Growth rate of the free whirl, 1/s: what is left of x + i y when the same a turn before is subtracted."""
    z = np.asarray(result.columns["rotor.displacement_x"]) + 1j * np.asarray(result.columns["rotor.displacement_y"])
    t, free = np.asarray(result.time[SAMPLES:]), np.abs(z[SAMPLES:] - z[:-SAMPLES])
    late = t > 2.0  # the backward whirl, damped by both, is gone
    return float(np.polyfit(t[late], np.log(free[late]), 1)[0])


def _chart(measured: dict[str, float]) -> Chart:
    r = np.linspace(0.01, 2.2, 800)
    closed = r**2 / (1.0 - r**2 + 2j * DAMPING_RATIO * r)
    panels = []
    for title, curve, name in (("amplitude / eccentricity", np.abs(closed), "amplitude"),
                               ("lag, degrees", -np.degrees(np.angle(closed)), "lag")):  # fmt: skip
        points = [measured[f"{name}.{ratio:g}"] for ratio in RATIOS]
        panels.append(Panel(title, (Series("closed form", r, curve), Series("runs", RATIOS, points, "points"))))
    return Chart("Unbalance response", "speed / critical speed", tuple(panels), "Runs: last turn after 24 time constants.")


CASE = function_case(
    "jeffcott",
    "Unbalance response and stability of the Jeffcott rotor",
    "Amplitude and phase of the unbalance response below, at and above the critical speed, its peak, and the speed from which on "
    "internal damping makes the rotor whirl by itself, against closed forms. A check of signs, phases and of the integration; "
    "a rotor of one mass has no gyroscopic effect to check.",
    "rotor",
    findings,
)
