"""Cases that ask of a documented system: does it do what its paper announces?"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING

from ....components.core.errors import StepFailed
from ...progress import tracked
from ..charts.chart import Chart, Grid
from .case import Case, Findings, claim_results, compare, function_case
from .questions import Options
from .reference import load_table

if TYPE_CHECKING:
    from ...results import Result

PREFIX = "paper-"  # of the names of these cases


@dataclass(frozen=True)
class Evidence:
    """What a study of one topic measured, by the rows' `measure`, with figures, runs worth showing, and sentences.

    claim: number of the claim below whose rows the figures stand; without it they come after all claims.
    """

    measured: Mapping[str, float]
    charts: tuple[Chart | Grid, ...] = ()
    runs: Mapping[str, Result] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    claim: str = ""


Study = Callable[[Options], Evidence]


def paper(name: str, title: str, text: str, system: str, studies: Sequence[Study]) -> Case:
    """The case of a paper: its table has claims and criteria, the studies measure.

    Two studies that measure the same thing are a defect of the case (ValueError).
    """
    return function_case(name, title, text, system, partial(_findings, name, studies))


def _findings(name: str, studies: Sequence[Study], options: Options) -> Findings:
    """All studies one by one, and their numbers beside the rows of the table; a run that fails ends them, and fails the case."""
    measured: dict[str, float] = {}
    charts: dict[str, tuple[Chart | Grid, ...]] = {}
    runs: dict[str, Result] = {}
    notes: list[str] = []
    failure = ""
    for study in tracked(studies, name, options.progress):
        try:
            evidence = study(options)
        except StepFailed as failed:
            failure = str(failed)
            break
        if twice := measured.keys() & evidence.measured:
            raise ValueError(f"case {name}: {', '.join(sorted(twice))} measured by two studies")
        measured |= evidence.measured
        charts[evidence.claim] = (*charts.get(evidence.claim, ()), *evidence.charts)
        runs |= evidence.runs
        notes += evidence.notes
    table = load_table(name)
    rows = compare(table.rows, measured)
    if unknown := charts.keys() - {"", *(claim.number for claim in table.claims)}:
        raise ValueError(f"case {name}: figures of {', '.join(sorted(unknown))}, which is no claim of its table")
    complete = not failure and all(run.outcome == "done" for run in runs.values())
    notes += [failure] if failure else []
    claims = claim_results(table.claims, rows, charts)
    return Findings(rows, runs, charts.get("", ()), tuple(notes), complete=complete, claims=claims)
