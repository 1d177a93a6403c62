"""Figures of friction-wheel drives: way and set point, rest, wheels and motors, contacts, moves, energies.

Read from [analysis]: feed_band, rotation_band; see `analysis.friction_drive`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ....harness.charts.blocks import Block
from ....harness.charts.charts import draw_chart
from ..keys import FrictionDriveKeys
from ..records import drives
from .contacts import contacts_chart, plane_chart
from .tables import energies_table, moves_table, rests_table
from .way import rest_chart, way_chart, wheels_chart

if TYPE_CHECKING:
    from ....harness.validation.case import Row
    from ....results import Result


def blocks(result: Result, rows: Sequence[Row] = ()) -> list[Block]:
    """Figures and tables of every drive whose feed and rotation were recorded; several share the figure of their way."""
    records = drives(result)
    if not records:
        return []
    keys = result.scene.analysis_as(FrictionDriveKeys)
    bands = {"feed": keys.feed_band, "rotation": keys.rotation_band}
    charts = [way_chart(records, bands), rest_chart(records)]
    for drive in records:
        who = f"{drive.unit}: " if len(records) > 1 else ""
        charts += [wheels_chart(drive, who), contacts_chart(drive, who), plane_chart(drive, who)]
    drawn: list[Block] = [draw_chart(c) for c in charts if c is not None]
    tables = [moves_table(records, bands), rests_table(records), energies_table(records)]
    return drawn[:1] + [t for t in tables if t is not None][:1] + drawn[1:] + [t for t in tables if t is not None][1:]
