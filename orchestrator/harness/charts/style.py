"""Colours, number formats and the layout all figures share.

Colours are those of Okabe and Ito: distinct for colour-blind readers and in print.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

INK = "#1c2733"
MUTED = "#5c6b7a"
RULE = "#d5dce3"
GRID = "#eef1f4"
BLUE, ORANGE, GREEN, PURPLE, SKY, VERMILION = "#0072b2", "#e69f00", "#009e73", "#aa4499", "#56b4e9", "#d55e00"
CYCLE = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY, INK)
RAW = "#a9bccd"
PAPER = "#ffffff"
DIVERGING = [[0, "#b35806"], [0.25, "#f1a340"], [0.5, "#f7f7f7"], [0.75, "#67a9cf"], [1, "#053061"]]
RISING = [[0, PAPER], [0.15, "#cfe3ee"], [0.4, "#67a9cf"], [0.7, BLUE], [1, "#08304f"]]
BINARY = [[0, PAPER], [1, INK]]
SHADES = [[0, BLUE], [0.5, "#8f9ba7"], [1, VERMILION]]  # of points: none of them fades into the paper
WORDS = {GREEN: "#00795a", VERMILION: "#b34a00", ORANGE: "#8a6000", SKY: "#1b6fa0"}  # of texts, 4.5 to 1 from the paper
# The same figures on dark paper: every colour of the left as the one of the right.
DARK = {
    PAPER: "#14191f", INK: "#e4e9ee", MUTED: "#a3b0bd", RULE: "#46525e", GRID: "#262e37", RAW: "#5d7183",
    BLUE: "#4fa8de", ORANGE: "#eeb13c", GREEN: "#2fc295", PURPLE: "#d283cf", SKY: "#8cd0f5", VERMILION: "#ff8742",
    "#f7f7f7": "#20262d", "#053061": "#a9d4f5", "#b35806": "#ffc68a", "#cfe3ee": "#1d3344", "#08304f": "#cfeaff",
    "#67a9cf": "#4386ad", "#f1a340": "#b8721f", "#00795a": "#2fc295", "#b34a00": "#ff8742", "#8a6000": "#eeb13c", "#1b6fa0": "#8cd0f5",
}  # fmt: skip
FONT = '"Source Sans 3", "Segoe UI", "Helvetica Neue", Arial, "Liberation Sans", sans-serif'
SAMPLES = "samples"  # of a trace: all of what it shows the band of, (x, y); nothing that Plotly knows

# of a layout: the legend is a column to the right of the panel
LEGEND_RIGHT: dict[str, Any] = {
    "margin": {"l": 70, "r": 250, "t": 34, "b": 50},
    "legend": {"orientation": "v", "x": 1.02, "y": 1, "font": {"size": 11}},
}


def tint(colour: str, alpha: float) -> str:
    """A colour "#rrggbb" as rgba text."""
    r, g, b = (int(colour[i : i + 2], 16) for i in (1, 3, 5))
    return f"rgba({r},{g},{b},{alpha:g})"


def axis(title: str = "", grid: bool = False, **more: Any) -> dict[str, Any]:
    """A calm axis: outside ticks, no zero line, a pale grid only where values are read off."""
    base = {
        "title": {"text": title, "standoff": 8, "font": {"size": 13}},
        "tickfont": {"size": 12},
        "exponentformat": "power",
        "automargin": True,
        "ticks": "outside",
        "ticklen": 4,
        "tickcolor": RULE,
        "linecolor": MUTED,
        "linewidth": 1,
        "showline": True,
        "showgrid": grid,
        "gridcolor": GRID,
        "zeroline": False,
    }
    return base | more


def layout(height: int, **more: Any) -> dict[str, Any]:
    """The layout every figure starts from."""
    base = {
        "height": height,
        "font": {"family": FONT, "size": 13, "color": INK},
        "paper_bgcolor": PAPER,
        "plot_bgcolor": PAPER,
        "margin": {"l": 66, "r": 20, "t": 34, "b": 48},
        "hovermode": "closest",
        "separators": ".",  # no comma between thousands
        "colorway": list(CYCLE),
        "legend": {"orientation": "h", "x": 0, "y": 1.0, "yanchor": "bottom", "font": {"size": 12}, "bgcolor": "rgba(0,0,0,0)"},
        "hoverlabel": {"font": {"size": 12, "family": FONT, "color": INK}, "bgcolor": PAPER, "bordercolor": RULE},
    }
    return base | more


def line(
    x: Any, y: Any, name: str, colour: str, width: float = 1.8, *, hover: str = "", dash: str = "solid", **more: Any
) -> dict[str, Any]:
    """A line trace; `hover` is Plotly's template of what the pointer shows."""
    base = {
        "type": "scatter",
        "mode": "lines",
        "x": drawn(x, 6),
        "y": drawn(y),
        "name": name,
        "line": {"color": colour, "width": width, "dash": dash},
    }
    return base | ({"hovertemplate": hover + "<extra></extra>"} if hover else {}) | more


