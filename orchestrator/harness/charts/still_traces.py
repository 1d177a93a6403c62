"""Traces of a still picture: lines, markers, bars, maps and contours as elements of an SVG."""

from __future__ import annotations

import math
import re
import struct
import zlib
from base64 import b64encode
from collections.abc import Sequence
from html import escape
from itertools import pairwise
from typing import Any

import numpy as np

from .bands import fewer
from .still_axes import Axis, Spec
from .style import CYCLE, INK, MUTED, PAPER

POINTS = 1000  # of a line: more than the picture has pixels across
PIXELS = (320, 200)  # most of a map
DASHES = {"dash": "6 4", "dot": "2 3", "dashdot": "6 3 2 3", "longdash": "10 4"}
MARKUP = re.compile(r"</?(?:b|i|sub|sup|span)\b[^<>]*>")


def text_at(
    content: Any, x: float, y: float, *, size: float = 12.0, colour: str = MUTED, anchor: str = "start", turn: float = 0.0
) -> str:
    """One text, lines of it under one another."""
    plain = str(content)
    bold = ' font-weight="650"' if "<b>" in plain else ""
    lines = [escape(MARKUP.sub("", line)) for line in plain.split("<br>")]
    turned = f' transform="rotate({turn:g} {x:.1f} {y:.1f})"' if turn else ""
    spans = lines[0] + "".join(f'<tspan x="{x:.1f}" dy="1.25em">{line}</tspan>' for line in lines[1:])
    return (
        f'<text x="{x:.1f}" y="{y:.1f}" font-size="{size:g}" fill="{colour}" text-anchor="{anchor}"{bold}{turned}>{spans}</text>'
    )


def segment(a: Sequence[float], b: Sequence[float], colour: str, width: float = 1.0) -> str:
    """A straight line from point a to point b, px."""
    return f'<path d="M{a[0]:.1f} {a[1]:.1f}L{b[0]:.1f} {b[1]:.1f}" stroke="{colour}" stroke-width="{width:g}"/>'


def draw_trace(trace: Spec, panel: Sequence[Spec], x: Axis, y: Axis) -> str:
    """The elements of one trace. panel: all traces on its axes, beside which its bars stand."""
    kind = trace.get("type", "scatter")
    if kind == "bar":
        return _bars(trace, [t for t in panel if t.get("type") == "bar"], x, y)
    if kind == "scatter":
        return _scatter(trace, x, y)
    if trace.get("contours", {}).get("coloring") == "none":
        return _contours(trace, x, y)
    return _map(trace, x, y)


def _scatter(trace: Spec, x: Axis, y: Axis) -> str:
    if trace.get("mode") == "lines" and trace.get("fill") != "tozeroy":
        trace = fewer(trace, POINTS)
    xs, ys = x.pixels(trace["x"]), y.pixels(trace["y"])
    mode, parts = trace.get("mode", "lines"), []
    if "lines" in mode and xs.size:
        parts.append(_path(trace, xs, ys, float(np.clip(y.pixel(0.0), y.end, y.start)) if not y.logarithmic else y.start))
    if "markers" in mode:
        marker = trace.get("marker", {})
        colours, sizes = marker_colours(marker, xs.size, trace), np.broadcast_to(marker.get("size", 6), xs.size)
        parts += [
            marker_at(marker.get("symbol", "circle"), a, b, 0.5 * size, c)
            for a, b, size, c in zip(xs, ys, sizes, colours, strict=True)
            if math.isfinite(a) and math.isfinite(b)
        ]
    return "".join(parts)


