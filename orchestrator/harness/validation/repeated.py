"""Errors of a case's numbers: the case is repeated with half of every step."""

from __future__ import annotations

import math
from dataclasses import replace
from time import process_time

from ....components.core.errors import BadInput, StepFailed
from ...judgement.comparison import SURE, UNSURE
from ...judgement.thresholds import ORDER_UNSURE, SECONDS
from ...judgement.verification import NOT_ASKED, Wish
from ...run_info import CompileTime
from ...shorter_steps import shorter_steps
from .case import Case, Findings, Row
from .questions import Options


def find(case: Case, options: Options, wish: Wish = "auto") -> Findings:
    """What a case finds, each row with its numerical error where a repetition with half of every step shows one.

    wish: "auto" repeats what takes at most `SECONDS` of CPU time, "whole" whatever it takes, "no" nothing. A number that is the
    same to the last digit has no error: no step is in it.
    """
    begun = process_time()
    with CompileTime() as compiling:
        findings = case.findings(options)
    cost = 2.0 * (process_time() - begun - compiling.spent[1])
    findings = case.with_studies(findings, options)
    if wish == "no" or not findings.complete:
        return replace(findings, unverified=NOT_ASKED if wish == "no" else "a run did not reach its end")
    if wish == "auto" and cost > SECONDS:
        why = f"to repeat the case with half of its steps would take about {cost:.2g} s: ask with --verify whole"
        return replace(findings, unverified=why)
    return _with_errors(findings, case, options)


def _with_errors(findings: Findings, case: Case, options: Options) -> Findings:
    try:
        with shorter_steps(2):
            finer = case.findings(replace(options, in_process=True))
    except (BadInput, StepFailed) as error:
        return replace(findings, unverified=f"the case cannot be repeated with half of its steps: {error}")
    if not finer.complete or len(finer.rows) != len(findings.rows):
        return replace(findings, unverified="a run with half of its steps did not reach its end")
    rows = tuple(_with_error(row, other) for row, other in zip(findings.rows, finer.rows, strict=True))
    claims = tuple(replace(c, rows=tuple(r for r in rows if r.reference.claim == c.claim.number)) for c in findings.claims)
    return replace(findings, rows=rows, claims=claims)


def _with_error(row: Row, finer: Row) -> Row:
    gap = abs(row.measured - finer.measured)
    if gap == 0.0 or not math.isfinite(gap):
        return row
    return replace(row, error=(UNSURE if gap > ORDER_UNSURE * abs(row.measured) else SURE) * gap)
