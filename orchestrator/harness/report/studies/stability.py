"""Pages of `cosimo stability`: limits of the macro step as bars, curves or maps with their closed form; internal steps."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, isfinite, isnan, log10
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ...charts.blocks import Block, Cells, Facts, Figure, Text
from ...charts.style import BLUE, CYCLE, INK, MUTED, RAW, RISING, VERMILION, axis, drawn, label, layout, vertical
from ..page import Page, Section, write_page

if TYPE_CHECKING:
    from ...studies.internal_steps import InternalSteps
    from ...studies.stability import Limit, Scheme, Stability

ROW = 34  # px of a bar
PANEL = 250  # px of a map
LEVELS = 12  # about so many contours
TICKS = 8  # values of a parameter that an axis may name


def for_stability(study: Stability, directory: str | Path) -> Path:
    """`report.html` of a scene's limits."""
    figures: list[Block] = [Text(list(study.remarks), "note")] if study.remarks else []
    figures += {0: _bars, 1: _curves, 2: _maps}[len(study.varied)](study)
    figures += _against_closed_form(study)
    lead = (
        "The longest macro step at which a small disturbance does not grow, by algorithm and degree of extrapolation; the "
        "numbers are in stability.csv."
    )
    settings = [
        ("macro step of the scene, s", f"{study.scene.master.step:g}"),
        ("algorithm of the scene", f"{study.scene.master.algorithm}, {study.scene.master.extrapolation}"),
        ("macro steps made", str(sum(limit.steps for limit in study.limits))),
    ]
    sections = [
        Section("What stays stable", figures),
        Section("Limits", [_table(study)]),
        Section("Settings", [Facts("The scene", settings)]),
    ]
    return write_page(Page(study.scene.title or study.scene.name, lead, sections), Path(directory) / "report.html")


def for_internal_steps(study: InternalSteps, directory: str | Path) -> Path:
    """`report.html` of a component's limits."""
    names = [", ".join(s.effects) or "no effects" for s in study.steps]
    rows = list(range(len(names)))[::-1]  # the first at the top
    data = [
        _dots(np.array([s.longest for s in study.steps]), rows, "measured", BLUE, "circle"),
        _dots(np.array([s.own for s in study.steps]), rows, "the component's own limit", VERMILION, "line-ns-open"),
    ]
    figure = Figure(
        "Longest stable internal step",
        {"data": data, "layout": _bar_layout("internal step, s", names, rows)},
        (
            "A measured limit left of the component's own: the component claims too much. Without a mark: no limit was found, or "
            "the component has none; see the table."
        ),
    )
    table = Cells(
        "",
        ("effects", "measured, s", "own limit, s", "margin", "what the next longer step did"),
        [
            (name, _limit(s.longest, s.tried), _own(s.own), f"{s.margin:.3g}" if isfinite(s.margin) else "–", s.seen)
            for name, s in zip(names, study.steps, strict=True)
        ],
        "Margin: measured over own limit.",
        frozenset((1, 2, 3)),
    )
    lead = "The longest internal step at which a small disturbance does not grow, inputs held; the numbers are in stability.csv."
    return write_page(
        Page(f"{study.title}: internal steps", lead, [Section("What stays stable", [figure, table])]),
        Path(directory) / "report.html",
    )


def _limit(longest: float, tried: float) -> str:
    if isnan(longest):
        return "–"
    return f"above {tried:.3g}" if longest == inf else f"below {tried:.3g}" if longest == 0.0 else f"{longest:.4g}"


def _own(step: float) -> str:
    return "none" if step == inf else "–" if isnan(step) else f"{step:.4g}"


def _name(scheme: Scheme) -> str:
    return f"{scheme[0]}, {('held', 'linear', 'quadratic')[scheme[1]]}"


