"""Charts of studies, drawn: panels in a grid, sharing an x axis or each with its own."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .bands import BAND_POINTS, DRAWN_POINTS, banded, is_history, simplified
from .blocks import Figure
from .chart import Chart, Panel, Picture, Series
from .style import (
    BINARY,
    CYCLE,
    DIVERGING,
    GREEN,
    INK,
    ORANGE,
    PURPLE,
    RAW,
    RISING,
    SHADES,
    SKY,
    VERMILION,
    axis,
    drawn,
    label,
    layout,
    rectangle,
    standing_colour,
    standing_dash,
    tint,
    vertical,
)

MODES = {"line": "lines", "points": "markers", "line+points": "lines+markers", "dots": "markers", "dashed": "lines"}
SYMBOLS = ("circle", "square", "diamond", "triangle-up", "cross", "x", "star")
PALETTES = {"binary": BINARY, "rising": RISING, "range": RISING, "diverging": DIVERGING}
LINE_COLOURS = (GREEN, PURPLE, ORANGE, SKY, VERMILION)
DRAWN_DOTS = 12_000  # of a cloud
LABEL_GAP = 0.045  # of the panel's width; labels of lines nearer to one another are left out
HEADROOM = 0.14  # of the y axis, for the labels of lines
LEGEND_ROW = 28  # px
LEGEND_WIDTH = 860  # px between the margins of a figure on a usual screen
LEGEND_ENTRY = (55.0, 6.4)  # px, about: of an entry's line and gaps, and of a character of its name


@dataclass
class _Drawing:
    """The parts of a figure that are drawn already."""

    names: list[str]  # of the series; the place of a name is its colour
    line_names: list[str]
    data: list[dict[str, Any]] = field(default_factory=list)
    shapes: list[dict[str, Any]] = field(default_factory=list)
    notes: list[dict[str, Any]] = field(default_factory=list)
    axes: dict[str, Any] = field(default_factory=dict)
    shown: set[str] = field(default_factory=set)
    banded: bool = False

    def first(self, name: str) -> bool:
        """Whether the name comes up for the first time, and so goes into the legend."""
        new = name not in self.shown
        self.shown.add(name)
        return new


def draw_chart(chart: Chart) -> Figure:
    """A chart as a figure. Series of one name have one colour in all panels and one entry in the legend."""
    columns, count = chart.columns, len(chart.panels)
    rows = math.ceil(count / columns)
    series = [s for p in chart.panels for s in p.series if not s.faint]
    names = list(dict.fromkeys(s.name for s in series))
    drawing = _Drawing(names, list(dict.fromkeys(x.name for p in chart.panels for x in p.lines)))
    inner = (chart.height or (300 if rows == 1 else 220)) * rows  # px, panels and the gaps between them
    titled, labelled = (any(bool(getattr(p, what)) for p in chart.panels) for what in ("title", "x_label"))
    scaled = any(p.picture is not None and p.picture.palette != "binary" for p in chart.panels)
    scaled |= any(len(s.shades) for s in series)
    gap_x, gap_y = 0.12 + 0.04 * scaled, ((44 if titled else 26) + 42 * labelled) / inner
    width, tall = (1 - gap_x * (columns - 1)) / columns, (1 - gap_y * (rows - 1)) / rows
    for i, panel in enumerate(chart.panels):
        row, column = divmod(i, columns)
        left, top = column * (width + gap_x), 1 - row * (tall + gap_y)
        place = ([left, min(1.0, left + width)], [max(0.0, top - tall), top])
        last = i + columns >= count
        _panel(drawing, panel, "" if i == 0 else str(i + 1), place, chart.x_label if last else "", last)
    legend = {"orientation": "h", "x": 0, "y": 1 + (28 if titled else 8) / inner, "yanchor": "bottom"}
    more = LEGEND_ROW * _further_rows(drawing.shown)  # of the legend: without room for them they run under the figure's buttons
    above = (62 if len(drawing.shown) > 1 else 34) + more
    figure_layout = layout(
        inner + 50 + above,
        shapes=drawing.shapes,
        annotations=drawing.notes,
        showlegend=len(drawing.shown) > 1,
        legend=legend,
        margin={"l": 66, "r": 90 if scaled else 20, "t": above, "b": 50},
        **drawing.axes,
    )
    text = chart.text + (" Bands: from the least to the largest value; zoom in for all samples." if drawing.banded else "")
    return Figure(chart.title, {"data": drawing.data, "layout": figure_layout}, text)


def _further_rows(names: Iterable[str]) -> int:
    """How many rows the legend has beyond its first."""
    line, character = LEGEND_ENTRY
    return int(sum(line + character * len(n) for n in names) // LEGEND_WIDTH)


def _panel(drawing: _Drawing, panel: Panel, n: str, place: tuple[list[float], list[float]], x_label: str, last: bool) -> None:
    """Axes, shapes and traces of one panel, on the axes xn and yn."""
    own = bool(panel.x_label)
    x = axis(panel.x_label or x_label, domain=place[0], anchor="y" + n, showticklabels=own or last)
    y = axis(panel.y_label, grid=panel.picture is None, domain=place[1], anchor="x" + n)
    if n and not own:
        x["matches"] = "x"
    ends = _y_range(panel)
    if panel.equal:
        ranges = _square(panel)
        x |= {"range": ranges[0], "constrain": "domain", "constraintoward": "left", "showgrid": True}
        y |= {"range": ranges[1], "constrain": "domain", "constraintoward": "top", "scaleanchor": "x" + n}
    elif ends is not None:
        y["range"] = [math.log10(e) for e in ends] if panel.logarithmic else list(ends)
    if panel.logarithmic:
        y |= {"type": "log", "tickformat": "~g"} | ({"dtick": 1} if _decades(panel, ends) > 1.5 else {})
    if panel.x_range is not None:
        x["range"] = list(panel.x_range)
    drawing.axes |= {"xaxis" + n: x, "yaxis" + n: y}
    if panel.title:
        bold = {"size": 12.5, "color": INK}
        left, top = place[0][0], place[1][1]
        drawing.notes.append(label(f"<b>{panel.title}</b>", left, top, xanchor="left", yanchor="bottom", font=bold))
    shapes, notes = _bands(panel, n)
    drawing.shapes += shapes
    drawing.notes += notes
    for at, text in panel.x_marks:
        drawing.shapes.append(vertical(at, "x" + n, f"y{n} domain"))
        drawing.notes.append(label(text, at, 1, xref="x" + n, yref=f"y{n} domain", xanchor="left", yanchor="top", textangle=-90))
    if panel.lines and ends is not None:
        _lines(drawing, panel, n, ends)
    if panel.picture is not None:
        drawing.data.append(_picture(panel.picture, n, place))
        drawing.data += [_level(panel.picture, value, n) for value in panel.picture.limits]
    for s in panel.series:
        trace, cut = _trace(s, n, drawing.names, drawing.first(s.name), place)
        drawing.data.append(trace)
        drawing.banded |= cut


def _values(panel: Panel, which: str) -> np.ndarray:
    """All finite numbers of a panel's series along x or y."""
    values = np.concatenate([np.zeros(0), *(np.asarray(getattr(s, which), dtype=float) for s in panel.series)])
    return values[np.isfinite(values)]


