"""Claims of a paper on a page: all in one table, then each with its criterion, its rows and what is to be said of it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ..charts.blocks import Block, Cells, Facts, Text
from ..charts.chart import Chart
from ..charts.charts import draw_chart
from . import generic
from .page import Section

if TYPE_CHECKING:
    from ..validation.case import ClaimResult


def overview(claims: Sequence[ClaimResult]) -> Cells:
    """One line a claim."""
    rows = [(c.claim.number, c.claim.announced, c.claim.kind, c.measured, c.verdict) for c in claims]
    header = ("claim", "announced", "kind", "measured", "verdict")
    return Cells(
        "What the abstract announces, and what is shown here",
        header,
        rows,
        "Criteria were derived before the runs; no number is one of the paper's own tables.",
    )


def section(result: ClaimResult) -> Section:
    """One claim whole."""
    claim = result.claim
    texts = [f"Announced (abstract): {claim.announced}"]
    texts += [f"Criterion, derived before the run: {claim.criterion}"] if claim.criterion else []
    texts += [f"Not modelled here: {claim.missing}"] if claim.missing else []
    blocks: list[Block] = [Text(texts)]
    if not result.as_reviewed:
        blocks.append(Text([f"The last review had the verdict “{claim.verdict}”."], "warning"))
    if result.rows:
        conditions = dict.fromkeys(r.reference.condition for r in result.rows)
        blocks += [
            generic.range_table(condition, [r for r in result.rows if r.reference.condition == condition])
            for condition in conditions
        ]
    blocks += [draw_chart(c) if isinstance(c, Chart) else generic.grid_table(c) for c in result.charts]
    if claim.discussion:
        blocks.append(Text([claim.discussion], "note"))
    if claim.shown_by:
        blocks.append(Facts("Where it is modelled and tested", [("components, effects, files", ", ".join(claim.shown_by))]))
    return Section(f"{claim.number}: {claim.kind}", blocks, 3, result.verdict)
