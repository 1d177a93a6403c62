"""Charts of studies, drawn: panels in a grid over one kind of x axis."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from .chart import Chart, Panel, Series
from .page import Figure
from .style import (
    CYCLE,
    INK,
    RAW,
    axis,
    drawn,
    label,
    layout,
    rectangle,
    standing_colour,
    standing_dash,
    thin_out,
    tint,
    vertical,
)

MODES = {"line": "lines", "points": "markers", "line+points": "lines+markers"}
SYMBOLS = ("circle", "square", "diamond", "triangle-up", "cross", "x", "star")


def draw_chart(chart: Chart) -> Figure:
    """A chart as a figure. Series of one name have one colour in all panels and one entry in the legend."""
    columns = chart.columns
    rows = math.ceil(len(chart.panels) / columns)
    names = list(dict.fromkeys(s.name for p in chart.panels for s in p.series if not s.faint))
    inner = (chart.height or (300 if rows == 1 else 220)) * rows  # px, panels and the gaps between them
    titled = any(p.title for p in chart.panels)
    gap_x, gap_y = 0.09, (44 if titled else 26) / inner
    width, tall = (1 - gap_x * (columns - 1)) / columns, (1 - gap_y * (rows - 1)) / rows
    shapes: list[dict[str, Any]] = []
    notes: list[dict[str, Any]] = []
    data: list[dict[str, Any]] = []
    axes: dict[str, Any] = {}
    shown: set[str] = set()
    for i, panel in enumerate(chart.panels):
        row, column = divmod(i, columns)
        n = "" if i == 0 else str(i + 1)
        left, top = column * (width + gap_x), 1 - row * (tall + gap_y)
        last = i + columns >= len(chart.panels)
        axes["xaxis" + n] = axis(chart.x_label if last else "", domain=[left, left + width], anchor="y" + n, showticklabels=last)
        if i:
            axes["xaxis" + n]["matches"] = "x"
        axes["yaxis" + n] = axis(panel.y_label, grid=True, domain=[max(0.0, top - tall), top], anchor="x" + n)
        if panel.title:
            bold = {"size": 12.5, "color": INK}
            notes.append(label(f"<b>{panel.title}</b>", left, top, xanchor="left", yanchor="bottom", font=bold))
        band_shapes, band_notes = _bands(panel, n)
        shapes += band_shapes
        notes += band_notes
        for x, text in panel.x_marks:
            shapes.append(vertical(x, "x" + n, f"y{n} domain"))
            notes.append(label(text, x, 1, xref="x" + n, yref=f"y{n} domain", xanchor="left", yanchor="top", textangle=-90))
        for s in panel.series:
            data.append(_trace(s, n, names, s.name not in shown))
            shown.add(s.name)
    legend = {"orientation": "h", "x": 0, "y": 1 + (28 if titled else 8) / inner, "yanchor": "bottom"}
    figure = {
        "data": data,
        "layout": layout(
            inner + 112,
            shapes=shapes,
            annotations=notes,
            showlegend=len(shown) > 1,
            legend=legend,
            margin={"l": 66, "r": 20, "t": 62, "b": 50},
            **axes,
        ),
    }
    series = [s for p in chart.panels for s in p.series]
    thinned = any(len(s.x) > len(t["x"]) for s, t in zip(series, data, strict=True))
    return Figure(
        chart.title, figure, chart.text + (" Drawn with fewer points than computed; extremes are kept." if thinned else "")
    )


def _bands(panel: Panel, n: str) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """Shapes and labels of the panel's ranges; an open end reaches somewhat beyond the data."""
    values = np.concatenate([np.zeros(0), *(np.asarray(s.y, dtype=float) for s in panel.series)])
    values = values[np.isfinite(values)] if np.isfinite(values).any() else np.zeros(1)
    beyond = 0.2 * float(np.ptp(values))
    shapes, notes = [], []
    for b in panel.bands:
        colour = standing_colour(b.standing)
        low = b.low if b.low is not None else float(values.min()) - beyond
        high = b.high if b.high is not None else float(values.max()) + beyond
        shapes.append(rectangle((0, 1), (low, high), colour, xref=f"x{n} domain", yref="y" + n))
        for end in (b.low, b.high):
            if end is not None:
                edge = {"width": 1, "color": tint(colour, 0.7), "dash": standing_dash(b.standing)}
                shapes.append(
                    rectangle((0, 1), (end, end), colour, xref=f"x{n} domain", yref="y" + n, border=edge) | {"type": "line"}
                )
        if b.name:
            notes.append(label(b.name, 1, high, xref=f"x{n} domain", yref="y" + n, xanchor="right", yanchor="top"))
    return shapes, notes


def _trace(s: Series, n: str, names: list[str], first: bool) -> dict[str, Any]:
    k = 0 if s.faint else names.index(s.name)
    colour = RAW if s.faint else CYCLE[k % len(CYCLE)]
    categories = len(s.x) and isinstance(s.x[0], str)
    if categories or s.labels:
        x: Any = list(s.x) if categories else drawn(s.x)
        y: Any = drawn(s.y)
    else:
        x, y, _ = thin_out(np.asarray(s.x, dtype=float), np.asarray(s.y, dtype=float))
        x, y = drawn(x, 6), drawn(y)
    trace: dict[str, Any] = {
        "type": "scatter",
        "x": x,
        "y": y,
        "name": s.name,
        "legendgroup": s.name,
        "showlegend": first,
        "mode": MODES[s.kind],
        "xaxis": "x" + n,
        "yaxis": "y" + n,
        "line": {"color": colour, "width": 1 if s.faint else 1.8},
        "marker": {"color": colour, "size": 8, "symbol": SYMBOLS[k % len(SYMBOLS)]},
    }
    if s.labels:
        trace |= {"text": list(s.labels), "hovertemplate": "%{text}<br>%{y:.4g}<extra>%{fullData.name}</extra>"}
    return trace
