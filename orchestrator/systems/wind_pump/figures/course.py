"""What happens over time: wind, speeds, ratio, power coefficient and powers; water delivered."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ....harness.charts.chart import Chart, Panel, Series
from .shown import COEFFICIENTS, Shown, scale

LITRES = 1e3  # per m³
MARKED = 6  # starts and stops in all that are marked; with more of them the marks hide what they mark


def course_chart(shown: Sequence[Shown]) -> Chart:
    """Wind, speeds, ratio, power coefficient and power over time, for all chains in the same panels."""
    seconds, unit = scale(shown[0].chain.time)
    t = shown[0].chain.time / seconds
    events = [(time / seconds, f"{s.who}{word}") for s in shown for word, time, _ in s.marks]
    few = len(events) <= MARKED
    marks = tuple(events) if few else ()
    plain = tuple((at, "") for at, _ in marks)
    panels = []
    if shown[0].wind is not None:
        winds = [Series("wind", t, shown[0].wind)]
        if shown[0].average and shown[0].chain.wind is not None:
            winds.insert(0, Series("wind as it blows", t, shown[0].chain.wind, faint=True))
        panels.append(Panel("wind, m/s", tuple(winds), x_marks=plain))
    speeds = [(f"{s.who}{name}", s.signals[key]) for s in shown
              for name, key in (("turbine", "turbine_speed"), ("pump", "pump_speed")) if key in s.signals]  # fmt: skip
    panels.append(Panel("speed, rad/s", tuple(Series(n, t, v) for n, v in speeds), x_marks=marks))
    ratios = tuple(Series(f"{s.who}pump", t, s.ratio) for s in shown if s.ratio is not None)
    if ratios:
        panels.append(Panel("pump speed over turbine speed, 1", ratios, x_marks=plain))
    for label, source, key, name in (
        ("power coefficient Cp, 1", "signals", "power_coefficient", "turbine"),
        ("power at the turbine, W", "powers", "aerodynamic", "turbine"),
        ("power into the water, W", "powers", "hydraulic", "pump"),
    ):
        series = tuple(Series(f"{s.who}{name}", t, getattr(s, source)[key]) for s in shown if key in getattr(s, source))
        if series:
            panels.append(Panel(label, series, x_marks=plain, y_range=COEFFICIENTS if "Cp" in label else None))
    text = f"{shown[0].averaged} Gaps in the ratio: the turbine stands (below {shown[0].standstill:g} rad/s)."
    if events:
        text += " Thin vertical lines: the pump starts or stops." if few else " The pump's starts and stops are in the table."
    return Chart("Course of the run", f"time, {unit}", tuple(panels), text.strip(), height=200)


def water_chart(shown: Sequence[Shown]) -> Chart | None:
    """Flow, water delivered and the tank's level over time; None where none of them was recorded."""
    seconds, unit = scale(shown[0].chain.time)
    t = shown[0].chain.time / seconds
    panels = []
    for label, key, factor in (("flow, l/s", "flow", LITRES), ("water delivered, m³", "delivered", 1.0),
                               ("level in the tank, m", "level", 1.0)):  # fmt: skip
        series = tuple(Series(f"{s.who}pump", t, factor * np.asarray(s.signals[key])) for s in shown if key in s.signals)
        if series:
            panels.append(Panel(label, series))
    if not panels:
        return None
    return Chart("Water", f"time, {unit}", tuple(panels), shown[0].averaged, height=200)
