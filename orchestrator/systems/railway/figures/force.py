"""The contact force against position, and its spectrum."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ....harness.analysis.signals import ButterworthFilter, amplitude_spectrum, uniform, window
from ....harness.charts.bands import dense_line
from ....harness.charts.blocks import Figure
from ....harness.charts.style import (
    BLUE,
    CYCLE,
    GREEN,
    INK,
    MUTED,
    PAPER,
    RAW,
    VERMILION,
    axis,
    drawn,
    label,
    layout,
    line,
    number,
    rectangle,
    standing_colour,
    standing_dash,
    tint,
    vertical,
)
from ..records import Passage, analysis_window, track_of
from .passage import track_marks

if TYPE_CHECKING:
    from ....harness.validation.case import Row
    from ....run.results import Result

LADDER = (("mean", ("mean",)), ("actual", ("max", "min")), ("mean ± 3σ", ("statistical_max", "statistical_min")))
SAMPLES = 16  # below which a spectrum shows nothing
HIGHEST = 35.0  # Hz, end of the spectrum's axis: the band of the filter and something beyond


def force_figure(result: Result, passages: list[Passage], rows: Sequence[Row], low_pass: ButterworthFilter) -> Figure:
    """Contact force against position: raw thin, filtered strong; beside it where the numbers lie in their ranges."""
    start, end = analysis_window(result)
    track = track_of(result)
    span = track.span or end - start
    low, high = _shown(passages, start - span, end + span)
    ladder = [(heading, [r for r in rows if r.reference.measure in names and _closed(r)]) for heading, names in LADDER]
    ladder = [(heading, members) for heading, members in ladder if members]
    right = 0.80 if ladder else 1.0

    shapes, notes = track_marks(track, low, high)
    shapes.append(rectangle((start, end), (0, 1), BLUE, 0.045, xref="x", yref="paper"))
    notes.append(label("analysis window", start, 0.0, xref="x", xanchor="left", yanchor="bottom"))
    shapes += [_band(r, (0, 1), 0.13, "x domain") for r in rows if r.reference.measure in ("mean", "max", "min") and _closed(r)]
    traces, banded = _force_traces(passages, low_pass)
    data = [*traces]
    axes: dict[str, Any] = {}
    if ladder:
        ticks: dict[str, Any] = {
            "tickvals": list(range(len(ladder))),
            "ticktext": [heading for heading, _ in ladder],
            "ticks": "",
            "showline": False,
        }
        axes["xaxis2"] = axis(domain=[right + 0.035, 1.0], anchor="y", range=[-0.5, len(ladder) - 0.5], fixedrange=True, **ticks)
        for i, (_, members) in enumerate(ladder):
            data += [_dot(i, r) for r in members]
            shapes += [_band(r, (i - 0.3, i + 0.3), 0.30, "x2", border=True) for r in members]
        notes.append(label("in their ranges", 0.5 * (right + 1.035), 1.0, yanchor="bottom", xanchor="center"))

    marks: dict[str, Any] = {"tick0": 0, "dtick": 0.5 * span} if high - low > span else {}  # of less than a span, where they fit
    caption = f"Blue background: analysis window {start:g} to {end:g} m. Filter: {low_pass}. Thin vertical lines: supports."
    if len(passages) > 1:
        caption += " Pale: the forces at the macro step, unfiltered."
    if ladder:
        caption += (
            " Bands: ranges of the mean, the actual maximum and the actual minimum. At the right: the measured numbers (dots) in "
            "their ranges; a diamond lies outside."
        )
    if banded:
        caption += " Bands: from the least to the largest value; zoom in for all samples."
    figure = {
        "data": data,
        "layout": layout(
            440,
            shapes=shapes,
            annotations=notes,
            showlegend=True,
            margin={"l": 66, "r": 14, "t": 56, "b": 48},
            legend={"orientation": "h", "x": 0, "y": 1.03, "yanchor": "bottom"},
            xaxis=axis("position of the contact point, m", domain=[0, right], range=[low, high], **marks),
            yaxis=axis(
                "contact force, N",
                grid=True,
                range=_force_range(traces, [r for _, members in ladder for r in members], low, high),
            ),
            **axes,
        ),
    }
    return Figure(f"Contact force at {3.6 * passages[0].speed:.0f} km/h", figure, caption)


def _shown(passages: list[Passage], low: float, high: float) -> tuple[float, float]:
    """What there is of a stretch of the track, m; all of it where the pantographs have not come so far together."""
    first, last = max(low, passages[0].record.position[0]), min([high, *(p.record.position[-1] for p in passages)])
    if first < last:
        return float(first), float(last)
    return float(min(p.record.position[0] for p in passages)), float(max(p.record.position[-1] for p in passages))


def _closed(row: Row) -> bool:
    return row.reference.low is not None and row.reference.high is not None


def _force_traces(passages: list[Passage], low_pass: ButterworthFilter) -> tuple[list[dict[str, Any]], bool]:
    data, banded = [], False
    for i, p in enumerate(passages):
        rate, _, (x, force) = uniform(p.record.time, p.record.position, p.record.force)
        who = f"{p.pantograph}: " if len(passages) > 1 else ""
        pale = RAW if i == 0 else tint(CYCLE[i], 0.35)
        for y, name, colour, width in (
            (force, "contact force at the macro step", pale, 1.0),
            (low_pass.apply(force, rate), f"filtered, {low_pass.cutoff:g} Hz", CYCLE[i], 2.2),
        ):
            more = {"showlegend": False} if who and width == 1.0 else {}  # of several, the caption says what is pale
            trace, cut = dense_line(x, y, who + name, colour, width, hover="%{x:.1f} m: %{y:.1f} N", **more)
            banded |= cut
            data.append(trace)
    return data, banded


def _force_range(traces: list[dict[str, Any]], rows: list[Row], low: float, high: float) -> list[float]:
    """Ends of the axis: 0, what is drawn between two positions, and the ranges."""
    values = [
        0.0,
        *(e for r in rows for e in (r.reference.low, r.reference.high, r.simulated) if e is not None and np.isfinite(e)),
    ]
    for trace in traces:
        values += [y for x, y in zip(trace["x"], trace["y"], strict=True) if low <= x <= high and y is not None]
    pad = 0.06 * (max(values) - min(values))
    return [min(values) - pad, max(values) + pad]


def _band(row: Row, x: tuple[float, float], alpha: float, xref: str, border: bool = False) -> dict[str, Any]:
    r = row.reference
    colour = standing_colour(r.standing)
    edge = {"width": 1, "color": colour, "dash": standing_dash(r.standing)} if border else None
    return rectangle(x, (r.low or 0.0, r.high or 0.0), colour, alpha, xref=xref, border=edge)


def _dot(i: int, row: Row) -> dict[str, Any]:
    r = row.reference
    marker = {
        "color": INK if row.inside else VERMILION,
        "size": 10,
        "symbol": "circle" if row.inside else "diamond",
        "line": {"color": PAPER, "width": 1.5},
    }
    hover = (
        f"{r.quantity}: {number(row.simulated, r.low, r.high)} N, range {r.low:g} to {r.high:g} N ({r.standing})<extra></extra>"
    )
    return {
        "type": "scatter",
        "mode": "markers",
        "x": [i],
        "y": drawn([row.simulated]),
        "xaxis": "x2",
        "yaxis": "y",
        "showlegend": False,
        "marker": marker,
        "hovertemplate": hover,
    }


def spectrum_figure(result: Result, passages: list[Passage], low_pass: ButterworthFilter) -> Figure | None:
    """Amplitude spectrum of the unfiltered contact force, with the frequencies of passing spans and droppers.

    None for a run that ends before it has passed a whole span behind its run-in.
    """
    track = track_of(result)
    span = track.span
    data, start, end = [], 0.0, 0.0
    for i, p in enumerate(passages):
        rate, _, (x, force) = uniform(p.record.time, p.record.position, p.record.force)
        start, end = _whole_spans(x, span, analysis_window(result)[0])
        if np.count_nonzero((x >= start) & (x < end)) < SAMPLES:
            return None
        f, a = amplitude_spectrum(force[window(x, start, end)], rate)
        kept = (f > 0.0) & (f <= HIGHEST)
        fill = {"fill": "tozeroy", "fillcolor": tint(CYCLE[i], 0.12)} if len(passages) == 1 else {}
        seen = {"visible": "legendonly"} if p.part else {}  # the force that changes from wire to wire would set the axis
        data.append(line(f[kept], a[kept], p.pantograph, CYCLE[i], 1.6, hover="%{x:.2f} Hz: %{y:.1f} N", **fill, **seen))
    shapes = [vertical(low_pass.cutoff, colour=MUTED, dash="dash")]
    notes = [_frequency_label(f"filter {low_pass.cutoff:g} Hz", low_pass.cutoff, MUTED) | {"yanchor": "top"}]
    speed = passages[0].speed
    for what, length, multiples, colour in (("span", span, 5, GREEN), ("dropper", track.dropper_spacing, 3, VERMILION)):
        if length > 0.0:  # false for NaN too
            for k in range(1, multiples + 1):
                if k * speed / length < HIGHEST:
                    shapes.append(vertical(k * speed / length, colour=tint(colour, 0.9 if k == 1 else 0.3)))
            notes.append(_frequency_label(f"{what} passing {speed / length:.3g} Hz", speed / length, colour))
    figure = {
        "data": data,
        "layout": layout(
            330,
            shapes=shapes,
            annotations=notes,
            showlegend=len(passages) > 1,
            legend={"orientation": "v", "x": 1, "xanchor": "right", "y": 1.0, "yanchor": "top"},
            xaxis=axis("frequency, Hz", range=[0, HIGHEST]),
            yaxis=axis("amplitude, N", grid=True, rangemode="tozero"),
        ),
    }
    return Figure(
        "Amplitude spectrum of the contact force",
        figure,
        f"Unfiltered force from {start:g} to {end:g} m, mean removed, Hann window, single-sided: a sine of amplitude A reads A. "
        "Pale lines: multiples of the marked frequencies.",
    )


def _whole_spans(x: np.ndarray, span: float, latest: float) -> tuple[float, float]:
    """Longest stretch of whole spans after a run-in of two spans, m: more spans than the window resolve frequencies better."""
    if not span:
        return float(x[0]), float(x[-1])
    start = min(float(x[0]) + 2.0 * span, latest)
    return start, start + span * float(np.floor((x[-1] - start) / span + 1e-9))


def _frequency_label(text: str, frequency: float, colour: str) -> dict[str, Any]:
    return label(text, frequency, 1.0, xref="x", xanchor="left", yanchor="bottom", xshift=3, font={"size": 11, "color": colour})
