"""Errors of a case's numbers: the case is repeated with half of every step, and where its scenes have meshes, with coarser ones.

What meshes change is kept in the cache, as it is for runs: it belongs to the scenes that the case runs, and to its numbers.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from ....components.core.errors import BadInput, StepFailed
from ...judgement.mesh import FOLDER
from ...judgement.verification import NOT_ASKED, Wish, work_of
from ...kept import Kept
from ...run import work
from ...run.comparison import SURE, UNSURE
from ...run.dependence import depends_on
from ...run.thresholds import BUDGETS_OF_CASE, ORDER_UNSURE, SECOND_ORDER
from ...scene.meshes import meshes_of
from ...scene.scene import Scene
from ...scene.shorter_steps import MadeRun, made_runs, runs_with
from ...scene.tolerances import tolerances_of
from .case import Case, Findings, Row
from .questions import Evidence, Options
from .reference import UNCHANGED


def find(case: Case, options: Options, wish: Wish = "auto") -> Findings:
    """What a case finds, each row with its numerical error where a repetition with half of every step shows one.

    wish: "auto" repeats the case where the counted work of its runs is within the budget, see `run.work`, "whole" whatever it
    takes, "no" nothing. Questions that run no scene are not asked again. A number that is the same to the last digit has no
    error: no step is in it. Each row without an error says why.
    """
    kept: dict[int, Evidence] = {}
    with made_runs() as runs:
        findings = case.findings(options, kept)
    findings = case.with_studies(findings, options)
    if wish != "no" and findings.complete:
        findings = _with_parameters(findings, case, options, kept, runs, wish)
    if wish == "no" or not findings.complete:
        return _unverified(findings, NOT_ASKED if wish == "no" else "a run did not reach its end")
    try:
        counted = sum(work_of(*one) for one in runs) if wish == "auto" else 0.0
    except BadInput as error:
        return _unverified(findings, f"the case cannot be repeated: {error}")
    if not work.allows(counted, 2.0, BUDGETS_OF_CASE):
        amount = work.shown(counted, 2.0, BUDGETS_OF_CASE)
        return _unverified(
            findings, f"to repeat the case with half of its steps is much work ({amount}): ask with --verify whole"
        )
    return _with_errors(findings, case, replace(options, in_process=True), kept, runs)


def _with_parameters(
    findings: Findings, case: Case, options: Options, kept: dict[int, Evidence], runs: Sequence[MadeRun], wish: Wish
) -> Findings:
    """The findings with what tolerances of the scenes make of each row, by runs with each parameter a standard deviation on either
    side. A parameter of the same name is the same in all runs."""
    try:
        given = [tolerances for one in runs if (tolerances := tolerances_of(one.scene)) is not None]
        names = list(dict.fromkeys(name for tolerances in given for name in tolerances.names))
        if not names:
            return findings
        counted = sum(work_of(*one) for one in runs) if wish == "auto" else 0.0
        if not work.allows(counted, 2.0 * len(names), BUDGETS_OF_CASE):
            raise BadInput(case.name, "much work", "less", "Ask with --verify whole.")
        slopes, bends = zip(*(_of_parameter(findings, case, options, kept, name) for name in names), strict=True)
    except (BadInput, StepFailed) as error:
        return replace(findings, notes=(*findings.notes, f"The errors exclude the tolerances of parameters: {error}"))
    correlation = np.eye(len(names))
    for tolerances in given:
        places = [names.index(name) for name in tolerances.names]
        correlation[np.ix_(places, places)] = tolerances.correlation
    errors = np.sqrt(np.maximum(np.einsum("ir,ij,jr->r", slopes, correlation, slopes), 0.0))
    rest = np.abs(bends).sum(axis=0)
    rows = tuple(replace(row, parameters=float(e)) for row, e in zip(findings.rows, errors, strict=True))
    bent = [r.reference.quantity for r, b, e in zip(rows, rest, errors, strict=True) if b > SECOND_ORDER * e]
    notes = [f"Parameter errors of {', '.join(bent)} are not of first order alone."] if bent else []
    return replace(_with_rows(findings, rows), notes=(*findings.notes, *notes))


def _of_parameter(
    findings: Findings, case: Case, options: Options, kept: dict[int, Evidence], name: str
) -> tuple[np.ndarray, np.ndarray]:
    """Of each row half the difference of both sides, and how far their mean is from it."""
    sides = []
    for way in (1.0, -1.0):
        with runs_with(moves=((name, way),)):
            moved = case.findings(replace(options, in_process=True), kept)
        if not moved.complete or len(moved.rows) != len(findings.rows):
            raise BadInput(case.name, f"a run with another {name} that does not come to its end", "runs that do")
        sides.append(np.array([row.simulated for row in moved.rows]))
    return 0.5 * (sides[0] - sides[1]), 0.5 * (sides[0] + sides[1]) - np.array([row.simulated for row in findings.rows])


def _with_errors(
    findings: Findings, case: Case, options: Options, kept: dict[int, Evidence], runs: Sequence[MadeRun]
) -> Findings:
    try:
        with runs_with(parts=2):
            finer = case.findings(options, kept)
    except (BadInput, StepFailed) as error:
        return _unverified(findings, f"the case cannot be repeated with half of its steps: {error}")
    if not finer.complete:
        why = ": ".join(("a run with half of its steps did not reach its end", *finer.notes[-1:]))
        return replace(_unverified(findings, why), confirmed=False)
    if len(finer.rows) != len(findings.rows):
        why = f"half of its steps give {len(finer.rows)} rows instead of {len(findings.rows)}"
        return replace(_unverified(findings, why), confirmed=False)
    rows = tuple(_with_error(row, other) for row, other in zip(findings.rows, finer.rows, strict=True))
    gaps, why = _mesh_gaps(findings, case, options, kept, [one.scene for one in runs if meshes_of(one.scene)])
    rows = tuple(_with_mesh(row, gap) for row, gap in zip(rows, gaps, strict=True)) if gaps else rows
    notes = (*findings.notes, f"The errors exclude the mesh: {why}") if why else findings.notes
    return replace(_with_rows(findings, rows), notes=notes)


def _unverified(findings: Findings, why: str) -> Findings:
    """The findings with the reason at each row without an error and at the whole."""
    rows = (row if math.isfinite(row.error) else replace(row, why=why) for row in findings.rows)
    return replace(_with_rows(findings, rows), unverified=why)


def _with_rows(findings: Findings, rows: Iterable[Row]) -> Findings:
    rows = tuple(rows)
    claims = tuple(replace(c, rows=tuple(r for r in rows if r.reference.claim == c.claim.number)) for c in findings.claims)
    return replace(findings, rows=rows, claims=claims)


def _with_error(row: Row, finer: Row) -> Row:
    gap = abs(row.simulated - finer.simulated)
    if gap == 0.0:
        return replace(row, why=UNCHANGED)
    if not math.isfinite(gap):
        return replace(row, why=f"with half of the steps it is {finer.simulated:.6g}")
    return replace(row, error=(UNSURE if gap > ORDER_UNSURE * abs(row.simulated) else SURE) * gap)


def _mesh_gaps(
    findings: Findings, case: Case, options: Options, kept: dict[int, Evidence], scenes: Sequence[Scene]
) -> tuple[list[float] | None, str]:
    """Of each row the change with elements twice as long; None where no scene has a mesh, or where that is refused, and why."""
    if not scenes:
        return None, ""
    place = mesh_place(case, scenes, [row.simulated for row in findings.rows])
    if (kept_gaps := place.read()) is not None:
        return kept_gaps, ""
    try:
        with runs_with(coarser=2):
            coarse = case.findings(options, kept)
    except (BadInput, StepFailed) as error:
        return None, str(error)
    if not coarse.complete or len(coarse.rows) != len(findings.rows):
        return None, "a run with a coarser one did not reach its end"
    gaps = [abs(row.simulated - other.simulated) for row, other in zip(findings.rows, coarse.rows, strict=True)]
    gaps = [gap if math.isfinite(gap) else 0.0 for gap in gaps]
    place.write(gaps)
    return gaps, ""


def mesh_place(case: Case, scenes: Iterable[Scene], measured: Sequence[float]) -> Kept:
    """Where the changes that meshes make are kept, by the scenes that the case runs and by its numbers."""
    keys = sorted({depends_on(scene, of="figures") for scene in scenes})
    return Kept(FOLDER, depends_on("mesh of a case", case.name, keys, measured))


def _with_mesh(row: Row, gap: float) -> Row:
    """The row with what the mesh makes of its error: at first order as much as elements of twice the length change it."""
    return replace(row, error=gap + (row.error if math.isfinite(row.error) else 0.0), why="") if gap else row
