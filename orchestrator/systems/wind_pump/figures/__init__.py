"""Figures of the wind pumps of a run: speeds, ratio, Cp and power over time and against the wind, starts and stops, water.

Read from [analysis]: average, standstill, pause, transient; see `analysis.wind_pump`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ....harness.analysis.records import after_transient
from ....harness.charts.blocks import Block
from ....harness.charts.charts import draw_chart
from ..keys import WindPumpKeys
from ..records import branches, chains, moving_mean
from .against_wind import bins_chart, branches_chart
from .course import course_chart, water_chart
from .shown import Shown
from .tables import efficiency_table, runs_table

if TYPE_CHECKING:
    from ....harness.validation.case import Row
    from ....results import Result


def blocks(result: Result, rows: Sequence[Row] = ()) -> list[Block]:
    """Figures and tables of every chain of turbine, transmission and pump whose speeds were recorded; none without one."""
    records = chains(result)
    if not records:
        return []
    keys = result.scene.analysis_as(WindPumpKeys)
    average = keys.average
    shown = [Shown.of(c, average, keys.standstill, keys.pause, f"{c.name}: " if len(records) > 1 else "") for c in records]
    content: list[Block] = [draw_chart(course_chart(shown))]
    wind = records[0].wind
    if wind is not None:
        smooth = moving_mean(result.time, wind, average)
        start = after_transient(result).start
        followed = branches(result.time[start:], smooth[start:])
        if followed:
            content.append(draw_chart(branches_chart(shown, followed, start)))
        elif (binned := bins_chart(shown, start)) is not None:
            content.append(draw_chart(binned))
    content.append(runs_table(shown))
    water = water_chart(shown)
    if water is not None:
        content.append(draw_chart(water))
    if any(c.powers for c in records):
        content.append(efficiency_table(result, shown, after_transient(result).start))
    return content
