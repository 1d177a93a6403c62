"""The parts of `cosimo run` beside the run: the dry run, files, numbers. Loaded when a scene is run."""

from __future__ import annotations

import sys
from pathlib import Path

from ...components.core.errors import BadInput, StepFailed
from ..delivery import DELIVERY
from ..harness.preferred_units import preferred
from ..harness.summary import Summary, pacing_rows, percent, to_json, to_table, verification_text
from ..judgement import advise
from ..judgement.dry_run import NOTHING_PROBED, first_part, lines, not_executed, tables, why_not_executed
from ..output import ensure_directory, write_json, write_table
from ..run.results import HELD, Result
from ..scene.scene import Scene
from ..systems import SYSTEMS, summary
from .common import fail, print_rows, print_table, print_written, warn

NO_ERRORS = "No error estimate."  # why is a warning


def dry_run(scene: Scene, in_process: bool, output: Path | None) -> None:
    """Print what a run would do, and draw the scene into the directory. FMUs that no sandbox holds are not executed for it."""
    closed = not_executed(scene)
    try:
        advice = NOTHING_PROBED if closed else advise(scene, in_process=in_process)
    except StepFailed as error:
        raise fail(error) from None
    coupling = scene.coupling
    for table in tables(scene, coupling):
        print_table(*table)
    for line in lines(scene, coupling, advice, in_process=in_process):
        print(line)
    if closed:
        print(
            f"left out: the stability of the coupling, the cost, and the first part of the run; {why_not_executed(closed)}. "
            "--isolate executes FMUs in a sandbox, for a dry run as well"
        )
        warn(scene.remarks)
    else:
        text, warnings = first_part(scene, advice)
        print(text)
        warn([*scene.remarks, *advice.warnings(scene), *warnings])
    if output is not None:
        print_written([scene.show().save(ensure_directory(output) / "scene.svg")])


def summary_of(result: Result) -> tuple[Summary, list[str]]:
    """The run in numbers, and a remark where [analysis] asks for what a run that reached its end does not have."""
    if not result.held:
        return (), [f"no summary of {result.rows} rows, which are more than memory should hold"]
    try:
        return summary(result), []
    except BadInput as error:
        return pacing_rows(result.info.real_time), [f"no summary: {error}"] if result.outcome == "done" else []


def write(result: Result, numbers: Summary, output: Path) -> list[Path]:
    """Write summary.json and the report beside the run's own files; the paths of all. What cannot be written is a message."""
    from ..harness import report
    from ..harness.validation.case import to_json as to_document
    from ..harness.validation.case import to_table as to_rows
    from ..harness.validation.limits_of_run import judge

    names = ["result.parquet", "result.csv", "run.json"]
    if numbers:
        try:
            write_json(output / "summary.json", to_json(numbers, result.info))
            write_table(output, "summary.csv", *to_table(numbers))
            names += ["summary.json", "summary.csv"]
        except OSError as error:
            print(f"cosimo: no summary.json: {error.strerror or error}", file=sys.stderr)
    if result.rows >= 2 and not result.held:
        print(f"cosimo: no report.html: it is drawn of at most {HELD} numbers, not of {result.rows} rows", file=sys.stderr)
    elif result.rows >= 2:
        if (judged := judge(result, numbers)) is not None:
            (output / "validation.json").write_text(to_document([judged[0]]), encoding="utf-8")
            write_table(output, "validation.csv", *to_rows([judged[0]]))
            names += ["validation.json", "validation.csv"]
        try:
            names.append(report.for_run(result, output, SYSTEMS).name)
            names += ["report.pdf"] if DELIVERY.get().browser else []
        except OSError as error:
            if result.outcome == "done":
                raise
            print(f"cosimo: no report.html: {error.strerror or error}", file=sys.stderr)
    return [output / name for name in names]


def print_limits(result: Result, numbers: Summary) -> bool:
    """Print the rows of the scene's limits, if it has some; whether the run fails one that decides."""
    if result.scene.limits is None:
        return False
    from ..harness.validation.limits_of_run import judge

    judged = judge(result, numbers)
    assert judged is not None
    case = judged[0]
    print_rows(case)
    warn([*case.findings.notes, *case.doubtful])
    print(f"{case.case.title}: {case.verdict}")
    return case.outcome == "failed"


def _signal(result: Result, name: str) -> tuple[str | float, ...]:
    """Name, unit, least, largest and last number of a signal, for a reader."""
    low, high, end = result.extremes(name)
    unit, factor = preferred(result.measures[name], max(abs(low), abs(high)), name)
    return name, unit, low * factor, high * factor, end * factor


def print_result(result: Result, numbers: Summary) -> None:
    """Print the signals, the run in numbers, how far they can be trusted, and what the run took."""
    verification = result.info.verification
    errors = {name: percent(error.rms) for name, error in verification.signals.items()}
    unknown = "not known" if errors else ""
    print_table(
        f"{result.scene.title or result.scene.name}: {result.outcome}",
        ("signal", "unit", "min", "max", "end", "error"),
        [(*_signal(result, name), errors.get(name, unknown)) for name in result.columns if result.rows],
    )
    if numbers:
        print_table(
            "Key results",
            ("name", "unit", "value ± error", "description"),
            [(r.name, r.unit, r.shown, r.text) for r in (row.for_reader() for row in numbers)],
        )
    print(verification_text(verification) if verification.done else NO_ERRORS)
    if (timing := result.info.timing) is None:
        return
    compiling = f", {timing.compile:.3g} s compiling (once)" if timing.compile else ""
    print(f"{timing.simulated:g} s simulated in {timing.run:.3g} s, {timing.start:.3g} s to start{compiling}")
