"""One run against the limits that its scene names: rows of a table, the conditions that hold for it, numbers with their errors.

The numbers that the rows are about are among the figures of the run, so that its repetition finds their errors like all others.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import isfinite, nan
from pathlib import Path
from typing import TYPE_CHECKING

from ....components.core.errors import BadInput, nearest
from ...settings.study import wanted
from ..half_answers import half_answers
from ..many.limits import rows_under, table_of
from ..studies.quantities import TimeHistory, quantities_of, recording
from ..summary import SummaryRow
from .case import Case, CaseResult, Findings
from .reference import Row, TableRow, named_function

if TYPE_CHECKING:
    from ...run.results import Result
    from ...scene.scene import Scene
    from ..summary import Summary

SHOWN = "limits"  # the case that a run with limits is, in validation.json


@dataclass(frozen=True)
class Rules:
    """What of a table holds for one object of a run, such as a pantograph.

    conditions: those of the table that hold; one that the table does not have is one for which there is no rule.
    measures: numbers by the rows' measures.  about: measure -> name of the figure, without its unit, that the number judges.
    differences: measures that are such a figure less a limit; a run shows the figure beside the limit as a number.
    """

    label: str
    conditions: tuple[str, ...]
    measures: Mapping[str, float]
    about: Mapping[str, str] = field(default_factory=dict)
    differences: frozenset[str] = frozenset()


@dataclass(frozen=True)
class Judged:
    """A row with the name of the number that is compared, and the figure that is coloured by the answer."""

    row: TableRow
    name: str
    value: float
    figure: str


def with_limits(scene: Scene) -> Scene:
    """The scene with the quantities of its limits among those of interest, and what they need recorded; part of reading it.

    Raises `BadInput` for a table or a condition that there is not, and where a run would have nothing to compare.
    """
    assert scene.limits is not None
    table = table_of(scene.limits.table)
    rows = rows_under(table.rows, scene.limits, unique=not table.rules)
    if table.check:
        named_function(table.check)(scene)
    kinds = [] if table.rules or table.measures else [row.measure for row in rows if "," in row.measure]
    if missing := [kind for kind in kinds if kind not in scene.study.quantities]:
        return scene.with_changes({"study.quantities": [*scene.study.quantities, *missing]})  # which comes here again
    return recording(scene) if kinds else scene


def judged_numbers(result: Result, numbers: Sequence[SummaryRow]) -> tuple[list[Judged], list[str]]:
    """(what is compared, a sentence for each condition without a rule). numbers: the figures of the run. Raises `BadInput`."""
    limits = result.scene.limits
    assert limits is not None
    table = table_of(limits.table)
    if not table.rules:
        rows = rows_under(table.rows, limits)
        measures = named_function(table.measures)(result) if table.measures else named_numbers(rows, result, numbers)
        objects = named_function(table.objects)(result.scene) if table.objects else ()
        if len(objects) < 2:
            return [Judged(row, row.measure, float(measures[row.measure]), row.measure) for row in rows], []
        of_each = [(f"{o}.{row.measure}", replace(row, condition=f"{o}, {row.condition}")) for o in objects for row in rows]
        return [Judged(row, name, float(measures[name]), name) for name, row in of_each], []
    known = {row.condition for row in table.rows}
    judged, missing = [], []
    for rules in named_function(table.rules)(result):
        conditions = limits.conditions or rules.conditions
        missing += [f"{rules.label}: {limits.table} has no rule for {c}" for c in conditions if c not in known]
        for row in (row for row in table.rows if row.condition in conditions):
            if row.measure not in rules.measures:
                missing.append(f"{rules.label}: {row.quantity} is not known of this run")
                continue
            figure = f"{rules.label}.{rules.about.get(row.measure, row.measure)}"
            shown = replace(row, condition=f"{rules.label}, {row.condition}")
            if row.measure in rules.differences:
                judged.append(_beside_limit(shown, rules, figure))
            else:
                judged.append(Judged(shown, f"{rules.label}.{row.measure}", float(rules.measures[row.measure]), figure))
    return judged, missing


def _beside_limit(row: TableRow, rules: Rules, figure: str) -> Judged:
    """The figure and its limits in the place of their difference."""
    value = float(rules.measures[rules.about[row.measure]])
    limit = value - float(rules.measures[row.measure])
    low, high = (None if end is None else end + limit for end in (row.low, row.high))
    return Judged(
        replace(row, quantity=row.quantity.replace(" less ", " against ", 1), low=low, high=high), figure, value, figure
    )


def named_numbers(rows: Sequence[TableRow], result: Result, numbers: Sequence[SummaryRow]) -> dict[str, float]:
    """Numbers of a user's rows by their measures: figures by their names, or quantities such as "unit.output, maximum".

    Raises `BadInput` for a measure that the run does not have, and for one in another unit.
    """
    figures = {row.name: (row.value, row.unit) for row in numbers}
    history = TimeHistory(result.time, result.columns)
    kinds = any("," in row.measure for row in rows)
    quantities = {str(wanted(q.name)): q for q in quantities_of(result.scene)} if kinds else {}
    measured = {}
    for row in rows:
        quantity = quantities.get(str(wanted(row.measure))) if "," in row.measure else None
        if quantity is None and row.measure not in figures:
            raise BadInput(
                f"row {row.quantity!r}",
                f"measure {row.measure!r}",
                'a name of the summary, or "unit.output, kind"',
                nearest(row.measure, figures) if figures else "This run has no summary.",
            )
        value, unit = (quantity.value(history), quantity.unit) if quantity is not None else figures[row.measure]
        if unit != row.unit:
            raise BadInput(f"row {row.quantity!r}", f"unit {row.unit!r}", f"{unit!r}, which {row.measure} has")
        measured[row.measure] = value
    return measured


def limit_numbers(result: Result, numbers: Sequence[SummaryRow]) -> list[SummaryRow]:
    """The numbers that limits are about and that are no figures of the run yet."""
    if result.scene.limits is None or result.time.size < 2:
        return []
    known = {row.name for row in numbers}
    judged, _ = judged_numbers(result, numbers)
    added = {j.name: SummaryRow(j.name, j.value, j.row.unit, j.row.quantity) for j in judged if j.name not in known}
    return list(added.values())


def judge(result: Result, numbers: Summary) -> tuple[CaseResult, dict[str, str]] | None:
    """(the run as a case with its rows, figure -> "in", "out", "undecided" or "unconfirmed"); None without limits.

    numbers: all figures of the run, with their errors. A run that did not reach its end is failed.
    """
    limits = result.scene.limits
    if limits is None:
        return None
    errors, parameters = ({row.name: getattr(row, key) for row in numbers} for key in ("error", "parameters"))
    try:
        judged, missing = judged_numbers(result, numbers) if result.time.size > 1 else ([], [])
    except BadInput as error:
        judged, missing = [], [str(error)]
    why = result.info.verification.why or "not repeated"
    rows = tuple(
        Row(j.row, j.value, e := errors.get(j.name, nan), "" if isfinite(e) else why, parameters.get(j.name, nan)) for j in judged
    )
    answers: dict[str, str] = {}
    for j, row in ((j, row) for j, row in zip(judged, rows, strict=True) if not row.missing):
        answer = _answer(row)
        if RANKS.index(answer) > RANKS.index(answers.get(j.figure, RANKS[0])):
            answers[j.figure] = answer
        answers.setdefault(j.figure, answer)
    case = Case(SHOWN, f"Limits of {Path(limits.table).stem}", "", ())
    why = result.info.verification.why if not any(isfinite(row.error) for row in rows) else ""
    return CaseResult(
        case,
        Findings(
            rows,
            notes=tuple(dict.fromkeys(missing)),
            complete=result.outcome == "done",
            unverified=why,
            doubts=tuple(half_answers(result, [row.reference.measure for row in rows], numbers)) if rows else (),
        ),
    ), answers


RANKS = ("in", "unconfirmed", "undecided", "out")


def _answer(row: Row) -> str:
    if not row.inside:
        return "out"
    if row.undecided:
        return "undecided"
    return "unconfirmed" if row.reference.standing == "unconfirmed" else "in"