def _y_range(panel: Panel) -> tuple[float, float] | None:
    """Ends of the y axis where they must be known: given, or lines reach over all of it. None: Plotly finds them."""
    if panel.y_range is not None or not panel.lines:
        return panel.y_range
    values = _values(panel, "y")
    if panel.logarithmic:
        values = values[values > 0.0]
    if not values.size:
        return (1.0, 10.0) if panel.logarithmic else (0.0, 1.0)
    low, high = float(values.min()), float(values.max())
    if panel.logarithmic:
        return 0.7 * low, high * (high / low) ** HEADROOM * 1.3
    low = min(0.0, low)
    return low, high + HEADROOM * (high - low or 1.0)


def _decades(panel: Panel, ends: tuple[float, float] | None) -> float:
    """How many powers of ten a logarithmic axis spans."""
    values = _values(panel, "y")
    low, high = ends or (min(values[values > 0.0], default=1.0), max(values[values > 0.0], default=1.0))
    return math.log10(high / low)


def _square(panel: Panel) -> tuple[list[float], list[float]]:
    """Equally long ranges of x and y about the middle of what is drawn; a picture fills its own."""
    x, y = _values(panel, "x"), _values(panel, "y")
    if panel.picture is not None:
        p = panel.picture
        return [float(p.x[0]), float(p.x[-1])], [float(p.y[0]), float(p.y[-1])]
    if not (x.size and y.size):
        return [-1.0, 1.0], [-1.0, 1.0]
    half = 0.54 * max(float(np.ptp(x)), float(np.ptp(y))) or 1.0
    middles = [0.5 * float(v.min() + v.max()) for v in (x, y)]
    return [middles[0] - half, middles[0] + half], [middles[1] - half, middles[1] + half]


