"""What a validation case is, what it finds, and how its outcome follows from its rows."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ....components.core.errors import StepFailed
from ...judgement.warnings import not_verified
from ...run.progress import tracked
from ...scene.shorter_steps import made_runs
from ...settings.document import DocumentSettings
from ..charts.chart import Chart, Grid
from .claims import CONSTRUCTION, ROLES, VERDICTS, Claim
from .questions import Evidence, Options, Question, RunFailed
from .reference import MISSING, Row, check_numbers, compare, load_table

if TYPE_CHECKING:
    from ...run.results import Result


FIRM = ("verbatim", "measured", "computed")  # provenance of ranges that decide
DECIDES_NOTHING = ("unconfirmed", MISSING)


def outcome(rows: tuple[Row, ...]) -> str:
    """ "failed" if a row is outside a range that is not just unconfirmed; else "undecided" if the error of one reaches beyond its
    range, or a range is missing; else "unconfirmed" if any range is not firm; else "passed".

    Unconfirmed ranges decide nothing: being inside them is no pass of a standard, being outside them no failure but a warning.
    Firm are ranges that were read or computed. No row, no pass.
    """
    deciding = [r for r in rows if r.reference.standing not in DECIDES_NOTHING]
    if not rows or not all(r.inside for r in deciding):
        return "failed"
    if any(r.undecided for r in deciding) or any(r.missing for r in rows):
        return "undecided"
    return "passed" if all(r.reference.standing in FIRM for r in rows) else "unconfirmed"


@dataclass(frozen=True)
class ClaimResult:
    """A claim beside the rows that were measured for it, and figures of the runs."""

    claim: Claim
    rows: tuple[Row, ...]
    charts: tuple[Chart | Grid, ...] = ()

    @property
    def verdict(self) -> str:
        """What the rows show; unconfirmed ranges decide nothing. A model without rows is shown by what it points to.

        "contradicted" if a contradicting row is inside its range, "not shown" if no supporting row is, "shown" if all
        supporting rows are, no limiting one is and nothing is missing, else "partly". Rows by construction support nothing: a
        finding that has no others is "by construction", and one of them outside its range is a defect, so a row that does not support.
        """
        firm = [r for r in self.rows if r.reference.standing not in DECIDES_NOTHING]
        inside = {role: [r.inside for r in firm if r.reference.role == role] for role in ROLES}
        if any(inside["contradicts"]):
            return "contradicted"
        held = all(inside[CONSTRUCTION])
        supported = inside["supports"] or [self.claim.kind == "model" and held]
        if not inside["supports"] and inside[CONSTRUCTION] and held and self.claim.kind == "finding":
            return CONSTRUCTION
        if not any(supported):
            return "not shown"
        return "shown" if all(supported) and held and not any(inside["limits"]) and not self.claim.missing else "partly"

    @property
    def rows_met(self) -> str:
        """How many rows met the criterion, in words; those that cannot fail apart."""
        if not self.rows:
            return "equations and tests"
        constructed = [r for r in self.rows if r.reference.role == CONSTRUCTION]
        others = [r for r in self.rows if r.reference.role != CONSTRUCTION]
        counted = ((others, ""), (constructed, f" {CONSTRUCTION}"))
        return ", ".join(f"{sum(r.inside for r in rows)} of {len(rows)} rows{how}" for rows, how in counted if rows)

    @property
    def as_reviewed(self) -> bool:
        """Whether the verdict is the one of the last review."""
        return self.verdict == self.claim.verdict

    def to_json(self) -> dict[str, Any]:
        """The claim of the machine-readable output."""
        c = self.claim
        return {
            "number": c.number,
            "kind": c.kind,
            "announced": c.announced,
            "criterion": c.criterion,
            "verdict": self.verdict,
            "reviewed": c.verdict,
            "missing": c.missing,
            "discussion": c.discussion,
            "shown_by": list(c.shown_by),
        }


def claim_results(
    claims: Iterable[Claim], rows: Iterable[Row], charts: Mapping[str, tuple[Chart | Grid, ...]]
) -> tuple[ClaimResult, ...]:
    """Every claim with its rows and its figures, those by its number."""
    rows = tuple(rows)
    return tuple(
        ClaimResult(claim, tuple(r for r in rows if r.reference.claim == claim.number), charts.get(claim.number, ()))
        for claim in claims
    )


@dataclass(frozen=True)
class Findings:
    """What a case finds: rows against references, runs worth showing, charts of studies, sentences."""

    rows: tuple[Row, ...]
    runs: Mapping[str, Result] = field(default_factory=dict)  # label -> result
    charts: tuple[Chart | Grid, ...] = ()
    notes: tuple[str, ...] = ()
    settings: Mapping[str, str] = field(default_factory=dict)  # condition -> how its numbers were made (window, filter)
    complete: bool = True  # False: a run failed, so that the case fails whatever its rows say
    claims: tuple[ClaimResult, ...] = ()  # of a paper: they decide, not the rows one by one
    unverified: str = ""  # why the errors of the rows are not known; "" where they are
    confirmed: bool = True  # False: a run with half of the steps did not reach its end, see `unverified`
    doubts: tuple[str, ...] = ()  # runs whose coupling may be unstable, numbers that are half an answer


@dataclass(frozen=True)
class Case:
    """A comparison with a reference: questions that are asked one after the other, and studies that explain their answers.

    name: of the case and its table.  text: what it shows, and what it cannot show.  studies: give charts, once; they are not
    repeated for errors.  system: filled in by the system whose case it is.  document: what its report says of itself.
    """

    name: str
    title: str
    text: str
    questions: tuple[Question, ...]
    studies: tuple[Question, ...] = ()
    system: str = ""
    document: DocumentSettings = field(default_factory=DocumentSettings)

    def findings(self, options: Options, kept: dict[int, Evidence] | None = None) -> Findings:
        """The evidence of all questions beside the rows of the table. A run that fails ends the case; what was measured stays.

        kept: evidence of questions by their places, which are not asked again; those that run no scene are added, as neither
        shorter steps nor coarser meshes change their numbers.
        Two questions that measure the same, figures of a claim that the table does not have, and rows that no question measures
        are defects of the case (ValueError).
        """
        evidence, failure = _ask(self.questions, self.name, options, {} if kept is None else kept)
        numbers = {measure: number for e in evidence for measure, number in e.numbers.items()}
        if len(numbers) < sum(len(e.numbers) for e in evidence):
            twice = [m for m in numbers if sum(m in e.numbers for e in evidence) > 1]
            raise ValueError(f"case {self.name}: {', '.join(sorted(twice))} measured by two questions")
        charts: dict[str, tuple[Chart | Grid, ...]] = {}
        for e in evidence:
            charts[e.claim] = (*charts.get(e.claim, ()), *e.charts)
        rows = tuple(row for e in evidence for row in e.rows)
        claims: tuple[ClaimResult, ...] = ()
        if numbers:
            table = load_table(self.name)
            if failure is None:
                check_numbers(self.name, table.rows, numbers)
            rows = (*compare(table.rows, numbers), *rows)
            if unknown := charts.keys() - {"", *(claim.number for claim in table.claims)}:
                raise ValueError(f"case {self.name}: figures of {', '.join(sorted(unknown))}, which is no claim of its table")
            claims = claim_results(table.claims, rows, charts)
        shown = {label: result for e in evidence for label, result in e.shown.items()}
        return Findings(
            rows,
            {**shown, **failure.runs} if failure else shown,
            charts.get("", ()),
            (*(note for e in evidence for note in e.notes), *(failure.notes if failure else ())),
            {condition: text for e in evidence for condition, text in e.settings.items()},
            failure is None,
            claims,
            doubts=tuple(dict.fromkeys(text for e in evidence for text in e.doubts)),
        )

    def with_studies(self, findings: Findings, options: Options) -> Findings:
        """Findings with the charts of the studies; of incomplete ones there is nothing to explain."""
        if not findings.complete:
            return findings
        evidence, failure = _ask(self.studies, self.name, options, {})
        notes = findings.notes + (failure.notes if failure else ())
        return replace(findings, charts=findings.charts + tuple(c for e in evidence for c in e.charts), notes=notes)


def _ask(
    questions: tuple[Question, ...], title: str, options: Options, kept: dict[int, Evidence]
) -> tuple[list[Evidence], Findings | None]:
    """(evidence of the questions up to one whose run fails, the failed run and its message or None)."""
    evidence: list[Evidence] = []
    several = options.progress and len(questions) > 1  # one bar over the questions, none over each run
    try:
        for k, question in enumerate(tracked(questions, title, several)):
            if k not in kept:
                with made_runs() as runs:
                    evidence.append(question.ask(replace(options, progress=options.progress and not several)))
                if runs:
                    continue
                kept[k] = evidence.pop()
            evidence.append(kept[k])
    except RunFailed as failed:
        return evidence, Findings((), {failed.label: failed.result}, notes=(failed.result.message,))
    except StepFailed as failed:
        return evidence, Findings((), notes=(str(failed),))
    return evidence, None


@dataclass(frozen=True)
class CaseResult:
    """A case that was run."""

    case: Case
    findings: Findings
    report: Path | None = None

    def __repr__(self) -> str:
        """The verdict, and a line for each row or claim."""
        lines = [f"<{self.case.name}: {self.verdict}>"]
        lines += [
            f"{r.reference.quantity} ({r.reference.condition}): {r.shown} {r.reference.unit}; inside: {r.answer}"
            for r in self.findings.rows
        ]
        lines += [f"{c.claim.number} {c.verdict}: {c.claim.announced}" for c in self.findings.claims]
        return "\n".join(lines)

    @property
    def outcome(self) -> str:
        """ "passed", "failed", "undecided" or "unconfirmed"; a paper passes if every claim has the verdict of its last review."""
        if not self.findings.complete:
            return "failed"
        if self.findings.claims:
            return "passed" if all(c.as_reviewed for c in self.findings.claims) else "failed"
        return outcome(self.findings.rows)

    @property
    def warnings(self) -> list[str]:
        """What is doubtful, and that errors are not known, one sentence each."""
        why = self.findings.unverified
        return self.doubtful + ([not_verified(why)] if why and self.findings.confirmed else [])

    @property
    def doubtful(self) -> list[str]:
        """What fails nothing, but may be a defect: doubtful rows, runs that may be unstable, and a repetition that failed."""
        not_confirmed = [] if self.findings.confirmed else [f"not confirmed: {self.findings.unverified}"]
        return [*self.doubtful_rows, *self.findings.doubts, *not_confirmed]

    @property
    def doubtful_rows(self) -> list[str]:
        """Rows outside of unconfirmed ranges and undecided ones, one sentence each."""
        return [
            f"{r.reference.quantity} ({r.reference.condition}): {r.simulated:.5g} {unit}is {_outside(r)}, an unconfirmed range"
            if not r.inside
            else f"{r.reference.quantity} ({r.reference.condition}): {r.shown} {unit}is undecided: a limit is {r.margin:.2g} away"
            for r in self.findings.rows
            if (r.reference.standing == "unconfirmed" and not r.inside) or r.undecided
            for unit in [f"{r.reference.unit} " if r.reference.unit != "1" else ""]
        ]

    @property
    def verdict(self) -> str:
        """The outcome in one sentence."""
        rows = self.findings.rows
        if not self.findings.complete:
            return "Failed: a run did not reach its end."
        if self.findings.claims:
            return _claims_in_words(self.findings.claims)
        parts = []
        kinds = ((FIRM, "range"), (("unconfirmed",), "unconfirmed range"), (("inferred",), "inferred range"))
        for names, kind in kinds:
            some = [r for r in rows if r.reference.standing in names]
            if some:
                undecided = f", {n} undecided" if (n := sum(r.undecided for r in some)) else ""
                parts.append(f"{sum(r.inside for r in some)} of {len(some)} rows inside the {kind}{undecided}")
        missing = sum(r.missing for r in rows)
        if missing:
            parts.append(f"{missing} of {len(rows)} rows without a range")
        text = {
            "passed": "Passed",
            "failed": "Failed",
            "undecided": "Not assessed" if missing else "Undecided: the error interval of a result crosses a limit",
            "unconfirmed": "Not assessed: some ranges are unconfirmed or inferred, not read in a source",
        }
        counted = ", ".join(parts) or "no row was compared"
        why = text[self.outcome]
        return f"{why}; {counted}." if ":" in why else f"{why}: {counted}."

    def to_json(self) -> dict[str, Any]:
        """The case of the machine-readable output."""
        return {
            "case": self.case.name,
            "title": self.case.title,
            "outcome": self.outcome,
            "verdict": self.verdict,
            "warnings": self.warnings,
            "rows": [r.to_json() for r in self.findings.rows],
            **({"claims": [c.to_json() for c in self.findings.claims]} if self.findings.claims else {}),
            "notes": list(self.findings.notes),
            "unverified": self.findings.unverified,
            "report": str(self.report) if self.report else None,
        }


def _claims_in_words(claims: tuple[ClaimResult, ...]) -> str:
    """How many claims have which verdict, and which of them have another one than at the last review."""
    numbers = {v: [c.claim.number for c in claims if c.verdict == v] for v in VERDICTS}
    text = "; ".join(f"{len(n)} {v} ({', '.join(n)})" for v, n in numbers.items() if n)
    other = [f"{c.claim.number} was {c.claim.verdict}" for c in claims if not c.as_reviewed]
    return f"{len(claims)} claims: {text}." + (f" Not as last reviewed: {', '.join(other)}." if other else "")


def _outside(row: Row) -> str:
    """Which end of its range a row has left."""
    low, high = row.reference.low, row.reference.high
    if low is not None and row.simulated < low:
        return f"below {low:.5g}"
    return f"above {high:.5g}" if high is not None and row.simulated > high else "not a number"


def to_table(results: list[CaseResult]) -> tuple[tuple[str, ...], list[tuple[str | float, ...]]]:
    """(names of the columns, rows) of validation.csv: every row of every case with the case's outcome and its own answer."""
    columns = ["quantity", "condition", "unit", "measured", "error", "low", "high", "standing", "confidence", "source"]
    if any(math.isfinite(row.parameters) for result in results for row in result.findings.rows):
        columns.insert(5, "parameters")
    rows = []
    for result in results:
        for row in result.findings.rows:
            cells = {"parameters": None, **row.to_json()}
            rows.append(
                (result.case.name, result.outcome, *("" if cells[c] is None else cells[c] for c in columns), row.answer, row.why)
            )
    return ("case", "outcome", *columns, "inside", "why no error"), rows


def to_json(results: list[CaseResult]) -> str:
    """The document of `cosimo validate --json`."""
    return json.dumps({"cases": [r.to_json() for r in results]}, indent=2, ensure_ascii=False)
