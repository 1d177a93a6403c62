"""Friction-wheel drive against closed forms: kinematics, speed under load, loss, limits of the load, and its split into units."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from ....harness.validation import Evidence, Runs
from ....run.results import Result
from ....scene.build import unit
from ....scene.scene import Scene
from ... import build_scene

RATE = 20.0  # rad/s of the wheels
RADIUS, SLEEVE, ANGLE = 0.01, 0.005, math.pi / 6.0
LIMIT = 12.0  # N, 2 mu N
SHARES = (0.0, 0.25, 0.5, 0.75, math.cos(ANGLE), 0.9)  # of it, that load the sleeve
LOADS = {"axial": (1.0, 0.0), "around": (0.0, 1.0), "both": (0.6, 0.8)}  # of force and torque, on the limit's ellipse
NEAR = 0.01  # share by which a load is below or above it
VOLTAGES: dict[str, Any] = {"first_voltage": 6.0, "second_voltage": 2.0}
STEPS = (2e-3, 1e-3, 5e-4)  # s, macro steps of the split drive
ROLLERS: dict[str, Any] = {"layout": "skewed_free_rollers"}


def wheels(parameters: Mapping[str, Any], effects: tuple[str, ...] = ("exact_slip",)) -> dict[str, Any]:
    """The wheels' unit."""
    return unit("FrictionWheels", effects=effects, **parameters)


def scenes() -> dict[str, Scene]:
    """All wheels side by side, the whole drive, and its parts with three macro steps."""
    return {"wheels": side_by_side(), "whole": drive(False, STEPS[0]), **{f"split {h:g}": drive(True, h) for h in STEPS}}


def side_by_side() -> Scene:
    """Wheels that turn at a given rate under many loads, and wheels that stand under loads about the limit."""
    units: dict[str, Any] = {}
    for layout in ("skewed", "skewed_free_rollers", "orthogonal"):
        for way, sign in (("feed", 1.0), ("rotation", -1.0)):
            second = RATE if layout == "orthogonal" else sign * RATE
            first = RATE if way == "feed" or layout != "orthogonal" else 0.0
            second = second if way == "rotation" or layout != "orthogonal" else 0.0
            if layout != "skewed" or way == "feed":  # unloaded plain wheels that turn against each other leave the feed open
                units[f"{layout}_{way}"] = wheels({"layout": layout, "first_rate": first, "second_rate": second})
    for share in SHARES[1:]:
        units[_loaded(share)] = wheels({"first_rate": RATE, "second_rate": RATE, "external_force": -share * LIMIT})
    for name, (force, torque) in LOADS.items():
        for way, share in (("below", 1.0 - NEAR), ("above", 1.0 + NEAR)):
            load = {"external_force": share * force * LIMIT, "external_torque": share * torque * LIMIT * SLEEVE}
            units[f"{name}_{way}"] = wheels({"exact_slip.static_ratio": 1.0, **load})
    signals = [f"{u}.{s}" for u in units for s in ("feed", "rotation", "feed_rate", "rotation_rate", "contact_power")]
    return build_scene(units, stop_time=0.5, step=1e-3, name="friction-drive", record={"signals": signals})


def _loaded(share: float) -> str:
    return f"loaded_{round(1e3 * share)}"


def drive(split: bool, step: float) -> Scene:
    """The drive at constant voltages, contacts that creep: two motors and wheels, or one unit."""
    units, links = {"drive": unit("FrictionDrive", **ROLLERS, **VOLTAGES)}, []
    if split:
        units = {f"{k}_motor": unit("ServoMotor", voltage=VOLTAGES[f"{k}_voltage"]) for k in ("first", "second")}
        units["drive"] = wheels(ROLLERS, ())
        links = [f"{k}_motor.rate -> drive.{k}_rate" for k in ("first", "second")]
        links += [f"drive.{k}_torque -> {k}_motor.load_torque" for k in ("first", "second")]
    record = {"signals": ["drive.feed", "drive.rotation"], "interval": STEPS[0]}
    name = "friction-drive-split" if split else "friction-drive-whole"
    return build_scene(units, links, stop_time=0.1, step=step, name=name, record=record)


def measure(runs: Runs) -> Evidence:
    """Rates and powers at the end, and how the split drive comes near the whole one as steps become shorter."""
    result = runs["wheels"]
    measured: dict[str, float] = {}
    for name in ("skewed_feed", "skewed_free_rollers_feed", "orthogonal_feed", *map(_loaded, SHARES[1:])):
        measured[f"{name}.rate"] = result[f"{name}.feed_rate"][-1]
        measured[f"{name}.power"] = result[f"{name}.contact_power"][-1]
    for name in ("skewed_free_rollers_rotation", "orthogonal_rotation"):
        measured[f"{name}.rate"] = result[f"{name}.rotation_rate"][-1]
    for name in LOADS:
        for way in ("below", "above"):
            rates = result[f"{name}_{way}.feed_rate"][-1], SLEEVE * result[f"{name}_{way}.rotation_rate"][-1]
            measured[f"{name}.{way}"] = float(np.hypot(*rates))
    apart = [_apart(runs[f"split {h:g}"], runs["whole"]) for h in STEPS]
    measured["split.order"] = float(np.polyfit(np.log(STEPS), np.log(apart), 1)[0])
    f = np.linspace(0.0, 0.95, 400)
    root = np.sqrt(1.0 - f * f)
    drawn = {
        "load": f,
        "closed.rate": RADIUS * RATE * (math.cos(ANGLE) - math.sin(ANGLE) * f / root),
        "closed.power": LIMIT * RADIUS * RATE * math.sin(ANGLE) / root,
        "shares": SHARES,
        **{
            f"runs.{key}": [measured[f"{n}.{key}"] for n in ("skewed_feed", *map(_loaded, SHARES[1:]))]
            for key in ("rate", "power")
        },
    }
    return Evidence(measured, data=drawn)


def _apart(split: Result, reference: Result) -> float:
    """Largest distance of the sleeve's surface from that of the whole drive, m."""
    ways = [split[f"drive.{n}"] - reference[f"drive.{n}"] for n in ("feed", "rotation")]
    return float(np.hypot(ways[0], SLEEVE * ways[1]).max())
