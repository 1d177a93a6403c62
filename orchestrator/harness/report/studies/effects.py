"""The page of `cosimo effects`: predicted beside actual size and what each effect costs, then the table with the reasons."""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite, log10
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...charts.blocks import Block, Cells, Facts, Figure, Text
from ...charts.style import BLUE, GREEN, INK, RAW, SKY, VERMILION, axis, drawn, label, layout, vertical
from ...studies.quantities import percent
from ..page import Page, Section, write_page

if TYPE_CHECKING:
    from ...studies.effects import Effects, Finding

ROW = 44  # px of an effect
DECADES = 4  # below the tolerance, of the axis of errors
LARGEST = 3.0  # error at the end of the axis: runs that fail reach it


def for_effects(study: Effects, directory: str | Path) -> Path:
    """`report.html` of the effects a scene calls for."""
    measured = [f for f in study.findings if f.status == "measured"]
    shown = sorted(measured, key=lambda f: f.actual)  # the largest at the top
    blocks: list[Block] = [Text(_advice(study))]
    blocks += [Text(list(study.remarks), "note")] if study.remarks else []
    blocks += [_sizes(study, shown), _costs(study, shown)] if shown else []
    sections = [
        Section("Which effects matter", blocks),
        Section("Effects", [_table(study), *_others(study)]),
        Section(
            "Study",
            [
                Facts(
                    "What was compared",
                    [
                        ("tolerance", percent(study.tolerance)),
                        ("quantities", "; ".join(study.quantities)),
                        ("models that were run", str(study.runs)),
                    ],
                )
            ],
        ),
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
    return [
        " ".join(costs),
        *(
            ["The smallest set: " + ", ".join(f.name for f in study.findings if f.chosen) + "."]
            if any(f.chosen for f in study.findings)
            else ["The smallest set has no effects."]
        ),
    ]


def _bars(
    values: Sequence[float], rows: Sequence[int], name: str, colour: str, shift: float, texts: Sequence[str], **more: Any
) -> dict[str, Any]:
    return {
        "type": "bar",
        "orientation": "h",
        "x": drawn(values, 4),
        "y": [r + shift for r in rows],
        "width": 0.34,
        "name": name,
        "marker": {"color": colour},
        "text": list(texts),
        "textposition": "none",
        "hovertemplate": "%{text}<extra></extra>",
    } | more


def _sizes(study: Effects, shown: Sequence[Finding]) -> Figure:
    rows, least = list(range(len(shown))), study.tolerance * 10.0**-DECADES

    def length(error: float) -> float:
        return LARGEST if error == float("inf") else max(error, least) if error == error else error

    data = [
        *(
            _bars(
                [length(f.actual) for f in some],
                [r for r, f in enumerate(shown) if f.chosen == chosen],
                name,
                colour,
                0.19,
                [f"{f.name}<br>actual: {_size(f.actual)}" + (f", in {f.worst}" if f.worst else "") for f in some],
            )
            for chosen, name, colour in ((True, "actual, chosen", BLUE), (False, "actual, left out", SKY))
            if (some := [f for f in shown if f.chosen == chosen])
        ),
        _bars(
            [length(f.predicted) for f in shown],
            rows,
            "predicted",
            VERMILION,
            -0.19,
            [f"{f.name}<br>predicted: {_size(f.predicted)}" for f in shown],
        ),
    ]
    figure_layout = _layout(
        "error without it",
        shown,
        barmode="overlay",
        shapes=[vertical(study.tolerance, colour=INK, dash="dash")],
        annotations=[label(percent(study.tolerance), log10(study.tolerance), 1.0, xref="x", yanchor="bottom")],
    )
    figure_layout["xaxis"] |= {"type": "log", "range": [log10(least), log10(LARGEST)], "dtick": 1}
    return Figure(
        "Size of each effect",
        {"data": data, "layout": figure_layout},
        (
            "Error without this effect (and those that require it), against the scene with all effects: measured, and predicted "
            "from short runs that start at points of the full solution. Dashed: the tolerance. Effects are left out as long as the "
            "error of leaving out all of them together stays within it. Bars at the left end are smaller than the axis shows; bars "
            "at the right end are runs that fail."
        ),
    )


def _costs(study: Effects, shown: Sequence[Finding]) -> Figure:
    rows, full = list(range(len(shown))), study.full
    places = [r for r, f in enumerate(shown) if isfinite(f.seconds)]
    texts = [f"{f.name}<br>{f.calls} calls, {_seconds(f)}, {f.states} states" for f in shown]
    data = [_bars([100.0 * f.calls / max(full.calls, 1) for f in shown], rows, "counted work", GREEN, 0.19, texts)]
    if places:
        data.append(
            _bars(
                [100.0 * shown[r].seconds / full.seconds for r in places],
                places,
                "CPU time",
                RAW,
                -0.19,
                [texts[r] for r in places],
            )
        )
    zero = vertical(0.0, colour=INK)
    figure_layout = _layout("cost of the effect, % of a run with all effects", shown, barmode="overlay", shapes=[zero])
    return Figure(
        "What each effect adds",
        {"data": data, "layout": figure_layout},
        (
            "Counted work is the same on every machine: evaluations of equations and exchanges of signals; an effect that only adds "
            "terms to an equation adds none. CPU time: smallest of several runs, drawn only where the difference exceeds the "
            "scatter of the runs. Bars to the left: the effect makes a run cheaper."
        ),
    )


def _layout(title: str, shown: Sequence[Finding], **more: Any) -> dict[str, Any]:
    rows = list(range(len(shown)))
    y = axis("", tickvals=rows, ticktext=[f.name for f in shown], range=[-0.6, len(rows) - 0.4])
    return layout(110 + ROW * len(rows), xaxis=axis(title, grid=True), yaxis=y) | more


def _seconds(effect: Finding) -> str:
    return f"{effect.seconds:.3g} s" if isfinite(effect.seconds) else "–"


def _size(error: float) -> str:
    return "the run fails" if error == float("inf") else percent(error)


def _table(study: Effects) -> Cells:
    order = sorted((f for f in study.findings if f.status in ("measured", "required")), key=lambda f: (not f.chosen, -f.actual))
    rows = [
        (
            f.name,
            "yes" if f.given else "no",
            "yes" if f.chosen else "no",
            percent(f.predicted),
            _size(f.actual),
            f.worst,
            percent(f.breaking),
            str(f.states),
            str(f.calls),
            _seconds(f),
            f.why(study.tolerance),
        )
        for f in order
    ]
    return Cells(
        "Effects of the full model",
        (
            "effect",
            "in the scene",
            "chosen",
            "predicted",
            "actual",
            "largest in",
            "error of the set without it",
            "states",
            "calls",
            "CPU time",
            "why",
        ),
        rows,
        "States, calls and CPU time: what the effect adds. –: less than the times scatter.",
        frozenset({3, 4, 6, 7, 8, 9}),
    )


def _others(study: Effects) -> list[Block]:
    rows = [(f.name, f.why(study.tolerance)) for f in study.findings if f.status in ("left out", "unable")]
    return [Facts("Not in the full model", rows, folded=len(rows) > 20)] if rows else []
