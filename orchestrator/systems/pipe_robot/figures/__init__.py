"""Figures of pipe robots: way and mean speed, friction in detail, resonance, the pipe along the way, standstill and creep.

Read from [analysis]: transient, average, detail; see `analysis.pipe_robot`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ....harness.charts.blocks import Block, Text
from ....harness.charts.charts import draw_chart
from ..keys import PipeRobotKeys
from ..records import robots
from .course import course_chart, creep_chart, detail_chart
from .places import frequency_chart, pipe_chart
from .tables import energy_table, travel_table

if TYPE_CHECKING:
    from ....harness.validation.case import Row
    from ....results import Result


def blocks(result: Result, rows: Sequence[Row] = ()) -> list[Block]:
    """Figures and tables of the robots whose position and velocity were recorded; none without one."""
    records = robots(result)
    if not records:
        return []
    transient = result.scene.analysis.transient
    kept = slice(int(np.searchsorted(result.time, transient)), None)
    part = result.scene.analysis_as(PipeRobotKeys).detail
    charts = [course_chart(records, transient), frequency_chart(records), pipe_chart(records), creep_chart(records),
              detail_chart(records, part)]  # fmt: skip
    content: list[Block] = [draw_chart(c) for c in charts if c is not None]
    if result.time[kept].size < 2:
        return [*content, Text([f"There are no tables: the run ends before its transient of {transient:g} s."], "note")]
    content.append(travel_table(records, kept))
    energy = energy_table(records, kept)
    return content if energy is None else [*content, energy]