def _table(study: Stability) -> Cells:
    names = [f"{n}, {unit}" if unit else n for n, unit in study.varied.items()]
    rows = [
        (
            *(f"{v:.4g}" for v in limit.point.values()),
            _name((limit.algorithm, limit.extrapolation)),
            _limit(limit.longest, limit.tried),
            _closed(limit.closed),
            _ratio(limit),
            limit.seen,
        )
        for limit in study.limits
    ]
    n = len(names)
    return Cells(
        "",
        (*names, "algorithm, inputs", "longest stable step, s", "closed form, s", "ratio", "what the next longer step did"),
        rows,
        "Closed form: the shortest limit of all pairs of units for which it is known. The measured limit is that of the "
        "whole scene; it is shorter where another coupling limits it, and longer where other damping helps.",
        frozenset([*range(n), n + 1, n + 2, n + 3]),
    )


def _closed(step: float) -> str:
    return "–" if isnan(step) else "any" if step == inf else "none" if step == 0.0 else f"{step:.4g}"


def _ratio(limit: Limit) -> str:
    return f"{limit.longest / limit.closed:.4f}" if _comparable(limit) else "–"


def _comparable(limit: Limit) -> bool:
    return all(isfinite(x) and x > 0.0 for x in (limit.longest, limit.closed))


def _dots(x: np.ndarray, y: Sequence[int], name: str, colour: str, symbol: str) -> dict[str, Any]:
    return {
        "type": "scatter",
        "mode": "markers",
        "x": drawn(np.where(x > 0.0, x, np.nan), 5),
        "y": list(y),
        "name": name,
        "hovertemplate": "%{x:.4g} s<extra>%{fullData.name}</extra>",
        "marker": {"color": colour, "symbol": symbol, "size": 11, "line": {"width": 3, "color": colour}},
    }


def _bar_layout(x_label: str, names: Sequence[str], rows: Sequence[int]) -> dict[str, Any]:
    return layout(
        ROW * len(names) + 110,
        xaxis=axis(x_label, grid=True, type="log"),
        yaxis=axis("", tickvals=list(rows), ticktext=list(names), range=[-0.6, len(names) - 0.4]),
        margin={"l": 190, "r": 20, "t": 40, "b": 50},
    )


def _bars(study: Stability) -> list[Block]:
    """One point: a row for each scheme."""
    limits = study.limits
    names = [_name(scheme) for scheme in study.schemes]
    rows = list(range(len(names)))[::-1]
    data = [
        _dots(np.array([limit.longest for limit in limits]), rows, "measured", BLUE, "circle"),
        _dots(np.array([limit.closed for limit in limits]), rows, "closed form", VERMILION, "line-ns-open"),
    ]
    figure_layout = _bar_layout("macro step, s", names, rows)
    step = study.scene.master.step
    figure_layout["shapes"] = [vertical(step, colour=INK, dash="dot")]
    notes = [label("the scene's", log10(step), 1.0, xref="x", yanchor="bottom")]
    for row, limit in zip(rows, limits, strict=True):
        if isfinite(limit.tried) and (limit.longest == inf or limit.longest == 0.0):
            arrow = f"stable up to {limit.tried:.3g} →" if limit.longest == inf else f"← unstable down to {limit.tried:.3g}"
            notes.append(
                label(arrow, log10(limit.tried), row, xref="x", yref="y", xanchor="right" if limit.longest == inf else "left")
            )
    figure_layout["annotations"] = notes
    return [
        Figure(
            "Longest stable macro step",
            {"data": data, "layout": figure_layout},
            "Without a mark: a closed form is not known there, or nothing was measured; see the table.",
        )
    ]


