"""Pages of what follows from many runs: sensitivity, uncertainty, fits, designs."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ....components.core.errors import counted
from ..charts.blocks import Block, Cells, Facts, Figure, Text
from ..charts.chart import Band, Chart, Panel, Series
from ..charts.charts import draw_chart
from ..charts.style import BLUE, ORANGE, axis, drawn, layout, number
from ..many.limits import unconfirmed
from ..many.residual_tests import RESIDUAL_TESTS
from . import generic, many_runs, sweeps
from .page import Page, Section, write_page

if TYPE_CHECKING:
    from ...scene.scene import Scene
    from ..many.design import Design
    from ..many.fitting import SceneFit
    from ..many.sensitivity import Sensitivity
    from ..many.uncertainty import Inside, Uncertainty

MOST_BINS = 60
MOST_PAIRS = 6  # of aims with a panel each
MOST_ROWS = 20  # of a front's table
LIMIT_COLUMNS = ("limit", "low", "high", "provenance", "samples", "probability", "95 %")


def for_sensitivity(answer: Sensitivity, directory: str | Path) -> Path:
    """`report.html`: bars with their intervals, then scatter of the quantities over the parameters."""
    blocks: list[Block] = []
    first, total = answer.columns
    for quantity in dict.fromkeys(i.quantity for i in answer.indices):
        rows = sorted((i for i in answer.indices if i.quantity == quantity), key=lambda i: -max(i.first, i.total))
        names = [i.parameter for i in rows]
        bars = [
            (first, [i.first for i in rows], [i.first_half for i in rows], BLUE),
            (total, [i.total for i in rows], [i.total_half for i in rows], ORANGE),
        ]
        caption = (
            "S1: share of the variance that goes with the parameter alone; ST: with all its interactions."
            if answer.method == "sobol"
            else "mu*: mean change over the parameter's range; sigma: its scatter, large where it is nonlinear or interacts."
        )
        blocks.append(_bars(quantity, names, bars, f"{caption} Whiskers: 95 % of bootstrap samples."))
    table = many_runs.table_of(answer.sweep)
    blocks += many_runs.blocks(table)
    lead = _strongest(answer)
    return _page(f"Sensitivity of {answer.sweep.scene.name}", lead, blocks, answer.messages, answer.sweep.scene, directory)


def _strongest(answer: Sensitivity) -> str:
    """What matters most, quantity by quantity."""
    parts = []
    for quantity in dict.fromkeys(i.quantity for i in answer.indices):
        best = max((i for i in answer.indices if i.quantity == quantity), key=lambda i: max(i.first, i.total))
        what = f"ST {number(best.total)}" if answer.method == "sobol" else f"mu* {number(best.first)}"
        parts.append(f"{quantity} depends most on {best.parameter} ({what})")
    return "; ".join(parts) + f". {counted(len(answer.sweep.outcomes), 'run')}." if parts else "No quantity changes."


def _bars(
    title: str, names: Sequence[str], bars: Sequence[tuple[str, Sequence[float], Sequence[float], str]], text: str
) -> Figure:
    data = [
        {
            "type": "bar",
            "orientation": "h",
            "name": label,
            "y": list(names),
            "x": drawn(values),
            "marker": {"color": colour},
            "error_x": {"type": "data", "array": [v or 0.0 for v in drawn(halves)], "thickness": 1.2, "width": 4},
        }
        for label, values, halves, colour in bars
    ]
    y = axis("", autorange="reversed", ticklabelposition="outside")
    figure = layout(
        110 + 46 * len(names), barmode="group", xaxis=axis("index", grid=True, rangemode="tozero"), yaxis=y, showlegend=True
    )
    return Figure(title, {"data": data, "layout": figure}, text)


def for_uncertainty(answer: Uncertainty, directory: str | Path) -> Path:
    """`report.html`: distributions with tolerance intervals, the table, effects beside the parameters."""
    blocks: list[Block] = []
    panels = []
    for s in answer.spreads:
        x = answer.values[s.quantity]
        x = x[np.isfinite(x)]
        count, edges = np.histogram(x, bins=int(np.clip(np.sqrt(x.size), 6, MOST_BINS)))
        middle = np.repeat(edges, 2)[1:-1]
        marks = tuple((v, "tolerance") for v in s.tolerance if np.isfinite(v))
        limit = answer.sweep.plan.limits.get(s.quantity)
        if limit is not None and x.size:  # those that are near enough to be seen beside the samples
            near = np.ptp(x)
            marks += tuple(
                (end, f"{limit.standing} limit".lstrip())
                for end in (limit.low, limit.high)
                if end is not None and x.min() - near <= end <= x.max() + near
            )
        label = f"{s.quantity}, {s.unit}" if s.unit not in ("", "1") else s.quantity
        panels.append(Panel("runs", (Series("samples", middle, np.repeat(count, 2)),), x_marks=marks, x_label=label))
    if panels:
        text = "Lines: tolerance interval, which holds 95 % of all values with 95 % confidence."
        blocks.append(draw_chart(Chart("Distributions", "", tuple(panels), text, columns=min(2, len(panels)), height=240)))
    rows = [
        (
            s.quantity,
            s.unit,
            number(s.mean),
            number(s.deviation),
            number(s.percentiles[0]),
            number(s.percentiles[-1]),
            number(s.tolerance[0]),
            number(s.tolerance[1]),
            sweeps.error_of(answer.sweep.repeated, s.quantity),
        )
        for s in answer.spreads
    ]
    blocks.append(
        Cells(
            "Numbers",
            (
                "quantity",
                "unit",
                "mean",
                "standard deviation",
                "2.5 %",
                "97.5 %",
                "tolerance, low",
                "tolerance, high",
                "error of a run",
            ),
            rows,
            sweeps.trust_text(answer.sweep),
            right=frozenset(range(2, 9)),
        )
    )
    if answer.limits:
        blocks.append(
            Cells(
                "Probability that the limits are met",
                LIMIT_COLUMNS,
                limit_rows(answer.limits),
                "95 %: interval of the probability, from independent samples.",
                right=frozenset({1, 2, 4, 5, 6}),
            )
        )
    blocks += many_runs.blocks(many_runs.table_of(answer.sweep))
    parts = [
        f"{s.quantity}: {number(s.mean)} ± {number(s.deviation)}{f' {s.unit}' if s.unit not in ('', '1') else ''}"
        for s in answer.spreads
    ]
    lead = f"{'; '.join(parts)} (mean and standard deviation of {answer.origin})."
    return _page(f"Uncertainty of {answer.sweep.scene.name}", lead, blocks, answer.messages, answer.sweep.scene, directory)


def limit_rows(limits: Sequence[Inside]) -> list[tuple[str, ...]]:
    """Rows of a table with `LIMIT_COLUMNS`."""
    rows: list[tuple[str, ...]] = []
    for i in limits:
        limit = i.limit
        shown = [number(i.probability), f"{number(i.low)} to {number(i.high)}"]
        if limit is None:
            rows.append(("all limits together", "", "", "", str(i.count), *shown))
        else:
            ends = ["" if end is None else number(end) for end in (limit.low, limit.high)]
            rows.append((limit.quantity or i.column, *ends, limit.standing, str(i.count), *shown))
    return rows


def for_fit(answer: SceneFit, directory: str | Path) -> Path:
    """`report.html`: parameters with their intervals, measured and fitted curves, correlations."""
    names = answer.fit.names
    rows = [
        (n, answer.units[n], number(v), number(s), number(low), number(high), number(answer.start[n]), answer.derivatives[n])
        for n, v, s, low, high in answer.fit.rows()
    ]
    blocks: list[Block] = [
        Cells(
            "Parameters",
            ("parameter", "unit", "value", "standard deviation", "low (95 %)", "high (95 %)", "start", "derivatives"),
            rows,
            right=frozenset(range(2, 7)),
        )
    ]
    blocks += [draw_chart(c) for c in answer.charts]
    if answer.targets:
        blocks.append(
            Cells(
                "Numbers",
                ("run", "quantity", "measured", "its standard deviation", "fitted"),
                [(run, q, number(m), number(d), number(f)) for run, q, m, d, f in answer.targets],
                right=frozenset({2, 3, 4}),
            )
        )
    tests = [tuple(c if isinstance(c, str) else number(c) for c in t.row) for t in answer.tests]
    blocks.append(Cells("Residuals: noise alone?", RESIDUAL_TESTS, tests, right=frozenset(range(2, 7))))
    if len(names) > 1:
        cells = [(n, *(f"{c:.3f}".replace("-", "−") for c in row)) for n, row in zip(names, answer.fit.correlation, strict=True)]
        blocks.append(Cells("Correlations", ("", *names), cells, right=frozenset(range(1, 1 + len(names)))))
    lead = (
        ", ".join(f"{n} = {number(v)} ± {number(s)}" for n, v, s, _, _ in answer.fit.rows())
        + f" (standard deviations); {answer.runs} runs, {answer.jacobians} with derivatives; "
        f"root mean square residual {number(answer.fit.rms)}."
    )
    return _page(f"Fit of {answer.scene.name}", lead, blocks, list(answer.fit.messages), answer.scene, directory)


def for_design(answer: Design, scene: Scene, directory: str | Path) -> Path:
    """`report.html`: the best run, the way of the search, every run over the parameters; of several aims the front."""
    if len(answer.quantities) > 1:
        return _for_front(answer, scene, directory)
    count = np.arange(1, len(answer.steps) + 1)
    y = np.array([s.quantity for s in answer.steps])
    good = np.array([s.feasible for s in answer.steps])
    series = [
        Series("keeps all limits", count[good], y[good], "points"),
        Series("breaks a limit or failed", count[~good], y[~good], "points"),
    ]
    panels = [Panel(answer.quantity, tuple(s for s in series if len(s.x)))]
    for k, (name, limit) in enumerate(answer.constraints.items()):
        values = np.array([s.constraints[k] for s in answer.steps])
        band = Band.of("limits", limit)
        panels.append(Panel(name, (Series("runs", count, values, "points"),), (band,)))
    blocks: list[Block] = [draw_chart(Chart("The search", "run", tuple(panels), height=230))]
    if answer.best >= 0:
        best = answer.steps[answer.best]
        facts = [(n, f"{number(v)} {answer.units.get(n, '')}".rstrip()) for n, v in answer.values.items()]
        facts += [(answer.quantity, number(best.quantity))]
        facts += [
            (n, f"{number(v)}{' (at its limit)' if n in answer.active else ''}")
            for n, v in zip(answer.constraints, best.constraints, strict=True)
        ]
        blocks.insert(0, Facts("Best run", facts))
        kind = "largest" if answer.maximise[0] else "least"
        lead = f"{answer.quantity} = {number(best.quantity)}, the {kind} of {len(y)} runs."
    else:
        lead = f"None of {len(y)} runs meets all limits."
    notes = [*answer.messages, *unconfirmed(answer.constraints)]
    notes.append(
        "The search is local: another start may lead to a better design."
        if answer.starts == 1
        else f"{answer.starts} local searches from points spread over the bounds: there may be a better place still."
    )
    return _page(f"Design of {scene.name}", lead, blocks, notes, scene, directory)


def _for_front(answer: Design, scene: Scene, directory: str | Path) -> Path:
    """Pairs of aims with the front, its points as a table, as lines through all columns, and over the parameters."""
    aims = np.array([s.quantities for s in answer.steps])
    good = np.array([s.feasible for s in answer.steps])
    front = np.array(answer.front, dtype=int)
    columns = [*answer.names, *answer.quantities, *answer.constraints]
    runs = np.array([(*s.parameters, *s.quantities, *s.constraints) for s in answer.steps])
    whole = runs[front].reshape(front.size, len(columns))
    values = dict(zip(columns, whole.T, strict=True))
    table = many_runs.Table(
        {n: values[n] for n in answer.names},
        {n: x for n, x in values.items() if n not in answer.names},
        answer.units,
        answer.constraints,
        False,
    )
    panels = []
    for i, j in list(combinations(range(len(answer.quantities)), 2))[:MOST_PAIRS]:
        series = [
            Series("breaks a limit or failed", aims[~good, i], aims[~good, j], "dots", faint=True),
            Series("keeps all limits", aims[good, i], aims[good, j], "dots"),
            Series("front", aims[front, i], aims[front, j], "line+points" if len(answer.quantities) == 2 else "points"),
        ]
        first, second = answer.quantities[i], answer.quantities[j]
        panels.append(
            Panel(table.label(second), tuple(s for s in series if len(s.x)), table.bands(second), x_label=table.label(first))
        )
    text = "Each dot is a run. On the Pareto front, no other run improves one aim without worsening another."
    blocks: list[Block] = [draw_chart(Chart("Front", "", tuple(panels), text, columns=min(2, len(panels)), height=380))]
    if front.size:
        shown = np.unique(np.linspace(0, front.size - 1, MOST_ROWS).round().astype(int))
        few = f"{shown.size} of {front.size} points; all are in design.csv." if front.size > shown.size else ""
        blocks += [
            many_runs.parallel(table),
            Cells(
                "Points of the front",
                [table.label(n) for n in columns],
                [tuple(number(v) for v in whole[k]) for k in shown],
                few,
                right=frozenset(range(len(columns))),
            ),
        ]
        blocks += many_runs.blocks(table)[:1]
        ways = ", ".join(f"{'large' if m else 'small'} {n}" for n, m in zip(answer.quantities, answer.maximise, strict=True))
        lead = f"{front.size} of {len(answer.steps)} runs make the front of {ways}."
    else:
        lead = f"None of {len(answer.steps)} runs meets all limits."
    notes = [
        *answer.messages,
        *unconfirmed(answer.constraints),
        "The Pareto front of these runs. NSGA-II does not prove that no better design exists.",
    ]
    return _page(f"Design of {scene.name}", lead, blocks, notes, scene, directory)


def _page(title: str, lead: str, blocks: list[Block], messages: Sequence[str], scene: Scene, directory: str | Path) -> Path:
    blocks = [
        *([Text(list(messages), "note")] if messages else []),
        *blocks,
        Facts("Scene", generic.flattened(scene.model_dump(mode="json")), True),
    ]
    return write_page(Page(title, lead, [Section("Answer", blocks)]), Path(directory) / "report.html")
