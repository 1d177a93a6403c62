"""Resolution of the sensors, the no-load speed, and where the drive stops: fifty approaches to one place from both sides."""

from __future__ import annotations

import math

import numpy as np

from ......components.friction_drive.kinematics import ANGLE, LAYOUTS, sleeve_rates
from .....harness.charts.chart import Chart, Panel, Series
from .....harness.validation.case import Options
from .....harness.validation.papers import Evidence
from .....run import run
from .... import read_scene
from .drive import CONSTANT, COSINE, FULL, GEAR, GEAR_LOSS, RESISTANCE, ROLLERS, SHAFT_STATIC, SLEEVE, VOLTAGE, WHEEL, controlled

COUNTS = 2048  # per turn of a motor: 512 lines, four counts a line
TARGET = 0.01  # m
APPROACHES = 50
GAIN, RATE_GAIN = 20.0, 0.4  # 1/s, V.s/rad
SEAL_STATIC = 2.6  # N
STEP = 1e-6  # m, of the sleeve's own sensor


def study(options: Options) -> Evidence:
    """Fifty runs of a second, a run at full voltage, and the counts."""
    count = 2.0 * math.pi / (COUNTS * GEAR)
    feed, _ = sleeve_rates(count, count, LAYOUTS.index("skewed"), ANGLE, WHEEL, SLEEVE)
    _, rotation = sleeve_rates(count, -count, LAYOUTS.index("skewed"), ANGLE, WHEEL, SLEEVE)
    full = run(
        read_scene(
            {
                "title": "Full voltage",
                "stop_time": 0.3,
                "master": {"step": 1e-3},
                "units": {
                    "drive": {
                        "component": "FrictionDrive",
                        "effects": list(FULL),
                        "parameters": {
                            "trocar_friction.level": 0.0,
                            "shaft_friction.level": 0.0,
                            "shaft_friction.gear_loss": 0.0,
                            "first_voltage": VOLTAGE,
                            "second_voltage": VOLTAGE,
                        },
                    }
                },
                "record": {"signals": ["drive.feed_rate"]},
            },
            "friction_drive",
        ),
        in_process=True,
    )
    starts = TARGET + np.concatenate((-np.linspace(5e-4, 0.0125, APPROACHES // 2), np.linspace(5e-4, 0.0125, APPROACHES // 2)))
    ends = np.array([approach(float(s)) for s in starts])
    measured = {
        "resolution.feed": 1e6 * feed,
        "resolution.rotation": math.degrees(rotation),
        "no_load": float(full["drive.feed_rate"][-1]),
        "repeatability": 1e6 * float(np.ptp(ends)),
        "repeatability.worst": 1e6 * float(np.abs(ends - TARGET).max()),
        "repeatability.band": 1e6 * band(),
    }
    measured["repeatability.share"] = measured["repeatability.worst"] / measured["repeatability.band"]
    panel = Panel(
        "end less set point, µm",
        (
            Series("approaches", 1e3 * (starts - TARGET), 1e6 * (ends - TARGET), "points"),
            Series("band of dry friction", [-12.5, 12.5], [1e6 * band()] * 2, faint=True),
            Series("band of dry friction", [-12.5, 12.5], [-1e6 * band()] * 2, faint=True),
        ),
    )
    chart = Chart(
        "Fifty approaches to one place",
        "start less set point, mm",
        (panel,),
        "Without integrals the drive stops where its friction holds it, short of the set point on either side.",
    )
    return Evidence(measured, (chart,))


def approach(start: float) -> float:
    """Where the sleeve stands a second after it was sent from `start` to the set point, m."""
    result = controlled(
        1.0,
        ROLLERS,
        FULL,
        {"start_feed": start},
        {"set_feed": TARGET, "rate_integral_gain": 0.0, "quantisation.feed_step": STEP, "quantisation.wheel_step": 1.65e-4},
        ("quantisation",),
    )
    return float(result["drive.feed"][-1])


def band() -> float:
    """Largest error at which friction of shafts and seal holds the drive, m: F_c / K_p of the whole loop.

    Each motor carries the static friction of its shaft and half of that of the seal, through a gear that loses a fifth. One count
    of the sensor is added: it is what the controller cannot see.
    """
    torque = (SHAFT_STATIC + 0.5 * WHEEL * SEAL_STATIC / COSINE) / (1.0 - GEAR_LOSS)
    voltage = RESISTANCE * torque / (GEAR * CONSTANT)
    wheel_rate = voltage / (GEAR * CONSTANT + RATE_GAIN)
    return wheel_rate * WHEEL / COSINE / GAIN + STEP