def _curves(study: Stability) -> list[Block]:
    """One parameter: a line for each scheme, dashed its closed form."""
    (name, unit), data = next(iter(study.varied.items())), []
    for k, scheme in enumerate(study.schemes):
        limits, colour = study.of(scheme), CYCLE[k % len(CYCLE)]
        x = [limit.point[name] for limit in limits]
        for what, values, style in (
            ("", [limit.longest for limit in limits], {"mode": "lines+markers"}),
            (", closed form", [limit.closed for limit in limits], {"mode": "lines"}),
        ):
            y = np.array(values)
            if (np.isfinite(y) & (y > 0.0)).any():
                data.append(
                    {
                        "type": "scatter",
                        "x": drawn(x, 6),
                        "y": drawn(np.where(y > 0.0, y, np.nan), 5),
                        **style,
                        "name": _name(scheme) + what,
                        "line": {"color": colour, "width": 1.8, "dash": "dash" if what else "solid"},
                    }
                )
    return [
        Figure(
            "Longest stable macro step",
            {
                "data": data,
                "layout": layout(
                    430,
                    xaxis=_parameter_axis(f"{name}, {unit}", study, name),
                    yaxis=axis("macro step, s", grid=True, type="log"),
                    margin={"l": 70, "r": 250, "t": 34, "b": 50},
                    legend={"orientation": "v", "x": 1.02, "y": 1, "font": {"size": 11}},
                ),
            },
            "Dashed: closed forms. A gap: every step that was tried is stable, or none is; see the table.",
        )
    ]


def _parameter_axis(title: str, study: Stability, name: str, **more: Any) -> dict[str, Any]:
    """Logarithmic where the values are spread over more than a decade."""
    values = np.array([limit.point[name] for limit in study.limits])
    spread = values.min() > 0.0 and values.max() > 8.0 * values.min()
    ticks = sorted(set(values.tolist())) if len(set(values.tolist())) <= TICKS else []
    marks: dict[str, Any] = {"tickvals": drawn(ticks, 6), "ticktext": [f"{v:.4g}" for v in ticks]} if ticks else {}
    return axis(title, type="log" if spread else "linear", **marks, **more)


