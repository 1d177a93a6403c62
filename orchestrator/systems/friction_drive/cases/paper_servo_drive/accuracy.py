"""Resolution of the sensors, the no-load speed, and where the drive stops: fifty approaches to one place from both sides."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ......components.friction_drive.kinematics import ANGLE, LAYOUTS, sleeve_rates
from .....harness.validation import Evidence, Runs
from .....scene.build import unit
from .....scene.scene import Scene
from .drive import (
    CONSTANT,
    COSINE,
    FULL,
    GEAR,
    GEAR_LOSS,
    RESISTANCE,
    ROLLERS,
    SHAFT_STATIC,
    SLEEVE,
    VOLTAGE,
    WHEEL,
    controlled,
    side_by_side,
)

COUNTS = 2048  # per turn of a motor: 512 lines, four counts a line
TARGET = 0.01  # m
AWAY = np.linspace(5e-4, 0.0125, 25)
STARTS = TARGET + np.concatenate((-AWAY, AWAY))  # m
GAIN, RATE_GAIN = 20.0, 0.4  # 1/s, V.s/rad
SEAL_STATIC = 2.6  # N
STEP = 1e-6  # m, of the sleeve's own sensor


def scenes() -> dict[Any, Scene]:
    """Fifty approaches of a second by their start in m, and a drive without friction at full voltage."""
    losses: dict[str, Any] = {"trocar_friction.level": 0.0, "shaft_friction.level": 0.0, "shaft_friction.gear_loss": 0.0}
    full = unit("FrictionDrive", effects=FULL, first_voltage=VOLTAGE, second_voltage=VOLTAGE, **losses)
    approaches = {float(start): approach(float(start)) for start in STARTS}
    return {**approaches, "full voltage": side_by_side({"drive": full}, 0.3, ["feed_rate"])}


def measure(runs: Runs) -> Evidence:
    """Where the approaches end, how fast the free drive is, and what a count of the encoders is worth."""
    count = 2.0 * math.pi / (COUNTS * GEAR)
    feed, _ = sleeve_rates(count, count, LAYOUTS.index("skewed"), ANGLE, WHEEL, SLEEVE)
    _, rotation = sleeve_rates(count, -count, LAYOUTS.index("skewed"), ANGLE, WHEEL, SLEEVE)
    ends = np.array([runs[float(start)]["drive.feed"][-1] for start in STARTS])
    measured = {
        "resolution.feed": 1e6 * feed,
        "resolution.rotation": math.degrees(rotation),
        "no_load": runs["full voltage"]["drive.feed_rate"][-1],
        "repeatability": 1e6 * float(np.ptp(ends)),
        "repeatability.worst": 1e6 * float(np.abs(ends - TARGET).max()),
        "repeatability.band": 1e6 * band(),
    }
    measured["repeatability.share"] = measured["repeatability.worst"] / measured["repeatability.band"]
    drawn = {"start": 1e3 * (STARTS - TARGET), "end": 1e6 * (ends - TARGET)}
    return Evidence(measured, data={**drawn, "below": [-measured["repeatability.band"]] * 2})


def approach(start: float) -> Scene:
    """The second after the sleeve was sent from `start`, m, to the set point."""
    sensors = {"quantisation.feed_step": STEP, "quantisation.wheel_step": 1.65e-4}
    control = {"set_feed": TARGET, "rate_integral_gain": 0.0, **sensors}
    return controlled(1.0, ROLLERS, FULL, {"start_feed": start}, control, ("quantisation",))


def band() -> float:
    """Largest error at which friction of shafts and seal holds the drive, m: F_c / K_p of the whole loop.

    Each motor carries the static friction of its shaft and half of that of the seal, through a gear that loses a fifth. One count
    of the sensor is added: it is what the controller cannot see.
    """
    torque = (SHAFT_STATIC + 0.5 * WHEEL * SEAL_STATIC / COSINE) / (1.0 - GEAR_LOSS)
    voltage = RESISTANCE * torque / (GEAR * CONSTANT)
    wheel_rate = voltage / (GEAR * CONSTANT + RATE_GAIN)
    return wheel_rate * WHEEL / COSINE / GAIN + STEP
