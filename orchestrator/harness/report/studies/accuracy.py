"""The page of `cosimo accuracy`: work-precision diagrams, error against the macro step, fronts, and every measured setting.

Axes are those of SciML's diagrams: error on x, time on y, both logarithmic, one marked line a method; what failed stays in the
picture as a cross with its reason.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import inf, isfinite, log10
from pathlib import Path
from typing import Any

from ...charts.blocks import Block, Cells, Facts, Figure, Text
from ...charts.style import CYCLE, INK, LEGEND_RIGHT, MUTED, RAW, VERMILION, axis, label, layout, markers, number, rectangle
from ...studies.accuracy import Accuracy, Point
from ...studies.quantities import percent
from ..page import Page, Section, write_page

SYMBOLS = ("circle", "square", "diamond", "triangle-up", "triangle-down", "pentagon", "hexagon", "star-square")
JOINED = ("coupling", "adaptive", "method")  # axes of settings whose points are joined
OTHERS = (
    ("other internal steps or meshes", ("substep", "mesh"), "circle-open"),
    ("without one effect", ("effect",), "diamond-open"),
)
FAILED = 2.0  # where crosses stand on an axis of errors
ASKED = (0.1, 0.01, 1e-3)  # errors for which the page names the quickest setting
ORDERS = (1, 2, 3, 4)
SHOWN = 8  # quantities in the table of the fronts
WORK = ("macro_steps", "derivative_calls", "iterations", "rollbacks", "events", "calls")  # columns of the table of all points


def for_accuracy(measured: Accuracy, directory: str | Path) -> Path:
    """`report.html` of what accuracy costs."""
    times = (
        f"Smallest of several warm runs, without compilation, on {measured.machine}; a time is shown only where a second "
        "measurement confirms it within 20 %. "
    )
    work = (
        "The same on every machine. Counted are, for each unit, its most frequent operation (usually evaluations of its "
        "equations), and one exchange of signals for each unit in each macro step or iteration. "
    )
    figures: list[Block] = [
        _work_precision(measured, "seconds", "Error against time", "CPU time of the run, s", times),
        _work_precision(measured, "calls", "Error against counted work", "counted operations", work),
        *_against_size(measured),
    ]
    sections = [
        Section("What accuracy costs", [Text(_advice(measured)), *figures]),
        Section("Settings", [front_cells(measured, SHOWN), _all_points(measured)]),
        Section("Reference", [Facts("Reference solution", _reference(measured))]),
    ]
    return write_page(Page(measured.title, _lead(measured), sections), Path(directory) / "report.html")


def _lead(measured: Accuracy) -> str:
    done = sum(p.outcome == "done" for p in measured.points)
    return (
        f"{done} of {len(measured.points)} settings gave a result. The error of a setting is the largest error of all quantities, "
        "relative to the range of the signal. It includes the error of the reference solution."
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


def _points(
    points: Sequence[Point],
    x: Sequence[float],
    y: Sequence[float],
    name: str,
    colour: str,
    symbol: str,
    size: float = 8,
    **more: Any,
) -> dict[str, Any]:
    """Settings as points, which the pointer names; line: of their connection, without it there is none."""
    texts = [
        f"{p.series}<br>{p.size:.3g}; error {percent(p.error)}, {_seconds(p)}, {p.work.get('calls', 0)} calls"
        + (f"<br>{p.reason}" if p.reason else "")
        for p in points
    ]
    mode = "lines+markers" if "line" in more else "markers"
    return markers(x, y, name, colour, symbol, size, hover="%{text}<extra></extra>", text=texts, mode=mode, **more)


def _styles(names: Sequence[str]) -> Mapping[str, tuple[str, str]]:
    """A colour and a symbol of each series."""
    return {n: (CYCLE[i % len(CYCLE)], SYMBOLS[i % len(SYMBOLS)]) for i, n in enumerate(names)}


def _work_precision(measured: Accuracy, cost: str, title: str, y_label: str, text: str) -> Figure:
    series = _series(measured)
    styles = _styles(list(series))
    drawable = [p for p in measured.points if isfinite(p.cost(cost))]
    done = [p for p in drawable if p.outcome == "done"]

    def trace(points: Sequence[Point], name: str, colour: str, symbol: str, size: float = 8, **more: Any) -> list[dict[str, Any]]:
        x, y = [p.error for p in points], [p.cost(cost) for p in points]
        return [_points(points, x, y, name, colour, symbol, size, **more)] if points else []

    data = []
    for name, points in series.items():
        colour, symbol = styles[name]
        data += trace([p for p in points if p in done], name, colour, symbol, line={"color": colour, "width": 1.4})
    for name, axes, symbol in OTHERS:
        data += trace([p for p in done if p.series not in series and p.axis in axes], name, RAW, symbol)
    ring = {"color": INK, "symbol": "circle-open", "size": 15, "line": {"width": 1.5}}
    dotted = {"color": INK, "width": 1, "dash": "dot"}
    data += trace(measured.front(cost), "front", INK, "circle-open", marker=ring, line=dotted)
    data += trace([p for p in done if p is measured.own], "the scene's own settings", VERMILION, "star", 13)
    failed = [p for p in drawable if p.outcome in ("failed", "useless")]
    data += _crosses(failed, [FAILED] * len(failed), [p.cost(cost) for p in failed])
    return Figure(
        title,
        {"data": data, "layout": _layout(measured, "error", y_label, bool(failed))},
        text + "Ringed: the front, the settings of which none is both cheaper and more accurate. A setting counts with the "
        "largest error of it and of all finer ones of its series, so that none is on the front by chance. Crosses: "
        "runs that failed, or whose error is above 100 %. Shaded: below the reference's own error.",
    )


def _crosses(points: Sequence[Point], x: Sequence[float], y: Sequence[float]) -> list[dict[str, Any]]:
    cross = {"color": MUTED, "symbol": "x-thin", "size": 9, "line": {"width": 2, "color": MUTED}}
    return [_points(points, x, y, "failed", MUTED, "x-thin", marker=cross)] if points else []


def _layout(measured: Accuracy, x_label: str, y_label: str, failed: bool) -> dict[str, Any]:
    least = min((p.error for p in measured.points if 0.0 < p.error < inf), default=1e-6)
    low = min(least, measured.smallest_known) if measured.smallest_known > 0.0 else least
    shapes, notes = [], []
    if measured.smallest_known > 0.5 * low:
        shapes.append(rectangle((low * 0.3, measured.smallest_known), (0, 1), MUTED, 0.1, xref="x", yref="paper"))
        at = log10(measured.smallest_known)
        notes.append(label("← below the reference's own error", at, 0.0, xref="x", xanchor="left", yanchor="bottom"))
    if failed:
        notes.append(label("failed", log10(FAILED), 1.0, xref="x", yanchor="bottom"))
    ends = [log10(low * 0.5), log10(FAILED * 1.6 if failed else 1.2)]
    return layout(
        430,
        xaxis=axis(x_label, grid=True, type="log", dtick=1, range=ends),
        shapes=shapes,
        annotations=notes,
        yaxis=axis(y_label, grid=True, type="log"),
        **LEGEND_RIGHT,
    )


def _against_size(measured: Accuracy) -> list[Block]:
    """Error against the macro step, or the internal one, where it is what a series varies; with triangles of whole orders."""
    every = _series(measured)
    styles, data = _styles(list(every)), []
    seen: list[Point] = []
    failed: list[Point] = []
    for name, of_series in every.items():
        points = [p for p in of_series if p.axis in ("coupling", "substep")]
        if len(points) > 1:
            done = [p for p in points if p.outcome == "done"]
            failed += [p for p in points if p.outcome in ("failed", "useless", "refused")]
            if done:
                colour, symbol = styles[name]
                errors, sizes = [p.error for p in done], [p.size for p in done]
                data.append(_points(done, sizes, errors, name, colour, symbol, line={"color": colour, "width": 1.4}))
            seen += done
    if not seen:
        return []
    data += _crosses(failed, [p.size for p in failed], [FAILED] * len(failed))
    inside = all(p.axis == "substep" for p in seen)
    what = "internal step, s" if inside else "macro step, s"
    sizes, errors = [p.size for p in seen], [p.error for p in seen if p.error > 0.0]
    shapes, notes = _triangles(max(sizes), min(errors), ORDERS if inside else ORDERS[:3]) if errors else ([], [])
    figure_layout = layout(
        430,
        xaxis=axis(what, grid=True, type="log"),
        yaxis=axis("error", grid=True, type="log", dtick=1),
        shapes=shapes,
        annotations=notes,
        **LEGEND_RIGHT,
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


def front_cells(measured: Accuracy, most: int = 0) -> Cells:
    """The scene's own settings and the fronts; with the errors of so many quantities."""
    quantities = list(measured.agreement)
    shown = quantities[:most]
    fronts = {name: measured.front(cost) for name, cost in (("time", "seconds"), ("work", "calls"))}
    chosen = [measured.own]
    chosen += [p for p in measured.points if p is not measured.own and any(p in front for front in fronts.values())]
    rows = [
        (
            p.series,
            f"{p.size:.3g}",
            percent(p.error_with_finer),
            _seconds(p),
            str(p.work.get("calls", "")),
            ", ".join(name for name, front in fronts.items() if p in front),
            *(percent(p.errors.get(q, float("nan"))) for q in shown),
        )
        for p in sorted(chosen, key=lambda p: p.work.get("calls", 0))
    ]
    hidden = len(quantities) > len(shown) > 0
    more = f" Of {len(quantities)} quantities the first {len(shown)} are shown; all are in accuracy.csv." if hidden else ""
    return Cells(
        "The scene's own settings, and the fronts over CPU time and over counted work",
        ("setting", "size", "error", "CPU time", "calls", "on the front of", *shown),
        rows,
        "Size: macro step in s, or tolerance."
        + (" Columns of quantities: distance from the reference alone." if shown else "")
        + more,
        frozenset({1, 2, 3, 4, *range(6, 6 + len(shown))}),
    )


def _all_points(measured: Accuracy) -> Cells:
    skipped = [p for p in measured.points if p.outcome == "skipped"]
    rows = [
        (
            p.series,
            f"{p.size:.3g}",
            p.outcome,
            percent(p.error),
            percent(p.error_with_finer),
            number(p.seconds),
            number(p.median),
            *(str(p.work.get(n, "")) for n in WORK),
            p.reason,
        )
        for p in measured.points
        if p.outcome != "skipped"
    ]
    counted = [n.replace("_", " ") for n in WORK]
    header = ("setting", "size", "outcome", "error", "with finer settings", "CPU time, s", "median", *counted, "reason")
    caption = f"{len(skipped)} more were skipped: {skipped[0].reason}. accuracy.csv names them." if skipped else ""
    return Cells("Every setting", header, rows, caption, frozenset(range(3, len(header) - 1)))


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
