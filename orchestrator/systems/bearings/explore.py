"""What a page that computes a bearing shows: its vibration, and after how many passages the motion repeats itself."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...harness.explore.figures import LiveFigure
from .records import BearingRecord, bearings

if TYPE_CHECKING:
    from ...run.results import Result

TURN = 2.0 * np.pi
SECTION = ("displacement_y", "displacement_x", "velocity_y", "velocity_x")  # the first one is drawn over parameters


def figures(result: Result) -> tuple[LiveFigure, ...]:
    """Of every bearing whose displacement was recorded, after the transient, as in the summary; and the points of its section."""
    return tuple(f for b in bearings(result) for f in _figures(b, result.scene.analysis.transient))


def _figures(bearing: BearingRecord, begin: float) -> list[LiveFigure]:
    def figure(name: str, text: str, unit: str, signal: str, kind: str) -> LiveFigure:
        return LiveFigure(f"{bearing.unit}.{name}", text, unit, (f"{bearing.unit}.{signal}",), kind, transient=begin)

    numbers = _section(bearing, begin)
    for name in bearing.signals:
        if name.startswith(("displacement", "acceleration")):
            called, unit = name.replace("_", " "), bearing.measures.get(name) or "1"
            numbers += [
                figure(f"{name}_rms", f"{called}, rms about the mean", unit, name, "standard deviation"),
                figure(f"{name}_peak_to_peak", f"{called}, peak to peak", unit, name, "peak to peak"),
                figure(f"{name}_kurtosis", f"{called}, kurtosis; a sine has 1.5", "1", name, "kurtosis"),
            ]
    if "max_ball_load" in bearing.signals:
        unit = bearing.measures.get("max_ball_load") or "1"
        numbers.append(figure("ball_load_max", "largest load of a ball", unit, "max_ball_load", "maximum"))
    return numbers


def _section(bearing: BearingRecord, begin: float) -> list[LiveFigure]:
    if "cage_angle" not in bearing.signals or not set(SECTION) <= bearing.signals.keys():
        return []
    text = "distinct points of the section, one a ball: few where the motion repeats itself"
    signals, section = tuple(f"{bearing.unit}.{n}" for n in SECTION), (f"{bearing.unit}.cage_angle", TURN / bearing.balls)
    return [
        LiveFigure(f"{bearing.unit}.distinct_points", text, "1", signals, "distinct points", transient=begin, section=section)
    ]
