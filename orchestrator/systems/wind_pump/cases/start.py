"""Start and stop of a piston pump in the wind: closed forms in a wind that changes slowly, and a whole rise and fall."""

from __future__ import annotations

import math

from ....harness.validation import Evidence, Runs
from ....run.results import Result
from ....scene.build import unit
from ....scene.scene import Scene
from ... import build_scene, load_scene
from ..records import chains, runnings

MEAN_TORQUE = 13.2435  # N.m, of the piston pump at 20 m; its peak is pi times that
KINDS = {"fixed": "FixedTransmission", "converter": "AveragedConverter"}
FREE = 2.4 / 1.5  # 1/m, speed of the unloaded turbine over the wind
# from, to in m/s, rate in m/s², speed of both shafts at the start in rad/s; what remains of the lag is the rate times some 4 s
STARTING: dict[str, tuple[float, float, float]] = {"fixed": (0.0, 3.75, 0.03), "converter": (2.55, 2.75, 1e-3)}
STOPPING: dict[str, tuple[float, float, float]] = {"fixed": (2.2, 1.95, 1e-3), "converter": (1.65, 1.45, 1e-3)}


def scenes() -> dict[str, Scene]:
    """Start and stop of both transmissions in a slow wind, and a whole rise and fall."""
    slow = {f"{kind}, {what}": scene(kind, what) for kind in KINDS for what in ("start", "stop")}
    return {**slow, "rise and fall": load_scene("wind-pump-start")}


def measure(runs: Runs) -> Evidence:
    """Winds at which the pump's shaft begins to turn and comes to rest, for both transmissions, and those of the scene."""
    measured: dict[str, float] = {}
    for kind in KINDS:
        for what in ("start", "stop"):
            measured[f"{what}.{kind}"] = turning_point(runs[f"{kind}, {what}"], what)
        measured[f"hysteresis.{kind}"] = measured[f"start.{kind}"] / measured[f"stop.{kind}"]
    free = runs["converter, start"]
    middle = free.time.size // 2  # the turbine has settled, and the pump has not started
    measured["free"] = float(free["turbine.speed"][middle] / (FREE * free["wind.speed"][middle]))
    for chain in chains(runs["rise and fall"]):
        pump_runs = runnings(chain)
        if pump_runs:
            measured[f"loop.start.{chain.name}"] = pump_runs[0].begin_wind or math.nan
            measured[f"loop.stop.{chain.name}"] = pump_runs[-1].end_wind or math.nan
        measured[f"loop.litres.{chain.name}"] = 1e3 * float(chain.signals["delivered"][-1])
    places = ("start", "stop", "loop.start", "loop.stop")
    return Evidence(measured, data={"winds": {kind: [measured.get(f"{n}.{kind}", math.nan) for n in places] for kind in KINDS}})


def scene(kind: str, what: str) -> Scene:
    """A turbine, a transmission and, for the start, a pump that stands at its peak; for the stop, the pump's mean torque."""
    first, last, rate = (STARTING if what == "start" else STOPPING)[kind]
    ramp = {"end_speed": last, "rate": rate}
    turning = what == "stop"
    speed = (0.5 if kind == "fixed" else FREE * first) if turning else 0.0
    units = {
        "wind": unit("Wind", effects=["ramp"], mean_speed=first, ramp=ramp),
        "turbine": unit("WindTurbine", preset="farm windmill", start_speed=speed),
        "transmission": unit(KINDS[kind], load_torque=MEAN_TORQUE, start_speed=0.5) if turning else unit(KINDS[kind]),
    }
    connections = {"wind.speed": "turbine.wind", "turbine.speed": "transmission.turbine_speed",
                   "transmission.turbine_torque": "turbine.torque"}  # fmt: skip
    if not turning:
        units["pump"] = unit("PistonPump", start_angle=0.5 * math.pi)
        connections |= {"transmission.speed": "pump.speed", "pump.torque": "transmission.load_torque"}
    return build_scene(
        units,
        connections,
        stop_time=abs(last - first) / rate,
        step=0.01 if kind == "fixed" else 0.05,
        name="wind-pump-start",
        title=f"{kind} transmission, {what} in a slow wind",
        record={"signals": ["wind.speed", "turbine.speed", "transmission.speed"], "interval": 0.05},
    )


def turning_point(result: Result, what: str) -> float:
    """The wind, m/s, at which the pump's shaft first turns or at last stands; NaN if it never does."""
    turning = result["transmission.speed"] > 0.0
    changed = turning[1:] != turning[:-1]
    wanted = changed & (turning[1:] if what == "start" else ~turning[1:])
    return float(result["wind.speed"][1:][wanted][0 if what == "start" else -1]) if wanted.any() else math.nan
