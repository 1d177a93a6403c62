"""Energy and momentum over time: their drift where the equations keep them, what is lost and given where they do not."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ....harness.charts.chart import Chart, Panel, Series
from ..records import JointRecord

UNITS = {"energy": "J", "momentum": "kg·m²/s"}
NARROW = 0.01  # of the largest value: what changes by less is shown as its change


def constants_chart(records: Sequence[JointRecord]) -> Chart | None:
    """One panel a quantity, one line a joint; None where nothing was recorded. What all of them keep is shown as its drift."""
    panels, kept, drifts = [], [], []
    for name, unit in UNITS.items():
        having = [r for r in records if name in r.kept]
        if not having:
            continue
        sizes = [float(np.abs(r.kept[name]).max()) or 1.0 for r in having]
        changes = [r.kept[name] - r.kept[name][0] for r in having]
        called = [name if len(records) == 1 else r.unit for r in having]
        values, label = [r.kept[name] for r in having], f"{name}, {unit}"
        if all(name in r.constant for r in having):
            values, label = [c / size for c, size in zip(changes, sizes, strict=True)], f"drift of {name}, 1"
            kept.append(name)
            drifts.append(f"{name} by {max(float(np.abs(v).max()) for v in values):.2g}")
        elif all(np.abs(c).max() < NARROW * size for c, size in zip(changes, sizes, strict=True)):
            values, label = changes, f"change of {name}, {unit}"
        lines = (Series(n, r.time, v) for n, r, v in zip(called, having, values, strict=True))
        panels.append(Panel(label, tuple(lines)))
    if not panels:
        return None
    text = ""
    if drifts:
        text = f"The equations keep {' and '.join(kept)}; the run drifts, relative to the largest value: {', '.join(drifts)}. "
        text += "A shorter substep reduces it."
    return Chart("Energy and momentum", "time, s", tuple(panels), text, height=200)
