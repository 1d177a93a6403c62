"""Recorded signals over time as a Plotly figure: a panel for each unit of measure."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ....components.core.errors import BadInput
from .chart import Chart, Panel, Series
from .charts import draw_chart
from .style import CYCLE, SAMPLES

if TYPE_CHECKING:
    from plotly.graph_objects import Figure

    from ...run.results import Result

MOST = 40  # signals of a figure that names none


def signal_figure(result: Result, signals: str | Iterable[str] | None = None, *, fig: Figure | None = None) -> Figure:
    """A figure of signals over time, for whoever has it to show.

    signals: "unit.variable", "unit.array" for all elements, "unit" for all of a unit; default: the first 40 of all.
    fig: a figure of another result, to whose panels the signals are added, with the name of this result's scene.
    Raises `BadInput` for signals that are not recorded or are texts, and where `fig` has no panel for a unit of measure.
    """
    from plotly.graph_objects import Figure

    names = [n for n in result.signals(signals) if n in result.columns]
    if not names:
        raise BadInput("plot", "no signal that is a number", "recorded numbers over time")
    names = names if signals is not None else names[:MOST]
    panels: dict[str, list[Series]] = {}
    for name in names:
        label = name if fig is None else f"{name}, {result.scene.name}"
        values = np.asarray(result.columns[name], dtype=float)
        panels.setdefault(result.measures.get(name, ""), []).append(Series(label, result.time, values))
    chart = Chart(
        result.scene.title, "time, s", tuple(Panel(axis_of(unit, [x.name for x in s]), tuple(s)) for unit, s in panels.items())
    )
    drawn = draw_chart(chart).figure
    drawn = {**drawn, "data": [{k: v for k, v in trace.items() if k != SAMPLES} for trace in drawn["data"]]}
    if fig is None:
        title = {"text": chart.title, "x": 0.0, "xref": "paper", "y": 0.99, "yanchor": "top", "font": {"size": 15}}
        return Figure(drawn["data"], {**drawn["layout"], "title": title, "meta": {"units": list(panels)}})
    return _added(fig, drawn["data"], list(panels))


def axis_of(unit: str, names: Sequence[str]) -> str:
    """The label of an axis of signals: the unit of measure, with the signal where it is the only one; of many without unit none."""
    measure = unit if unit != "1" else ""
    if len(names) > 1:
        return measure
    return ", ".join(filter(None, (names[0].rpartition(".")[2].replace("_", " "), measure)))


def _added(fig: Figure, traces: list[dict[str, Any]], units: list[str]) -> Figure:
    """The figure with further traces, each on the axes of its unit of measure."""
    have = list((fig.layout.meta or {}).get("units", ()))
    if missing := [unit for unit in units if unit not in have]:
        raise BadInput(
            "plot: fig",
            f"signals in {missing[0] or 1!r}",
            f"a figure of signals in {', '.join(have) or 'none'}",
            "Draw them in a figure of their own.",
        )
    known = len(fig.data)
    for k, trace in enumerate(traces):
        own = trace.get("yaxis", "y").removeprefix("y") or "1"
        place = have.index(units[int(own) - 1])
        n = "" if place == 0 else str(place + 1)
        colour = CYCLE[(known + k) % len(CYCLE)]
        fig.add_trace({**trace, "xaxis": f"x{n}", "yaxis": f"y{n}", "line": {**trace.get("line", {}), "color": colour}})
    fig.update_layout(showlegend=True)
    return fig