def _lines(drawing: _Drawing, panel: Panel, n: str, ends: tuple[float, float]) -> None:
    """Vertical lines through the panel; their texts at its top, those that come first in the panel before others."""
    shared = panel.x_range or (float(min(_values(panel, "x"), default=0.0)), float(max(_values(panel, "x"), default=1.0)))
    room = LABEL_GAP * (shared[1] - shared[0])
    everywhere = [at for family in panel.lines for at, _ in family.at]
    taken: list[tuple[float, float]] = []
    for family in panel.lines:
        colour = LINE_COLOURS[drawing.line_names.index(family.name) % len(LINE_COLOURS)]
        x = [v for at, _ in family.at for v in (at, at, math.nan)]
        y = [v for _ in family.at for v in (*ends, math.nan)]
        trace = {
            "type": "scatter",
            "mode": "lines",
            "x": drawn(x, 6),
            "y": drawn(y),
            "name": family.name,
            "legendgroup": family.name,
            "showlegend": drawing.first(family.name),
            "legendrank": 1001,  # drawn first, named after the data
            "xaxis": "x" + n,
            "yaxis": "y" + n,
            "line": {"color": tint(colour, 0.75), "width": 1.2, "dash": "dot"},
            "text": [text for _, name in family.at for text in (name, name, "")],
            "hovertemplate": "%{fullData.name} %{text}<br>%{x:.5g}<extra></extra>",
        }
        drawing.data.append(trace)
        for at, text in family.at:
            side = _side(at, room, [*everywhere, shared[0]], taken) if text else 0
            if side:
                taken.append((min(at, at + side * room), max(at, at + side * room)))
                font, anchor = {"size": 11, "color": colour}, "left" if side > 0 else "right"
                drawing.notes.append(
                    label(text, at, 1, xref="x" + n, yref=f"y{n} domain", xanchor=anchor, yanchor="top", font=font, xshift=side)
                )


def _side(at: float, room: float, lines: list[float], taken: list[tuple[float, float]]) -> int:
    """Where a line's text of a width goes: 1 right of it, -1 left where another line is too near there, 0 nowhere."""

    def free(low: float, high: float) -> bool:
        return all(high <= a or low >= b for a, b in taken)

    def empty(low: float, high: float) -> bool:
        return not any(low < x < high for x in lines if x != at)

    right, left = (at, at + room), (at - room, at)
    if free(*right) and (empty(*right) or not (free(*left) and empty(*left))):
        return 1
    return -1 if free(*left) and empty(*left) else 0


def _picture(picture: Picture, n: str, place: tuple[list[float], list[float]]) -> dict[str, Any]:
    """A heat map; a binary one by whole pixels, others smoothed."""
    binary = picture.palette == "binary"
    values = np.asarray(picture.values, dtype=float)
    limit = float(np.nanmax(np.abs(values), initial=0.0)) or 1.0
    low = -limit if picture.palette == "diverging" else 0.0
    if picture.palette == "range" and np.isfinite(values).any():
        low, limit = float(np.nanmin(values)), float(np.nanmax(values))
        low -= 0.15 * (limit - low)  # the least value is not the paper's colour
    rows = [[int(v) for v in row] for row in values] if binary else [drawn(row, 3) for row in values]
    middle = 0.5 * (place[1][0] + place[1][1])
    bar = {"title": {"text": picture.label, "side": "right", "font": {"size": 13}}, "thickness": 12, "outlinewidth": 0}
    bar |= {"x": place[0][1] + 0.01, "xanchor": "left", "y": middle, "len": place[1][1] - place[1][0]}
    return {
        "type": "heatmap",
        "x": drawn(picture.x, 6),
        "y": drawn(picture.y, 6),
        "z": rows,
        "zmin": low,
        "zmax": 1.0 if binary else limit,
        "zsmooth": False if binary else "best",
        "colorscale": PALETTES[picture.palette],
        "showscale": not binary,
        "colorbar": bar,
        "xaxis": "x" + n,
        "yaxis": "y" + n,
        **({"hoverinfo": "skip"} if binary else {"hovertemplate": "%{x:.4g}, %{y:.4g}: %{z:.3g}<extra></extra>"}),
    }


