"""The page of `cosimo trim`: a steady state with its modes, or steady states over a parameter."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ....derivatives.trim import WORDS, SteadyState, SteadyStates
from ...charts.blocks import Block, Cells, Figure, Text
from ...charts.chart import Chart, Panel, Series
from ...charts.charts import draw_chart
from ...studies.modes import Modes
from ..page import Page, Section, write_page
from .modes import bode, mode_cells, nyquist, poles

COLUMNS = 4  # of the table over a parameter; trim.csv has all
ZERO = 1e-12  # what rounding leaves of 0, in any unit
PANELS = 6  # of outputs over a parameter, those that move most


def for_trim(study: SteadyStates, directory: str | Path) -> Path:
    """`report.html` of steady states."""
    notes = [text for _, state in study.points for text in state.remarks]
    notes += [f"{study.parameter} = {value:g}: {reason}" for value, reason in study.refused if value is not None]
    blocks: list[Block] = [_over(study)] if study.parameter else []
    blocks += [trim_cells(study), *([Text(list(dict.fromkeys(notes)), "note")] if notes else [])]
    sections = [Section("Steady states" if study.parameter else "Steady state", blocks)]
    linear = tuple((value, state.linear) for value, state in study.points if state.linear is not None)
    if linear:
        modes = Modes(study.scene, study.parameter, linear)
        sections.append(Section("Modes", [poles(modes), mode_cells(modes)]))
    if linear and not study.parameter and linear[0][1].inputs:
        about = linear[0][1]
        sections.append(Section("Frequency response", [draw(about, n) for n in about.inputs for draw in (bode, nyquist)]))
    lead = "Fixed points of the coupled macro step, by Newton's method on its exact derivative."
    return write_page(Page(study.scene.title or study.scene.name, lead, sections), Path(directory) / "report.html")


def trim_cells(study: SteadyStates) -> Cells:
    """What was found, as a table; over a parameter the outputs that move most."""
    if not study.parameter:
        state = study.points[0][1]
        rows: list[tuple[str, ...]] = [(name, f"{value:.8g}", unit, kind) for kind, name, value, unit in state.rows()]
        return Cells(f"Steady state, {WORDS[state.stable]}", ("name", "value", "unit", ""), rows, right=frozenset({1}))
    names = _moved(study)[:COLUMNS]
    header = (study.parameter, *names, "")
    rows = [(f"{v:.6g}", *(f"{_value(s, n):.6g}" for n in names), WORDS[s.stable]) for v, s in study.points]
    return Cells(f"Steady states over {study.parameter}", header, rows, right=frozenset(range(len(names) + 1)))


def _value(state: SteadyState, name: str) -> float:
    return next(value for _, known, value, _ in state.rows() if known == name)


def _moved(study: SteadyStates) -> list[str]:
    """What was free, and the outputs that move most over the parameter, relative to their size."""
    kinds = {name: kind for kind, name, _, _ in study.points[0][1].rows()}
    free = [name for name, kind in kinds.items() if kind == "free"]
    ranges = {}
    for name in study.points[0][1].outputs:
        values = np.array([state.outputs[name] for _, state in study.points])
        size = np.abs(values).max()
        ranges[name] = np.ptp(values) / size if size > ZERO else 0.0
    return [*free, *sorted((n for n, r in ranges.items() if r > 0.0), key=lambda n: -ranges[n])][:PANELS]


def _over(study: SteadyStates) -> Figure:
    at = np.array([value for value, _ in study.points], dtype=float)
    units = {name: unit for _, name, _, unit in study.points[0][1].rows()}
    panels = []
    for name in _moved(study):
        values = np.array([_value(state, name) for _, state in study.points])
        lines = [Series(name, at, values, "line")]
        unstable = np.array([state.stable is False for _, state in study.points])
        if unstable.any():
            lines.append(Series("unstable", at[unstable], values[unstable], "points"))
        panels.append(Panel(f"{name}, {units[name]}" if units[name] not in ("", "1") else name, tuple(lines)))
    return draw_chart(Chart(f"Steady states over {study.parameter}", study.parameter, tuple(panels), columns=2))
