"""Figures of the rotors of a run: run-up, spectra, Campbell diagram, orbits and forces at the bearings.

Read from [analysis], beside what `analysis.machines` and `analysis.whirl` say: orbit_windows = [[from, to], ...] in s,
orders = [1, 2] (lines in the waterfall).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ....harness.analysis.records import after_transient
from ....harness.analysis.spectra import turns_steadily
from ....harness.charts.blocks import Block
from ....harness.charts.charts import draw_chart
from ...bearings.figures.heat import heat_chart
from ...bearings.records import STEADY
from ..keys import RotorKeys
from ..records import RotorRecord, rotors
from ..whirl import whirl
from .campbell import campbell_chart
from .orbits import forces_chart, orbits_chart
from .speed import history_chart, run_up_chart, spectrum_chart, waterfall_chart

if TYPE_CHECKING:
    from ....harness.validation.case import Row
    from ....results import Result

TURNS = 8  # in the record, below which nothing is followed; of an orbit


def blocks(result: Result, rows: Sequence[Row] = ()) -> list[Block]:
    """Figures of every rotor of a run whose speed was recorded; none without one."""
    records = rotors(result)
    content = [b for record in records for b in _of_one(result, record, f"{record.unit}: " if len(records) > 1 else "")]
    heat = heat_chart(result)
    return [*content, draw_chart(heat)] if heat is not None else content


def _of_one(result: Result, record: RotorRecord, who: str) -> list[Block]:
    analysis = result.scene.analysis_as(RotorKeys)
    begin = float(result.time[after_transient(result).start])
    speed = record.signals["speed"][record.time >= begin]
    diagram = whirl(result, record)
    if diagram is not None:
        critical = diagram.critical
    else:
        critical = np.asarray(analysis.critical_speeds, dtype=float)
    varies = float(np.ptp(speed)) > STEADY * float(np.abs(speed).max())
    moves = {"x", "y"} <= record.signals.keys()
    turns = "angle" in record.signals and _turns(record.signals["angle"][record.time >= begin]) >= TURNS
    content: list[Block] = []
    if moves:
        content.append(draw_chart(history_chart(record, begin, who)))
    if moves and turns and varies:
        content.append(draw_chart(run_up_chart(record, begin, critical, who)))
        content.append(draw_chart(waterfall_chart(record, begin, critical, analysis.orders, who)))
    elif moves and speed.any():
        content.append(draw_chart(spectrum_chart(record, begin, who)))
    if diagram is not None:
        content.append(draw_chart(campbell_chart(diagram, who)))
    content += [draw_chart(c) for c in orbits_chart(record, _windows(analysis.orbit_windows, record), who)]
    if any("force_x" in p for p in record.ports.values()):
        content.append(draw_chart(forces_chart(record, begin, who)))
    return content


def _turns(angle: np.ndarray) -> float:
    """Turns of a recorded angle; 0 where it stands or turns back."""
    return abs(float(np.ptp(np.unwrap(angle)))) / (2.0 * np.pi) if turns_steadily(angle) else 0.0


def _windows(given: Sequence[Sequence[float]], record: RotorRecord) -> list[tuple[float, float]]:
    """Times of the orbits: the scene's, else the last turns at the last speed, else the last tenth."""
    first, last = float(record.time[0]), float(record.time[-1])
    if given:
        return [(float(a), float(b)) for a, b in given]
    speed = abs(float(record.signals["speed"][-1]))
    length = TURNS * 2.0 * np.pi / speed if speed > 0.0 else 0.1 * (last - first)
    return [(max(first, last - length), last)]
