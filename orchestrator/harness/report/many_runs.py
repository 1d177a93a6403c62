"""Figures of many runs: maps over two parameters with limits drawn in, scatter over each parameter, parallel coordinates."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from ...run.key_results import STATISTICS
from ..charts.blocks import Block, Figure, Text
from ..charts.chart import Band, Chart, Panel, Picture, Series
from ..charts.charts import draw_chart
from ..charts.style import INK, RISING, drawn, layout
from ..many.limits import unconfirmed

if TYPE_CHECKING:
    from ...settings.plan import LimitSettings
    from ..sweep import Sweep

MOST_SHOWN = 6  # measures that have figures
MOST_AXES = 4  # parameters with a column of panels each
LINES = 2_000  # of parallel coordinates: more are one block of ink
FEWEST_LEVELS = 3  # of each axis of a map
CLOUD = 200  # points from which on they are small dots


@dataclass(frozen=True)
class Table:
    """Columns of points that are done. varied, measured: (n,) each."""

    varied: Mapping[str, np.ndarray]
    measured: Mapping[str, np.ndarray]
    units: Mapping[str, str]
    limits: Mapping[str, LimitSettings]
    grid: bool
    inside: np.ndarray = field(default_factory=lambda: np.zeros(0, dtype=bool))  # (n,) whether a point keeps all limits

    def label(self, name: str) -> str:
        """With its unit of measure."""
        unit = self.units.get(name, "")
        return f"{name}, {unit}" if unit not in ("", "1") else name

    def bands(self, name: str) -> tuple[Band, ...]:
        """The limits of a measure."""
        limit = self.limits.get(name)
        return (Band.of("limits", limit),) if limit is not None else ()


def table_of(sweep: Sweep) -> Table:
    """The points of a sweep that are done, with the measures that are worth a figure."""
    done = sweep.done
    limits = {n: limit for n, limit in sweep.plan.limits.items() if n in sweep.measures}
    inside = np.array([all(limit.keeps(sweep.measures[n][k]) for n, limit in limits.items()) for k in np.flatnonzero(done)])
    return Table(
        {n: v[done] for n, v in sweep.varied.items()},
        {n: sweep.measures[n][done] for n in shown(sweep)},
        sweep.units,
        limits,
        sweep.plan.method == "grid",
        inside.astype(bool),
    )


def shown(sweep: Sweep) -> list[str]:
    """Measures with limits, then figures, quantities and own functions, then maxima; those that are the same everywhere last."""
    own = [n for n in sweep.measures if n.rpartition(", ")[2] not in STATISTICS]
    extremes = [n for n in sweep.measures if n.endswith((", maximum", ", minimum"))]
    names = dict.fromkeys([*(n for n in sweep.plan.limits if n in sweep.measures), *own, *extremes])
    done = sweep.done
    varying = [n for n in names if n in sweep.plan.limits or np.ptp(np.nan_to_num(sweep.measures[n][done])) > 0.0]
    different: list[str] = []
    for name in varying:  # what never differs from another one, such as the extremes of constants, is shown once
        if not any(np.array_equal(sweep.measures[name][done], sweep.measures[other][done]) for other in different):
            different.append(name)
    limited = sum(n in sweep.plan.limits for n in different)
    return different[: max(MOST_SHOWN, limited)]


def blocks(table: Table) -> list[Block]:
    """All figures that fit the points."""
    numeric = {n: v for n, v in table.varied.items() if v.dtype.kind == "f" and np.unique(v).size > 1}
    if not numeric or not table.measured:
        return []
    figures: list[Block] = []
    if table.grid and (chart := map_chart(table, numeric)) is not None:
        figures.append(draw_chart(chart))
    elif not table.grid or len(numeric) > 1:
        figures.append(draw_chart(scatter_chart(table, numeric)))
    if len(numeric) + len(table.measured) > 2:
        figures.append(parallel(table))
    return figures


def outside_text(table: Table) -> Text | None:
    """How many points keep all limits."""
    if not table.limits or not table.inside.size:
        return None
    text = f"{int(table.inside.sum())} of {table.inside.size} points keep all limits."
    return Text([text, *unconfirmed(table.limits)], "" if table.inside.all() else "note")


def map_chart(table: Table, numeric: Mapping[str, np.ndarray]) -> Chart | None:
    """A map of each measure over the two parameters of most values, at the first value of all others."""
    levels = {n: np.unique(v) for n, v in numeric.items()}
    first, *others = sorted(levels, key=lambda n: -levels[n].size)
    if not others or levels[others[0]].size < FEWEST_LEVELS:
        return None
    second = others[0]
    at = np.ones(numeric[first].size, dtype=bool)
    fixed = [n for n in table.varied if n not in (first, second)]
    for name in fixed:
        at &= table.varied[name] == table.varied[name][0]
    panels = []
    for name, x in table.measured.items():
        values = np.full((levels[second].size, levels[first].size), np.nan)
        rows, columns = (np.searchsorted(levels[n], numeric[n][at]) for n in (second, first))
        values[rows, columns] = x[at]
        limit = table.limits.get(name)
        limits = tuple(v for v in (limit.low, limit.high) if v is not None) if limit is not None else ()
        unit = table.units.get(name, "")
        picture = Picture(levels[first], levels[second], values, "" if unit == "1" else unit, "range", limits)
        panels.append(Panel(table.label(second), (), title=name, picture=picture))
    where = "; ".join(f"{n} = {table.varied[n][0]}" for n in fixed)
    text = "Lines: limits of the plan. " if any(n in table.limits for n in table.measured) else ""
    text += f"At {where}." if where else ""
    return Chart("Maps over two parameters", table.label(first), tuple(panels), text, columns=min(2, len(panels)), height=300)


def scatter_chart(table: Table, numeric: Mapping[str, np.ndarray]) -> Chart:
    """Each measure over each parameter: what has no slope and no shape there does not matter alone."""
    names = list(numeric)[:MOST_AXES]
    panels = []
    for row, (measure, y) in enumerate(table.measured.items()):
        for k, name in enumerate(names):
            kind = "dots" if y.size > CLOUD else "points"
            series = Series("points", numeric[name], y, kind)
            panels.append(
                Panel(
                    table.label(measure) if k == 0 else "",
                    (series,),
                    table.bands(measure),
                    x_label=table.label(name),
                    title=measure if k == 0 and row < MOST_SHOWN else "",
                )
            )
    more = len(numeric) - len(names)
    text = f"One point per run.{f' {more} more parameters: see the table.' if more else ''}"
    return Chart("Measures over parameters", "", tuple(panels), text, columns=len(names), height=230)


def parallel(table: Table) -> Figure:
    """Every run as a line through its parameters and measures, coloured by the first measure."""
    columns: dict[str, np.ndarray] = {**table.varied, **table.measured}
    n = next(iter(columns.values())).size
    kept = np.sort(np.random.default_rng(0).permutation(n)[:LINES])
    dimensions = [_dimension(name, x[kept], table) for name, x in columns.items()]
    colour = next(iter(table.measured.values()))[kept]
    scale = [[0.0, RISING[1][1]], [0.5, RISING[3][1]], [1.0, INK]]  # none is the paper's
    line = {
        "color": drawn(colour, 4),
        "colorscale": scale,
        "showscale": True,
        "colorbar": {"title": {"text": next(iter(table.measured)), "side": "right"}, "thickness": 12},
    }
    data = {"type": "parcoords", "dimensions": dimensions, "line": line, "labelangle": -20, "labelfont": {"size": 11}}
    figure = layout(430, margin={"l": 80, "r": 90, "t": 130, "b": 30})
    few = f" {LINES} of {n} runs, chosen by chance." if n > LINES else ""
    return Figure(
        "Parallel coordinates", {"data": [data], "layout": figure}, f"One line per run. Drag along an axis to select runs.{few}"
    )


def _dimension(name: str, x: np.ndarray, table: Table) -> dict[str, Any]:
    label = name if len(name) <= 34 else name[:16] + " … " + name[-16:]
    if x.dtype.kind == "f":
        unit = table.units.get(name, "")
        return {"label": f"{label}, {unit}" if unit not in ("", "1") else label, "values": drawn(x, 6)}
    texts: Sequence[str] = sorted(set(x.tolist()))
    return {
        "label": label,
        "values": [texts.index(t) for t in x.tolist()],
        "tickvals": list(range(len(texts))),
        "ticktext": [t[:24] for t in texts],
    }
