"""Friction-wheel drive against closed forms: kinematics, speed under load, loss, limits of the load, and its split into units."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from ....harness.charts.chart import Chart, Panel, Series
from ....harness.validation.case import Case, Findings, Options, compare
from ....harness.validation.reference import load_table
from ....results import Result
from ....run import run
from ....scene.scene import Scene
from ... import read_scene

RATE = 20.0  # rad/s of the wheels
RADIUS, SLEEVE, ANGLE = 0.01, 0.005, math.pi / 6.0
LIMIT = 12.0  # N, 2 mu N
SHARES = (0.0, 0.25, 0.5, 0.75, math.cos(ANGLE), 0.9)  # of it, that load the sleeve
LOADS = {"axial": (1.0, 0.0), "around": (0.0, 1.0), "both": (0.6, 0.8)}  # of force and torque, on the limit's ellipse
NEAR = 0.01  # share by which a load is below or above it
VOLTAGES = {"first_voltage": 6.0, "second_voltage": 2.0}
STEPS = (2e-3, 1e-3, 5e-4)  # s, macro steps of the split drive
ROLLERS = {"layout": "skewed_free_rollers"}


def wheels(parameters: Mapping[str, Any], effects: tuple[str, ...] = ("exact_slip",)) -> dict[str, Any]:
    """The wheels' unit."""
    return {"component": "FrictionWheels", "effects": list(effects), "parameters": dict(parameters)}


def scene() -> Scene:
    """Wheels that turn at a given rate under many loads, and wheels that stand under loads about the limit."""
    units: dict[str, Any] = {}
    for layout in ("skewed", "skewed_free_rollers", "orthogonal"):
        for way, sign in (("feed", 1.0), ("rotation", -1.0)):
            second = RATE if layout == "orthogonal" else sign * RATE
            pair = {"first_rate": RATE if way == "feed" or layout != "orthogonal" else 0.0,
                    "second_rate": second if way == "rotation" or layout != "orthogonal" else 0.0}  # fmt: skip
            if layout != "skewed" or way == "feed":  # unloaded plain wheels that turn against each other leave the feed open
                units[f"{layout}_{way}"] = wheels({"layout": layout, **pair})
    for share in SHARES[1:]:
        units[_loaded(share)] = wheels({"first_rate": RATE, "second_rate": RATE, "external_force": -share * LIMIT})
    for name, (force, torque) in LOADS.items():
        for way, share in (("below", 1.0 - NEAR), ("above", 1.0 + NEAR)):
            load = {"external_force": share * force * LIMIT, "external_torque": share * torque * LIMIT * SLEEVE}
            units[f"{name}_{way}"] = wheels({"exact_slip.static_ratio": 1.0, **load})
    signals = [f"{u}.{s}" for u in units for s in ("feed", "rotation", "feed_rate", "rotation_rate", "contact_power")]
    data = {"title": "Wheels on a sleeve", "stop_time": 0.5, "units": units, "master": {"step": 1e-3},
            "record": {"signals": signals}}  # fmt: skip
    return read_scene(data, "friction-drive")


def _loaded(share: float) -> str:
    return f"loaded_{round(1e3 * share)}"


def whole(split: bool, step: float) -> Scene:
    """The drive at constant voltages, contacts that creep: two motors and wheels, or one unit."""
    motor = {f"{k}_motor": {"component": "ServoMotor", "parameters": {"voltage": VOLTAGES[f"{k}_voltage"]}}
             for k in ("first", "second")}  # fmt: skip
    if not split:
        units = {"drive": {"component": "FrictionDrive", "parameters": {**ROLLERS, **VOLTAGES}}}
        links: list[str] = []
    else:
        units = {**motor, "drive": wheels(ROLLERS, ())}
        links = [f"{k}_motor.rate -> drive.{k}_rate" for k in ("first", "second")]
        links += [f"drive.{k}_torque -> {k}_motor.load_torque" for k in ("first", "second")]
    data = {"title": "The drive", "stop_time": 0.1, "units": units, "connections": links, "master": {"step": step},
            "record": {"signals": ["drive.feed", "drive.rotation"], "interval": STEPS[0]}}  # fmt: skip
    return read_scene(data, "friction-drive-split" if split else "friction-drive-whole")