def _level(picture: Picture, value: float, n: str) -> dict[str, Any]:
    """The line through the places of a picture that have a value."""
    rows = [drawn(row, 6) for row in np.asarray(picture.values, dtype=float)]
    contours = {
        "start": value,
        "end": value,
        "size": 1.0,
        "coloring": "none",
        "showlabels": True,
        "labelfont": {"size": 11, "color": VERMILION},
    }
    return {
        "type": "contour",
        "x": drawn(picture.x, 6),
        "y": drawn(picture.y, 6),
        "z": rows,
        "contours": contours,
        "autocontour": False,
        "showscale": False,
        "line": {"color": VERMILION, "width": 2},
        "xaxis": "x" + n,
        "yaxis": "y" + n,
        "hoverinfo": "skip",
        "name": "limit",
        "showlegend": False,
    }


def _bands(panel: Panel, n: str) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """Shapes and labels of the panel's ranges; an open end reaches somewhat beyond the data."""
    values = _values(panel, "y") if _values(panel, "y").size else np.zeros(1)
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


def _kept(s: Series, history: bool) -> np.ndarray | None:
    """Samples that are drawn of a cloud or an orbit; None: all of them."""
    if history or len(s.x) <= DRAWN_POINTS:
        return None
    if s.kind == "dots":  # by chance: every k-th point of a motion of period k would be one place of it
        return np.sort(np.random.default_rng(0).permutation(len(s.x))[:DRAWN_DOTS])
    return simplified(np.asarray(s.x, dtype=float), np.asarray(s.y, dtype=float), DRAWN_POINTS)


def _shading(shades: np.ndarray, kept: np.ndarray | None, text: str, place: tuple[list[float], list[float]]) -> dict[str, Any]:
    """Marker properties for numbers shown as colours: one hue below zero, another above; a few extremes do not set the scale."""
    finite = shades[np.isfinite(shades)]
    low, high = (float(v) for v in np.percentile(finite, (2, 98))) if finite.size else (-1.0, 1.0)
    low, high = min(low, 0.0), max(high, 0.0)
    if low == high:
        low, high = -1.0, 1.0
    (_, below), (_, middle), (_, above) = SHADES
    zero = -low / (high - low)
    scale = [[0.0, below if low < 0.0 else middle], [zero, middle], [1.0, above if high > 0.0 else middle]]
    bar = {"title": {"text": text, "side": "right", "font": {"size": 13}}, "thickness": 12, "outlinewidth": 0}
    bar |= {"x": place[0][1] + 0.01, "xanchor": "left", "y": 0.5 * sum(place[1]), "len": place[1][1] - place[1][0]}
    colours = {"color": drawn(shades if kept is None else shades[kept], 3), "colorscale": scale, "colorbar": bar}
    return colours | {"cmin": low, "cmax": high, "showscale": True}


def _trace(
    s: Series, n: str, names: list[str], first: bool, place: tuple[list[float], list[float]]
) -> tuple[dict[str, Any], bool]:
    k = 0 if s.faint else names.index(s.name)
    colour = RAW if s.faint else CYCLE[k % len(CYCLE)]
    dots, named = s.kind == "dots", bool(s.labels) or (len(s.x) > 0 and isinstance(s.x[0], str))
    history = named or (not dots and is_history(np.asarray(s.x, dtype=float)))
    kept = _kept(s, history)
    x, y = (s.x, s.y) if kept is None else (np.asarray(s.x)[kept], np.asarray(s.y)[kept])
    symbol = "circle" if dots else SYMBOLS[k % len(SYMBOLS)]
    marker: dict[str, Any] = {"color": colour, "size": 3 if dots else 8, "symbol": symbol}
    if len(s.shades):
        marker |= _shading(np.asarray(s.shades, dtype=float), kept, s.shade_label, place)
    trace: dict[str, Any] = {
        "type": "scatter",
        "x": list(x) if len(x) and isinstance(x[0], str) else drawn(x, 6),
        "y": drawn(y),
        "name": s.name,
        "legendgroup": s.name,
        "showlegend": first and not len(s.shades),
        "mode": MODES[s.kind],
        "xaxis": "x" + n,
        "yaxis": "y" + n,
        "line": {"color": colour, "width": 1 if s.faint else 1.8},
        "marker": marker,
    }
    if s.kind == "dashed":
        trace["line"]["dash"] = "dash"
    if s.labels:
        trace |= {"text": list(s.labels), "hovertemplate": "%{text}<br>%{y:.4g}<extra>%{fullData.name}</extra>"}
    if history and not named and len(s.x) > DRAWN_POINTS:
        return banded(trace, np.asarray(s.x, dtype=float), np.asarray(s.y, dtype=float), BAND_POINTS), True
    return trace, False
