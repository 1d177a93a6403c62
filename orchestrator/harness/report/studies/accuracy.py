"""The page of `cosimo accuracy`: work-precision diagrams, error against the macro step, fronts, and every measured setting.

Axes are those of SciML's diagrams: error on x, time on y, both logarithmic, one marked line a method; what failed stays in the
picture as a cross with its reason.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isfinite, log10
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...charts.style import CYCLE, INK, MUTED, RAW, VERMILION, axis, drawn, label, layout, number, rectangle
from ...studies.quantities import percent
from ..page import Block, Cells, Facts, Figure, Page, Section, Text, write_page

if TYPE_CHECKING:
    from ...studies.accuracy import Accuracy, Point

SYMBOLS = ("circle", "square", "diamond", "triangle-up", "triangle-down", "pentagon", "hexagon", "star-square")
LINES = ("coupling", "adaptive", "method")  # knobs whose points are joined
OTHERS = (("other internal steps or meshes", ("substep", "mesh"), "circle-open"),
          ("without one effect", ("effect",), "diamond-open"))
FAILED = 2.0  # where crosses stand on an axis of errors
ASKED = (0.1, 0.01, 1e-3)  # errors for which the page names the quickest setting
ORDERS = (1, 2, 3, 4)
LEGEND = 250  # px


def for_accuracy(measured: Accuracy, directory: str | Path) -> Path:
    """`report.html` of what accuracy costs."""
    figures: list[Block] = [
        _work_precision(measured, "seconds", "Error against time", "time of the run, s", (
            f"Time of the processor, minimum of several warm runs on {measured.machine}. ")),
        _work_precision(measured, "calls", "Error against counted work", "operations of the units and hand-overs", (
            "The same on every machine: of each unit its dearest operation, such as an evaluation of its equations, and one for "
            "every unit in every macro step or iteration. ")),
        *_against_size(measured),
    ]
    sections = [Section("What accuracy costs", [Text(_advice(measured)), *figures]),
                Section("Settings", [_front_table(measured), _all_points(measured)]),
                Section("Reference", [Facts("What errors are measured against", _reference(measured))])]
    return write_page(Page(measured.title, _lead(measured), sections), Path(directory) / "report.html")


def _lead(measured: Accuracy) -> str:
    done = sum(p.outcome == "done" for p in measured.points)
    return (f"{done} of {len(measured.points)} settings came to a result. An error is the largest of the quantities looked at, "
            "over the range of its signal.")


def _advice(measured: Accuracy) -> list[str]:
    front, said = measured.front(), []
    for asked in ASKED:
        point = next((p for p in front if p.held <= asked), None)
        if asked < measured.least or point is None:
            said.append(f"{percent(asked)}: no measured setting holds it, or the reference is not known that well.")
        else:
            said.append(f"{percent(asked)}: {_name(point)}, {point.seconds:.3g} s, error {percent(point.held)}.")
    own = measured.own
    said.append(f"As it is: {own.seconds:.3g} s, error {percent(own.held)}." if own.outcome == "done"
                else f"As it is, it {own.outcome}: {own.reason}")
    return said


def _name(point: Point) -> str:
    return f"{point.line} at {point.size:.3g}"


def _lines(measured: Accuracy) -> dict[str, list[Point]]:
    """The points of every line that is drawn joined, in the order of their size."""
    found: dict[str, list[Point]] = {}
    for p in measured.points:
        joined = p.knob in LINES or (p.knob == "substep" and not any(q.knob in LINES[:2] for q in measured.points))
        if joined:
            found.setdefault(p.line, []).append(p)
    return {name: sorted(points, key=lambda p: p.size) for name, points in found.items()}


def _marked(points: Sequence[Point], x: Sequence[float], y: Sequence[float], name: str, colour: str, symbol: str,
            **more: Any) -> dict[str, Any]:
    shown = [f"{p.line}<br>{p.size:.3g}; error {percent(p.error)}, {p.seconds:.3g} s, {p.work.get('calls', 0)} calls"
             + (f"<br>{p.reason}" if p.reason else "") for p in points]
    return {"type": "scatter", "x": drawn(x, 5), "y": drawn(y, 5), "name": name, "text": shown,
            "hovertemplate": "%{text}<extra></extra>", "mode": "lines+markers",
            "line": {"color": colour, "width": 1.4}, "marker": {"color": colour, "symbol": symbol, "size": 8}} | more


def _styles(names: Sequence[str]) -> Mapping[str, tuple[str, str]]:
    """A colour and a symbol of each line."""
    return {n: (CYCLE[i % len(CYCLE)], SYMBOLS[i % len(SYMBOLS)]) for i, n in enumerate(names)}


def _work_precision(measured: Accuracy, cost: str, title: str, y_label: str, text: str) -> Figure:
    lines = _lines(measured)
    styles = _styles(list(lines))
    data = []
    for name, points in lines.items():
        done = [p for p in points if p.outcome == "done"]
        if done:
            data.append(_marked(done, [p.error for p in done], [p.cost(cost) for p in done], name, *styles[name]))
    joined = {p.line for points in lines.values() for p in points}
    for name, knobs, symbol in OTHERS:
        others = [p for p in measured.points if p.line not in joined and p.knob in knobs and p.outcome == "done"]
        if others:
            data.append(_marked(others, [p.error for p in others], [p.cost(cost) for p in others], name, RAW, symbol,
                                mode="markers"))
    front = measured.front(cost)
    data.append(_marked(front, [p.error for p in front], [p.cost(cost) for p in front], "front", INK, "circle-open",
                        line={"color": INK, "width": 1, "dash": "dot"},
                        marker={"color": INK, "symbol": "circle-open", "size": 15, "line": {"width": 1.5}}))
    if measured.own.outcome == "done":
        own = [measured.own]
        data.append(_marked(own, [own[0].error], [own[0].cost(cost)], "as it is", VERMILION, "star", mode="markers",
                            marker={"color": VERMILION, "symbol": "star", "size": 13}))
    failed = [p for p in measured.points if p.outcome in ("failed", "useless") and isfinite(p.cost(cost))]
    if failed:
        data.append(_crosses(failed, [FAILED] * len(failed), [p.cost(cost) for p in failed]))
    return Figure(title, {"data": data, "layout": _layout(measured, "error", y_label, bool(failed))}, text
                  + "Ringed: the front, where nothing is both quicker and more accurate; its error counts the finer settings of "
                  "the same line, too, so that none is there by chance. Crosses: runs that failed or were off by more than "
                  "100 %. Shaded: below what the reference itself is known to.")


def _crosses(points: Sequence[Point], x: Sequence[float], y: Sequence[float]) -> dict[str, Any]:
    return _marked(points, x, y, "failed", MUTED, "x-thin", mode="markers",
                   marker={"color": MUTED, "symbol": "x-thin", "size": 9, "line": {"width": 2, "color": MUTED}})


def _layout(measured: Accuracy, x_label: str, y_label: str, failed: bool) -> dict[str, Any]:
    least = min((p.error for p in measured.points if p.error > 0.0), default=1e-6)
    low = min(least, measured.least if isfinite(measured.least) else least)
    shapes, notes = [], []
    if measured.least > 0.5 * low:
        shapes.append(rectangle((low * 0.3, measured.least), (0, 1), MUTED, 0.1, xref="x", yref="paper"))
        notes.append(label("← below the reference's own", log10(measured.least), 0.0, xref="x", xanchor="left", yanchor="bottom"))
    if failed:
        notes.append(label("failed", log10(FAILED), 1.0, xref="x", yanchor="bottom"))
    ends = [log10(low * 0.5), log10(FAILED * 1.6 if failed else 1.2)]
    return layout(430, xaxis=axis(x_label, grid=True, type="log", dtick=1, range=ends), shapes=shapes, annotations=notes,
                  yaxis=axis(y_label, grid=True, type="log"), margin={"l": 70, "r": LEGEND, "t": 34, "b": 50},
                  legend={"orientation": "v", "x": 1.02, "y": 1, "font": {"size": 11}})


def _against_size(measured: Accuracy) -> list[Block]:
    """Error against the macro step, or the internal one, where it is a line's axis; with triangles of whole orders."""
    lines = {n: [p for p in points if p.knob in ("coupling", "substep")] for n, points in _lines(measured).items()}
    lines = {n: points for n, points in lines.items() if len(points) > 1}
    if not lines:
        return []
    styles, data = _styles(list(_lines(measured))), []
    seen = []
    for name, points in lines.items():
        done = [p for p in points if p.outcome == "done"]
        seen += done
        if done:
            data.append(_marked(done, [p.size for p in done], [p.error for p in done], name, *styles[name]))
    failed = [p for points in lines.values() for p in points if p.outcome in ("failed", "useless", "refused")]
    if failed:
        data.append(_crosses(failed, [p.size for p in failed], [FAILED] * len(failed)))
    if not seen:
        return []
    inside = all(p.knob == "substep" for p in seen)
    what = "internal step, s" if inside else "macro step, s"
    sizes, errors = [p.size for p in seen], [p.error for p in seen if p.error > 0.0]
    shapes, notes = _triangles(max(sizes), min(errors), ORDERS if inside else ORDERS[:3])
    made = layout(430, xaxis=axis(what, grid=True, type="log"), yaxis=axis("error", grid=True, type="log", dtick=1),
                  shapes=shapes, annotations=notes, margin={"l": 70, "r": LEGEND, "t": 34, "b": 50},
                  legend={"orientation": "v", "x": 1.02, "y": 1, "font": {"size": 11}})
    return [Figure(f"Error against the {what.partition(',')[0]}", {"data": data, "layout": made},
                   "Slope triangles: errors that fall with the first, second ... power of the step. Lines that turn flat have "
                   "met another error, such as that of the internal steps or of a peak between two samples, which no coupling "
                   "makes smaller. Crosses at the top: runs that failed, were refused, or were off by more than 100 %.")]