def _path(trace: Spec, xs: np.ndarray, ys: np.ndarray, zero: float) -> str:
    style = trace.get("line", {})
    shown = np.isfinite(xs) & np.isfinite(ys)
    commands: list[str] = []
    pieces = np.split(np.arange(xs.size), np.flatnonzero(~shown))
    fill = ""
    for piece in pieces:
        own = piece[shown[piece]]
        if own.size:
            commands.append("M" + "L".join(f"{a:.1f} {b:.1f}" for a, b in zip(xs[own], ys[own], strict=True)))
            if trace.get("fill") == "toself":
                fill += f'<path d="{commands[-1]}Z" fill="{trace.get("fillcolor", "none")}"/>'
            elif trace.get("fill") == "tozeroy":
                area = f"{commands[-1]}L{xs[own[-1]]:.1f} {zero:.1f}L{xs[own[0]]:.1f} {zero:.1f}Z"
                fill += f'<path d="{area}" fill="{trace.get("fillcolor", "none")}"/>'
    dash = DASHES.get(style.get("dash", ""), "")
    dashed = f' stroke-dasharray="{dash}"' if dash else ""
    colour, width = style.get("color", CYCLE[0]), style.get("width", 1.8)
    return f'{fill}<path d="{"".join(commands)}" fill="none" stroke="{colour}" stroke-width="{width:g}"{dashed}/>'


def marker_colours(marker: Spec, count: int, trace: Spec) -> Sequence[str]:
    """A colour for each marker, of its number on the scale where it has one."""
    colour = marker.get("color", trace.get("line", {}).get("color", CYCLE[0]))
    if isinstance(colour, str):
        return [colour] * count
    if all(isinstance(c, str) for c in colour):
        return list(colour)
    numbers = np.array([np.nan if c is None else c for c in colour], dtype=float)
    low, high = marker.get("cmin", np.nanmin(numbers)), marker.get("cmax", np.nanmax(numbers))
    rgb = _on_scale(numbers, low, high, marker.get("colorscale", [[0, PAPER], [1, INK]]))
    return [f"rgb({r},{g},{b})" for r, g, b, _ in rgb.tolist()]


def _on_scale(values: np.ndarray, low: float, high: float, scale: Sequence[Sequence[Any]]) -> np.ndarray:
    """Colours (..., 4) of numbers; transparent where there is none."""
    places = np.clip((values - low) / ((high - low) or 1.0), 0.0, 1.0)
    stops = np.array([[int(str(c)[i : i + 2], 16) for i in (1, 3, 5)] for _, c in scale], dtype=float)
    at = [float(p) for p, _ in scale]
    known = np.isfinite(places)
    rgb = [np.interp(np.where(known, places, 0.0), at, stops[:, k]) for k in range(3)]
    return np.stack([*rgb, 255.0 * known], axis=-1).round().astype(np.uint8)


def marker_at(symbol: str, x: float, y: float, r: float, colour: str) -> str:
    """A symbol of Plotly's, of radius r px."""
    hollow = str(symbol).endswith("-open")
    paint = f'fill="none" stroke="{colour}" stroke-width="1.5"' if hollow else f'fill="{colour}"'
    shape = str(symbol).removesuffix("-open")
    if shape in ("square", "diamond"):
        turn = f' transform="rotate(45 {x:.1f} {y:.1f})"' if shape == "diamond" else ""
        return f'<rect x="{x - r:.1f}" y="{y - r:.1f}" width="{2 * r:.1f}" height="{2 * r:.1f}" {paint}{turn}/>'
    if shape in ("x", "cross", "x-thin", "cross-thin"):
        angle = 45 if shape.startswith("x") else 0
        at = f"M{x - r:.1f} {y:.1f}h{2 * r:.1f}M{x:.1f} {y - r:.1f}v{2 * r:.1f}"
        return f'<path d="{at}" stroke="{colour}" stroke-width="2" transform="rotate({angle} {x:.1f} {y:.1f})"/>'
    if shape.startswith("triangle"):
        return f'<path d="M{x - r:.1f} {y + r:.1f}h{2 * r:.1f}L{x:.1f} {y - r:.1f}Z" {paint}/>'
    return f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{r:.1f}" {paint}/>'


