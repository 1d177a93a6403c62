"""Figures and statistics of pantographs under a catenary, from a run and, where there are any, its rows of a reference table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from .....components.core.errors import BadInput
from ....harness.analysis.records import RecordedUnit
from ....harness.analysis.signals import ButterworthFilter
from ....harness.charts.blocks import Block, Figure, Sketch, Text
from ....harness.report.windows import fault_windows, shaded
from ..line import svg
from ..records import Passage, analysis_window, passages, statistics
from .force import force_figure, spectrum_figure
from .passage import passage_figure
from .wire import lateral_figure, uplift_figure, waves_figure, wire_figure

if TYPE_CHECKING:
    from ....harness.validation.case import Row
    from ....run.results import Result


SKETCH_WIDTH, MOST_DRAWN = 960.0, 500.0  # px, m


def blocks(result: Result, rows: Sequence[Row] = ()) -> list[Block]:
    """The figures, with a line where the run does not reach the window of its statistics."""
    content: list[Block] = [*line_sketches(result), *figures(result, rows)]
    if content and not rows:
        try:
            statistics(result)
        except BadInput as error:
            content.append(Text([f"No statistics; the figures show the run as far as it goes: {error}"], "warning"))
    return content


def line_sketches(result: Result) -> list[Sketch]:
    """The lines from tables of a run, each about the window of analysis or, without one, where the pantograph was."""
    sketches = []
    for name, passage in {p.catenary: p for p in passages(result)}.items():
        if name not in result.scene.units or "line_table" not in result.scene.units[name].effects:
            continue
        try:
            low, high = analysis_window(result)
        except BadInput:
            low, high = float(passage.record.position.min()), float(passage.record.position.max())
        high = min(high, low + MOST_DRAWN)
        line: Any = RecordedUnit(result, name).component
        if line is None:
            continue
        sketches.append(Sketch("The line", svg(line.form(), f"{name} from {low:g} to {high:g} m", (low, high), SKETCH_WIDTH)))
    return sketches


def figures(result: Result, rows: Sequence[Row] = (), low_pass: ButterworthFilter | None = None) -> list[Figure]:
    """All figures the run has the data for; none if no contact force was recorded."""
    all_passages = passages(result)
    if not all_passages:
        return []
    low_pass = low_pass or ButterworthFilter()
    candidates: list[Figure | None] = [_with_faults(result, all_passages, force_figure(result, all_passages, rows, low_pass))]
    if all_passages[0].supports:
        candidates.append(uplift_figure(result, all_passages, rows))
    candidates.append(lateral_figure(result, all_passages[0]))
    candidates.append(spectrum_figure(result, all_passages, low_pass))
    candidates.insert(0, passage_figure(result, all_passages[0], low_pass))
    name = f"{all_passages[0].catenary}.wire_profile.height"
    if name in result.snapshots:
        candidates += [wire_figure(result, all_passages[0], name), waves_figure(result, all_passages[0], name)]
    return [figure for figure in candidates if figure is not None]


def _with_faults(result: Result, all_passages: Sequence[Passage], figure: Figure) -> Figure:
    """The force with the windows of faults, at the positions where the pantograph then is; with several, it has no one place."""
    if len(all_passages) > 1:
        return figure
    axis = figure.figure["layout"]["xaxis"]
    low, high = axis["range"]
    record, windows = all_passages[0].record, []
    for window in fault_windows(result):
        begin, end = np.interp((window.begin, window.end), record.time, record.position).clip(low, high).tolist()
        if begin < end:
            windows.append(replace(window, begin=begin, end=end))
    return shaded(figure, windows, (low, high), axis["title"]["text"])
