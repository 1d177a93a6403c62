"""Closed forms of a wind pump's parts: curves of the turbine, both pumps, gear set and averaged converter."""

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
from ... import read_scene

HELD = 1e9  # kg.m², of a shaft whose speed is to stay as it is
DEGREE = math.pi / 180.0
# name of the curve -> its choice, pitch in rad, speed of the rotor in rad/s; the wind goes from 6 to 1.25 m/s
CURVES = {
    "heier": ("heier", 0.0, 10.0),
    "heier.5": ("heier", 5.0 * DEGREE, 10.0),
    "heier.10": ("heier", 10.0 * DEGREE, 10.0),
    "simple": ("simple", 0.0, 10.0),
    "variant": ("variant", 0.0, 10.0),
    "farm": ("farm", 0.0, 1.8),
}
STRONG, WEAK, RATE = 6.0, 1.25, 0.25  # m/s, m/s, m/s²
TURN = 2.0 * math.pi
LOAD = 30.0  # N.m, on the planetary gear set


def findings(options: Options) -> Findings:
    """Runs of single units with held inputs and of small chains, each for one group of rows."""
    measured: dict[str, float] = {}
    runs: dict[str, Result] = {}
    for measure in (_curves, _pistons, _centrifugal, _planetary, _converter):
        for label, result in measure(measured, options).items():
            if result.outcome != "done":
                return Findings((), {label: result}, notes=(result.message,), complete=False)
            runs[label] = result
    measured["highest"] = max(measured[f"cp.{name}"] for name in CURVES)
    return Findings(compare(load_table("wind-pump-closed-forms").rows, measured), charts=(_chart(runs),))


def _run(
    options: Options, units: dict[str, Any], signals: list[str], duration: float, step: float, connections: tuple[str, ...] = ()
) -> Result:
    data = {"stop_time": duration, "units": units, "connections": connections, "master": {"step": step},
            "record": {"signals": signals}}  # fmt: skip
    return run(read_scene(data, "wind-pump-closed-forms"), in_process=options.in_process)


def _curves(measured: dict[str, float], options: Options) -> dict[str, Result]:
    """A rotor that keeps its speed in a wind that dies down passes its best tip speed ratio; and one that stands."""
    runs = {}
    for name, (curve, pitch, speed) in CURVES.items():
        values: dict[str, Any] = {"curve": curve, "inertia": HELD, "start_speed": speed}
        if pitch:
            values["pitch"] = {"angle": pitch}
        turbine = {"component": "WindTurbine", "effects": ["pitch"] if pitch else [], "parameters": values}
        wind = {"component": "Wind", "effects": ["ramp"],
                "parameters": {"mean_speed": STRONG, "ramp": {"end_speed": WEAK, "rate": RATE}}}  # fmt: skip
        signals = ["turbine.power_coefficient", "turbine.tip_speed_ratio"]
        runs[name] = result = _run(options, {"wind": wind, "turbine": turbine}, signals, (STRONG - WEAK) / RATE, 5e-3,
                                   ("wind.speed -> turbine.wind",))  # fmt: skip
        if result.outcome == "done":
            measured[f"lambda.{name}"], measured[f"cp.{name}"] = peak(result[signals[1]], result[signals[0]])
    for curve in ("farm", "simple"):
        standing = {"component": "WindTurbine", "parameters": {"curve": curve, "inertia": HELD, "wind": 5.0}}
        signals = ["turbine.aerodynamic_torque"]
        runs[f"{curve} at standstill"] = result = _run(options, {"turbine": standing}, signals, 0.01, 0.01)
        measured[f"standstill.{curve}"] = float(result[signals[0]][0])
    return runs


def peak(x: np.ndarray, y: np.ndarray) -> tuple[float, float]:
    """Place and height of the largest y (n,) over x (n,): of the parabola through the samples about it."""
    k = int(np.clip(np.argmax(y), 2, x.size - 3))
    a, b, c = np.polyfit(x[k - 2 : k + 3] - x[k], y[k - 2 : k + 3], 2)
    return float(x[k] - 0.5 * b / a), float(c - 0.25 * b * b / a)


def _pistons(measured: dict[str, float], options: Options) -> dict[str, Result]:
    """A turn a second at a head of 20 m: whole turns, so that means are means."""
    runs = {}
    for action in ("single", "double"):
        pump = {"component": "PistonPump", "parameters": {"action": action, "speed": TURN, "head": 20.0}}
        signals = [f"pump.{n}" for n in ("torque", "flow", "hydraulic_power")]
        runs[f"{action}-acting piston"] = result = _run(options, {"pump": pump}, signals, 3.0, 1e-3)
        torque, flow, power = (result[n] for n in signals)
        mean = {n: float(np.mean(v[1:])) for n, v in (("torque", torque), ("flow", flow), ("power", power))}
        measured |= {
            f"{action}.mean": mean["torque"],
            f"{action}.peak": float(torque.max()),
            f"{action}.litres": 1e3 * mean["flow"],
            f"{action}.power": mean["power"] / (TURN * mean["torque"]),
        }
    return runs


