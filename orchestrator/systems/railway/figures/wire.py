"""The contact wire: uplift at the supports, its shape around the pantograph, waves."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from .....components.railway.mesh import NO_WIRE
from ....harness.charts.bands import dense_line
from ....harness.charts.blocks import Figure
from ....harness.charts.style import (
    BLUE,
    CYCLE,
    DIVERGING,
    INK,
    MUTED,
    RULE,
    VERMILION,
    axis,
    drawn,
    label,
    layout,
    line,
    rectangle,
    standing_colour,
    tint,
    vertical,
)
from ..records import Passage, analysis_window, lateral_position, track_of
from .passage import track_marks

if TYPE_CHECKING:
    from ....harness.validation.case import Row
    from ....run.results import Result

SHAPES = 40  # of the slider
STRIPES = 300  # times of the picture of the waves


def uplift_figure(result: Result, passages: list[Passage], rows: Sequence[Row]) -> Figure:
    """Uplift of the contact wire at the supports over time, with the instants of passing."""
    start, end = analysis_window(result)
    shapes, notes, data = [], [], []
    record = passages[0].record
    for k, (x, uplift) in enumerate(zip(passages[0].supports, record.uplifts, strict=True)):
        colour, inside = CYCLE[k % len(CYCLE)], start - 1e-6 <= x <= end + 1e-6
        followed = ~np.isnan(uplift)
        until = "" if followed.all() else f", not followed from {record.time[~followed][0]:.2f} s on"
        trace, _ = dense_line(
            record.time[followed],
            1e3 * uplift[followed],
            f"support at {x:g} m{until}",
            colour,
            2.0 if inside else 1.2,
            dash="solid" if inside else "dot",
            hover="%{x:.3f} s: %{y:.1f} mm",
        )
        data.append(trace)
        for p in passages:
            if p.record.position[0] < x < p.record.position[-1]:
                passing = float(np.interp(x, p.record.position, p.record.time))
                shapes.append(vertical(passing, colour=tint(colour, 0.45), dash="dot"))
    for r in (row.reference for row in rows):
        if r.measure == "uplift_mm" and r.low is not None and r.high is not None:
            shapes.append(rectangle((0, 1), (r.low, r.high), standing_colour(r.standing)))
            notes.append(label(f"range of the maximum ({r.standing})", 0, r.high, yref="y", xanchor="left", yanchor="top"))
    figure = {
        "data": data,
        "layout": layout(
            330, shapes=shapes, annotations=notes, showlegend=True, xaxis=axis("time, s"), yaxis=axis("uplift, mm", grid=True)
        ),
    }
    return Figure(
        "Uplift of the contact wire at the supports",
        figure,
        "Dotted vertical lines: a pantograph passes the support of that colour. Dotted curves: supports outside the window.",
    )


def lateral_figure(result: Result, passage: Passage) -> Figure | None:
    """Lateral position of the contact wire along the track, with the straight lines between supports; None where not recorded."""
    if (sideways := lateral_position(result, passage)) is None:
        return None
    x = passage.record.position
    marks, notes = track_marks(track := track_of(result), float(x[0]), float(x[-1]))
    supports = [place for _, place in track.supports_between(float(x[0]), float(x[-1]))]
    wire, _ = dense_line(x, 1e3 * sideways, "contact wire", BLUE, 2.2, hover="%{x:.1f} m: %{y:.0f} mm")
    straight = line(supports, 1e3 * np.interp(supports, x, sideways), "straight between supports", MUTED, 1.2, dash="dash")
    figure = {
        "data": [straight, wire],
        "layout": layout(
            300,
            shapes=marks,
            annotations=notes,
            showlegend=True,
            xaxis=axis("position of the contact point, m"),
            yaxis=axis("lateral position, mm", grid=True),
        ),
    }
    text = "In plan, as the pantograph meets the wire; 0 is the middle of the track. What lies beside the straight lines is blown off."
    return Figure("Lateral position of the contact wire", figure, text)


def profile(result: Result, passage: Passage, name: str) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Times (k,) s, contact positions (k,) m, offsets (m,) m from the contact point, heights (k, m) mm, NaN where no wire is."""
    snapshot = result.snapshots[name]
    points = snapshot.values.shape[1]
    offsets = np.arange(points) - 0.5 * (points - 1)  # 1 m apart, the contact point in the middle
    wire = snapshot.values < 0.99 * NO_WIRE
    wire[:, 1:-1] &= wire[:, :-2] & wire[:, 2:]  # beside its end a point is drawn towards where there is none
    heights = np.where(wire, 1e3 * snapshot.values, np.nan)
    return snapshot.time, np.interp(snapshot.time, passage.record.time, passage.record.position), offsets, heights


