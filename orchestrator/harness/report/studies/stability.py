"""Pages of `cosimo stability`: limits of the macro step as bars, curves or maps; internal steps."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, isfinite, isnan, log10
from pathlib import Path
from typing import Any

import numpy as np

from ....judgement.growth import limit_text
from ...charts.blocks import Block, Cells, Facts, Figure, Text
from ...charts.style import (
    BLUE,
    CYCLE,
    INK,
    LEGEND_RIGHT,
    MUTED,
    RISING,
    VERMILION,
    axis,
    drawn,
    label,
    layout,
    line,
    markers,
    rows_axis,
    vertical,
)
from ...studies.internal_steps import InternalStep, InternalSteps
from ...studies.stability import Scheme, SchemeLimit, StabilityMap
from ..page import Page, Section, write_page

ROW = 34  # px of a bar
PANEL = 250  # px of a map
GAPS = 0.07, 0.12  # between maps, shares of the figure's width and height
LEVELS = 12  # about so many contours
TICKS = 8  # values of a parameter that an axis may name
TITLE = "Longest stable macro step"


def for_stability(study: StabilityMap, directory: str | Path) -> Path:
    """`report.html` of a scene's limits."""
    figures: list[Block] = [Text(list(study.remarks), "note")] if study.remarks else []
    figures.append({0: _bars, 1: _curves, 2: _maps}[len(study.varied)](study))
    lead = (
        "The longest macro step at which a small disturbance does not grow, by algorithm and degree of extrapolation; the "
        "numbers are in stability.csv."
    )
    master = study.scene.master
    settings = [
        ("macro step of the scene, s", f"{master.step:g}"),
        ("algorithm of the scene", f"{master.algorithm}, {master.extrapolation}"),
    ]
    sections = [
        Section("What stays stable", figures),
        Section("Limits", [limit_cells(study)]),
        Section("Settings", [Facts("The scene", settings)]),
    ]
    return write_page(Page(study.scene.title or study.scene.name, lead, sections), Path(directory) / "report.html")


def for_internal_steps(study: InternalSteps, directory: str | Path) -> Path:
    """`report.html` of a component's limits."""
    figure = _rows_figure(
        "Longest stable internal step",
        "internal step, s",
        [_set_text(s) for s in study.steps],
        [("measured", [s.longest for s in study.steps]), ("the component's own limit", [s.own for s in study.steps])],
        "A measured limit left of the component's own: the component claims too much. Without a mark: no limit was found, or "
        "the component has none; see the table.",
    )
    lead = "The longest internal step at which a small disturbance does not grow, inputs held; the numbers are in stability.csv."
    sections = [Section("What stays stable", [figure, step_cells(study)])]
    return write_page(Page(f"{study.title}: internal steps", lead, sections), Path(directory) / "report.html")


def step_cells(study: InternalSteps) -> Cells:
    """The limit of a component with each set of effects."""
    return Cells(
        "Longest stable internal step",
        ("effects", "measured, s", "own limit, s", "margin", "what the next longer step did"),
        [
            (_set_text(s), limit_text(s.longest, s.tried), _step_text(s.own, "none"), _step_text(s.margin), s.seen)
            for s in study.steps
        ],
        "Margin: measured over own limit.",
        frozenset((1, 2, 3)),
    )


def _set_text(step: InternalStep) -> str:
    return ", ".join(step.effects) or "no effects"


def _step_text(step: float, without_limit: str = "any") -> str:
    return "–" if isnan(step) else without_limit if step == inf else "none" if step == 0.0 else f"{step:.4g}"


def _scheme_text(scheme: Scheme) -> str:
    return f"{scheme[0]}, {('held', 'linear', 'quadratic')[scheme[1]]}"


def _labels(study: StabilityMap) -> list[str]:
    return [f"{name}, {unit}" if unit else name for name, unit in study.varied.items()]


def _own_step_text(step: float, limit: SchemeLimit) -> str:
    """Whether the scene's own step is stable by a limit, which may lie beyond the steps that were tried."""
    if isnan(limit.longest) or (limit.longest == inf and step > limit.tried) or (limit.longest == 0.0 and step < limit.tried):
        return "–"
    return "stable" if step <= limit.longest else "unstable"


