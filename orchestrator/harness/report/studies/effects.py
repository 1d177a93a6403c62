"""The page of `cosimo effects`: how large each effect is and what it costs, then the table with the reasons."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, isfinite, isnan, log10
from pathlib import Path
from typing import Any

from ...charts.blocks import Block, Cells, Facts, Figure, Text
from ...charts.style import BLUE, GREEN, INK, RAW, SKY, axis, drawn, label, layout, rows_axis, vertical
from ...studies.effects import Effects, Finding
from ...studies.quantities import percent
from ..page import Page, Section, write_page

ROW = 44  # px of an effect
DECADES = 4  # below the tolerance, of the axis of errors
HALF = 0.19  # of a row: where a bar lies that shares it with another
LARGEST = 3.0  # error at the end of the axis: runs that fail reach it


def for_effects(study: Effects, directory: str | Path) -> Path:
    """`report.html` of the effects a scene calls for."""
    measured = [f for f in study.findings if f.status == "measured"]
    shown = sorted(measured, key=lambda f: f.actual)  # the largest at the top
    blocks: list[Block] = [Text(_advice(study))]
    blocks += [_sizes(study, shown), _costs(study, shown)] if shown else []
    compared = [
        ("tolerance", percent(study.tolerance)),
        ("quantities", "; ".join(study.quantities)),
        ("models that were run", str(study.runs)),
    ]
    sections = [
        Section("Which effects matter", blocks),
        Section("Effects", [effect_cells(study), *_others(study)]),
        Section("Study", [Facts("What was compared", compared)]),
    ]
    return write_page(Page(study.scene.title or study.scene.name, _lead(study), sections), Path(directory) / "report.html")


def _lead(study: Effects) -> str:
    chosen = sum(f.chosen for f in study.findings)
    every = sum(f.status in ("measured", "required") for f in study.findings)
    return (
        f"{chosen} of {every} effects keep the error within {percent(study.tolerance)} of the scene with all {every}. None "
        "of them can be left out without exceeding this."
    )


def _advice(study: Effects) -> list[str]:
    rows = (("All effects", study.full), ("The scene's own effects", study.given), ("Smallest set", study.least))
    costs = [f"{name}: error {percent(c.error)}, {c.calls} calls, {c.seconds:.3g} s." for name, c in rows]
    chosen = [f.name for f in study.findings if f.chosen]
    return [" ".join(costs), f"The smallest set: {', '.join(chosen)}." if chosen else "The smallest set has no effects."]


def _bars(
    values: Sequence[float], rows: Sequence[int], name: str, colour: str, texts: Sequence[str], above: float
) -> dict[str, Any]:
    """Horizontal bars, so far above the middles of their rows."""
    return {
        "type": "bar",
        "orientation": "h",
        "x": drawn(values, 4),
        "y": [row + above for row in rows],
        "width": 0.34,
        "name": name,
        "marker": {"color": colour},
        "text": list(texts),
        "textposition": "none",
        "hovertemplate": "%{text}<extra></extra>",
    }


def _figure(
    title: str, x_axis: dict[str, Any], shown: Sequence[Finding], data: list[dict[str, Any]], caption: str, **more: Any
) -> Figure:
    names = [f.name for f in shown]
    figure_layout = layout(110 + ROW * len(names), xaxis=x_axis, yaxis=rows_axis(names), barmode="overlay", **more)
    return Figure(title, {"data": data, "layout": figure_layout}, caption)


def _sizes(study: Effects, shown: Sequence[Finding]) -> Figure:
    least = study.tolerance * 10.0**-DECADES

    def lengths(errors: Sequence[float]) -> list[float]:
        return [error if isnan(error) else LARGEST if error == inf else max(error, least) for error in errors]

    data = []
    for chosen, name, colour in ((True, "chosen", BLUE), (False, "left out", SKY)):
        if rows := [r for r, f in enumerate(shown) if f.chosen == chosen]:
            some = [shown[r] for r in rows]
            texts = [f"{f.name}<br>{_size(f.actual)}" + (f", in {f.worst}" if f.worst else "") for f in some]
            data.append(_bars(lengths([f.actual for f in some]), rows, name, colour, texts, 0.0))
    return _figure(
        "Size of each effect",
        axis("error without it", grid=True, type="log", range=[log10(least), log10(LARGEST)], dtick=1),
        shown,
        data,
        "Error without this effect (and those that require it), against the scene with all effects. Dashed: the tolerance. "
        "Effects are left out as long as the error of leaving out all of them together stays within it. Bars at the left end are "
        "smaller than the axis shows; bars at the right end are runs that fail.",
        shapes=[vertical(study.tolerance, colour=INK, dash="dash")],
        annotations=[label(percent(study.tolerance), log10(study.tolerance), 1.0, xref="x", yanchor="bottom")],
    )


def _costs(study: Effects, shown: Sequence[Finding]) -> Figure:
    rows, full = range(len(shown)), study.full
    texts = [f"{f.name}<br>{f.calls} calls, {_seconds(f)}, {f.states} states" for f in shown]
    data = [_bars([100.0 * f.calls / max(full.calls, 1) for f in shown], rows, "counted work", GREEN, texts, HALF)]
    if timed := [r for r in rows if isfinite(shown[r].seconds)]:
        shares = [100.0 * shown[r].seconds / full.seconds for r in timed]
        data.append(_bars(shares, timed, "CPU time", RAW, [texts[r] for r in timed], -HALF))
    return _figure(
        "What each effect adds",
        axis("cost of the effect, % of a run with all effects", grid=True),
        shown,
        data,
        "Counted work is the same on every machine: evaluations of equations and exchanges of signals; an effect that only adds "
        "terms to an equation adds none. CPU time: smallest of several runs, drawn only where the difference exceeds the "
        "scatter of the runs. Bars to the left: the effect makes a run cheaper.",
        shapes=[vertical(0.0, colour=INK)],
    )


def _seconds(effect: Finding) -> str:
    return f"{effect.seconds:.3g} s" if isfinite(effect.seconds) else "–"


def _size(error: float) -> str:
    return "the run fails" if error == inf else percent(error)


def effect_cells(study: Effects) -> Cells:
    """Every effect that was in the full model, or was to be in it, with its size, what it adds, and why it is chosen."""
    looked_at = (f for f in study.findings if f.status != "left out")
    order = sorted(looked_at, key=lambda f: (not f.chosen, isnan(f.actual), -f.actual))
    rows = [
        (
            f.name,
            "yes" if f.given else "no",
            "yes" if f.chosen else "no",
            _size(f.actual),
            f.worst,
            str(f.states),
            str(f.calls),
            _seconds(f),
            f.why(study.tolerance),
        )
        for f in order
    ]
    costs = ("states", "calls", "CPU time")
    errors = ("error without it", "largest in")
    header = ("effect", "in the scene", "chosen", *errors, *costs, "why")
    return Cells(
        "Effects of the full model",
        header,
        rows,
        "States, calls and CPU time: what the effect adds. –: less than the times scatter.",
        frozenset({3, 5, 6, 7}),
    )


def _others(study: Effects) -> list[Block]:
    rows = [(f.name, f.why(study.tolerance)) for f in study.findings if f.status == "left out"]
    return [Facts("Not in the full model", rows, folded=len(rows) > 20)] if rows else []
