"""A made-up run of an underwater vehicle, as the report sees it: a circle at 5 m depth, a thruster at its limit for a while."""

from types import SimpleNamespace

import numpy as np
from cosimo.orchestrator.systems import read_scene

RADIUS, DEPTH, DURATION, STEP = 3.0, 5.0, 20.0, 0.1
ASIDE = 0.2  # m, by which the track is east of the set point
LIMIT = (8.0, 13.0)  # s, when thruster 6 is at its limit
THRUST = 4.0  # N, times the number of the thruster
CONNECTIONS = [
    *(f"t{k}.thrust -> hull.thrust[{k}]" for k in range(1, 7)),
    *(f"control.command[{k}] -> t{k}.command" for k in range(1, 7)),
    "hull.position_north -> control.position_north",
]


def vehicle_run(analysis=None, vertical=False, control=True):
    """North along a circle, the bow ahead, a half turn; `vertical`: the bow up from 10 s on, where roll and yaw are not told."""
    t = np.arange(0.0, DURATION + 0.5 * STEP, STEP)
    way = np.pi * t / DURATION
    yaw, zero = way.copy(), np.zeros_like(t)
    pitch = np.where(vertical & (t >= 10.0), 0.5 * np.pi, 0.0)
    up, half = 0.5 * pitch, 0.5 * yaw
    columns = {
        "hull.position_north": RADIUS * np.sin(way),
        "hull.position_east": RADIUS * (1.0 - np.cos(way)),
        "hull.depth": DEPTH + zero,
        "hull.quaternion_w": np.cos(half) * np.cos(up),
        "hull.quaternion_x": -np.sin(half) * np.sin(up),
        "hull.quaternion_y": np.cos(half) * np.sin(up),
        "hull.quaternion_z": np.sin(half) * np.cos(up),
        "hull.roll": zero,
        "hull.pitch": pitch,
        "hull.yaw": np.remainder(2.0 * yaw + np.pi, 2.0 * np.pi) - np.pi,  # wraps at 10 s
        "hull.attitude_valid": np.where(pitch > 1.5, 0.0, 1.0),
        "hull.surge": np.pi * RADIUS / DURATION + zero,
        "hull.sway": zero,
        "hull.heave": zero,
        "hull.yaw_rate": np.pi / DURATION + zero,
    }
    units = {"hull": {"component": "RovHull", "effects": ["linear_drag"]}}
    if control:
        units |= {f"t{k}": {"component": "Thruster"} for k in range(1, 7)} | {"control": {"component": "RovController"}}
        columns |= {f"t{k}.thrust": THRUST * k + zero for k in range(1, 7)}
        columns |= {f"control.command[{k}]": 0.1 * k + zero for k in range(1, 6)}
        columns["control.command[6]"] = np.where((t >= LIMIT[0]) & (t <= LIMIT[1]), 1.0, 0.6)
        columns |= {
            "control.error_north": zero,
            "control.error_east": zero - ASIDE,
            "control.error_down": zero,
            "control.error_roll": zero,
            "control.error_pitch": zero,
            "control.error_yaw": 0.1 * np.cos(2.0 * np.pi * t),
            "control.scale": np.where((t >= LIMIT[0]) & (t <= LIMIT[1]), 0.7, 1.0),
        }
    scene = {
        "title": "Made-up vehicle",
        "stop_time": DURATION,
        "master": {"step": STEP},
        "units": units,
        "connections": CONNECTIONS if control else [],
        "analysis": {"system": "rov", **(analysis or {})},
    }
    return SimpleNamespace(scene=read_scene(scene), time=t, columns=columns, measures=dict.fromkeys(columns, "1"), outcome="done")
