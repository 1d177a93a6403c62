"""The passage: the line to scale as the pantograph meets it, the force above it, slack droppers marked, moving."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from .....components.railway.line.form import Form
from ....harness.analysis.records import RecordedUnit
from ....harness.analysis.signals import ButterworthFilter, uniform
from ....harness.charts.blocks import Figure
from ....harness.charts.style import BLUE, GREEN, INK, MUTED, RAW, RULE, VERMILION, axis, label, layout, line, tint, vertical
from ..records import Passage, Track, analysis_window, track_of

if TYPE_CHECKING:
    from ....run.results import Result

FRAMES = 60
SYSTEM_HEIGHT = 1.2  # m, of the messenger's supports over a uniform line, which has none in the plane model (from memory)
BELOW = 0.35  # m under the wire that are drawn
WIDE = 900.0  # px of the panel on a usual page, for the scale in the caption
ABOVE = (("auxiliary wire", GREEN, 1.8), ("messenger", INK, 1.6))
PICTURE, LINE_SHARE = 560, 0.5  # px of the figure, share of it that the line has


def passage_figure(result: Result, passage: Passage, low_pass: ButterworthFilter) -> Figure | None:
    """Both wires, droppers and the force at chosen times, to be played; None without the profiles of both wires in the window."""
    names = [
        f"{passage.catenary}.{n}"
        for n in ("wire_profile.height", "line_profile.messenger_uplift", "line_profile.dropper_tension")
    ]
    if not all(n in result.snapshots for n in names):
        return None
    contact, messenger, tension = (result.snapshots[n].values for n in names)
    times = result.snapshots[names[0]].time
    record = passage.record
    at = np.interp(times, record.time, record.position)
    start, end = analysis_window(result)
    during = np.flatnonzero((at >= start) & (at <= end))
    if during.size < 2:
        return None
    chosen = during[np.linspace(0, during.size - 1, min(FRAMES, during.size)).round().astype(int)]
    catenary: Any = RecordedUnit(result, passage.catenary).component
    form: Form = catenary.form()
    displaced = {1: messenger}  # lane -> (k, m) m, of the wires above the contact wire that are seen to move
    if form.layout.auxiliary_lanes and (auxiliary := result.snapshots.get(f"{passage.catenary}.line_profile.auxiliary_uplift")):
        displaced[form.layout.auxiliary_lanes[0]] = auxiliary.values
    offset = 0.0 if "line_table" in catenary.on else SYSTEM_HEIGHT
    offsets = np.arange(contact.shape[1]) - contact.shape[1] // 2
    low, high = start + offsets[0], end + offsets[-1]
    rate, _, (x, force) = uniform(record.time, record.position, record.force)
    filtered = low_pass.apply(force, rate)

    def rest(lane: int) -> tuple[np.ndarray, np.ndarray]:
        """Positions and heights of a wire at rest about the picture, m; NaN where it has no wire."""
        here = (form.position >= low - 30.0) & (form.position <= high + 30.0)
        return form.position[here], form.height[here, lane] + (offset if lane else 0.0)

    def moving(k: int) -> list[dict[str, Any]]:
        place = at[k] + offsets
        segments: dict[bool, tuple[list[float], list[float]]] = {False: ([], []), True: ([], [])}
        d = form.layout.droppers
        for position, low_end, top, bottom, length in zip(d.position, d.lower, d.upper, d.height, form.length, strict=True):
            if not low <= position <= high:
                continue
            cell = int(np.floor(position - place[0] + 0.5))
            seen = 0 <= cell < offsets.size and position >= place[0]
            slack = bool(seen and tension[k, cell] == 0.0)
            shift = {lane: float(np.interp(position, place, of[k])) for lane, of in displaced.items() if seen}
            head = bottom + length + offset + shift.get(top, 0.0)
            foot = bottom + shift.get(low_end, 0.0)
            if seen and low_end not in form.layout.auxiliary_lanes:
                foot = np.interp(position, place, contact[k])
            xs, ys = segments[slack]
            xs += [position, position, np.nan]
            ys += [foot, head, np.nan]
        touch = float(np.interp(at[k], place, contact[k]))
        return [
            line(
                [at[k]],
                [float(np.interp(at[k], x, filtered))],
                "force now",
                VERMILION,
                mode="markers",
                yaxis="y",
                marker={"color": VERMILION, "size": 11},
                showlegend=False,
            ),
            line(place, contact[k], "contact wire", BLUE, 2.2, yaxis="y2"),
            *(
                line(place, np.interp(place, *rest(lane)) + of[k], *ABOVE[lane == 1], yaxis="y2")
                for lane, of in displaced.items()
            ),
            *(
                line(*segments[slack], name, colour, width, yaxis="y2", hoverinfo="skip", hovertemplate=None)
                for slack, name, colour, width in ((False, "dropper", MUTED, 1.2), (True, "slack dropper", VERMILION, 3.0))
            ),
            line(
                [at[k] - 1.2, at[k] + 1.2, np.nan, at[k], at[k]],
                [touch, touch, np.nan, touch, touch - BELOW],
                "pantograph",
                VERMILION,
                4.0,
                yaxis="y2",
                hoverinfo="skip",
                hovertemplate=None,
            ),
        ]

    inside = (x >= low) & (x <= high)
    still = [
        line(x[inside], filtered[inside], f"contact force, filtered, {low_pass.cutoff:g} Hz", RAW, 2.0, yaxis="y"),
        *(
            line(
                *rest(lane),
                "at rest",
                tint(MUTED, 0.5),
                1.0,
                yaxis="y2",
                showlegend=lane == 0,
                hoverinfo="skip",
                hovertemplate=None,
            )
            for lane in range(form.layout.lanes)
        ),
    ]
    first = chosen[0]
    indices = list(range(len(still), len(still) + len(moving(first))))
    frames = [
        {"name": str(i), "traces": indices, "data": [{n: t[n] for n in ("type", "x", "y")} for t in moving(k)]}
        for i, k in enumerate(chosen)
    ]
    heights = np.concatenate([rest(lane)[1] for lane in range(form.layout.lanes)] + [contact[chosen].ravel()])
    bottom, top = float(np.nanmin(heights)) - BELOW, float(np.nanmax(heights)) + 0.1
    exaggeration = (high - low) / WIDE * PICTURE * LINE_SHARE / (top - bottom)
    shapes, notes = track_marks(track_of(result), low, high)
    figure = {
        "data": [*still, *moving(first)],
        "frames": frames,
        "layout": layout(
            PICTURE,
            shapes=shapes,
            annotations=notes,
            showlegend=True,
            margin={"l": 66, "r": 20, "t": 60, "b": 120},
            legend={"orientation": "h", "x": 0, "y": 1.03, "yanchor": "bottom"},
            xaxis=axis("position along the track, m", range=[low, high], anchor="y2"),
            yaxis=axis("contact force, N", grid=True, domain=[LINE_SHARE + 0.1, 1.0]),
            yaxis2=axis("height, m", range=[bottom, top], domain=[0.0, LINE_SHARE]),
            **_controls([times[k] for k in chosen]),
        ),
    }
    text = (
        f"{chosen.size} of {times.size} recorded instants; press play or move the slider. Heights are drawn "
        f"{exaggeration:.0f} times as large as lengths. A dropper in red is slack: the wire has been lifted off it."
    )
    if offset:
        text += f" Messenger's supports drawn {SYSTEM_HEIGHT:g} m over the contact wire's clamps, which the model does not need."
    return Figure("The passage", figure, text)


def _controls(times: list[float]) -> dict[str, Any]:
    """Play, pause and a slider."""
    now = {"mode": "immediate", "frame": {"duration": 0, "redraw": False}, "transition": {"duration": 0}}
    play = {"frame": {"duration": 90, "redraw": False}, "fromcurrent": True, "transition": {"duration": 0}}
    steps = [{"label": f"{t:.2f}", "method": "animate", "args": [[str(i)], now]} for i, t in enumerate(times)]
    slider = {
        "steps": steps,
        "active": 0,
        "x": 0.14,
        "len": 0.86,
        "y": -0.16,
        "pad": {"t": 8},
        "ticklen": 3,
        "font": {"size": 10, "color": MUTED},
        "bordercolor": RULE,
        "currentvalue": {"prefix": "time ", "suffix": " s", "font": {"size": 13, "color": INK}},
    }
    buttons = {
        "type": "buttons",
        "direction": "left",
        "x": 0.0,
        "y": -0.2,
        "xanchor": "left",
        "yanchor": "top",
        "showactive": False,
        "buttons": [
            {"label": "play", "method": "animate", "args": [None, play]},
            {"label": "pause", "method": "animate", "args": [[None], now]},
        ],
    }
    return {"sliders": [slider], "updatemenus": [buttons]}


def track_marks(track: Track, low: float, high: float) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """(lines at the supports, numbers of the spans) between two positions in m; empty without a span."""
    supports = track.supports_between(low, high)
    texts = [label(f"span {i + 1}", 0.5 * (a + b), 1.0, xref="x", yanchor="top") for (i, a), (_, b) in pairwise(supports)]
    return [vertical(x) for _, x in supports], texts
