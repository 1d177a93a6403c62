"""Temperatures, and what they do to clearances, of a run with heat in it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ....harness.charts.chart import Chart, Panel, Series

if TYPE_CHECKING:
    from ....results import Result

ICE = 273.15  # K
GROUPS = (  # ending of the signal's name, label, factor, offset
    ("temperature", "temperature, °C", 1.0, -ICE),
    ("clearance_change", "change of clearance, µm", 1e6, 0.0),
    ("power", "friction, W", 1.0, 0.0),
    ("conductance", "conductance, W/K", 1.0, 0.0),
)


def heat_chart(result: Result) -> Chart | None:
    """Recorded temperatures, changes of clearance, friction powers and conductances over time; None without a temperature."""
    panels = []
    for ending, label, factor, offset in GROUPS:
        signals = {n: np.asarray(c, dtype=float) for n, c in result.columns.items() if n.endswith(ending)}
        if signals:
            series = tuple(Series(n.replace("_", " "), result.time, factor * c + offset) for n, c in signals.items())
            panels.append(Panel(label, series))
    if not panels or not panels[0].y_label.startswith("temperature"):
        return None
    text = "Clearances are diametral; they fall where the shaft warms faster than the housing."
    return Chart("Heat", "time, s", tuple(panels), text)