def _centrifugal(measured: dict[str, float], options: Options) -> dict[str, Result]:
    """Half and full speed on a pipe that has friction only: head and flow answer each other."""
    runs, final_values = {}, {}
    for speed in (75.0, 150.0):
        curve = {"rated_speed": 150.0, "shutoff_head": 30.0, "linear_drop": 2e3, "curve_drop": 5.3e6}
        units = {"pump": {"component": "CentrifugalPump", "parameters": {"speed": speed, **curve}},
                 "pipe": {"component": "WaterPipe", "effects": ["friction"],
                          "parameters": {"static_head": 0.0, "friction": {"coefficient": 1e7}}}}  # fmt: skip
        signals = ["pump.flow", "pipe.head", "pump.torque"]
        connections = ("pump.flow -> pipe.flow", "pipe.head -> pump.head")
        runs[f"centrifugal pump at {speed:g} rad/s"] = result = _run(options, units, signals, 2.0, 0.1, connections)
        final_values[speed] = [float(result[n][-1]) for n in signals]
    (flow, head, torque), (flow_2, head_2, torque_2) = final_values.values()
    measured |= {"affinity.flow": flow_2 / flow, "affinity.head": head_2 / head, "affinity.power": 2.0 * torque_2 / torque}
    measured["centrifugal.flow"] = 1e3 * flow_2
    return runs


def _planetary(measured: dict[str, float], options: Options) -> dict[str, Result]:
    """Turbine on the ring, steady load on the carrier, viscous brake on the sun, until nothing accelerates any more."""
    units = {"wind": {"component": "Wind", "parameters": {"mean_speed": 5.0}},
             "turbine": {"component": "WindTurbine", "preset": "farm windmill"},
             "gear": {"component": "PlanetaryTransmission", "parameters": {"teeth_ratio": 3.0, "load_torque": LOAD}}}  # fmt: skip
    names = ("speed", "third_speed", "turbine_torque", "driving_torque", "third_torque", "dissipation")
    connections = ("wind.speed -> turbine.wind", "turbine.speed -> gear.turbine_speed", "gear.turbine_torque -> turbine.torque")
    result = _run(options, units, ["turbine.speed", *(f"gear.{n}" for n in names)], 60.0, 0.01, connections)
    ring = float(result["turbine.speed"][-1])
    carrier, sun, on_ring, on_carrier, on_sun, lost = (float(result[f"gear.{n}"][-1]) for n in names)
    measured |= {  # torques on the gear set: those of load and brake are against it
        "willis": (sun + 3.0 * ring) / carrier,
        "torque.carrier": -on_carrier / on_ring,
        "torque.sun": -on_sun / on_ring,
        "power.gear": (LOAD * carrier + lost) / (on_ring * ring),
    }
    return {"planetary gear set": result}


def _converter(measured: dict[str, float], options: Options) -> dict[str, Result]:
    """Torques at held speeds: stalled at two speeds of the crank, and with the driven shaft at 10 rad/s."""
    runs = {}
    for name, crank, driven in (("stall.10", 10.0, 0.0), ("stall.20", 20.0, 0.0), ("running", 20.0, 10.0)):
        values = {"turbine_speed": crank / 6.0, "start_speed": driven, "driven_inertia": HELD, "load_torque": 1e3}
        signals = ["converter.driving_torque", "converter.turbine_torque", "converter.speed"]
        units = {"converter": {"component": "AveragedConverter", "parameters": values}}
        runs[f"averaged converter, {name}"] = result = _run(options, units, signals, 0.05, 0.05)
        torque, taken, speed = (float(result[n][0]) for n in signals)
        measured[name] = torque
        if driven:
            measured["power.converter"] = torque * speed / (taken * crank / 6.0)
    return runs


def _chart(runs: dict[str, Result]) -> Chart:
    curves = {n: (runs[n]["turbine.tip_speed_ratio"], runs[n]["turbine.power_coefficient"]) for n in CURVES}
    names = {n: f"{n.replace('.', ' at a pitch of ')} degrees" if "." in n else n for n in CURVES}
    series = [Series(names[n], x, np.maximum(y, 0.0)) for n, (x, y) in curves.items()]
    ends = [0.0, max(float(x.max()) for x, _ in curves.values())]
    betz = Series("Betz", ends, [16.0 / 27.0, 16.0 / 27.0], faint=True)
    text = "As the runs passed them. The farm windmill has its best ratio at 1.2, where the others hardly give any torque."
    return Chart("Power coefficients", "tip speed ratio, 1", (Panel("power coefficient, 1", (betz, *series)),), text)


CASE = function_case(
    "wind-pump-closed-forms",
    "Closed forms of a wind pump's parts",
    "Largest power coefficients of the turbine's curves and where they lie, Betz's limit, torque at standstill; mean and peak "
    "torque and volume of piston pumps; affinity laws of the centrifugal pump in a pipe; Willis's relation and torques of the "
    "planetary gear set; torque and power of the averaged converter. Measured in runs of the units, not by evaluating their "
    "functions. It shows that the equations are the ones cited; it does not show that a real windmill has these curves.",
    "wind_pump",
    findings,
)
