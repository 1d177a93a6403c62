"""The page of `cosimo stability --hard-cases`: how far each claim of each component is from its limit, and the cases in words."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import inf, isfinite, isnan
from pathlib import Path
from typing import Any

from .....components.catalogue import component_class
from ...charts.blocks import Block, Cells, Figure, Text
from ...charts.style import BLUE, INK, MUTED, VERMILION, axis, label, layout, markers, rows_axis, vertical
from ...studies.hard_cases import HardCases, Verdict
from ..page import Page, Section, write_page

ROW = 21  # px of a component
FARTHEST = 1e9  # a margin is drawn here if it is larger
EXACT = 1e10  # where claims are drawn of whose limit nothing was used
FAILED = 0.3  # where claims without a number are drawn that do not hold


def for_hard_cases(study: HardCases, directory: str | Path) -> Path:
    """`report.html` of the hard cases."""
    by_component: dict[str, list[Verdict]] = {}
    for verdict in study.verdicts:
        by_component.setdefault(verdict.component, []).append(verdict)
    blocks: list[Block] = [_margins(by_component)]
    if study.failed:
        blocks.insert(0, Text([f"{v.component}, {v.case}: {v.message or _numbers(v)}" for v in study.failed], "warning"))
    sections = [Section("What stays stable", blocks), Section("Cases", [_table(n, v) for n, v in by_component.items()])]
    lead = study.summary + ". Each component declares where it is at its limits, and what has to hold there."
    return write_page(Page("Hard cases", lead, sections), Path(directory) / "report.html")


def margin_text(verdict: Verdict) -> str:
    """The margin as text: a factor, or that nothing of the limit was used."""
    if verdict.margin == inf:
        return "exact"
    if isnan(verdict.margin):
        return "–"
    return f"{verdict.margin:.3g}" if verdict.margin < FARTHEST else f"over {FARTHEST:.0e}".replace("e+0", "e")


def _margins(by_component: dict[str, list[Verdict]]) -> Figure:
    names = list(by_component)
    rows = {name: len(names) - 1 - k for k, name in enumerate(names)}  # the first at the top
    every = [v for verdicts in by_component.values() for v in verdicts]
    claims = [v for v in every if v.holds and not isnan(v.limit)]
    refusals = [v for v in every if v.holds and isnan(v.limit)]
    data = [
        _marks("holds", claims, rows, BLUE, "circle"),
        _marks("refused, with a remedy", [v for v in refusals if isfinite(v.margin)], rows, INK, "diamond-open"),
        _marks("does not hold", [v for v in every if not v.holds], rows, VERMILION, "x"),
    ]
    exact = label("exact", 10.0, 1.0, xref="x", yanchor="bottom", font={"size": 11, "color": MUTED})
    figure_layout = layout(
        ROW * len(names) + 120,
        xaxis=axis("margin: limit over what was reached", grid=True, type="log"),
        yaxis=rows_axis(names[::-1]),
        margin={"l": 180, "r": 20, "t": 50, "b": 50},
        shapes=[vertical(1.0, colour=INK)],
        annotations=[exact],
    )
    return Figure(
        "How far each claim is from its limit",
        {"data": data, "layout": figure_layout},
        (
            "At 1 a claim would just hold; a magnitude cut off at its limit may be 1. Exact: the deviation is "
            "zero. For a refusal: the factor between a number that is refused and one that is accepted: the limit "
            f"lies between them. Margins above {FARTHEST:.0e} are drawn there."
        ).replace("e+0", "e"),
    )


def _marks(name: str, verdicts: Sequence[Verdict], rows: dict[str, int], colour: str, symbol: str) -> dict[str, Any]:
    texts = [f"{v.case}<br>{v.claim}<br>{_numbers(v)}" for v in verdicts]
    x, y = [_place(v) for v in verdicts], [rows[v.component] for v in verdicts]
    return markers(x, y, name, colour, symbol, 9, hover="%{text}<extra>%{fullData.name}</extra>", text=texts, opacity=0.75)


def _place(verdict: Verdict) -> float:
    if isnan(verdict.margin) or (not verdict.holds and verdict.margin < FAILED):
        return FAILED
    return EXACT if verdict.margin == inf else min(verdict.margin, FARTHEST)


def _numbers(verdict: Verdict) -> str:
    if isnan(verdict.limit):
        return verdict.message
    return f"{verdict.reached:.3g} of {verdict.limit:.3g}"


def _table(name: str, verdicts: Iterable[Verdict]) -> Cells:
    rows, before = [], ""
    for v in verdicts:
        first = v.case != before
        before = v.case
        rows.append(
            (
                v.case if first else "",
                v.text if first else "",
                v.claim,
                "" if isnan(v.reached) else f"{v.reached:.3g}",
                "" if isnan(v.limit) else f"{v.limit:.3g}",
                margin_text(v),
                "" if v.holds else "does not hold",
            )
        )
    return Cells(
        component_class(name).title,
        ("case", "what is hard", "what holds", "reached", "limit", "margin", ""),
        rows,
        right=frozenset((3, 4, 5)),
    )