def markers(
    x: Any, y: Any, name: str, colour: str, symbol: str = "circle", size: float = 8, *, hover: str = "", **more: Any
) -> dict[str, Any]:
    """A trace of points; `hover` is Plotly's template of what the pointer shows."""
    base = {
        "type": "scatter",
        "mode": "markers",
        "x": drawn(x),
        "y": drawn(y),
        "name": name,
        "marker": {"color": colour, "symbol": symbol, "size": size},
    }
    return base | ({"hovertemplate": hover} if hover else {}) | more


def rows_axis(names: Sequence[str]) -> dict[str, Any]:
    """A y axis with a name at each whole number from 0, upwards."""
    return axis("", tickvals=list(range(len(names))), ticktext=list(names), range=[-0.6, len(names) - 0.4])


def vertical(x: float, xref: str = "x", yref: str = "paper", *, colour: str = RULE, dash: str = "solid") -> dict[str, Any]:
    """A thin vertical line over the full height, behind the data."""
    return {
        "type": "line",
        "x0": x,
        "x1": x,
        "xref": xref,
        "y0": 0,
        "y1": 1,
        "yref": yref,
        "layer": "below",
        "line": {"color": colour, "width": 1, "dash": dash},
    }


def rectangle(
    x: tuple[float, float],
    y: tuple[float, float],
    colour: str,
    alpha: float = 0.13,
    *,
    xref: str = "paper",
    yref: str = "y",
    border: dict[str, Any] | None = None,
) -> dict[str, Any]:
    """A shaded rectangle behind the data; by default over the full width."""
    return {
        "type": "rect",
        "x0": x[0],
        "x1": x[1],
        "xref": xref,
        "y0": y[0],
        "y1": y[1],
        "yref": yref,
        "layer": "below",
        "fillcolor": tint(colour, alpha),
        "line": border or {"width": 0},
    }


def label(text: str, x: float, y: float, **more: Any) -> dict[str, Any]:
    """A small text in a figure, in the figure's own coordinates unless given otherwise."""
    note: dict[str, Any] = {"text": text, "x": x, "y": y, "xref": "paper", "yref": "paper", "showarrow": False} | more
    font = {"size": 11, "color": MUTED} | note.get("font", {})
    return note | {"font": font | {"color": WORDS.get(font["color"], font["color"])}}


def standing_colour(standing: str) -> str:
    """Ranges that decide are green, those that do not are orange (and dashed or hatched)."""
    return ORANGE if standing in ("unconfirmed", "inferred") else GREEN


def standing_dash(standing: str) -> str:
    """Dash of a range's border."""
    return "dash" if standing in ("unconfirmed", "inferred") else "solid"


def drawn(values: Any, digits: int = 5) -> list[Any]:
    """Numbers for a figure's JSON: `digits` significant ones, None for what is not finite."""
    return [float(f"{v:.{digits}g}") if math.isfinite(v) else None for v in np.asarray(values, dtype=float).ravel().tolist()]


def number(value: float, low: float | None = None, high: float | None = None) -> str:
    """A measured number as text, with about one digit more than its range is wide."""
    if not math.isfinite(value):
        return "–"
    width = 0.0 if low is None or high is None else high - low
    if width > 0.0:
        decimals = max(0 if width > 100 else 1, 2 - math.ceil(math.log10(width)))
        text = f"{value:.{decimals}f}"
    else:
        text = f"{value:.4g}" if value else "0"
    return text.replace("-", "−")