def _maps(study: Stability) -> list[Block]:
    """Two parameters: a map for each scheme, filled as measured, with the closed form's lines at the same steps."""
    (first, _), (second, _) = (items := list(study.varied.items()))
    xs, ys = (sorted({limit.point[n] for limit in study.limits}) for n in (first, second))
    finite = [log10(limit.longest) for limit in study.limits if 0.0 < limit.longest < inf]
    if not finite:
        return [Text(["No limit lies between the steps that were tried; see the table."], "note")]
    low, high = min(finite), max(finite)
    levels = {"start": low, "end": high, "size": max((high - low) / LEVELS, 1e-3)}
    schemes = study.schemes
    columns = len({degree for _, degree in schemes})
    rows = -(-len(schemes) // columns)
    width, tall = (1.0 - 0.07 * (columns - 1)) / columns, (1.0 - 0.12 * (rows - 1)) / rows
    data: list[dict[str, Any]] = []
    axes: dict[str, Any] = {}
    notes = []
    labels = [f"{n}, {unit}" if unit else n for n, unit in items]
    for k, scheme in enumerate(schemes):
        row, column = divmod(k, columns)
        left, top = column * (width + 0.07), 1.0 - row * (tall + 0.12)
        n = "" if k == 0 else str(k + 1)
        axes["xaxis" + n] = _parameter_axis(
            labels[0] if row == rows - 1 else "", study, first, domain=[left, left + width], anchor="y" + n
        )
        axes["yaxis" + n] = _parameter_axis(
            labels[1] if column == 0 else "", study, second, domain=[max(top - tall, 0.0), top], anchor="x" + n
        )
        bold = {"size": 12.5, "color": INK}
        notes.append(label(f"<b>{_name(scheme)}</b>", left, top, xanchor="left", yanchor="bottom", font=bold))
        place = {"x": drawn(xs, 6), "y": drawn(ys, 6), "xaxis": "x" + n, "yaxis": "y" + n}
        limits = study.of(scheme)
        measured, closed = (_grid(limits, (first, xs), (second, ys), which) for which in ("longest", "closed"))
        if np.isfinite(measured).any():
            data.append(
                {
                    "type": "contour",
                    "z": [drawn(r, 5) for r in measured],
                    **place,
                    "zmin": low,
                    "zmax": high,
                    "contours": levels | {"coloring": "fill"},
                    "line": {"width": 0.6, "color": MUTED},
                    "colorscale": RISING,
                    "showscale": not any(d.get("showscale") for d in data),
                    "colorbar": _scale(low, high),
                    "name": "measured",
                    "hovertemplate": "%{x:.4g}, %{y:.4g}: 10^%{z:.3f} s<extra>measured</extra>",
                }
            )
        if np.isfinite(closed).any():
            data.append(
                {
                    "type": "contour",
                    "z": [drawn(r, 5) for r in closed],
                    **place,
                    "zmin": low,
                    "zmax": high,
                    "contours": levels | {"coloring": "none"},
                    "line": {"width": 2, "color": VERMILION, "dash": "dash"},
                    "showscale": False,
                    "name": "closed form",
                    "hoverinfo": "skip",
                }
            )
        data += _marks(limits, first, second, n)
    figure_layout = layout(
        PANEL * rows + 90, annotations=notes, showlegend=False, margin={"l": 70, "r": 90, "t": 34, "b": 50}, **axes
    )
    return [
        Figure(
            "Longest stable macro step",
            {"data": data, "layout": figure_layout},
            (
                "Filled, with thin lines: as measured. Dashed: the closed form at the same steps, where there is one; the two lie on one "
                "another where nothing but that pair of units limits the scene. ○: every step tried is stable; ×: none is."
            ),
        )
    ]


def _scale(low: float, high: float) -> dict[str, Any]:
    ticks = np.linspace(low, high, 5)
    return {
        "title": {"text": "macro step, s", "side": "right", "font": {"size": 13}},
        "thickness": 12,
        "outlinewidth": 0,
        "tickvals": drawn(ticks),
        "ticktext": [f"{10.0**t:.2g}" for t in ticks],
    }


def _grid(limits: Sequence[Limit], x: tuple[str, list[float]], y: tuple[str, list[float]], which: str) -> np.ndarray:
    """Logarithms of a scheme's steps, (len(y), len(x)); NaN where there is none."""
    grid = np.full((len(y[1]), len(x[1])), np.nan)
    for limit in limits:
        if 0.0 < (value := getattr(limit, which)) < inf:
            grid[y[1].index(limit.point[y[0]]), x[1].index(limit.point[x[0]])] = log10(value)
    return grid


def _marks(limits: Sequence[Limit], first: str, second: str, n: str) -> list[dict[str, Any]]:
    """Points of a map without a limit."""
    traces = []
    for symbol, at in (("circle-open", [m for m in limits if m.longest == inf]), ("x", [m for m in limits if m.longest == 0.0])):
        if at:
            traces.append(
                {
                    "type": "scatter",
                    "mode": "markers",
                    "x": [m.point[first] for m in at],
                    "y": [m.point[second] for m in at],
                    "xaxis": "x" + n,
                    "yaxis": "y" + n,
                    "hoverinfo": "skip",
                    "marker": {"symbol": symbol, "color": MUTED, "size": 7},
                }
            )
    return traces


def _against_closed_form(study: Stability) -> list[Block]:
    """Measured limits over those of the closed form, a mark for every point of the map."""
    data = []
    for k, scheme in enumerate(study.schemes):
        pairs = [limit for limit in study.of(scheme) if _comparable(limit)]
        if pairs:
            data.append(
                {
                    "type": "scatter",
                    "mode": "markers",
                    "name": _name(scheme),
                    "x": drawn([p.closed for p in pairs], 5),
                    "y": drawn([p.longest / p.closed for p in pairs], 5),
                    "hovertemplate": "%{x:.4g} s: %{y:.4f}<extra>%{fullData.name}</extra>",
                    "marker": {"color": CYCLE[k % len(CYCLE)], "size": 8, "opacity": 0.8},
                }
            )
    if not data:
        return []
    figure_layout = layout(
        300,
        xaxis=axis("limit of the closed form, s", grid=True, type="log"),
        yaxis=axis("measured over closed form", grid=True),
        margin={"l": 70, "r": 250, "t": 34, "b": 50},
        legend={"orientation": "v", "x": 1.02, "y": 1, "font": {"size": 11}},
    )
    figure_layout["shapes"] = [
        {"type": "line", "x0": 0, "x1": 1, "xref": "paper", "y0": 1, "y1": 1, "line": {"color": RAW, "width": 1}}
    ]
    return [Figure("Against the closed form", {"data": data, "layout": figure_layout})]
