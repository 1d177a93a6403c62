"""Mean speed and amplitude against the exciter's frequency, and against the place in the pipe."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ....harness.charts.chart import Chart, Panel, Series
from ..records import RobotRecord, amplitude, mean_speed
from .course import changes, resonance_lines

MILLI = 1e3
DEGREES = 180.0 / np.pi
SWING = 0.2  # of the largest frequency, from which on a stretch is a sweep, and not a motor that swings about its speed


def frequency_chart(records: Sequence[RobotRecord]) -> Chart | None:
    """Mean speed and amplitude over a frequency that changes, rising and falling; None where none does."""
    turning = [r for r in records if r.frequency is not None and changes(r.frequency)]
    if not turning:
        return None
    speeds, amplitudes = [], []
    low, high = np.inf, 0.0
    for r in turning:
        w = r.frequency
        if w is None:
            continue
        low, high = min(low, float(w.min())), max(high, float(w.max()))
        size = amplitude(r)
        for way, part in ways(w):
            name = f"{r.unit}, {way}"
            speeds.append(Series(name, w[part], mean_speed(r)[part]))
            if size is not None:
                amplitudes.append(Series(name, w[part], MILLI * size[part]))
    lines = resonance_lines(turning, low, high)
    panels = [Panel("mean speed, m/s", tuple(speeds), lines=lines)]
    if amplitudes:
        panels.append(Panel("amplitude of the inner mass against the body, mm", tuple(amplitudes), lines=lines))
    text = "The inner mass resonates against the free body, or against one that sticks; the robot is fastest where it does."
    return Chart("Against the exciter's frequency", "exciter, rad/s", tuple(panels), text, columns=2, height=320)


def ways(frequency: np.ndarray) -> list[tuple[str, slice]]:
    """("rising" or "falling", samples) of the stretches up to the largest frequency and after it; small ones are left out."""
    top = int(np.argmax(frequency))
    parts = [("rising", slice(0, top + 1)), ("falling", slice(top, frequency.size))]
    return [(way, p) for way, p in parts if np.ptp(frequency[p]) > SWING * frequency[top]]


def pipe_chart(records: Sequence[RobotRecord]) -> Chart | None:
    """Mean speed and slope over the place in the pipe; None where the slope was not recorded or is the same everywhere."""
    sloping = [r for r in records if "route.slope" in r.signals and np.ptp(r.signals["route.slope"]) > 0.0]
    if not sloping:
        return None
    speeds = [Series(r.unit, r.signals["position"], mean_speed(r)) for r in sloping]
    longest = max(sloping, key=lambda r: float(np.ptp(r.signals["position"])))
    order = np.argsort(longest.signals["position"], kind="stable")
    slope = Series("pipe", longest.signals["position"][order], DEGREES * longest.signals["route.slope"][order])
    panels = (Panel("mean speed, m/s", tuple(speeds)), Panel("slope of the pipe, degrees", (slope,)))
    text = "At a slope at which friction and weight forwards equal friction less weight backwards, a robot gets no further."
    return Chart("Along the pipe", "place, m", panels, text, columns=2, height=280)
