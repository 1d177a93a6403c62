"""What a page that computes a friction drive shows: how it moves to its set points."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...harness.analysis.records import RecordedUnit
from ...harness.explore.figures import LiveFigure
from . import FrictionDriveKeys
from .records import AXES, Drive, drives, moves
from .summary import TEXTS

if TYPE_CHECKING:
    from ...run.results import Result


def figures(result: Result) -> tuple[LiveFigure, ...]:
    """Of every drive whose feed and rotation were recorded, as in the summary. Set points change when they do in the scene."""
    return tuple(f for drive in drives(result) for f in _figures(result, drive))


def _figures(result: Result, drive: Drive) -> list[LiveFigure]:
    keys, unit = result.scene.analysis_as(FrictionDriveKeys), RecordedUnit(result, drive.unit)
    bands, controller, rows = {"feed": keys.feed_band, "rotation": keys.rotation_band}, unit.driving("feed", "feed"), []
    done = moves(drive, bands)
    for axis in AXES:
        if controller is None or axis not in drive.error:
            continue
        signals = controller.column(f"wanted_{axis}"), unit.column(axis)
        mine = [m for m in done if m.axis == axis]
        ends = [*(m.begin for m in mine[1:]), float(drive.time[-1]) + 1.0]  # the last one stays
        table = tuple(
            (m.begin, m.begin + m.lasts, end, float(np.sign(m.way)), bands[axis]) for m, end in zip(mine, ends, strict=True)
        )
        kinds = {"error_end": "end", "error_max": "largest size"}
        kinds |= {"overshoot": "overshoot", "settling_time": "settling time"} if mine else {}
        for name, kind in kinds.items():
            measure, text = TEXTS[f"{axis}_{name}"]
            rows.append(
                LiveFigure(f"{drive.unit}.{axis}_{name}", text, measure, signals, kind, combine="difference", moves=table)
            )
    return rows
