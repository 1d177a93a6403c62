"""Energy and impulse of a vehicle without drag and loads: the equations keep them, and the run shows by how much it does not."""

from __future__ import annotations

import numpy as np

from ....harness.charts.chart import Chart, Panel, Series
from ..records import Vehicle

AXES = ("north", "east", "down")


def constants_chart(vehicle: Vehicle, who: str = "") -> Chart:
    """Drift of each, relative to its size at the start."""
    panels, drifts = [], []
    for name, values in vehicle.constants.items():
        drift = (values - values[:, :1]) / (float(np.linalg.norm(values[:, 0])) or 1.0)
        lines = ("energy",) if len(values) == 1 else AXES
        panels.append(Panel(f"{name}, 1", tuple(Series(n, vehicle.time, d) for n, d in zip(lines, drift, strict=True))))
        drifts.append(f"{name} by {float(np.abs(drift).max()):.2g}")
    text = f"A body in a perfect fluid keeps them; the run drifts, relative to the value at the start: {', '.join(drifts)}."
    return Chart(f"{who}Drift of energy and impulse", "time, s", tuple(panels), text, height=150)
