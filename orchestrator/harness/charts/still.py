"""A figure as a still picture: an SVG element of the numbers of a Plotly figure, for pages whose scripts do not run.

No browser draws it. Hover, zoom and animation are left out; of an animation, the picture is its first frame.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from html import escape
from typing import Any

from .still_axes import DEFAULT_MARGIN, WIDTH, Axis, Spec, axes_of
from .still_traces import DASHES, draw_scale, draw_trace, has_scale, marker_at, marker_colours, segment, text_at
from .style import CYCLE, INK, MUTED, RULE

LEGEND_ROW = 18.0  # px
SCALE_ROOM = 72  # px, right of the panels
CHARACTER = 0.54  # of the font's size, about: width of a letter
DRAWABLE = ("scatter", "bar", "heatmap", "contour")


def still(figure: Spec, name: str) -> str:
    """The text of an SVG element; "" of a figure of a kind that has no still picture. name: unique in its page."""
    if any(trace.get("type", "scatter") not in DRAWABLE for trace in figure["data"]):
        return ""
    figure = {**figure, "layout": _still_layout(figure)}
    layout = figure["layout"]
    height = layout["height"]
    axes = axes_of(figure)
    right = max(axis.end for name, axis in axes.items() if name[0] == "x")
    parts: list[str] = []
    shapes = list(layout.get("shapes", ()))
    parts += [_shape(s, layout, axes) for s in shapes if s.get("layer") == "below"]
    for k, (x, y) in enumerate(_panels(figure)):
        parts += _frame(axes[x], axes[y], axes[x].settings.get("anchor", y) == y)
        left, top = axes[x].start, axes[y].end
        box = f'x="{left:.1f}" y="{top:.1f}" width="{axes[x].end - left:.1f}" height="{axes[y].start - top:.1f}"'
        own = [t for t in figure["data"] if (t.get("xaxis", "x"), t.get("yaxis", "y")) == (x, y)]
        traces = "".join(draw_trace(t, own, axes[x], axes[y]) for t in own)
        parts.append(f'<clipPath id="{name}c{k}"><rect {box}/></clipPath><g clip-path="url(#{name}c{k})">{traces}</g>')
        parts += [draw_scale(t, axes[x], axes[y], right) for t in own if has_scale(t)]
    parts += [_shape(s, layout, axes) for s in shapes if s.get("layer") != "below"]
    parts += [_note(n, layout, axes) for n in layout.get("annotations", ())]
    parts += _legends(figure)
    font = escape(str(layout.get("font", {}).get("family", "sans-serif")), quote=True)
    label = "still picture of the figure"
    head = f'<svg class="still" role="img" aria-label="{label}" viewBox="0 0 {WIDTH:g} {height:g}" font-family="{font}" font-size="12"'
    return f'{head} xmlns="http://www.w3.org/2000/svg">{"".join(parts)}</svg>'


def _still_layout(figure: Spec) -> dict[str, Any]:
    """The layout with all four margins: room for scales at the right, none for sliders and buttons, which are left out."""
    layout = dict(figure["layout"])
    margin = DEFAULT_MARGIN | dict(layout.get("margin", {}))
    height = float(layout["height"])
    if layout.get("sliders"):
        height -= max(0, margin["b"] - DEFAULT_MARGIN["b"])
        margin["b"] = DEFAULT_MARGIN["b"]
    if any(map(has_scale, figure["data"])):
        margin["r"] = max(margin["r"], SCALE_ROOM)
    return layout | {"margin": margin, "height": height}


def _panels(figure: Spec) -> list[tuple[str, str]]:
    """(x, y) of each pair of axes that has traces."""
    return list(dict.fromkeys((t.get("xaxis", "x"), t.get("yaxis", "y")) for t in figure["data"]))


def _frame(x: Axis, y: Axis, anchored: bool) -> list[str]:
    """The lines of a pair of axes with ticks, their texts and titles. anchored: the x axis has its texts below this panel."""
    anchored &= x.settings.get("showticklabels", True)
    parts: list[str] = []
    for at, text in y.ticks():
        if y.settings.get("showgrid"):
            parts.append(segment((x.start, at), (x.end, at), y.settings.get("gridcolor", RULE)))
        parts += [segment((x.start - 4, at), (x.start, at), RULE)]
        if y.settings.get("showticklabels", True):
            parts.append(text_at(text, x.start - 7, at + 4, anchor="end", colour=INK))
    for at, text in x.ticks():
        if x.settings.get("showgrid"):
            parts.append(segment((at, y.start), (at, y.end), x.settings.get("gridcolor", RULE)))
        parts.append(segment((at, y.start), (at, y.start + 4), RULE))
        if anchored:
            parts.append(text_at(text, at, y.start + 17, anchor="middle", colour=INK))
    parts += [segment((x.start, y.start), (x.end, y.start), MUTED), segment((x.start, y.start), (x.start, y.end), MUTED)]
    titles = [axis.settings.get("title", {}).get("text", "") for axis in (x, y)]
    if titles[0] and anchored:
        parts.append(text_at(titles[0], 0.5 * (x.start + x.end), y.start + 35, anchor="middle", colour=INK))
    if titles[1]:
        left, middle = max(12.0, x.start - 50.0), 0.5 * (y.start + y.end)
        parts.append(text_at(titles[1], left, middle, anchor="middle", colour=INK, turn=-90))
    return parts


def _place(value: Any, reference: str, layout: Spec, axes: Mapping[str, Axis], along: str) -> float:
    """A coordinate of a shape or note in px; its reference is "paper", an axis, or "AXIS domain"."""
    name, _, domain = reference.partition(" ")
    if domain or name == "paper":
        if name == "paper":
            margin = layout["margin"]
            ends = (margin["l"], WIDTH - margin["r"]) if along == "x" else (layout["height"] - margin["b"], margin["t"])
        else:
            ends = (axes[name].start, axes[name].end)
        return float(ends[0] + float(value) * (ends[1] - ends[0]))
    return axes[name].pixel(value)


def _shape(shape: Spec, layout: Spec, axes: Mapping[str, Axis]) -> str:
    line = shape.get("line", {})
    dash = DASHES.get(line.get("dash", ""), "none")
    stroke = f'stroke="{line.get("color", "none")}" stroke-width="{line.get("width", 1):g}" stroke-dasharray="{dash}"'
    xref, yref = shape.get("xref", "x"), shape.get("yref", "y")
    if shape["type"] == "path":
        places = {"x": (xref, layout, axes, "x"), "y": (yref, layout, axes, "y")}
        words, along = [], "x"
        for word in re.findall(r"[A-Za-z]|[-+0-9.eE]+", shape["path"]):  # letters of commands, then x and y in turn
            words.append(word if word.isalpha() else f"{_place(float(word), *places[along]):.1f}")
            along = "x" if word.isalpha() or along == "y" else "y"
        return f'<path d="{" ".join(words)}" fill="{shape.get("fillcolor", "none")}" {stroke}/>'
    x0, x1 = (_place(shape[k], xref, layout, axes, "x") for k in ("x0", "x1"))
    y0, y1 = (_place(shape[k], yref, layout, axes, "y") for k in ("y0", "y1"))
    if not all(map(math.isfinite, (x0, x1, y0, y1))):
        return ""
    if shape["type"] == "line":
        return f'<path d="M{x0:.1f} {y0:.1f}L{x1:.1f} {y1:.1f}" {stroke}/>'
    box = f'x="{min(x0, x1):.1f}" y="{min(y0, y1):.1f}" width="{abs(x1 - x0):.1f}" height="{abs(y1 - y0):.1f}"'
    return f'<rect {box} fill="{shape.get("fillcolor", "none")}" {stroke}/>'


def _note(note: Spec, layout: Spec, axes: Mapping[str, Axis]) -> str:
    # a note on a logarithmic axis is given by its exponent
    at = []
    for along in "xy":
        reference = note.get(f"{along}ref", along)
        on_axis = axes.get(reference)
        raw = on_axis is not None and on_axis.logarithmic
        value = note[along]
        at.append(
            on_axis.pixel(value, raw=True) if on_axis is not None and raw else _place(value, reference, layout, axes, along)
        )
    x, y = at[0] + note.get("xshift", 0), at[1] - note.get("yshift", 0)
    if not (math.isfinite(x) and math.isfinite(y)):
        return ""
    font, turn = note.get("font", {}), float(note.get("textangle", 0) or 0)
    size = float(font.get("size", 12))
    anchor = {"left": "start", "right": "end"}.get(note.get("xanchor", "center"), "middle")
    vertical = {"top": 0.9, "bottom": -0.3}.get(note.get("yanchor", "middle"), 0.35) * size
    if turn:  # as Plotly turns a text about the middle of its box
        x, anchor, vertical = x + size, "end" if note.get("yanchor") == "top" else "start", 0.0
    return text_at(note.get("text", ""), x, y + vertical, size=size, colour=font.get("color", INK), anchor=anchor, turn=turn)


def _legends(figure: Spec) -> Iterator[str]:
    """Entries of each legend: in rows above the panel, or in a column."""
    layout = figure["layout"]
    named = [
        t for t in figure["data"] if t.get("name") and t.get("showlegend", True) and t.get("type") not in ("heatmap", "contour")
    ]
    if not layout.get("showlegend", len(named) > 1):
        return
    margin = layout["margin"]
    width, height = WIDTH - margin["l"] - margin["r"], layout["height"] - margin["t"] - margin["b"]
    for key in dict.fromkeys(t.get("legend", "legend") for t in named):
        settings, entries = layout.get(key, {}), [t for t in named if t.get("legend", "legend") == key]
        x0 = margin["l"] + float(settings.get("x", 1.02)) * width
        y0 = margin["t"] + (1.0 - float(settings.get("y", 1.0))) * height
        sizes = [40.0 + CHARACTER * 12.0 * len(str(t["name"])) for t in entries]
        if settings.get("orientation", "v") == "h":
            rows: list[list[int]] = [[]]
            for k, size in enumerate(sizes):
                if rows[-1] and sum(sizes[i] for i in rows[-1]) + size > width:
                    rows.append([])
                rows[-1].append(k)
            for r, row in enumerate(rows):
                y, x = y0 - 8.0 - (len(rows) - 1 - r) * LEGEND_ROW, x0
                for k in row:
                    yield _entry(entries[k], x, y)
                    x += sizes[k]
        else:
            right = settings.get("xanchor") == "right"
            for k, trace in enumerate(entries):
                yield _entry(trace, x0 - max(sizes) if right else x0, y0 + 12.0 + k * LEGEND_ROW)


def _entry(trace: Spec, x: float, y: float) -> str:
    style, marker = trace.get("line", {}), trace.get("marker", {})
    colour = marker_colours(marker, 1, trace)[0] if "lines" not in trace.get("mode", "") else style.get("color", CYCLE[0])
    if trace.get("type") == "bar":
        sign = f'<rect x="{x:.1f}" y="{y - 10:.1f}" width="14" height="10" fill="{colour}"/>'
    elif "lines" in trace.get("mode", "lines"):
        dash = DASHES.get(style.get("dash", ""), "none")
        sign = f'<path d="M{x:.1f} {y - 4:.1f}h22" stroke="{colour}" stroke-width="{style.get("width", 1.8):g}" stroke-dasharray="{dash}"/>'
    else:
        sign = marker_at(
            marker.get("symbol", "circle") if isinstance(marker.get("symbol", ""), str) else "circle", x + 11, y - 4, 4, colour
        )
    return sign + text_at(trace["name"], x + 27, y, colour=INK)
