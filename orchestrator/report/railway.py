"""Figures of a pantograph under a catenary, from a run and, where there is one, its rows of a reference table."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..analysis.railway import Passage, analysis_window, dropper_spacing, passages
from ..analysis.signals import Filter, amplitude_spectrum, uniform, window
from .page import Figure
from .style import (
    BLUE,
    CYCLE,
    GREEN,
    INK,
    MUTED,
    ORANGE,
    RAW,
    RULE,
    VERMILION,
    axis,
    drawn,
    horizontal_band,
    label,
    layout,
    number,
    thin_out,
    tint,
    vertical,
)

if TYPE_CHECKING:
    from ..results import Result
    from ..validation.case import Row

LADDER = (  # columns beside the force: heading, then quantities
    ("mean", ("mean",)), ("actual", ("max", "min")), ("mean ± 3σ", ("statistical_max", "statistical_min")))


def figures(result: Result, rows: Sequence[Row] = (), low_pass: Filter | None = None) -> list[Figure]:
    """All figures the run has the data for; none if no contact force was recorded."""
    found = passages(result)
    if not found:
        return []
    low_pass = low_pass or Filter()
    made = [force_figure(result, found, rows, low_pass)]
    if any(p.supports for p in found):
        made.append(uplift_figure(result, found[0], rows))
    made.append(spectrum_figure(result, found, low_pass))
    name = f"{found[0].catenary}.wire_profile.height"
    if name in result.snapshots:
        made += [wire_figure(result, found[0], name), waves_figure(result, found[0], name)]
    return made


def _marks(result: Result, low: float, high: float) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """Supports as lines, spans as small texts, over x from low to high."""
    span = result.scene.analysis.get("span")
    if not span:
        return [], []
    supports = np.arange(np.ceil(low / span - 1e-9), np.floor(high / span + 1e-9) + 1) * span
    lines = [vertical(x) for x in supports]
    texts = [label(f"span {round(a / span) + 1}", a + 0.5 * span, 1.0, xref="x", yanchor="top") for a in supports[:-1]]
    return lines, texts


def force_figure(result: Result, found: list[Passage], rows: Sequence[Row], low_pass: Filter) -> Figure:
    """Contact force against position: raw thin, filtered strong; beside it where the numbers lie in their ranges."""
    start, end = analysis_window(result.scene)
    span = float(result.scene.analysis.get("span", end - start))
    last = min(p.record.position[-1] for p in found)
    low, high = max(start - span, found[0].record.position[0]), min(end + span, last)
    ladder = [(h, [r for r in rows if r.reference.measure in q]) for h, q in LADDER]
    ladder = [(h, rs) for h, rs in ladder if rs]
    right = 0.80 if ladder else 1.0
    shapes, notes = _marks(result, low, high)
    shapes.append({"type": "rect", "xref": "x", "yref": "paper", "x0": start, "x1": end, "y0": 0, "y1": 1, "layer": "below",
                   "fillcolor": tint(BLUE, 0.045), "line": {"width": 0}})
    data: list[dict[str, Any]] = []
    thinned = False
    for i, p in enumerate(found):
        rate, _, (x, force) = uniform(p.record.time, p.record.position, p.record.force)
        filtered = low_pass.apply(force, rate)
        who = f"{p.pantograph}: " if len(found) > 1 else ""
        for y, name, line in ((force, "contact force at the macro step", {"color": RAW if i == 0 else tint(CYCLE[i], 0.35), "width": 1}),
                              (filtered, f"filtered, {low_pass.cutoff:g} Hz", {"color": CYCLE[i], "width": 2.2})):
            xs, ys, cut = thin_out(x, y)
            thinned |= cut
            data.append({"type": "scatter", "mode": "lines", "x": drawn(xs, 6), "y": drawn(ys), "name": who + name, "line": line,
                         "hovertemplate": "%{x:.1f} m: %{y:.1f} N<extra></extra>"})
    for row in rows:
        r = row.reference
        if r.measure in ("mean", "max", "min") and r.low is not None and r.high is not None:
            shapes.append(horizontal_band(r.low, r.high, _standing_colour(row), "x domain"))
    axes: dict[str, Any] = {}
    if ladder:
        axes["xaxis2"] = axis(domain=[right + 0.035, 1.0], anchor="y", range=[-0.5, len(ladder) - 0.5], tickvals=list(range(len(ladder))),
                              ticktext=[h for h, _ in ladder], ticks="", showline=False, fixedrange=True)
        data += [_rung(i, row) for i, (_, rs) in enumerate(ladder) for row in rs]
        shapes += [_rung_range(i, row) for i, (_, rs) in enumerate(ladder) for row in rs]
        notes.append(label("in their ranges", right + 0.035 + (0.965 - right) / 2, 1.0, yanchor="bottom", xanchor="center"))
    notes.append(label("analysis window", start, 0.0, xref="x", xanchor="left", yanchor="bottom"))
    caption = (
        f"Blue background: analysis window {start:g} to {end:g} m. Filter: {low_pass}. Thin vertical lines: supports."
        + (" Bands: ranges of the mean, the actual maximum and the actual minimum; at the right the measured numbers (dots) in all their "
           "ranges." if ladder else "") + (" Drawn with fewer points than recorded; extremes are kept." if thinned else ""))
    everything = np.concatenate([p.record.force[(p.record.position >= low) & (p.record.position <= high)] for p in found])
    ends = [e for _, rs in ladder for r in rs for e in (r.reference.low, r.reference.high, r.measured) if e is not None]
    bottom, top = min([everything.min(), 0.0, *ends]), max([everything.max(), *ends])
    pad = 0.06 * (top - bottom)
    speed = 3.6 * found[0].speed
    figure = {"data": data, "layout": layout(
        440, shapes=shapes, annotations=notes, showlegend=True, margin={"l": 66, "r": 14, "t": 56, "b": 48},
        legend={"orientation": "h", "x": 0, "y": 1.03, "yanchor": "bottom"},
        xaxis=axis("position of the contact point, m", domain=[0, right], range=[low, high], tick0=0, dtick=span / 2 if span < 100 else None),
        yaxis=axis("contact force, N", range=[bottom - pad, top + pad], showgrid=True, gridcolor="#eef1f4"), **axes)}
    return Figure(f"Contact force at {speed:.0f} km/h", figure, caption)


def _standing_colour(row: Row) -> str:
    return ORANGE if row.reference.standing in ("recalled", "inferred") else GREEN


def _rung(i: int, row: Row) -> dict[str, Any]:
    r = row.reference
    return {
        "type": "scatter", "mode": "markers", "x": [i], "y": drawn([row.measured]), "xaxis": "x2", "yaxis": "y", "showlegend": False,
        "marker": {"color": INK if row.inside else VERMILION, "size": 10, "symbol": "circle" if row.inside else "diamond",
                   "line": {"color": "white", "width": 1.5}},
        "hovertemplate": f"{r.quantity}: {number(row.measured, r.low, r.high)} N, range {r.low} to {r.high} N ({r.standing})<extra></extra>"}


def _rung_range(i: int, row: Row) -> dict[str, Any]:
    r, colour = row.reference, _standing_colour(row)
    return {
        "type": "rect", "xref": "x2", "yref": "y", "x0": i - 0.3, "x1": i + 0.3, "y0": r.low, "y1": r.high, "layer": "below",
        "fillcolor": tint(colour, 0.30), "line": {"width": 1, "color": colour, "dash": "dash" if colour == ORANGE else "solid"}}


def uplift_figure(result: Result, passage: Passage, rows: Sequence[Row]) -> Figure:
    """Uplift of the contact wire at the supports over time, with the instants of passing."""
    start, end = analysis_window(result.scene)
    shapes, notes, data = [], [], []
    record = passage.record
    for k, (x, uplift) in enumerate(zip(passage.supports, record.uplifts, strict=True)):
        colour = CYCLE[k % len(CYCLE)]
        inside = start - 1e-6 <= x <= end + 1e-6
        t, u, _ = thin_out(record.time, 1e3 * uplift, 4000)
        data.append({"type": "scatter", "mode": "lines", "x": drawn(t), "y": drawn(u), "name": f"support at {x:g} m",
                     "line": {"color": colour, "width": 2 if inside else 1, "dash": "solid" if inside else "dot"},
                     "hovertemplate": "%{x:.3f} s: %{y:.1f} mm<extra></extra>"})
        if record.position[0] < x < record.position[-1]:
            shapes.append(vertical(float(np.interp(x, record.position, record.time)), colour=tint(colour, 0.45), dash="dot"))
    for row in rows:
        r = row.reference
        if r.measure == "uplift_mm" and r.low is not None and r.high is not None:
            shapes.append(horizontal_band(r.low, r.high, _standing_colour(row)))
            notes.append(label(f"range of the maximum ({r.standing})", 1, r.high, yref="y", xanchor="right", yanchor="bottom"))
    figure = {"data": data, "layout": layout(
        330, shapes=shapes, annotations=notes, showlegend=True, xaxis=axis("time, s"),
        yaxis=axis("uplift, mm", showgrid=True, gridcolor="#eef1f4"))}
    return Figure("Uplift of the contact wire at the supports", figure,
                  "Dotted vertical lines: the pantograph passes the support of that colour. Dotted curves: supports outside the window.")


def spectrum_figure(result: Result, found: list[Passage], low_pass: Filter) -> Figure:
    """Amplitude spectrum of the unfiltered contact force, with the frequencies of passing spans and droppers."""
    span = float(result.scene.analysis.get("span", 0.0))
    data, shapes, notes = [], [], []
    for i, p in enumerate(found):
        rate, _, (x, force) = uniform(p.record.time, p.record.position, p.record.force)
        start = min(x[0] + (2 * span if x[-1] - x[0] > 4 * span else 0.0), analysis_window(result.scene)[0])
        end = start + np.floor((x[-1] - start) / span + 1e-9) * span if span else x[-1]
        f, a = amplitude_spectrum(force[window(x, start, end)], rate)
        kept = (f > 0.0) & (f <= 35.0)
        data.append({"type": "scatter", "mode": "lines", "x": drawn(f[kept]), "y": drawn(a[kept], 4), "name": p.pantograph,
                     "line": {"color": CYCLE[i], "width": 1.6}, "fill": "tozeroy" if len(found) == 1 else "none",
                     "fillcolor": tint(CYCLE[i], 0.12), "hovertemplate": "%{x:.2f} Hz: %{y:.1f} N<extra></extra>"})
    speed, spacing = found[0].speed, dropper_spacing(result.scene)
    if span:
        shapes += [vertical(k * speed / span, colour=tint(GREEN, 0.9 if k == 1 else 0.3)) for k in range(1, 6)]
        notes.append(label(f"span passing {speed / span:.2f} Hz", speed / span, 1.0, xref="x", xanchor="left", yanchor="bottom",
                           font={"size": 11, "color": GREEN}))
    if np.isfinite(spacing) and speed / spacing < 35.0:
        shapes += [vertical(k * speed / spacing, colour=tint(VERMILION, 0.9 if k == 1 else 0.3)) for k in (1, 2, 3) if k * speed / spacing < 35.0]
        notes.append(label(f"dropper passing {speed / spacing:.1f} Hz", speed / spacing, 1.0, xref="x", xanchor="left", yanchor="bottom",
                           font={"size": 11, "color": VERMILION}))
    shapes.append(vertical(low_pass.cutoff, colour=MUTED, dash="dash"))
    notes.append(label(f"filter {low_pass.cutoff:g} Hz", low_pass.cutoff, 1.0, xref="x", xanchor="left", yanchor="bottom"))
    figure = {"data": data, "layout": layout(
        330, shapes=shapes, annotations=notes, showlegend=len(found) > 1, xaxis=axis("frequency, Hz", range=[0, 35]),
        yaxis=axis("amplitude, N", rangemode="tozero", showgrid=True, gridcolor="#eef1f4"))}
    return Figure("Amplitude spectrum of the contact force", figure,
                  f"Unfiltered force from {start:g} to {end:g} m, mean removed, Hann window, single-sided: a sine of amplitude A reads A. "
                  "Pale lines: multiples of the marked frequencies.")


def _profile(result: Result, passage: Passage, name: str) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Times (k,), contact positions (k,), offsets (m,) from the contact point in m, heights (k, m) in mm."""
    snapshot = result.snapshots[name]
    offsets = np.arange(snapshot.values.shape[1]) - 0.5 * (snapshot.values.shape[1] - 1)  # 1 m apart, the contact point in the middle
    return snapshot.time, np.interp(snapshot.time, passage.record.time, passage.record.position), offsets, 1e3 * snapshot.values