def findings(options: Options) -> Findings:
    """One run of all wheels, one of the whole drive, three of its parts."""
    scenes = {"wheels": scene(), "whole": whole(False, STEPS[0]), **{f"split {h:g}": whole(True, h) for h in STEPS}}
    runs = {name: run(s, in_process=options.in_process) for name, s in scenes.items()}
    for name, result in runs.items():
        if result.outcome != "done":
            return Findings((), {name: result}, notes=(result.message,), complete=False)
    result = runs["wheels"]
    measured: dict[str, float] = {}
    for unit in ("skewed_feed", "skewed_free_rollers_feed", "orthogonal_feed"):
        measured[f"{unit}.rate"] = float(result[f"{unit}.feed_rate"][-1])
        measured[f"{unit}.power"] = float(result[f"{unit}.contact_power"][-1])
    for unit in ("skewed_free_rollers_rotation", "orthogonal_rotation"):
        measured[f"{unit}.rate"] = float(result[f"{unit}.rotation_rate"][-1])
    for share in SHARES[1:]:
        measured[f"{_loaded(share)}.rate"] = float(result[f"{_loaded(share)}.feed_rate"][-1])
        measured[f"{_loaded(share)}.power"] = float(result[f"{_loaded(share)}.contact_power"][-1])
    for name in LOADS:
        for way in ("below", "above"):
            rates = result[f"{name}_{way}.feed_rate"][-1], SLEEVE * result[f"{name}_{way}.rotation_rate"][-1]
            measured[f"{name}.{way}"] = float(np.hypot(*rates))
    apart = [_apart(runs[f"split {h:g}"], runs["whole"]) for h in STEPS]
    measured["split.order"] = float(np.polyfit(np.log(STEPS), np.log(apart), 1)[0])
    return Findings(compare(load_table("friction-drive").rows, measured), {}, (_chart(measured), _paths(runs)))


def _apart(split: Result, reference: Result) -> float:
    """Largest distance of the sleeve's surface from that of the whole drive, m."""
    ways = [split[f"drive.{n}"] - reference[f"drive.{n}"] for n in ("feed", "rotation")]
    return float(np.hypot(ways[0], SLEEVE * ways[1]).max())


def _chart(measured: Mapping[str, float]) -> Chart:
    f = np.linspace(0.0, 0.95, 400)
    root = np.sqrt(1.0 - f * f)
    curves = RADIUS * RATE * (math.cos(ANGLE) - math.sin(ANGLE) * f / root), LIMIT * RADIUS * RATE * math.sin(ANGLE) / root
    names = ["skewed_feed", *(_loaded(s) for s in SHARES[1:])]
    panels = []
    for label, key, curve in (("feed rate, m/s", "rate", curves[0]), ("loss, W", "power", curves[1])):
        points = [measured[f"{n}.{key}"] for n in names]
        panels.append(Panel(label, (Series("closed form", f, curve), Series("runs", SHARES, points, "points"))))
    text = ("Plain skewed wheels at 20 rad/s. They slip across all the time, so that their dry friction acts along the axis like "
            "a viscous one; at cos 30° = 0.866 the sleeve stands, and slides back beyond.")  # fmt: skip
    return Chart("Under load", "load over what both contacts bear, 1", tuple(panels), text, columns=2)


def _paths(runs: Mapping[str, Result]) -> Chart:
    shown = [(n, r) for n, r in runs.items() if n != "wheels"]
    panels = [Panel(label, tuple(Series(n if n == "whole" else f"{n} s", r.time, factor * r[f"drive.{key}"]) for n, r in shown))
              for label, key, factor in (("feed, mm", "feed", 1e3), ("rotation, rad", "rotation", 1.0))]  # fmt: skip
    return Chart("In one unit and in three", "time, s", tuple(panels),
                 "Voltages of 6 and 2 V from rest; macro steps of the split.")  # fmt: skip


CASE = Case(
    "friction-drive",
    "Friction-wheel drive against closed forms",
    "Feed and rotation of the three layouts without load, speed and loss of plain skewed wheels under load up to where the "
    "sleeve slides back, loads just inside and outside what the contacts bear, and the drive in three units against the one in "
    "one. Frączak's drive (2013) is known by its abstract: layouts and numbers are ours, and no measurement of it is in here.",
    "friction_drive",
    findings,
)
