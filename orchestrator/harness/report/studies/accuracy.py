"""The page of `cosimo accuracy`: work-precision diagrams, error against the macro step, fronts, and every measured setting.

Axes are those of SciML's diagrams: error on x, time on y, both logarithmic, one marked line a method; what failed stays in the
picture as a cross with its reason.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isfinite, log10
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...charts.blocks import Block, Cells, Facts, Figure, Text
from ...charts.style import CYCLE, INK, MUTED, RAW, VERMILION, axis, drawn, label, layout, number, rectangle
from ...studies.quantities import percent
from ..page import Page, Section, write_page

if TYPE_CHECKING:
    from ...studies.accuracy import Accuracy, Point

SYMBOLS = ("circle", "square", "diamond", "triangle-up", "triangle-down", "pentagon", "hexagon", "star-square")
JOINED = ("coupling", "adaptive", "method")  # axes of settings whose points are joined
OTHERS = (
    ("other internal steps or meshes", ("substep", "mesh"), "circle-open"),
    ("without one effect", ("effect",), "diamond-open"),
)
FAILED = 2.0  # where crosses stand on an axis of errors
ASKED = (0.1, 0.01, 1e-3)  # errors for which the page names the quickest setting
ORDERS = (1, 2, 3, 4)
LEGEND = 250  # px


def for_accuracy(measured: Accuracy, directory: str | Path) -> Path:
    """`report.html` of what accuracy costs."""
    figures: list[Block] = [
        _work_precision(
            measured,
            "seconds",
            "Error against time",
            "CPU time of the run, s",
            (
                f"Smallest of several warm runs, without compilation, on {measured.machine}; a time is shown only where a second "
                "measurement confirms it within 20 %. "
            ),
        ),
        _work_precision(
            measured,
            "calls",
            "Error against counted work",
            "counted operations",
            (
                "The same on every machine. Counted are, for each unit, its most frequent operation (usually evaluations of its "
                "equations), and one exchange of signals for each unit in each macro step or iteration. "
            ),
        ),
        *_against_size(measured),
    ]
    sections = [
        Section("What accuracy costs", [Text(_advice(measured)), *figures]),
        Section("Settings", [_front_table(measured), _all_points(measured)]),
        Section("Reference", [Facts("What errors are measured against", _reference(measured))]),
    ]
    return write_page(Page(measured.title, _lead(measured), sections), Path(directory) / "report.html")


def _lead(measured: Accuracy) -> str:
    done = sum(p.outcome == "done" for p in measured.points)
    return (
        f"{done} of {len(measured.points)} settings came to a result. An error is the largest of the quantities looked at, "
        "over the range of its signal, with the reference's own error added."
    )


def _advice(measured: Accuracy) -> list[str]:
    front, sentences = measured.front(), []
    for asked in ASKED:
        point = next((p for p in front if p.error_with_finer <= asked), None)
        if asked < measured.smallest_known or point is None:
            sentences.append(f"{percent(asked)}: no measured setting holds it, or the reference is not known that well.")
        else:
            sentences.append(f"{percent(asked)}: {_name(point)}, {_seconds(point)}, error {percent(point.error_with_finer)}.")
    own = measured.own
    sentences.append(
        f"The scene's own settings: {_seconds(own)}, error {percent(own.error_with_finer)}."
        if own.outcome == "done"
        else f"The scene's own settings: {own.outcome}: {own.reason}"
    )
    return sentences


def _name(point: Point) -> str:
    return f"{point.series} at {point.size:.3g}"


def _series(measured: Accuracy) -> dict[str, list[Point]]:
    """The points of every series that is drawn joined, in the order of their size."""
    joined_points: dict[str, list[Point]] = {}
    for p in measured.points:
        joined = p.axis in JOINED or (p.axis == "substep" and not any(q.axis in JOINED[:2] for q in measured.points))
        if joined:
            joined_points.setdefault(p.series, []).append(p)
    return {name: sorted(points, key=lambda p: p.size) for name, points in joined_points.items()}


def _marked(
    points: Sequence[Point], x: Sequence[float], y: Sequence[float], name: str, colour: str, symbol: str, **more: Any
) -> dict[str, Any]:
    shown = [
        f"{p.series}<br>{p.size:.3g}; error {percent(p.error)}, {_seconds(p)}, {p.work.get('calls', 0)} calls"
        + (f"<br>{p.reason}" if p.reason else "")
        for p in points
    ]
    return {
        "type": "scatter",
        "x": drawn(x, 5),
        "y": drawn(y, 5),
        "name": name,
        "text": shown,
        "hovertemplate": "%{text}<extra></extra>",
        "mode": "lines+markers",
        "line": {"color": colour, "width": 1.4},
        "marker": {"color": colour, "symbol": symbol, "size": 8},
    } | more


def _styles(names: Sequence[str]) -> Mapping[str, tuple[str, str]]:
    """A colour and a symbol of each series."""
    return {n: (CYCLE[i % len(CYCLE)], SYMBOLS[i % len(SYMBOLS)]) for i, n in enumerate(names)}


def _work_precision(measured: Accuracy, cost: str, title: str, y_label: str, text: str) -> Figure:
    lines = _series(measured)
    styles = _styles(list(lines))
    data = []
    for name, points in lines.items():
        done = [p for p in points if p.outcome == "done" and isfinite(p.cost(cost))]
        if done:
            data.append(_marked(done, [p.error for p in done], [p.cost(cost) for p in done], name, *styles[name]))
    joined = {p.series for points in lines.values() for p in points}
    for name, axes, symbol in OTHERS:
        others = [
            p
            for p in measured.points
            if p.series not in joined and p.axis in axes and p.outcome == "done" and isfinite(p.cost(cost))
        ]
        if others:
            data.append(
                _marked(others, [p.error for p in others], [p.cost(cost) for p in others], name, RAW, symbol, mode="markers")
            )
    front = measured.front(cost)
    data.append(
        _marked(
            front,
            [p.error for p in front],
            [p.cost(cost) for p in front],
            "front",
            INK,
            "circle-open",
            line={"color": INK, "width": 1, "dash": "dot"},
            marker={"color": INK, "symbol": "circle-open", "size": 15, "line": {"width": 1.5}},
        )
    )
    if measured.own.outcome == "done" and isfinite(measured.own.cost(cost)):
        own = [measured.own]
        data.append(
            _marked(
                own,
                [own[0].error],
                [own[0].cost(cost)],
                "the scene's own settings",
                VERMILION,
                "star",
                mode="markers",
                marker={"color": VERMILION, "symbol": "star", "size": 13},
            )
        )
    failed = [p for p in measured.points if p.outcome in ("failed", "useless") and isfinite(p.cost(cost))]
    if failed:
        data.append(_crosses(failed, [FAILED] * len(failed), [p.cost(cost) for p in failed]))
    return Figure(
        title,
        {"data": data, "layout": _layout(measured, "error", y_label, bool(failed))},
        text + "Ringed: the front, the settings of which none is both cheaper and more accurate. A setting counts with the "
        "largest error of it and of all finer ones of its series, so that none is on the front by chance. Crosses: "
        "runs that failed, or whose error is above 100 %. Shaded: below the reference's own error.",
    )


def _crosses(points: Sequence[Point], x: Sequence[float], y: Sequence[float]) -> dict[str, Any]:
    return _marked(
        points,
        x,
        y,
        "failed",
        MUTED,
        "x-thin",
        mode="markers",
        marker={"color": MUTED, "symbol": "x-thin", "size": 9, "line": {"width": 2, "color": MUTED}},
    )


def _layout(measured: Accuracy, x_label: str, y_label: str, failed: bool) -> dict[str, Any]:
    least = min((p.error for p in measured.points if p.error > 0.0), default=1e-6)
    low = min(least, measured.smallest_known if isfinite(measured.smallest_known) else least)
    shapes, notes = [], []
    if measured.smallest_known > 0.5 * low:
        shapes.append(rectangle((low * 0.3, measured.smallest_known), (0, 1), MUTED, 0.1, xref="x", yref="paper"))
        notes.append(
            label(
                "← below the reference's own error",
                log10(measured.smallest_known),
                0.0,
                xref="x",
                xanchor="left",
                yanchor="bottom",
            )
        )
    if failed:
        notes.append(label("failed", log10(FAILED), 1.0, xref="x", yanchor="bottom"))
    ends = [log10(low * 0.5), log10(FAILED * 1.6 if failed else 1.2)]
    return layout(
        430,
        xaxis=axis(x_label, grid=True, type="log", dtick=1, range=ends),
        shapes=shapes,
        annotations=notes,
        yaxis=axis(y_label, grid=True, type="log"),
        margin={"l": 70, "r": LEGEND, "t": 34, "b": 50},
        legend={"orientation": "v", "x": 1.02, "y": 1, "font": {"size": 11}},
    )


def _against_size(measured: Accuracy) -> list[Block]:
    """Error against the macro step, or the internal one, where it is what a series varies; with triangles of whole orders."""
    lines = {n: [p for p in points if p.axis in ("coupling", "substep")] for n, points in _series(measured).items()}
    lines = {n: points for n, points in lines.items() if len(points) > 1}
    if not lines:
        return []
    styles, data = _styles(list(_series(measured))), []
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
    inside = all(p.axis == "substep" for p in seen)
    what = "internal step, s" if inside else "macro step, s"
    sizes, errors = [p.size for p in seen], [p.error for p in seen if p.error > 0.0]
    shapes, notes = _triangles(max(sizes), min(errors), ORDERS if inside else ORDERS[:3])
    figure_layout = layout(
        430,
        xaxis=axis(what, grid=True, type="log"),
        yaxis=axis("error", grid=True, type="log", dtick=1),
        shapes=shapes,
        annotations=notes,
        margin={"l": 70, "r": LEGEND, "t": 34, "b": 50},
        legend={"orientation": "v", "x": 1.02, "y": 1, "font": {"size": 11}},
    )
    return [
        Figure(
            f"Error against the {what.partition(',')[0]}",
            {"data": data, "layout": figure_layout},
            "Slope triangles: errors that fall with the first, second ... power of the step. Where a series turns flat, "
            "another error prevails: that of the internal steps, of a peak between two samples, or the reference's own. "
            "Crosses at the top: runs that failed, were refused, or whose error is above 100 %.",
        )
    ]


def _triangles(largest: float, least: float, orders: Sequence[int]) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """Triangles over one another on one base, in the corner of long steps below all errors, which is free."""
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
    quantities = list(measured.agreement)
    shown = quantities[:8]
    chosen = [measured.own]
    chosen += [p for p in measured.points if p is not measured.own and (p in measured.front() or p in measured.front("calls"))]
    rows = [
        (
            p.series,
            f"{p.size:.3g}",
            percent(p.error_with_finer),
            _seconds(p),
            str(p.work.get("calls", "")),
            *(percent(p.errors.get(q, float("nan"))) for q in shown),
        )
        for p in sorted(chosen, key=lambda p: p.work.get("calls", 0))
    ]
    hidden = len(quantities) > len(shown)
    more = f" Of {len(quantities)} quantities the first {len(shown)} are shown; all are in accuracy.csv." if hidden else ""
    return Cells(
        "The scene's own settings, and the fronts over CPU time and over counted work",
        ("setting", "size", "error", "CPU time", "calls", *shown),
        rows,
        "Size: macro step in s, or tolerance. Columns of quantities: distance from the reference alone." + more,
        frozenset(range(1, 5 + len(shown))),
    )


def _all_points(measured: Accuracy) -> Cells:
    rows = [
        (
            p.series,
            f"{p.size:.3g}",
            p.outcome,
            percent(p.error),
            percent(p.error_with_finer),
            number(p.seconds),
            number(p.median),
            *(str(p.work.get(n, "")) for n in ("macro_steps", "derivative_calls", "iterations", "rollbacks", "events", "calls")),
            p.reason,
        )
        for p in measured.points
        if p.outcome != "skipped"
    ]
    skipped = [p for p in measured.points if p.outcome == "skipped"]
    caption = f"{len(skipped)} more were skipped: {skipped[0].reason}. accuracy.csv names them." if skipped else ""
    return Cells(
        "Every setting",
        (
            "setting",
            "size",
            "outcome",
            "error",
            "with finer settings",
            "CPU time, s",
            "median",
            "macro steps",
            "derivative calls",
            "iterations",
            "rollbacks",
            "events",
            "calls",
            "reason",
        ),
        rows,
        caption,
        frozenset(range(3, 13)),
    )


def _reference(measured: Accuracy) -> list[tuple[str, str]]:
    rows = [
        ("reference", measured.reference),
        ("shared with the runs", f"{measured.shares}; a defect of these does not show"),
        ("second solution", measured.second_solution),
    ]
    rows += [(f"distance of the two, {name}", percent(value)) for name, value in measured.agreement.items()]
    rows += [(f"mesh of the reference, {name}", f"{percent(value)} (Richardson)") for name, value in measured.mesh_error.items()]
    return [*rows, ("machine", measured.machine), ("versions", measured.versions)]


def _seconds(point: Point) -> str:
    return f"{point.seconds:.3g} s" if isfinite(point.seconds) else "time refused" if isfinite(point.scatter) else "–"
