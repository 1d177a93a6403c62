"""The page of `cosimo gradient`: which parameters move a figure most, and the derivatives."""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite
from pathlib import Path

from ....derivatives.gradient import Gradient, Slope
from ...charts.blocks import Block, Cells, Figure, Text
from ...charts.style import BLUE, axis, drawn, layout, rows_axis
from ...summary import with_error
from ..page import Page, Section, write_page

ROW = 26  # px of a parameter
MOST = 20  # bars of a figure


def for_gradient(study: Gradient, directory: str | Path) -> Path:
    """`report.html` of derivatives."""
    figures = dict.fromkeys(s.figure for s in study.slopes)
    sections = [Section(name, _blocks([s for s in study.slopes if s.figure == name])) for name in figures]
    if study.refused:
        refused = [f"{name}: {reason}." for name, reason in study.refused.items()]
        sections.append(Section("Parameters without a derivative", [Text(refused, "note")]))
    lead = f"Derivatives of {len(figures)} figures by {len({s.parameter for s in study.slopes})} parameters."
    return write_page(Page(study.scene.title or study.scene.name, lead, sections), Path(directory) / "report.html")


def gradient_cells(slopes: Sequence[Slope]) -> Cells:
    """The derivatives of one figure as a table."""
    header = ("parameter", "value", "derivative", "elasticity, %/%", "how")
    shown = [(with_error(s.derivative, s.error), f"{s.elasticity:.3g}") for s in slopes]
    rows = [
        (s.parameter, f"{s.at:.6g}", *("–" if "nan" in text else text for text in texts), s.how)
        for s, texts in zip(slopes, shown, strict=True)
    ]
    title = f"{slopes[0].figure} = {slopes[0].value:.6g} {slopes[0].unit}"
    return Cells(title, header, rows, right=frozenset({1, 2, 3}))


def _blocks(slopes: Sequence[Slope]) -> list[Block]:
    shown = [s for s in slopes if isfinite(s.elasticity) and s.elasticity][:MOST][::-1]  # the largest at the top
    return [*([_bars(shown)] if shown else []), gradient_cells(slopes)]


def _bars(shown: Sequence[Slope]) -> Figure:
    bars = {
        "type": "bar",
        "orientation": "h",
        "x": drawn([s.elasticity for s in shown], 4),
        "y": list(range(len(shown))),
        "marker": {"color": BLUE},
        "hovertemplate": "%{x}<extra></extra>",
    }
    size = layout(110 + ROW * len(shown), xaxis=axis("elasticity, %/%", grid=True), yaxis=rows_axis([s.parameter for s in shown]))
    caption = "So many percent the figure moves for one percent of the parameter."
    return Figure("What moves it", {"data": [bars], "layout": size}, caption)
