"""Charts of studies, drawn: panels in a grid over one kind of x axis."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from .chart import Chart, Panel, Series
from .page import Figure
from .style import CYCLE, GREEN, INK, ORANGE, RAW, axis, drawn, label, layout, thin_out, tint, vertical

MODES = {"line": "lines", "points": "markers", "line+points": "lines+markers"}
BAND_COLOURS = {"recalled": ORANGE, "inferred": ORANGE}
SYMBOLS = ("circle", "square", "diamond", "triangle-up", "cross", "x", "star")


def draw_chart(chart: Chart) -> Figure:
    """A chart as a figure. Series of one name have one colour in all panels and one entry in the legend."""
    columns = chart.columns
    rows = math.ceil(len(chart.panels) / columns)
    names = list(dict.fromkeys(s.name for p in chart.panels for s in p.series if not s.faint))
    height = (chart.height or (300 if rows == 1 else 220)) * rows + 90
    shapes: list[dict[str, Any]] = []
    notes: list[dict[str, Any]] = []
    data: list[dict[str, Any]] = []
    axes: dict[str, Any] = {}
    gap_x, gap_y = 0.09, 44 / (height - 90) if any(p.title for p in chart.panels) else 26 / (height - 90)
    width, tall = (1 - gap_x * (columns - 1)) / columns, (1 - gap_y * (rows - 1)) / rows
    shown: set[str] = set()
    for i, panel in enumerate(chart.panels):
        row, column = divmod(i, columns)
        n = "" if i == 0 else str(i + 1)
        left, top = column * (width + gap_x), 1 - row * (tall + gap_y)
        last = i + columns >= len(chart.panels)
        axes["xaxis" + n] = axis(
            chart.x_label if last else "", domain=[left, left + width], anchor="y" + n,
            **({"matches": "x", "showticklabels": last} if i else {"showticklabels": last}))
        axes["yaxis" + n] = axis(panel.y_label, domain=[max(0.0, top - tall), top], anchor="x" + n, showgrid=True, gridcolor="#eef1f4")
        if panel.title:
            notes.append(label(f"<b>{panel.title}</b>", left, top, xanchor="left", yanchor="bottom", font={"size": 12.5, "color": INK}))
        shapes += _bands(panel, n, notes, left + width, chart)
        for x, text in panel.x_marks:
            shapes.append(vertical(x, "x" + n, f"y{n} domain"))
            if text:
                notes.append(label(text, x, 1, xref="x" + n, yref=f"y{n} domain", xanchor="left", yanchor="top", textangle=-90))
        for s in panel.series:
            data.append(_trace(s, n, names, s.name not in shown))
            shown.add(s.name)
    legend = {"orientation": "h", "x": 0, "y": 1 + (34 if any(p.title for p in chart.panels) else 8) / (height - 90), "yanchor": "bottom"}
    figure = {"data": data, "layout": layout(
        height, shapes=shapes, annotations=notes, showlegend=len(shown) > 1, margin={"l": 66, "r": 20, "t": 62, "b": 50}, legend=legend, **axes)}
    thinned = any(len(s.x) > len(t["x"]) for s, t in zip((s for p in chart.panels for s in p.series), data, strict=True))
    return Figure(chart.title, figure, chart.text + (" Drawn with fewer points than computed; extremes are kept." if thinned else ""))


def _bands(panel: Panel, n: str, notes: list[dict[str, Any]], right: float, chart: Chart) -> list[dict[str, Any]]:
    values = np.concatenate([np.asarray(s.y, dtype=float) for s in panel.series]) if panel.series else np.zeros(1)
    values = values[np.isfinite(values)]
    spread = np.ptp(values) + 1.0
    shapes = []
    for b in panel.bands:
        colour = BAND_COLOURS.get(b.standing, GREEN)
        low = b.low if b.low is not None else values.min() - spread
        high = b.high if b.high is not None else values.max() + spread
        shapes.append({
            "type": "rect", "xref": f"x{n} domain", "x0": 0, "x1": 1, "yref": "y" + n, "y0": low, "y1": high, "layer": "below",
            "fillcolor": tint(colour, 0.13), "line": {"width": 0}})
        for end in (b.low, b.high):
            if end is not None:
                shapes.append({
                    "type": "line", "xref": f"x{n} domain", "x0": 0, "x1": 1, "yref": "y" + n, "y0": end, "y1": end, "layer": "below",
                    "line": {"width": 1, "color": tint(colour, 0.7), "dash": "dash" if b.standing in BAND_COLOURS else "solid"}})
        if b.name:
            notes.append(label(b.name, 1, high, xref=f"x{n} domain", yref="y" + n, xanchor="right", yanchor="top"))
    return shapes


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
        "type": "scatter", "x": x, "y": y, "name": s.name, "legendgroup": s.name, "showlegend": first, "mode": MODES[s.kind],
        "xaxis": "x" + n, "yaxis": "y" + n, "line": {"color": colour, "width": 1 if s.faint else 1.8},
        "marker": {"color": colour, "size": 8, "symbol": SYMBOLS[k % len(SYMBOLS)]}}
    if s.labels:
        trace |= {"text": list(s.labels), "hovertemplate": "%{text}<br>%{y:.4g}<extra>%{fullData.name}</extra>"}
    return trace