def limit_cells(study: StabilityMap) -> Cells:
    """The limit of each scheme at each point."""
    names, master = _labels(study), study.scene.master
    own = master.algorithm, master.extrapolation
    rows = [
        (
            *(f"{v:.4g}" for v in limit.point.values()),
            _scheme_text(scheme := (limit.algorithm, limit.extrapolation)) + (" (the scene's)" if scheme == own else ""),
            limit_text(limit.longest, limit.tried),
            _own_step_text(master.step, limit),
            limit.how or "–",
            limit.seen,
        )
        for limit in study.limits
    ]
    n = len(names)
    return Cells(
        TITLE,
        (
            *names,
            "algorithm, inputs",
            "longest stable step, s",
            f"the scene's {master.step:g} s",
            "told by",
            "what a longer step does",
        ),
        rows,
        "Eigenvalue: the derivative of a macro step is the same all along the run, and the limit is exact. Growth along the run: "
        "that of a push over stretches that begin on a run with short steps, beside that of a quarter of the step; some per cent.",
        frozenset([*range(n), n + 1]),
    )


def _rows_figure(
    title: str, x_label: str, names: Sequence[str], marks: Sequence[tuple[str, Sequence[float]]], caption: str, **more: Any
) -> Figure:
    """Positive numbers of named rows, the first at the top: of the first kind as dots, of the second as bars across."""
    rows = range(len(names))[::-1]
    data = [
        markers(
            np.where(np.asarray(x) > 0.0, x, np.nan),
            rows,
            name,
            colour,
            hover="%{x:.4g} s<extra>%{fullData.name}</extra>",
            marker={"color": colour, "symbol": symbol, "size": 11, "line": {"width": 3, "color": colour}},
        )
        for (name, x), colour, symbol in zip(marks, (BLUE, VERMILION), ("circle", "line-ns-open"), strict=False)
    ]
    figure_layout = layout(
        ROW * len(names) + 110,
        xaxis=axis(x_label, grid=True, type="log"),
        yaxis=rows_axis(names[::-1]),
        margin={"l": 190, "r": 20, "t": 40, "b": 50},
        **more,
    )
    return Figure(title, {"data": data, "layout": figure_layout}, caption)


def _bars(study: StabilityMap) -> Figure:
    """One point: a row for each scheme."""
    limits, step = study.limits, study.scene.master.step
    notes = [label("the scene's", log10(step), 1.0, xref="x", yanchor="bottom")]
    for row, limit in enumerate(reversed(limits)):
        if isfinite(limit.tried) and limit.longest in (inf, 0.0):
            stable = limit.longest == inf
            text = f"stable up to {limit.tried:.3g} →" if stable else f"← unstable down to {limit.tried:.3g}"
            notes.append(label(text, log10(limit.tried), row, xref="x", yref="y", xanchor="right" if stable else "left"))
    return _rows_figure(
        TITLE,
        "macro step, s",
        [_scheme_text(scheme) for scheme in study.schemes],
        [("longest stable", [limit.longest for limit in limits])],
        "Without a mark: no limit lies between the steps that were tried, or stability was not examined; see the table.",
        shapes=[vertical(step, colour=INK, dash="dot")],
        annotations=notes,
    )


def _curves(study: StabilityMap) -> Figure:
    """One parameter: a series for each scheme."""
    (name,), data = study.varied, []
    for k, scheme in enumerate(study.schemes):
        limits, colour = study.of(scheme), CYCLE[k % len(CYCLE)]
        x = [limit.point[name] for limit in limits]
        y = np.array([limit.longest for limit in limits])
        if (np.isfinite(y) & (y > 0.0)).any():
            data.append(line(x, np.where(y > 0.0, y, np.nan), _scheme_text(scheme), colour, mode="lines+markers"))
    figure_layout = layout(
        430,
        xaxis=_parameter_axis(_labels(study)[0], study, name),
        yaxis=axis("macro step, s", grid=True, type="log"),
        **LEGEND_RIGHT,
    )
    caption = "A gap: every step that was tried is stable, or none is; see the table."
    return Figure(TITLE, {"data": data, "layout": figure_layout}, caption)


