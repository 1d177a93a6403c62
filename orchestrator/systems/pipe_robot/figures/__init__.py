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
    found = robots(result)
    if not found:
        return []
    transient = result.scene.analysis.transient
    kept = slice(int(np.searchsorted(result.time, transient)), None)
    part = result.scene.analysis_as(PipeRobotKeys).detail
    charts = [course_chart(found, transient), frequency_chart(found), pipe_chart(found), creep_chart(found),
              detail_chart(found, part)]  # fmt: skip
    made: list[Block] = [draw_chart(c) for c in charts if c is not None]
    if result.time[kept].size < 2:
        return [*made, Text([f"There are no tables: the run ends before its transient of {transient:g} s."], "note")]
    made.append(travel_table(found, kept))
    energy = energy_table(found, kept)
    return made if energy is None else [*made, energy]
