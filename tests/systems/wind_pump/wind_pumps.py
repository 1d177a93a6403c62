"""Made-up runs of wind pumps, as the report sees them: a wind that rises and falls, a pump that starts later than it stops."""

from types import SimpleNamespace

import numpy as np
from cosimo.orchestrator.run.run_record import RunRecord
from cosimo.orchestrator.systems import read_scene

STARTS, STOPS, TOP = 3.6, 2.4, 5.0  # m/s
CP, TRANSMITTED, PUMPED = 0.3, 0.8, 0.9  # of the wind; of the turbine's power; of the pump shaft's
RADIUS, DENSITY = 1.5, 1.225
HEAD_TORQUE = 10.0  # N.m, of the pump
CHAIN = [
    "wind.speed -> turbine.wind",
    "turbine.speed -> gear.turbine_speed",
    "gear.turbine_torque -> turbine.torque",
    "gear.speed -> pump.speed",
    "pump.torque -> gear.load_torque",
    "pump.flow -> pipe.flow",
    "pipe.head -> pump.head",
]


def triangle(duration=400.0, step=0.1):
    """Times and a wind that rises from 0 to its top and falls back."""
    t = np.arange(0.0, duration + 0.5 * step, step)
    return t, TOP * (1.0 - np.abs(2.0 * t / duration - 1.0))


def run_of(t, wind, running, ripple=0.0, analysis=None):
    """Signals of a chain of the gear ratio 0.5 while the pump is running (n,), and of a free turbine while it is not.

    ripple: of the power into the water, relative, at 1 Hz.
    """
    turbine = np.where(running, wind, 1.6 * wind)
    pump = np.where(running, 0.5 * turbine, 0.0)
    power = np.where(running, CP * 0.5 * DENSITY * np.pi * RADIUS**2 * wind**3, 0.0)
    at_pump = TRANSMITTED * power
    water = PUMPED * at_pump * (1.0 + ripple * np.sin(2.0 * np.pi * t))
    flow = 1e-4 * pump
    columns = {
        "wind.speed": wind,
        "turbine.speed": turbine,
        "turbine.power": power,
        "turbine.power_coefficient": np.where(running, CP, 0.0),
        "gear.speed": pump,
        "gear.turbine_torque": np.divide(power, turbine, out=np.zeros_like(power), where=turbine > 0.0),
        "pump.torque": np.divide(at_pump, pump, out=np.full_like(power, HEAD_TORQUE), where=pump > 0.0),
        "pump.flow": flow,
        "pump.hydraulic_power": water,
        "pipe.delivered": np.concatenate(([0.0], np.cumsum(0.5 * (flow[1:] + flow[:-1]) * np.diff(t)))),
    }
    scene = {
        "title": "Made-up wind pump",
        "stop_time": float(t[-1]),
        "master": {"step": float(t[1] - t[0])},
        "units": {
            "wind": {"component": "Wind"},
            "turbine": {"component": "WindTurbine", "parameters": {"radius": RADIUS, "density": DENSITY}},
            "gear": {"component": "FixedTransmission"},
            "pump": {"component": "PistonPump"},
            "pipe": {"component": "WaterPipe"},
        },
        "connections": CHAIN,
        "analysis": {"system": "wind_pump", **(analysis or {})},
    }
    return SimpleNamespace(scene=read_scene(scene), time=t, columns=columns, measures=dict.fromkeys(columns, "1"),
                           snapshots={}, outcome="done", message="", info=RunRecord(outcome="done"))  # fmt: skip


def hysteresis_run(analysis=None):
    """The pump starts at 3.6 m/s in the rising wind and stops at 2.4 m/s in the falling one."""
    t, wind = triangle()
    rising = t <= 0.5 * t[-1]
    return run_of(t, wind, np.where(rising, wind >= STARTS, wind > STOPS), analysis=analysis)


def gusty_run(analysis=None):
    """Six hours of a wind that goes up and down every ten minutes around 5 m/s, with some noise; the pump always runs."""
    t = np.arange(0.0, 6.0 * 3600.0 + 0.5, 1.0)
    wind = 5.0 + 2.0 * np.sin(2.0 * np.pi * t / 600.0) + 0.2 * np.random.default_rng(7).normal(size=t.size)
    return run_of(t, wind, np.full(t.size, True), analysis={"average": 60.0, **(analysis or {})})
