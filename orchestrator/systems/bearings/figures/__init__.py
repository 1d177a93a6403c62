"""Figures and measures of the bearings of a run.

Read from [analysis], beside what `analysis.machines` says: section = { signal, angle, turns }, marks = ["outer", "inner",
"ball", "cage", "shaft"], highest_frequency, envelope_band = [from, to], recurrence = { threshold, theiler, interval }.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ....harness.analysis.records import after_transient
from ....harness.charts.blocks import Block
from ....harness.charts.charts import draw_chart
from ..keys import BearingKeys
from ..records import BearingRecord, bearings
from .heat import heat_chart
from .motion import history_chart, motion_table, orbit_chart, section_points
from .repetition import quantified, recurrence_chart, recurrence_table
from .spectrum import envelope_chart, spectrum_chart

if TYPE_CHECKING:
    from ....harness.validation.case import Row
    from ....results import Result


def blocks(result: Result, rows: Sequence[Row] = ()) -> list[Block]:
    """Figures and tables of every bearing of a run whose displacement was recorded; none without one."""
    records = bearings(result)
    content: list[Block] = []
    for record in records:
        content += _of_one(result, record, f"{record.unit}: " if len(records) > 1 else "")
    heat = heat_chart(result)
    return [*content, draw_chart(heat)] if heat is not None else content


def _of_one(result: Result, record: BearingRecord, who: str) -> list[Block]:
    analysis = result.scene.analysis_as(BearingKeys)
    begin = float(result.time[after_transient(result).start])
    points = section_points(result, record, begin)
    content: list[Block] = [draw_chart(history_chart(record, begin, who))]
    content.append(draw_chart(spectrum_chart(record, begin, analysis, who)))
    envelope = envelope_chart(record, begin, analysis, who)
    content += [draw_chart(envelope)] if envelope is not None else []
    content.append(draw_chart(orbit_chart(record, begin, points, who)))
    recurrence = quantified(record, begin, analysis)
    content.append(draw_chart(recurrence_chart(recurrence, record, who)))
    content += [recurrence_table(recurrence, record, who), motion_table(record, begin, points, who)]
    return content