def _ends(heights: np.ndarray) -> str:
    return " The first of two wires; nothing is drawn where it has ended." if np.isnan(heights).any() else ""


def wire_figure(result: Result, passage: Passage, name: str) -> Figure | None:
    """Shape of the contact wire around the pantograph at chosen times, with a slider; None where none falls into the window."""
    start, end = analysis_window(result)
    times, at, offsets, heights = profile(result, passage, name)
    during = np.flatnonzero((at >= start) & (at <= end) & np.isfinite(heights).any(axis=1))
    if not during.size:
        return None
    chosen = during[np.linspace(0, during.size - 1, min(SHAPES, during.size)).round().astype(int)]
    middle = heights.shape[1] // 2

    def traces(k: int) -> list[dict[str, Any]]:
        wire = line(at[k] + offsets, heights[k], "contact wire", BLUE, 2.0, hover="%{x:.0f} m: %{y:.1f} mm")
        point = line(
            [at[k]],
            [heights[k, middle]],
            "contact point",
            VERMILION,
            mode="markers",
            marker={"color": VERMILION, "size": 12, "symbol": "triangle-up"},
        )
        return [wire, point]

    move = {"mode": "immediate", "frame": {"duration": 0, "redraw": False}, "transition": {"duration": 0}}
    steps = [{"label": f"{times[k]:.2f}", "method": "animate", "args": [[str(i)], move]} for i, k in enumerate(chosen)]
    slider = {
        "steps": steps,
        "active": chosen.size // 2,
        "x": 0.0,
        "len": 1.0,
        "y": -0.16,
        "pad": {"t": 8},
        "ticklen": 3,
        "font": {"size": 10, "color": MUTED},
        "currentvalue": {"prefix": "time ", "suffix": " s", "font": {"size": 13, "color": INK}},
        "bordercolor": RULE,
    }
    frames = [
        {"name": str(i), "data": [{k: t[k] for k in ("type", "x", "y")} for t in traces(at_)]} for i, at_ in enumerate(chosen)
    ]
    low, high = start + offsets[0], end + offsets[-1]
    shapes, notes = track_marks(track_of(result), low, high)
    lowest, highest = float(np.nanmin(heights[chosen])), float(np.nanmax(heights[chosen]))
    pad = 0.06 * (highest - lowest)
    figure = {
        "data": traces(chosen[chosen.size // 2]),
        "frames": frames,
        "layout": layout(
            430,
            shapes=shapes,
            annotations=notes,
            sliders=[slider],
            showlegend=True,
            margin={"l": 66, "r": 20, "t": 34, "b": 130},
            xaxis=axis("position along the track, m", range=[low, high]),
            yaxis=axis("height of the contact wire, mm", grid=True, range=[lowest - pad, highest + pad]),
        ),
    }
    return Figure(
        "Shape of the contact wire while the pantograph crosses the window",
        figure,
        f"{chosen.size} of {times.size} recorded shapes; move the slider. Height 0: the unloaded wire at a dropper."
        + _ends(heights),
    )


def waves_figure(result: Result, passage: Passage, name: str) -> Figure:
    """Height of the wire over time and distance from the pantograph: waves that run ahead and behind show as slanting stripes."""
    times, _, offsets, heights = profile(result, passage, name)
    every = max(1, times.size // STRIPES)
    limit = float(np.nanmax(np.abs(heights)))
    picture = {
        "type": "heatmap",
        "x": drawn(offsets),
        "y": drawn(times[::every], 4),
        "z": [drawn(h, 3) for h in heights[::every]],
        "zmin": -limit,
        "zmax": limit,
        "zsmooth": "best",
        "colorscale": DIVERGING,
        "colorbar": {"title": {"text": "height, mm", "side": "right", "font": {"size": 13}}, "thickness": 12, "outlinewidth": 0},
        "hovertemplate": "%{x:.0f} m, %{y:.2f} s: %{z:.1f} mm<extra></extra>",
    }
    figure = {
        "data": [picture],
        "layout": layout(
            380,
            shapes=[vertical(0.0, colour=INK) | {"layer": "above"}],
            xaxis=axis("distance from the contact point, m (positive: ahead)"),
            yaxis=axis("time, s"),
        ),
    }
    return Figure(
        "Height of the contact wire around the pantograph over time",
        figure,
        "Supports pass as slanting bands at the train's speed; waves and their reflections cross them at the wave speed."
        + _ends(heights),
    )