def wire_figure(result: Result, passage: Passage, name: str) -> Figure:
    """Shape of the contact wire around the pantograph at chosen times, with a slider."""
    start, end = analysis_window(result.scene)
    times, at, offsets, heights = _profile(result, passage, name)
    during = np.flatnonzero((at >= start) & (at <= end))
    chosen = during[np.linspace(0, during.size - 1, min(40, during.size)).round().astype(int)]
    middle = heights.shape[1] // 2

    def traces(k: int) -> list[dict[str, Any]]:
        x = at[k] + offsets
        return [{"type": "scatter", "x": drawn(x, 6), "y": drawn(heights[k], 4)},
                {"type": "scatter", "x": drawn([at[k]], 6), "y": drawn([heights[k, middle]], 4)}]

    first = traces(chosen[0])
    first[0] |= {"mode": "lines", "line": {"color": BLUE, "width": 2}, "name": "contact wire",
                 "hovertemplate": "%{x:.0f} m: %{y:.1f} mm<extra></extra>"}
    first[1] |= {"mode": "markers", "marker": {"color": VERMILION, "size": 12, "symbol": "triangle-up"}, "name": "contact point"}
    shown = heights[chosen]
    pad = 0.06 * np.ptp(shown)
    steps = [{"label": f"{times[k]:.2f}", "method": "animate",
              "args": [[str(i)], {"mode": "immediate", "frame": {"duration": 0, "redraw": False}, "transition": {"duration": 0}}]}
             for i, k in enumerate(chosen)]
    low, high = start + offsets[0], end + offsets[-1]
    shapes, notes = _marks(result, low, high)
    slider = {"steps": steps, "x": 0.0, "len": 1.0, "y": -0.16, "pad": {"t": 8}, "ticklen": 3, "font": {"size": 10, "color": MUTED},
              "currentvalue": {"prefix": "time ", "suffix": " s", "font": {"size": 13, "color": INK}}, "bordercolor": RULE}
    figure = {
        "data": first, "frames": [{"name": str(i), "data": traces(k)} for i, k in enumerate(chosen)],
        "layout": layout(430, shapes=shapes, annotations=notes, sliders=[slider], margin={"l": 66, "r": 20, "t": 34, "b": 130},
                         xaxis=axis("position along the track, m", range=[low, high]),
                         yaxis=axis("height of the contact wire, mm", range=[shown.min() - pad, shown.max() + pad], showgrid=True,
                                    gridcolor="#eef1f4"))}
    return Figure("Shape of the contact wire while the pantograph crosses the window", figure,
                  f"{chosen.size} of {times.size} recorded shapes; move the slider. Height 0: the unloaded wire at a dropper.")