def _bars(trace: Spec, bars: Sequence[Spec], x: Axis, y: Axis) -> str:
    """Bars beside one another, with whiskers."""
    lying = trace.get("orientation") == "h"
    of_places, of_values = (y, x) if lying else (x, y)
    places, values = (trace["y"], trace["x"]) if lying else (trace["x"], trace["y"])
    unit = abs(of_places.pixel(1.0, raw=True) - of_places.pixel(0.0, raw=True))
    grouped = [t for t in bars if t.get("width") is None]
    share = 0.8 / max(1, len(grouped))
    number = next((k for k, t in enumerate(grouped) if t is trace), 0)
    thick = unit * (trace["width"] if isinstance(trace.get("width"), int | float) else share)
    offset = 0.0 if len(grouped) < 2 else (number - 0.5 * (len(grouped) - 1)) * unit * share
    colours = marker_colours(trace.get("marker", {}), len(values), trace)
    bases, halves = trace.get("base") or [0.0] * len(values), trace.get("error_x", trace.get("error_y", {})).get("array", ())
    parts = []
    for k, (place, value, colour) in enumerate(zip(places, values, colours, strict=True)):
        if value is None:
            continue
        base = bases[k] if isinstance(bases, Sequence) else bases
        ends = sorted((_on_axis(of_values, base), _on_axis(of_values, base + value)))
        side = of_places.pixel(place) + offset - 0.5 * thick
        size = ends[1] - ends[0]
        a, b, width, tall = (ends[0], side, size, thick) if lying else (side, ends[0], thick, size)
        parts.append(f'<rect x="{a:.1f}" y="{b:.1f}" width="{width:.1f}" height="{tall:.1f}" fill="{colour}"/>')
        if k < len(halves) and halves[k]:
            a, b, middle = of_values.pixel(value - halves[k]), of_values.pixel(value + halves[k]), side + 0.5 * thick
            parts.append(segment((a, middle), (b, middle), INK) if lying else segment((middle, a), (middle, b), INK))
    return "".join(parts)


def _on_axis(axis: Axis, value: float) -> float:
    """The place of an end of a bar; that of zero on a logarithmic axis is its start."""
    return axis.start if axis.logarithmic and value <= 0.0 else axis.pixel(value)


def _grid(trace: Spec) -> tuple[np.ndarray, np.ndarray]:
    """Values of a map, (rows, columns), and the ends of its colours."""
    z = np.array([[np.nan if v is None else v for v in row] for row in trace["z"]], dtype=float)
    known = z[np.isfinite(z)]
    least, largest = (float(known.min()), float(known.max())) if known.size else (0.0, 1.0)
    return z, np.array([trace.get("zmin", least), trace.get("zmax", largest)], dtype=float)


def _map(trace: Spec, x: Axis, y: Axis) -> str:
    """A map as a picture of its nearest values, so that it is right on any axis."""
    z, (low, high) = _grid(trace)
    columns, rows = (axis.pixels(trace[n]) for axis, n in ((x, "x"), (y, "y")))
    spans = [_edges(columns), _edges(rows)]
    at = [np.linspace(a, b, n + 1)[:-1] + 0.5 * (b - a) / n for (a, b), n in zip(spans, PIXELS, strict=True)]
    near = [np.abs(a[:, None] - c[None, :]).argmin(axis=1) for a, c in zip(at, (columns, rows), strict=True)]
    colours = _on_scale(z[np.ix_(near[1], near[0])], low, high, trace["colorscale"])
    (left, right), (top, bottom) = spans
    place = f'x="{left:.1f}" y="{top:.1f}" width="{right - left:.1f}" height="{bottom - top:.1f}"'
    return f'<image {place} preserveAspectRatio="none" href="data:image/png;base64,{b64encode(_png(colours)).decode()}"/>'


def _edges(centres: np.ndarray) -> tuple[float, float]:
    """From half a cell before the first centre to half a cell behind the last, in rising order."""
    ends = np.sort(centres)
    if ends.size < 2:
        return float(ends[0]) - 10.0, float(ends[0]) + 10.0
    return float(ends[0] - 0.5 * (ends[1] - ends[0])), float(ends[-1] + 0.5 * (ends[-1] - ends[-2]))