def _parameter_axis(title: str, study: StabilityMap, name: str, **more: Any) -> dict[str, Any]:
    """Logarithmic where the values are spread over more than a decade."""
    values = sorted({limit.point[name] for limit in study.limits})
    spread = values[0] > 0.0 and values[-1] > 8.0 * values[0]
    few = len(values) <= TICKS
    marks: dict[str, Any] = {"tickvals": drawn(values, 6), "ticktext": [f"{v:.4g}" for v in values]} if few else {}
    return axis(title, type="log" if spread else "linear", **marks, **more)


def _maps(study: StabilityMap) -> Block:
    """Two parameters: a map for each scheme."""
    first, second = study.varied
    xs, ys = (sorted({limit.point[n] for limit in study.limits}) for n in (first, second))
    finite = [log10(limit.longest) for limit in study.limits if 0.0 < limit.longest < inf]
    if not finite:
        return Text(["No limit lies between the steps that were tried; see the table."], "note")
    low, high = min(finite), max(finite)
    columns = len({degree for _, degree in study.schemes})
    rows = -(-len(study.schemes) // columns)
    width, tall = ((1.0 - gap * (n - 1)) / n for gap, n in zip(GAPS, (columns, rows), strict=True))
    labels = _labels(study)
    data: list[dict[str, Any]] = []
    axes: dict[str, Any] = {}
    notes = []
    for k, scheme in enumerate(study.schemes):
        row, column = divmod(k, columns)
        left, top = column * (width + GAPS[0]), 1.0 - row * (tall + GAPS[1])
        n = "" if k == 0 else str(k + 1)
        x_label, y_label = labels[0] if row == rows - 1 else "", labels[1] if column == 0 else ""
        axes["xaxis" + n] = _parameter_axis(x_label, study, first, domain=[left, left + width], anchor="y" + n)
        axes["yaxis" + n] = _parameter_axis(y_label, study, second, domain=[max(top - tall, 0.0), top], anchor="x" + n)
        bold = {"size": 12.5, "color": INK}
        notes.append(label(f"<b>{_scheme_text(scheme)}</b>", left, top, xanchor="left", yanchor="bottom", font=bold))
        place = {"xaxis": "x" + n, "yaxis": "y" + n}
        limits = study.of(scheme)
        grid = np.full((len(ys), len(xs)), np.nan)
        for limit in limits:
            if 0.0 < limit.longest < inf:
                grid[ys.index(limit.point[second]), xs.index(limit.point[first])] = log10(limit.longest)
        if np.isfinite(grid).any():
            scale = not any(trace.get("showscale") for trace in data)
            data.append(_contours(grid, xs, ys, low, high, scale) | place)
        for symbol, longest in (("circle-open", inf), ("x", 0.0)):
            if at := [limit.point for limit in limits if limit.longest == longest]:
                x, y = ([point[name] for point in at] for name in (first, second))
                data.append(markers(x, y, "", MUTED, symbol, 7, hoverinfo="skip", **place))
    figure_layout = layout(
        PANEL * rows + 90, annotations=notes, showlegend=False, margin={"l": 70, "r": 90, "t": 34, "b": 50}, **axes
    )
    return Figure(TITLE, {"data": data, "layout": figure_layout}, "○: every step tried is stable; ×: none is.")


def _contours(grid: np.ndarray, x: Sequence[float], y: Sequence[float], low: float, high: float, scale: bool) -> dict[str, Any]:
    """A map of logarithms of steps, (len(y), len(x))."""
    ticks = np.linspace(low, high, 5)
    bar = {
        "title": {"text": "macro step, s", "side": "right", "font": {"size": 13}},
        "thickness": 12,
        "outlinewidth": 0,
        "tickvals": drawn(ticks),
        "ticktext": [f"{10.0**t:.2g}" for t in ticks],
    }
    levels = {"start": low, "end": high, "size": max((high - low) / LEVELS, 1e-3), "coloring": "fill"}
    return {
        "type": "contour",
        "z": [drawn(row) for row in grid],
        "x": drawn(x, 6),
        "y": drawn(y, 6),
        "zmin": low,
        "zmax": high,
        "contours": levels,
        "showscale": scale,
        "line": {"width": 0.6, "color": MUTED},
        "colorscale": RISING,
        "colorbar": bar,
        "hovertemplate": "%{x:.4g}, %{y:.4g}: 10^%{z:.3f} s<extra></extra>",
    }
