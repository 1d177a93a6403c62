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
RESONANCE = 41  # further ones about a lightly damped mode
DECADES = 4  # below the highest frequency that samples tell


def for_modes(study: Modes, directory: str | Path) -> Path:
    """`report.html` of modes."""
    blocks: list[Block] = [poles(study), mode_cells(study)]
    notes = [text for _, linear in study.points for text in linear.remarks]
    notes += [f"{study.parameter} = {value:g}: {reason}" for value, reason in study.refused if value is not None]
    if notes:
        blocks.append(Text(list(dict.fromkeys(notes)), "note"))
    sections = [Section("Modes", blocks)]
    linear = study.points[0][1]
    if linear.inputs:
        sections.append(Section("Frequency response", [draw(linear, name) for name in linear.inputs for draw in (bode, nyquist)]))
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


def poles(study: Modes) -> Figure:
    """Eigenvalues in the complex plane, or over the parameter."""
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


def _responses(linear: Linear, name: str) -> tuple[np.ndarray, list[tuple[str, np.ndarray]]]:
    """Frequencies, Hz, and by output its response to an input there, where there is any."""
    highest = 0.5 / linear.step
    frequencies = highest * np.logspace(-DECADES, 0.0, POINTS + 1)[:-1]
    around = np.tan(np.linspace(-1.5, 1.5, RESONANCE))  # a lightly damped mode turns within its damping ratio of its frequency
    peaks = [m.frequency * (1.0 + m.damping * around) for m in linear.reduced().modes() if m.frequency and abs(m.damping) < 0.2]
    finer = np.concatenate([frequencies, *peaks])
    frequencies = np.unique(finer[(finer >= frequencies[0]) & (finer < highest)])
    values = linear.response(frequencies)[:, :, linear.inputs.index(name)]
    return frequencies, [(output, values[:, k]) for k, output in enumerate(linear.outputs) if np.abs(values[:, k]).max() > 0.0]


def bode(linear: Linear, name: str) -> Figure:
    """Magnitude and phase of all outputs by an input, over frequency."""
    frequencies, drawn = _responses(linear, name)
    sizes = tuple(Series(output, frequencies, np.abs(v)) for output, v in drawn)
    phases = tuple(Series(output, frequencies, np.rad2deg(np.unwrap(np.angle(v)))) for output, v in drawn)
    panels = (Panel("magnitude", sizes, logarithmic=True), Panel("phase, deg", phases))
    figure = draw_chart(Chart(f"By {name}", "frequency, Hz", panels, "Outputs per input, both in their units of measure."))
    for key, axis in figure.figure["layout"].items():
        if key.startswith("xaxis"):
            axis.update(type="log", range=[float(np.log10(frequencies[0])), float(np.log10(0.5 / linear.step))])
    return figure


def nyquist(linear: Linear, name: str) -> Figure:
    """The same responses in the complex plane, a panel an output, with the point -1 where it is near."""
    frequencies, drawn = _responses(linear, name)
    panels = []
    for output, values in drawn:
        size = float(np.abs(values).max())
        labels = [f"{f:.4g} Hz" for f in frequencies]
        lines = [Series(output, values.real, values.imag, "line", labels=labels)]
        if 0.02 < 1.0 / size < 2.0:
            lines.append(Series("-1", np.array([-1.0]), np.array([0.0]), "points"))
        panels.append(Panel("imaginary part", tuple(lines), x_label=f"real part of {output}", equal=True))
    text = "From low to high frequency. With positive frequencies alone; those of negative ones are mirrored at the real axis."
    return draw_chart(
        Chart(f"Nyquist plot, by {name}", "real part", tuple(panels), text, columns=min(len(panels), 2), height=320)
    )
