"""Figures of underwater vehicles: track from above and from the side, attitude, thrusts with their limits, errors, constants.

Read from [analysis]: headings, s between marks of the heading on the track; transient, s, left out of the table of errors, which
a run that ends before it does not have.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ....harness.charts.blocks import Block
from ....harness.charts.charts import draw_chart
from ..keys import RovKeys
from ..records import vehicles
from .constants import constants_chart
from .control import errors_chart, errors_table, thrusts_chart, thrusts_table
from .motion import attitude_chart, current_chart, motion_chart, track_chart

if TYPE_CHECKING:
    from ....harness.validation.case import Row
    from ....results import Result

MARKS = 20  # of the heading on a track, where the scene does not say


def blocks(result: Result, rows: Sequence[Row] = ()) -> list[Block]:
    """Figures and tables of every vehicle whose position was recorded; several share the figures of their motion."""
    records = vehicles(result)
    if not records:
        return []
    interval = result.scene.analysis_as(RovKeys).headings or float(result.time[-1] - result.time[0]) / MARKS
    start = int(np.searchsorted(result.time, result.scene.analysis.transient))
    charts = [track_chart(records, interval), attitude_chart(records), motion_chart(records), current_chart(records)]
    content: list[Block] = [draw_chart(c) for c in charts if c is not None]
    for vehicle in records:
        who = f"{vehicle.unit}: " if len(records) > 1 else ""
        if vehicle.thrusts:
            content += [draw_chart(thrusts_chart(vehicle, who)), thrusts_table(vehicle, who)]
        if vehicle.errors:
            content.append(draw_chart(errors_chart(vehicle, who)))
            content += [errors_table(vehicle, start, who)] if start < result.time.size else []
        if vehicle.constants:
            content.append(draw_chart(constants_chart(vehicle, who)))
    return content
