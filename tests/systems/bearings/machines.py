"""Made-up runs of bearings and rotors, as the report sees them: signals put together from known lines."""

from types import SimpleNamespace

import numpy as np
from cosimo.orchestrator.run.run_record import RunRecord
from cosimo.orchestrator.systems import read_scene

SPEED = 188.49555921538757  # rad/s, 30 Hz
RATE = 10_000.0
JIS_6306 = {"outer": 92.5385, "inner": 147.4615}  # Hz at 30 Hz: 4 * 30 (1 -+ 11.9 / 52)


def _result(scene, time, columns, measures):
    settled = read_scene(scene)
    return SimpleNamespace(
        scene=settled,
        time=time,
        columns=columns,
        measures=measures,
        snapshots={},
        outcome="done",
        message="",
        info=RunRecord(outcome="done"),
    )


def bearing_run(analysis=None, effects=("clearance", "outer_defect"), duration=2.0):
    """A ball passes the outer race's pit 92.54 times a second and rings at 1500 Hz; displacement has the shaft's 30 Hz."""
    t = np.arange(0.0, duration, 1.0 / RATE)
    ringing = sum(
        np.where(t >= s, np.exp(-300.0 * np.clip(t - s, 0, 1)) * np.sin(2 * np.pi * 1500.0 * (t - s)), 0.0)
        for s in np.arange(0.0, duration, 1.0 / JIS_6306["outer"])
    )
    inner = SPEED * t
    cage = 0.5 * (1.0 - 11.9 / 52.0) * inner
    x, y = 5e-6 + 2e-6 * np.cos(inner), 1e-6 * np.sin(inner)
    columns = {
        "bearing.displacement_x": x,
        "bearing.displacement_y": y,
        "bearing.velocity_x": -2e-6 * SPEED * np.sin(inner),
        "bearing.velocity_y": 1e-6 * SPEED * np.cos(inner),
        "bearing.acceleration_x": 2.0 * ringing + 0.01 * np.random.default_rng(4).normal(size=t.size),
        "bearing.inner_angle": inner % (2 * np.pi),
        "bearing.cage_angle": cage % (2 * np.pi),
        "bearing.max_ball_load": 100.0 + 10.0 * ringing,
    }
    units = {"displacement": "m", "velocity": "m/s", "acceleration": "m/s2", "inner": "rad", "cage": "rad", "max": "N"}
    measures = {n: units[n.partition(".")[2].partition("_")[0]] for n in columns}
    scene = {
        "title": "Made-up bearing",
        "stop_time": duration,
        "master": {"step": 1.0 / RATE},
        "units": {"bearing": {"component": "BallBearing", "preset": "JIS 6306", "effects": list(effects)}},
        "analysis": {"system": "bearings", "transient": 0.25, **(analysis or {})},
    }
    return _result(scene, t, columns, measures)


def rotor_run(analysis=None, rate=20.0, duration=20.0):
    """A run-up whose synchronous motion is that of an oscillator of 100 rad/s, at every speed as if it stood."""
    t = np.arange(0.0, duration, 1e-3)
    speed = 40.0 + rate * t
    angle = 40.0 * t + 0.5 * rate * t**2
    r = speed / 100.0
    z = 1e-5 * r**2 / (1.0 - r**2 + 2j * 0.1 * r) * np.exp(1j * angle)
    columns = {
        "rotor.displacement_x": z.real, "rotor.displacement_y": z.imag, "rotor.speed": speed, "rotor.angle": angle % (2 * np.pi),
        "rotor.bearing_a.displacement_x": 0.1 * z.real, "rotor.bearing_a.displacement_y": 0.2 * z.imag,
        "front.force_x": -1e6 * z.real, "front.force_y": -1e6 * z.imag, "front.max_ball_load": np.abs(1e6 * z),
    }  # fmt: skip
    scene = {
        "title": "Made-up rotor",
        "stop_time": duration,
        "master": {"step": 1e-3},
        "units": {
            "rotor": {
                "component": "BeamRotor",
                "effects": ["gyroscopic", "disks", "unbalance", "run_up", "linear_supports", "bearing_a"],
            },
            "front": {"component": "DeepGrooveBearing", "effects": ["linearisation"]},
        },
        "connections": ["rotor.bearing_a.* -> front.*", "front.linearisation.* -> rotor.bearing_a.*"],
        "analysis": {"system": "rotor", **(analysis or {})},
    }  # fmt: skip
    return _result(scene, t, columns, dict.fromkeys(columns, "m"))