def _triangles(largest: float, least: float, orders: Sequence[int]) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """Triangles over one another on one base, in the corner of long steps below all errors, which lines leave free."""
    right, left = largest, largest / 2.0
    bottom = least / 2.0 / 2.0 ** orders[-1]
    shapes, notes = [], []
    for order in orders:
        top = bottom * 2.0**order
        path = f"M {left} {bottom} L {right} {bottom} L {right} {top} Z"
        shapes.append({"type": "path", "path": path, "xref": "x", "yref": "y", "line": {"color": MUTED, "width": 1}})
        notes.append(label(str(order), log10(right), log10(top), xref="x", yref="y", xanchor="left", xshift=3))
    return shapes, notes


def _front_table(measured: Accuracy) -> Cells:
    quantities = list(measured.floor)
    shown = quantities[:8]
    chosen = [measured.own]
    chosen += [p for p in measured.points if p is not measured.own and (p in measured.front() or p in measured.front("calls"))]
    rows = [(p.line, f"{p.size:.3g}", percent(p.held), f"{p.seconds:.3g}", str(p.work.get("calls", "")),
             *(percent(p.errors.get(q, float("nan"))) for q in shown))
            for p in sorted(chosen, key=lambda p: p.seconds)]
    hidden = len(quantities) > len(shown)
    more = f" Of {len(quantities)} quantities the first {len(shown)} are shown; all are in accuracy.csv." if hidden else ""
    return Cells("As it is, and the fronts over time and over counted work",
                 ("setting", "size", "error", "seconds", "calls", *shown), rows,
                 "Size: macro step in s, or tolerance." + more, frozenset(range(1, 5 + len(shown))))


def _all_points(measured: Accuracy) -> Cells:
    rows = [(p.line, f"{p.size:.3g}", p.outcome, percent(p.error), percent(p.held), number(p.seconds), number(p.middle),
             *(str(p.work.get(n, "")) for n in ("macro_steps", "derivative_calls", "iterations", "rollbacks", "events", "calls")),
             p.reason) for p in measured.points if p.outcome != "skipped"]
    skipped = [p for p in measured.points if p.outcome == "skipped"]
    caption = f"{len(skipped)} more were skipped: {skipped[0].reason}. accuracy.csv names them." if skipped else ""
    return Cells("Every setting", ("setting", "size", "outcome", "error", "with finer ones", "seconds, minimum", "median",
                                   "macro steps", "derivative calls", "iterations", "rollbacks", "events", "calls", "reason"),
                 rows, caption, frozenset(range(3, 13)))


def _reference(measured: Accuracy) -> list[tuple[str, str]]:
    rows = [("reference", measured.how), ("second solution", measured.witness)]
    rows += [(f"agreement of {name}", percent(value)) for name, value in measured.floor.items()]
    return [*rows, ("machine", measured.machine), ("versions", measured.versions)]
