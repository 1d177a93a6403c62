"""Made-up runs of joints with two axes, as the report sees them: angles put together from known frequencies."""

import numpy as np
from cosimo.orchestrator.run.results import Result
from cosimo.orchestrator.run.run_record import RunRecord
from cosimo.orchestrator.systems import read_scene


def _result(scene, time, columns):
    settled = read_scene({"stop_time": float(time[-1]), "master": {"step": float(time[1])}, **scene})
    return Result(settled, time, columns, {}, dict.fromkeys(columns, "rad"), RunRecord(outcome="done"))


def _columns(unit, names, angles, rates, **more):
    columns = {f"{unit}.{n}_angle": a for n, a in zip(names, angles, strict=True)}
    columns |= {f"{unit}.{n}_rate": r for n, r in zip(names, rates, strict=True)}
    return columns | {f"{unit}.{n}": v for n, v in more.items()}


def gimbal_run(analysis=None, effects=(), duration=40.0, orientation="vertical"):
    """The outer axis turns steadily, the inner one swings with another frequency: a regular motion on a torus."""
    t = np.arange(0.0, duration, 5e-3)
    inner = 0.4 * np.sin(3.7 * t)
    columns = _columns(
        "body",
        ("outer", "inner"),
        (2.0 * t, inner),
        (np.full_like(t, 2.0), 1.48 * np.cos(3.7 * t)),
        outer_momentum=0.3 + 1e-12 * t,
        mechanical_energy=2.0 - 4e-11 * t,
    )
    unit = {"component": "GimbalBody", "effects": list(effects), "parameters": {"axis_orientation": orientation}}
    return _result({"units": {"body": unit}, "analysis": {"system": "two_axis_joint", **(analysis or {})}}, t, columns)


def chain_run(effects=("gravity", "viscous")):
    """A chain that swings and dies down, the second link going round."""
    t = np.arange(0.0, 20.0, 5e-3)
    decay = np.exp(-0.2 * t)
    angles = (0.5 * decay * np.cos(2.0 * t), 3.0 * t)
    rates = (np.gradient(angles[0], t), np.full_like(t, 3.0))
    x, y = np.sin(angles[0]) + np.sin(angles[1]), -np.cos(angles[0]) - np.cos(angles[1])
    columns = _columns(
        "chain", ("first", "second"), angles, rates, tip_x=x, tip_y=y, angular_momentum=decay, mechanical_energy=5.0 * decay
    )
    return _result({"units": {"chain": {"component": "TwoLinkChain", "effects": list(effects)}},
                    "analysis": {"system": "two_axis_joint"}}, t, columns)  # fmt: skip


def three_frictions():
    """The same swing three times: one stands from 5 s on, one creeps, one dies down."""
    t = np.arange(0.0, 10.0, 1e-2)
    frictions = {"exact": "stick_friction", "creeping": "smoothed_friction", "damped": "viscous"}
    units = {n: {"component": "GimbalBody", "effects": [effect]} for n, effect in frictions.items()}
    swing = np.where(t < 5.0, np.cos(2.0 * t), 0.0)
    rests = {"exact": 0.0 * t, "creeping": np.where(t < 5.0, 0.0, 1e-5), "damped": np.exp(-t)}
    columns = {}
    for unit, rest in rests.items():
        columns |= _columns(unit, ("outer", "inner"), (swing, swing), (swing + rest, swing + rest))
    return _result({"units": units, "analysis": {"system": "two_axis_joint"}}, t, columns)
