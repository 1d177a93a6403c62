"""Closed forms of a wind pump's parts: curves of the turbine, both pumps, gear set and averaged converter."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ....harness.validation import Evidence, Runs
from ....run.results import Result
from ....scene.build import unit
from ....scene.scene import Scene
from ... import build_scene

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
STANDING, ACTIONS, SPEEDS = ("farm", "simple"), ("single", "double"), (75.0, 150.0)  # curves; of pistons; rad/s
STROKE = ("torque", "flow", "hydraulic_power")
ON_GEAR = ("speed", "third_speed", "turbine_torque", "driving_torque", "third_torque", "dissipation")
OF_CONVERTER = ("driving_torque", "turbine_torque", "speed")
# name -> speeds of crank and driven shaft, rad/s: stalled twice, and running
CONVERTERS = {"stall.10": (10.0, 0.0), "stall.20": (20.0, 0.0), "running": (20.0, 10.0)}


def scenes() -> dict[str, Scene]:
    """Runs of single units with held inputs and of small chains, by their names."""
    return {
        **{name: _dying_wind(*given) for name, given in CURVES.items()},
        **{f"{curve} at standstill": _standing(curve) for curve in STANDING},
        **{f"{action}-acting piston": _piston(action) for action in ACTIONS},
        **{f"centrifugal pump at {speed:g} rad/s": _centrifugal(speed) for speed in SPEEDS},
        "planetary gear set": _planetary(),
        **{f"averaged converter, {name}": _converter(*given) for name, given in CONVERTERS.items()},
    }


def measure(runs: Runs) -> Evidence:
    """The numbers of every group of rows."""
    measured: dict[str, float] = {}
    for name in CURVES:
        ratio, coefficient = (runs[name][f"turbine.{n}"] for n in ("tip_speed_ratio", "power_coefficient"))
        measured[f"lambda.{name}"], measured[f"cp.{name}"] = peak(ratio, coefficient)
    measured |= {f"standstill.{c}": runs[f"{c} at standstill"]["turbine.aerodynamic_torque"][0] for c in STANDING}
    for action in ACTIONS:
        measured |= _strokes(runs[f"{action}-acting piston"], action)
    measured |= _affinity(*(runs[f"centrifugal pump at {speed:g} rad/s"] for speed in SPEEDS))
    measured |= _gear_set(runs["planetary gear set"])
    for name, (crank, driven) in CONVERTERS.items():
        measured |= _torques(runs[f"averaged converter, {name}"], name, crank, driven)
    measured["highest"] = max(measured[f"cp.{name}"] for name in CURVES)
    curves = {n: (runs[n]["turbine.tip_speed_ratio"], np.maximum(runs[n]["turbine.power_coefficient"], 0.0)) for n in CURVES}
    named = {f"{n.replace('.', ' at a pitch of ')} degrees" if "." in n else n: curve for n, curve in curves.items()}
    ends = [0.0, max(float(x.max()) for x, _ in curves.values())]
    return Evidence(measured, data={"curves": named, "betz": {"Betz": (ends, [16.0 / 27.0, 16.0 / 27.0])}})


def _scene(
    units: Mapping[str, Any], signals: Sequence[str], duration: float, step: float, connections: Mapping[str, str] | None = None
) -> Scene:
    record = {"signals": list(signals)}
    return build_scene(units, connections or {}, stop_time=duration, step=step, name="wind-pump-closed-forms", record=record)


def _dying_wind(curve: str, pitch: float, speed: float) -> Scene:
    """A rotor that keeps its speed in a wind that dies down passes its best tip speed ratio."""
    given: dict[str, Any] = {"pitch": {"angle": pitch}} if pitch else {}
    turbine = unit("WindTurbine", effects=list(given), curve=curve, inertia=HELD, start_speed=speed, **given)
    wind = unit("Wind", effects=["ramp"], mean_speed=STRONG, ramp={"end_speed": WEAK, "rate": RATE})
    signals = ("turbine.power_coefficient", "turbine.tip_speed_ratio")
    duration = (STRONG - WEAK) / RATE
    return _scene({"wind": wind, "turbine": turbine}, signals, duration, 5e-3, {"wind.speed": "turbine.wind"})


def _standing(curve: str) -> Scene:
    turbine = unit("WindTurbine", curve=curve, inertia=HELD, wind=5.0)
    return _scene({"turbine": turbine}, ["turbine.aerodynamic_torque"], 0.01, 0.01)


def peak(x: np.ndarray, y: np.ndarray) -> tuple[float, float]:
    """Place and height of the largest y (n,) over x (n,): of the parabola through the samples about it."""
    k = int(np.clip(np.argmax(y), 2, x.size - 3))
    a, b, c = np.polyfit(x[k - 2 : k + 3] - x[k], y[k - 2 : k + 3], 2)
    return float(x[k] - 0.5 * b / a), float(c - 0.25 * b * b / a)


def _piston(action: str) -> Scene:
    """A turn a second at a head of 20 m: whole turns, so that means are means."""
    pump = unit("PistonPump", action=action, speed=TURN, head=20.0)
    return _scene({"pump": pump}, [f"pump.{n}" for n in STROKE], 3.0, 1e-3)


def _strokes(result: Result, action: str) -> dict[str, float]:
    """Mean and peak torque, N.m, litres a second, and the power into the water over that of the mean torque."""
    torque, flow, power = (result[f"pump.{n}"] for n in STROKE)
    mean = float(np.mean(torque[1:]))
    return {
        f"{action}.mean": mean,
        f"{action}.peak": float(torque.max()),
        f"{action}.litres": 1e3 * float(np.mean(flow[1:])),
        f"{action}.power": float(np.mean(power[1:])) / (TURN * mean),
    }


def _centrifugal(speed: float) -> Scene:
    """A pump on a pipe that has friction only: head and flow answer each other."""
    pump = unit("CentrifugalPump", speed=speed, rated_speed=150.0, shutoff_head=30.0, linear_drop=2e3, curve_drop=5.3e6)
    pipe = unit("WaterPipe", effects=["friction"], static_head=0.0, friction={"coefficient": 1e7})
    connections = {"pump.flow": "pipe.flow", "pipe.head": "pump.head"}
    return _scene({"pump": pump, "pipe": pipe}, ["pump.flow", "pipe.head", "pump.torque"], 2.0, 0.1, connections)


def _affinity(half: Result, full: Result) -> dict[str, float]:
    """Ratios of flow, head and power at full and at half speed, and the flow at full speed, l/s."""
    flow, head, torque = (full[n][-1] / half[n][-1] for n in ("pump.flow", "pipe.head", "pump.torque"))
    return {
        "affinity.flow": flow,
        "affinity.head": head,
        "affinity.power": 2.0 * torque,
        "centrifugal.flow": 1e3 * full["pump.flow"][-1],
    }


def _planetary() -> Scene:
    """Turbine on the ring, steady load on the carrier, viscous brake on the sun, until nothing accelerates any more."""
    units = {
        "wind": unit("Wind", mean_speed=5.0),
        "turbine": unit("WindTurbine", preset="farm windmill"),
        "gear": unit("PlanetaryTransmission", teeth_ratio=3.0, load_torque=LOAD),
    }
    connections = {"wind.speed": "turbine.wind", "turbine.speed": "gear.turbine_speed", "gear.turbine_torque": "turbine.torque"}
    return _scene(units, ["turbine.speed", *(f"gear.{n}" for n in ON_GEAR)], 60.0, 0.01, connections)


def _gear_set(result: Result) -> dict[str, float]:
    """Willis's relation, torques over that on the ring, and power taken over power given."""
    ring = result["turbine.speed"][-1]
    carrier, sun, on_ring, on_carrier, on_sun, lost = (result[f"gear.{n}"][-1] for n in ON_GEAR)
    return {  # torques on the gear set: those of load and brake are against it
        "willis": (sun + 3.0 * ring) / carrier,
        "torque.carrier": -on_carrier / on_ring,
        "torque.sun": -on_sun / on_ring,
        "power.gear": (LOAD * carrier + lost) / (on_ring * ring),
    }


def _converter(crank: float, driven: float) -> Scene:
    given = unit("AveragedConverter", turbine_speed=crank / 6.0, start_speed=driven, driven_inertia=HELD, load_torque=1e3)
    return _scene({"converter": given}, [f"converter.{n}" for n in OF_CONVERTER], 0.05, 0.05)


def _torques(result: Result, name: str, crank: float, driven: float) -> dict[str, float]:
    """Torque on the driven shaft, N.m; where that turns, power given over power taken."""
    torque, taken, speed = (result[f"converter.{n}"][0] for n in OF_CONVERTER)
    return {name: torque, **({"power.converter": torque * speed / (taken * crank / 6.0)} if driven else {})}
