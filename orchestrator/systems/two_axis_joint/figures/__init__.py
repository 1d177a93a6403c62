"""Figures of joints with two axes: motion, phase portraits and sections, where the axis points, what should stay constant.

Read from [analysis]: transient, s, left out of phase portraits, tracks and sections; section = { angle, turns }.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ....harness.analysis.records import after_transient
from ....harness.charts.blocks import Block
from ....harness.charts.chart import Chart
from ....harness.charts.charts import draw_chart
from ..records import JointRecord, joints, poincare
from .constants import constants_chart
from .phase import comparison_charts, history_chart, phase_chart, section_chart
from .track import sphere_chart, tip_chart

if TYPE_CHECKING:
    from ....harness.validation.case import Row
    from ....results import Result


def blocks(result: Result, rows: Sequence[Row] = ()) -> list[Block]:
    """Figures of the joints of a run whose angles and rates were recorded; none without one. Several are compared first."""
    records = joints(result)
    begin = float(result.time[after_transient(result).start])
    single = len(records) == 1
    charts = [history_chart(records[0], begin)] if single else comparison_charts(records, begin)
    for record in records:
        charts += _of_one(result, record, begin, "" if single else f"{record.unit}: ")
    constants = constants_chart(records)
    return [draw_chart(c) for c in (charts if constants is None else [*charts, constants])]


def _of_one(result: Result, record: JointRecord, begin: float, who: str) -> list[Chart]:
    charts = []
    if record.pointing is not None and not who:  # of several that are compared, the tracks would all look alike
        charts.append(sphere_chart(record, begin))
    if record.tip is not None:
        charts.append(tip_chart(record, begin, who))
    further = (phase_chart(record, begin, who), section_chart(poincare(result, record, begin), who))
    return charts + [c for c in further if c is not None]
