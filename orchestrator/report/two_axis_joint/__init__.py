"""Figures of joints with two axes: motion, phase portraits and sections, where the axis points, what should stay constant.

Read from [analysis]: transient, s, left out of phase portraits, tracks and sections; section = { angle, turns }.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ...analysis.joints import JointRecord, joints, poincare
from ...analysis.machines import after_transient
from ..charts import draw_chart
from ..page import Block
from .constants import constants_chart
from .phase import history_chart, phase_chart, section_chart
from .track import sphere_chart, tip_chart

if TYPE_CHECKING:
    from ...results import Result
    from ...validation.case import Row


def blocks(result: Result, rows: Sequence[Row] = ()) -> list[Block]:
    """Figures of every joint of a run whose angles and rates were recorded; none without one."""
    found = joints(result)
    begin = float(result.time[after_transient(result).start])
    return [b for record in found for b in _of_one(result, record, begin, f"{record.unit}: " if len(found) > 1 else "")]


def _of_one(result: Result, record: JointRecord, begin: float, who: str) -> list[Block]:
    charts = [history_chart(record, begin, who)]
    if record.pointing is not None:
        charts.append(sphere_chart(record, begin, who))
    if record.tip is not None:
        charts.append(tip_chart(record, begin, who))
    charts.append(phase_chart(record, begin, who))
    for chart in (section_chart(poincare(result, record, begin), who), constants_chart(record, who)):
        charts += [chart] if chart is not None else []
    return [draw_chart(c) for c in charts]
