"""The page of `cosimo modes`: eigenvalues, their path over a parameter, and frequency responses."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ....derivatives.linear import Linear, Mode
from ...charts.blocks import Block, Cells, Figure, Text
from ...charts.chart import Chart, Panel, Series
from ...charts.charts import draw_chart
from ...studies.modes import Modes
from ..page import Page, Section, write_page

POINTS = 400  # of a frequency response
DECADES = 4  # below the highest frequency that samples tell


def for_modes(study: Modes, directory: str | Path) -> Path:
    """`report.html` of modes."""
    blocks: list[Block] = [_poles(study), mode_cells(study)]
    notes = [text for _, linear in study.points for text in linear.remarks]
    notes += [f"{study.parameter} = {value:g}: {reason}" for value, reason in study.refused if value is not None]
    if notes:
        blocks.append(Text(list(dict.fromkeys(notes)), "note"))
    sections = [Section("Modes", blocks)]
    linear = study.points[0][1]
    if linear.inputs:
        sections.append(Section("Frequency response", [bode(linear, name) for name in linear.inputs]))
    lead = f"Linear about t = {linear.time:g} s, with steps of {linear.step:g} s."
    return write_page(Page(study.scene.title or study.scene.name, lead, sections), Path(directory) / "report.html")


def mode_cells(study: Modes) -> Cells:
    """The modes as a table; over a parameter those that move."""
    header = ("rate, 1/s", "frequency, Hz", "damping ratio", "kind", "units")

    def texts(mode: Mode) -> tuple[str, ...]:
        damping = "" if np.isnan(mode.damping) else f"{mode.damping:.4g}"
        return f"{mode.rate.real:.5g}", f"{mode.frequency:.5g}", damping, mode.kind, mode.where

    if not study.parameter:
        linear = study.points[0][1]
        rows = [texts(mode) for mode in linear.modes()]
        return Cells(f"Modes at t = {linear.time:.6g} s", header, rows, right=frozenset({0, 1, 2}))
    rows = [(f"{value:g}", *texts(mode)) for value, mode in study.rows() if mode.rate]
    return Cells(f"Modes over {study.parameter}", (study.parameter, *header), rows, right=frozenset({0, 1, 2, 3}))


def _poles(study: Modes) -> Figure:
    rows = study.rows()
    rates, frequencies = np.array([m.rate.real for _, m in rows]), np.array([m.frequency for _, m in rows])
    labels = [m.where for _, m in rows]
    if study.parameter:
        at = np.array([value for value, _ in rows], dtype=float)
        panels = tuple(
            Panel(label, (Series(study.parameter, at, values, "points", labels=labels),))
            for label, values in (("rate, 1/s", rates), ("frequency, Hz", frequencies))
        )
        return draw_chart(Chart(f"Modes over {study.parameter}", study.parameter, panels, "A mode with a positive rate grows."))
    panel = Panel("frequency, Hz", (Series("modes", rates, frequencies, "points", labels=labels),))
    return draw_chart(
        Chart(
            "Eigenvalues",
            "rate, 1/s",
            (panel,),
            "A mode with a positive rate grows. One eigenvalue of each conjugate pair is drawn.",
        )
    )


def bode(linear: Linear, name: str) -> Figure:
    """Magnitude and phase of all outputs by an input, over frequency."""
    highest = 0.5 / linear.step
    frequencies = highest * np.logspace(-DECADES, 0.0, POINTS + 1)[:-1]
    values = linear.response(frequencies)[:, :, linear.inputs.index(name)]
    drawn = [(output, values[:, k]) for k, output in enumerate(linear.outputs) if np.abs(values[:, k]).max() > 0.0]
    sizes = tuple(Series(output, frequencies, np.abs(v)) for output, v in drawn)
    phases = tuple(Series(output, frequencies, np.rad2deg(np.unwrap(np.angle(v)))) for output, v in drawn)
    panels = (Panel("magnitude", sizes, logarithmic=True), Panel("phase, deg", phases))
    figure = draw_chart(Chart(f"By {name}", "frequency, Hz", panels, "Outputs per input, both in their units of measure."))
    for key, axis in figure.figure["layout"].items():
        if key.startswith("xaxis"):
            axis.update(type="log", range=[float(np.log10(frequencies[0])), float(np.log10(highest))])
    return figure
