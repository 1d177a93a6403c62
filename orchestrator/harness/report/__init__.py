"""One self-contained page of figures and tables; numbers come in, nothing is simulated here."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fnmatch import fnmatch
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ....components.core.errors import BadInput, counted
from ...run.run_record import VerificationRecord
from ..charts.blocks import Answer, Block, Cells, Facts, Figure, Text
from ..charts.chart import Chart
from ..charts.charts import draw_chart
from ..charts.style import number
from ..many.failures import failure_groups
from ..summary import Summary, SummaryRow, verification_text, with_errors
from ..validation.limits_of_run import judge
from . import first_page, generic, many_runs, numerics, sweeps, trust
from .page import Page, Section, write_page
from .windows import fault_windows, shaded

if TYPE_CHECKING:
    from ...run.results import Result
    from ...scene.scene import Scene
    from ..sweep import Sweep
    from ..system import Systems
    from ..validation.case import CaseResult, ClaimResult

MOST_NUMBERS = 12  # of the summary at the top of a page; the table below them has all
FIRST_NUMBERS = 4  # where the system does not say which of them a run is judged by
PROVENANCE = (
    "Provenance of each range: verbatim = copied from a public source; computed = from a closed form or an independent solver; "
    "inferred = derived from other published values; unconfirmed = quoted from memory, not checked against the source (hatched).",
    "± is the estimated numerical error: twice the change when all steps are halved. A row inside is undecided if an end of its range lies "
    "within ±, or within two standard deviations of its parameter error. A number without ± did not change with halved steps, or "
    "its run was not repeated, as the row says.",
)
_ENDED = {"failed": "failed", "unstable": "is unstable", "stopped": "was stopped"}


def for_run(result: Result, directory: str | Path, systems: Systems) -> Path:
    """`report.html` of one run: outcome and first numbers, figures of its system, signals, how it was computed, settings."""
    scene = result.scene
    judged = judge(result, result.summary) if result.scene.limits is not None else None
    answer = _answer(result, systems, judged[1] if judged else {})
    first: list[Block] = [Text([_ended(result)], "warning")] if result.outcome != "done" else []
    first += [*answer[:1], *first_page.blocks(result, systems), *(_limits(judged[0]) if judged else [])]
    warnings = result.info.warnings
    doubts = [_sentence(text, scene) for text in warnings if text not in scene.remarks]
    for texts, tone in ((doubts, "warning"), (list(scene.remarks), "note")):
        first += [Text(texts, tone)] if texts else []
    verified = result.info.verification != VerificationRecord(done=False, why="")
    first += [Text([verification_text(result.info.verification)], "settings")] if verified else []
    figures, computed = _of_system(result, systems), numerics.blocks(result)
    signals: list[Block] = [*generic.time_series(result)]
    if windows := fault_windows(result):
        span = (float(result.time[0]), float(result.time[-1]))
        figures, signals, computed = (
            [shaded(b, windows, span) if isinstance(b, Figure) else b for b in part] for part in (figures, signals, computed)
        )
    chapters = (
        ("Key results", answer[1:]),
        ("Figures", figures),
        ("Signals", signals),
        ("Numerical errors", trust.blocks(result)[1:] if verified else []),
        ("How it was computed", computed),
    )
    sections = [Section("Run", first, badge=judged[0].outcome if judged else result.outcome)]
    sections += [Section(title, blocks) for title, blocks in chapters if blocks]
    how = Text([generic.run_line(result)], "settings")
    sections.append(Section("Inputs and versions", [how, *generic.units_and_connections(result), *generic.run_blocks(result)]))
    title = scene.document.title or scene.title or scene.name
    lead = f"{judged[0].case.title}. {judged[0].verdict} {_verdict(result)}" if judged else _verdict(result)
    return write_page(Page(title, lead, sections, PROVENANCE if judged else ()), Path(directory) / "report.html")


def _ended(result: Result) -> str:
    """How a run ended that did not reach its end."""
    return f"This run {_ENDED[result.outcome]}. The report shows the results up to that point. {result.message}"


def _sentence(warning: str, scene: Scene) -> str:
    """A warning with a capital, unless it begins with a name, and a full stop."""
    first = warning.partition(" ")[0]
    begin = warning[:1] if first in scene.units or not first.isalpha() else warning[:1].upper()
    return f"{begin}{warning[1:]}{'' if warning.endswith(('.', '?', '!')) else '.'}"


def _limits(case: CaseResult) -> list[Block]:
    """The rows of the limits of a run, and what is to be said of them."""
    notes: list[Block] = [
        Text(list(texts), tone) for texts, tone in ((case.doubtful, "warning"), (case.findings.notes, "note")) if texts
    ]
    rows = case.findings.rows
    return [generic.range_table("", rows, grouped=True), *notes] if rows else notes


def _verdict(result: Result) -> str:
    """How the run ended, in one sentence."""
    end = f"{number(float(result.time[-1]) if result.time.size else 0.0)} s simulated"
    if result.outcome != "done":
        return f"This run {_ENDED[result.outcome]}, {end}."
    count = len([text for text in result.info.warnings if text not in result.scene.remarks])
    return f"Done: {end}, " + (f"{count} warning{'s' if count > 1 else ''}." if count else "no warning.")


def _answer(result: Result, systems: Systems, answers: Mapping[str, str]) -> list[Block]:
    """The numbers that a run of its system is judged by, and a table of all; none of a run that has none.

    answers: figure -> what the limits say of it.
    """
    rows = _summary(result, systems)
    if not rows:
        return []
    patterns = systems[result.scene.analysis.system].headline
    whole = [row for row in rows if not row.part]
    first = [row for row in whole if any(fnmatch(row.name.rpartition(".")[2], pattern) for pattern in patterns)]
    numbers = [
        (
            f"{row.for_reader().shown} {row.for_reader().unit}".rstrip(),
            ", ".join(filter(None, (row.text, row.name.rpartition(".")[0]))),
            answers.get(row.name, ""),
        )
        for row in (first or (whole or rows)[:FIRST_NUMBERS])[:MOST_NUMBERS]
    ]
    unknown = Text(["These numbers have no error estimate; the section on numerical errors says why."], "note")
    known = any(np.isfinite(row.error) for row in rows)
    return [Answer(numbers), _all_figures(rows), *([] if known else [unknown])]


def _summary(result: Result, systems: Systems) -> Summary:
    """The run in numbers; none of a run that is too short, or whose [analysis] asks for what it does not have."""
    system = result.scene.analysis.system
    if system not in systems or result.time.size < 2:
        return ()
    try:
        return with_errors(systems[system].summary(result), result.info.verification)
    except BadInput:
        return ()  # the line in place of the figures says why


def _all_figures(rows: Sequence[SummaryRow]) -> Cells:
    """All numbers of the summary: a line for each quantity, a column for each unit that has it."""
    units = list(dict.fromkeys(row.name.rpartition(".")[0] for row in rows))
    sizes: dict[tuple[str, str], float] = {}
    for row in rows:
        sizes[row.text, row.unit] = max(sizes.get((row.text, row.unit), 0.0), abs(row.value))
    lines: dict[tuple[str, str], dict[str, str]] = {}
    for row in (row.for_reader(sizes[row.text, row.unit]) for row in rows):
        lines.setdefault((row.text, row.unit), {})[row.name.rpartition(".")[0]] = row.shown
    cells = [(text, unit, *(values.get(name, "") for name in units)) for (text, unit), values in lines.items()]
    right = frozenset(range(2, 2 + len(units)))
    return Cells("All key results", ("quantity", "unit", *units), cells, right=right, folded=True)


def _of_system(result: Result, systems: Systems) -> list[Block]:
    """The machine in motion and the figures of the scene's system; a line instead where its [analysis] asks for what is missing.

    A run that failed has them as far as it went, if it made a step.
    """
    system = result.scene.analysis.system
    if system not in systems or (result.outcome != "done" and result.time.size < 2):
        return []
    try:
        return [*(machine.motion(result) for machine in systems[system].motions(result)), *systems[system].figures(result)]
    except BadInput as error:
        return [Text([f"No charts of system = {system!r}: {error}"], "warning")]


def for_cases(case_results: Sequence[CaseResult], directory: str | Path, systems: Systems) -> Path:
    """`report.html` of validation cases: per case what it shows, figures, tables with margins, studies, settings."""
    sections = [s for r in case_results for s in _case_sections(r, len(case_results) == 1, systems)]
    if len(case_results) > 1:
        overview = [(r.case.title, r.outcome, r.verdict) for r in case_results]
        sections.insert(0, Section("Overview", [Cells("", ("case", "outcome", "in words"), overview)]))
    count = {o: sum(r.outcome == o for r in case_results) for o in ("passed", "failed", "undecided", "unconfirmed")}
    lead = ", ".join(f"{n} {o}" for o, n in count.items() if n) + "."
    if count["unconfirmed"]:
        lead += " “Unconfirmed”: some ranges are quoted from memory, so a result inside them does not count as passed."
    if len(case_results) == 1:
        lead = case_results[0].verdict
    if len(case_results) == 1:
        title = case_results[0].case.document.title or case_results[0].case.title
    else:
        title = f"{len(case_results)} validation cases"
    return write_page(Page(title, lead, sections, PROVENANCE), Path(directory) / "report.html")


def for_sweep(sweep: Sweep, directory: str | Path) -> Path:
    """`report.html` of a sweep: its section against the last parameter that varies, and the measures."""
    scene = sweep.scene
    blocks: list[Block] = []
    if failures := failure_groups(sweep.outcomes):
        blocks.append(Text(failures, "warning"))
    blocks += [Text(sweep.remarks, "note")] if sweep.remarks else []
    table = many_runs.table_of(sweep)
    blocks += [text] if (text := many_runs.outside_text(table)) is not None else []
    if (chart := sweeps.section_chart(sweep)) is not None:
        blocks.append(draw_chart(chart))
    blocks += many_runs.blocks(table)
    if sweeps.few_groups(sweep) and (chart := sweeps.measures_chart(sweep)) is not None:
        blocks.append(draw_chart(chart))
    ranges = [_range(name, values, sweep.units[name]) for name, values in sweep.varied.items()]
    lead = (
        f"{counted(len(sweep.outcomes), 'run')} of the scene {scene.name}. The file sweep.csv contains all numbers. "
        f"Parameters that do not vary have the values of the scene: {scene.title or scene.name}."
    )
    settings: list[Block] = [Facts("Scene", generic.flattened(scene.model_dump(mode="json")), True)]
    trusted = Section("Numerical errors", sweeps.trust(sweep))
    title = f"Sweep of {', '.join(ranges)}"
    sections = [Section("Sweep", blocks), trusted, Section("Settings", settings)]
    return write_page(Page(title, lead, sections), Path(directory) / "report.html")


def _range(name: str, values: np.ndarray, unit: str) -> str:
    """What a sweep varies, from where to where."""
    if values.dtype.kind not in "iuf":
        return f"{name} ({', '.join(dict.fromkeys(map(str, values)))})"
    return f"{name}, {number(float(values.min()))} to {number(float(values.max()))} {unit if unit != '1' else ''}".rstrip()


def _case_sections(result: CaseResult, alone: bool, systems: Systems) -> list[Section]:
    case, findings = result.case, result.findings
    answer: list[Block] = [
        Text([case.text] if alone else [result.verdict, case.text]),
        *([_claims_table(findings.claims)] if findings.claims else []),
    ]
    special = systems[case.system].figures if case.system in systems else None
    plain = [r for r in findings.rows if not r.reference.claim]
    if plain:  # before the figures that show it
        named = {c: findings.settings[c] for c in dict.fromkeys(r.reference.condition for r in plain) if c in findings.settings}
        how = (
            "; ".join(f"{c}: {text}" for c, text in named.items())
            if len(set(named.values())) > 1
            else next(iter(named.values()), "")
        )
        answer.append(generic.range_table("", plain, how, grouped=True))
    if alone and findings.runs:
        about = first_page.document(next(iter(findings.runs.values())), case.document)
        answer = [answer[0], *about, *answer[1:], *first_page.simulated(findings.runs, systems)]
    answer += [Text(result.warnings, "warning")] if result.warnings else []
    sections = [Section(case.title, answer, badge=result.outcome), *map(_claim_section, findings.claims)]
    settings: list[Block] = []
    for label, run in findings.runs.items():
        rows = [r for r in plain if r.reference.condition == label]
        blocks: list[Block] = []
        if run.outcome != "done":
            blocks.append(Text([_ended(run)], "warning"))
        if not rows and (numbers := _summary(run, systems)):
            blocks.append(_all_figures(numbers))
        of_system = special(run, rows) if special and run.outcome == "done" else []
        sections.append(Section(label, [*blocks, *(of_system or generic.time_series(run))], 3))
        settings += [Text([f"{label}: {generic.run_line(run)}"]), *generic.run_blocks(run)]
    studies: list[Block] = [draw_chart(c) if isinstance(c, Chart) else generic.grid_table(c) for c in findings.charts]
    if studies:
        sections.append(Section("Studies", studies, 3))
    if findings.notes:
        sections.append(Section("Notes", [Text(findings.notes, "note")], 3))
    if settings:
        sections.append(Section("Settings", settings, 3))
    return sections


def _claims_table(claims: Sequence[ClaimResult]) -> Cells:
    """One line a claim."""
    rows = [(c.claim.number, c.claim.announced, c.claim.kind, c.rows_met, c.verdict) for c in claims]
    header = ("claim", "announced", "kind", "simulated", "verdict")
    return Cells(
        "Statements of the abstract and their reproduction",
        header,
        rows,
        "The criteria were fixed before the runs. No criterion uses a number from the paper's own tables.",
    )


def _claim_section(result: ClaimResult) -> Section:
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