def waves_figure(result: Result, passage: Passage, name: str) -> Figure:
    """Height of the wire over time and distance from the pantograph: waves that run ahead and behind show as slanting stripes."""
    times, _, offsets, heights = _profile(result, passage, name)
    every = max(1, times.size // 300)
    limit = float(np.abs(heights).max())
    figure = {
        "data": [{"type": "heatmap", "x": drawn(offsets), "y": drawn(times[::every], 4), "z": [drawn(h, 3) for h in heights[::every]],
                  "zmin": -limit, "zmax": limit, "zsmooth": "best",
                  "colorscale": [[0, "#b35806"], [0.25, "#f1a340"], [0.5, "#f7f7f7"], [0.75, "#67a9cf"], [1, "#053061"]],
                  "colorbar": {"title": {"text": "height, mm", "side": "right"}, "thickness": 12, "outlinewidth": 0},
                  "hovertemplate": "%{x:.0f} m, %{y:.2f} s: %{z:.1f} mm<extra></extra>"}],
        "layout": layout(380, xaxis=axis("distance from the contact point, m (positive: ahead)"), yaxis=axis("time, s"),
                         shapes=[vertical(0.0, colour=INK) | {"layer": "above"}])}
    return Figure("Height of the contact wire around the pantograph over time", figure,
                  "The supports pass as slanting bands of the train's speed; waves and their reflections cross them at the wave speed.")