def _png(pixels: np.ndarray) -> bytes:
    """An image file of colours (rows, columns, 4)."""
    rows, columns, _ = pixels.shape
    lines = b"".join(b"\0" + line.tobytes() for line in pixels)

    def chunk(kind: bytes, content: bytes) -> bytes:
        return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))

    header = struct.pack(">IIBBBBB", columns, rows, 8, 6, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(lines, 9)) + chunk(b"IEND", b"")


def _contours(trace: Spec, x: Axis, y: Axis) -> str:
    """Lines through the places of a map that have a level (marching squares)."""
    z, _ = _grid(trace)
    columns, rows = [x.pixel(v) for v in trace["x"]], [y.pixel(v) for v in trace["y"]]
    levels, size = trace["contours"], trace["contours"].get("size") or 1.0
    count = round((levels["end"] - levels["start"]) / size) + 1
    style, commands = trace.get("line", {}), []
    for level in (levels["start"] + k * size for k in range(count)):
        for i, j in np.ndindex(z.shape[0] - 1, z.shape[1] - 1):
            corners = [(i, j), (i, j + 1), (i + 1, j + 1), (i + 1, j)]
            crossings = [
                tuple((1 - s) * p + s * q for p, q in zip((columns[a[1]], rows[a[0]]), (columns[b[1]], rows[b[0]]), strict=True))
                for a, b in pairwise([*corners, corners[0]])
                if (z[a] - level) * (z[b] - level) < 0.0
                for s in [(level - z[a]) / (z[b] - z[a])]
            ]
            commands += [
                f"M{a[0]:.1f} {a[1]:.1f}L{b[0]:.1f} {b[1]:.1f}" for a, b in zip(crossings[::2], crossings[1::2], strict=False)
            ]
    dash = DASHES.get(style.get("dash", ""), "none")
    return f'<path d="{"".join(commands)}" fill="none" stroke="{style.get("color", INK)}" stroke-width="2" stroke-dasharray="{dash}"/>'


def has_scale(trace: Spec) -> bool:
    """Whether a scale of its colours stands beside the panel."""
    if trace.get("type") in ("heatmap", "contour"):
        return bool(trace.get("showscale", True)) and trace.get("contours", {}).get("coloring") != "none"
    return bool(trace.get("marker", {}).get("showscale"))


def draw_scale(trace: Spec, x: Axis, y: Axis, right: float) -> str:
    """The scale of colours at the right of its panel, or of all panels, whose end is `right`, where it has no place of its own."""
    of_map = trace.get("type") in ("heatmap", "contour")
    own = trace if of_map else trace["marker"]
    low, high = _grid(trace)[1].tolist() if of_map else (own["cmin"], own["cmax"])
    colours = _on_scale(np.linspace(low, high, 24), low, high, own["colorscale"])
    bar = own.get("colorbar", {})
    left, step = (x.end if "x" in bar else right) + 10.0, (y.start - y.end) / 24
    parts = [
        f'<rect x="{left:.1f}" y="{y.start - (k + 1) * step:.1f}" width="12" height="{step + 0.5:.1f}" fill="rgb({r},{g},{b})"/>'
        for k, (r, g, b, _) in enumerate(colours.tolist())
    ]
    texts = dict(zip(bar.get("tickvals", ()), bar.get("ticktext", ()), strict=True)) or {low: f"{low:.3g}", high: f"{high:.3g}"}
    parts += [
        text_at(t, left + 15, y.start + (v - low) / ((high - low) or 1) * (y.end - y.start) + 4, size=11)
        for v, t in texts.items()
    ]
    title = bar.get("title", {}).get("text", "")
    return "".join(parts) + text_at(title, left + 52, 0.5 * (y.start + y.end), anchor="middle", turn=90, colour=INK)
