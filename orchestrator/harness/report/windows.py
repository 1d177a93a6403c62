"""Windows of faults on purpose, shaded and named in figures over time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from ..charts.blocks import Figure
from ..charts.style import GREEN, PURPLE, VERMILION, label, rectangle, tint, vertical

if TYPE_CHECKING:
    from ...run.results import Result
    from ...settings import FaultSettings

COLOURS = (VERMILION, PURPLE, GREEN)  # that can be read as text
TIME = "time, s"  # the x axis of the figures concerned
ROW = 17  # px of a row of names above a figure
CHARACTER = 6.2  # px, about
WIDTH = 860  # px between the margins of a figure on a usual screen


@dataclass(frozen=True)
class Window:
    """A fault within the run. begin, end: in the unit of the figure's x axis.  colour: of the shade and the name."""

    name: str
    begin: float
    end: float
    colour: str


def fault_name(fault: FaultSettings) -> str:
    """What a fault does, in words."""
    if fault.kind == "lost":
        return f"{fault.unit} lost"
    done = {"override": f"overridden with {fault.value or 0.0:g}", "offset": f"offset by {fault.value or 0.0:g}",
            "freeze": "frozen", "drop": "dropped"}  # fmt: skip
    return f"{fault.signal} {done[fault.kind]}"


def fault_windows(result: Result) -> list[Window]:
    """Windows of the scene's faults that the run has reached, in the order of the scene."""
    last = float(result.time[-1]) if result.time.size else -1.0
    return [
        Window(fault_name(f), f.begin, last if f.end is None else min(f.end, last), COLOURS[i % len(COLOURS)])
        for i, f in enumerate(result.scene.faults)
        if f.begin <= last
    ]


def shaded(figure: Figure, windows: Sequence[Window], span: tuple[float, float], over: str = TIME) -> Figure:
    """A figure with the windows shaded in all panels and their names above them; one whose x axis is not `over` as it is.

    span: ends of the x axis, in its units as the windows. Names stand in as many rows as they need.
    """
    given = figure.figure["layout"]
    x_axes = {k: v for k, v in given.items() if k.startswith("xaxis")}
    if not windows or not any(v["title"]["text"] == over for v in x_axes.values()):
        return figure
    shapes: list[dict[str, Any]] = []
    notes: list[dict[str, Any]] = []
    inner = given["height"] - given["margin"]["t"] - given["margin"]["b"]
    rows: list[float] = []  # px, how far each is filled
    for window in windows:
        shapes.append(rectangle((window.begin, window.end), (0, 1), window.colour, 0.10, xref="x", yref="paper"))
        shapes += [vertical(at, colour=tint(window.colour, 0.6)) for at in (window.begin, window.end) if span[0] < at < span[1]]
        length = CHARACTER * len(window.name)
        left = WIDTH * (window.begin - span[0]) / ((span[1] - span[0]) or 1.0)
        backwards = left + length > WIDTH
        start = max(left - length if backwards else left, 0.0)
        row = next((k for k, filled in enumerate(rows) if filled < start), len(rows))
        rows[row : row + 1] = [start + length + CHARACTER]
        anchor = "right" if backwards else "left"
        font = {"size": 11.5, "color": window.colour}
        notes.append(label(window.name, window.begin, 1, xref="x", xanchor=anchor, yanchor="bottom", yshift=ROW * row, font=font))
    more = ROW * len(rows)
    layout = given | {
        "height": given["height"] + more,
        "margin": given["margin"] | {"t": given["margin"]["t"] + more},
        "shapes": [*given.get("shapes", ()), *shapes],
        "annotations": [*given.get("annotations", ()), *notes],
    }
    if given["legend"].get("yanchor") == "bottom":  # the legend is above the panels, too
        layout["legend"] = given["legend"] | {"y": given["legend"]["y"] + more / inner}
    caption = f"{figure.caption} Shaded: faults on purpose.".strip()
    return replace(figure, figure=figure.figure | {"layout": layout}, caption=caption)
