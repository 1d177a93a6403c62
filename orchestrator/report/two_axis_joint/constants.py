"""Energy and momentum over time: their drift where the equations keep them, what is lost and given where they do not."""

from __future__ import annotations

import numpy as np

from ...analysis.joints import JointRecord
from ..chart import Chart, Panel, Series

UNITS = {"energy": "J", "momentum": "kg·m²/s"}


def constants_chart(record: JointRecord, who: str = "") -> Chart | None:
    """One panel a quantity; None where none was recorded. Those that are constant are shown as what they drift by."""
    panels, drifts = [], []
    for name, values in record.kept.items():
        if name in record.constant:
            size = float(np.abs(values).max()) or 1.0
            drift = (values - values[0]) / size
            drifts.append(f"{name} by {np.abs(drift).max():.2g}")
            panels.append(Panel(f"drift of {name}, 1", (Series(name, record.time, drift),)))
        else:
            panels.append(Panel(f"{name}, {UNITS[name]}", (Series(name, record.time, values),)))
    if not panels:
        return None
    text = ""
    if drifts:
        text = f"The equations keep {' and '.join(n for n in record.kept if n in record.constant)}; the run drifts, relative to "
        text += f"the largest value: {', '.join(drifts)}. A shorter substep reduces it."
    return Chart(f"{who}Energy and momentum", "time, s", tuple(panels), text, height=200)
