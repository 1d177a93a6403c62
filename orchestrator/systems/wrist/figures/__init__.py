"""Figures of wrists: motion of hand and rows, postures with the row rule, muscles, ligaments, four-bar linkages.

Read from [analysis]: transient, s, left out of paths and postures; postures, s, instants that are tabulated.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ....harness.analysis.records import after_transient
from ....harness.charts.blocks import Block
from ....harness.charts.charts import draw_chart
from ..keys import WristKeys
from ..records import bundles, linkages, muscles, wrists
from .four_bars import linkage_chart
from .motion import motion_chart, paths_chart
from .parts import ligaments_chart, muscles_chart
from .postures import difference_table, posture_table

if TYPE_CHECKING:
    from ....harness.validation.case import Row
    from ....results import Result


def blocks(result: Result, rows: Sequence[Row] = ()) -> list[Block]:
    """Figures and tables of the wrists and four-bar linkages of a run that were recorded; several wrists are compared."""
    content: list[Block] = []
    begin = after_transient(result).start
    records = wrists(result)
    if records:
        instants = result.scene.analysis_as(WristKeys).postures
        content += [draw_chart(motion_chart(records, instants)), draw_chart(paths_chart(records, instants, begin))]
        content.append(posture_table(records, instants, begin))
        if len(records) > 1 and instants:
            content.append(difference_table(records, instants))
    pulled, bound = muscles(result), bundles(result)
    content += [draw_chart(muscles_chart(m, len(pulled) > 1)) for m in pulled[:1]]  # those of compared wrists have one programme
    if bound:
        content.append(draw_chart(ligaments_chart(bound)))
    content += [draw_chart(linkage_chart(record)) for record in linkages(result)]
    return content
