"""How punctual a run at the pace of the clock was."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ..charts.blocks import Block
from ..charts.chart import Chart, Grid, Panel, Series
from ..charts.charts import draw_chart
from ..summary import PACING
from .generic import grid_table

if TYPE_CHECKING:
    from ...results import Result

NAMES = {**PACING, "waking": "behind the clock when the wait ended"}


def blocks(result: Result) -> list[Block]:
    """Distribution of the durations and the lateness, and their percentiles; none of a run that did not keep to the clock."""
    of: Mapping[str, Any] = result.info.get("real_time") or {}
    if not of:
        return []
    edges = 1e3 * np.array(of["bins"])
    x = np.repeat(edges, 2)[1:-1]
    step = 1e3 * result.scene.master.step
    series = tuple(
        Series(text, x, np.maximum(np.repeat(np.array(of[f"{name}_counts"], dtype=float), 2), 0.5))
        for name, text in (("duration", "duration of a step"), ("lateness", "behind the clock"))
    )
    largest = max(of["duration"]["100 %"], of["lateness"]["100 %"], 1e-3 * step)
    panel = Panel("steps", series, x_marks=((step, "macro step"),), logarithmic=True, x_range=(0.0, 1.2e3 * largest))
    text = f"{of['steps']} steps, {of['late']} of them behind the clock. Ten bins in a decade; an empty bin is drawn at 0.5."
    chart = Chart("Steps at the pace of the clock", "ms", (panel,), text, height=260)
    columns = tuple(of["duration"])
    rows = tuple((NAMES[name], *(f"{1e3 * of[name][p]:.3g}" for p in columns)) for name in NAMES if of[name])
    return [draw_chart(chart), grid_table(Grid("Percentiles, ms", ("", *columns), rows))]
