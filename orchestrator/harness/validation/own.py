"""Cases of users: a scene of theirs, against ranges and measured curves of theirs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from pydantic import ValidationError

from ....components.core.errors import BadInput, nearest
from ...scene.files import read_toml
from ...settings.case import COMPARED, CaseSettings, CurveSettings
from ...settings.messages import one_message
from ..studies.quantities import recording
from .case import Case, Row, compare
from .curves import Comparison, compare_curve, read_curve, units_of
from .limits_of_run import judge, named_numbers, with_limits
from .questions import Evidence, Question, Runs
from .reference import TableRow, rows_of, table_rows

if TYPE_CHECKING:
    from ...run.results import Result
    from ...scene.scene import Scene
    from ..summary import Summary

Loader = Callable[[str | Path], "Scene"]
Summarize = Callable[["Result"], "Summary"]


def read_case(path: Path, load_scene: Loader, summarize: Summarize) -> Case:
    """The case of a TOML file, checked with its scene, changes and curves before anything runs; faults are one `BadInput`."""
    if not path.is_file():
        raise BadInput("case", repr(str(path)), "the file of a case, or the name of one that cosimo list cases shows")
    name = path.stem
    try:
        settings = CaseSettings.model_validate(read_toml(path, "case"))
    except ValidationError as error:
        raise one_message(error, CaseSettings, name) from None
    given = rows_of(name, {"rows": settings.rows}, path.parent)
    if not (given or settings.curves or settings.limits):
        raise BadInput(
            name, "neither rows nor curves", '[[rows]], rows = "FILE.csv", [[curves]] or limits = "TABLE" to compare with'
        )
    if (given or settings.curves) and not settings.sources:
        raise BadInput(name, "no sources", 'sources = { name = "where ranges and curves come from" }')
    beside = path.parent / settings.scene
    scene = load_scene(beside if beside.suffix else settings.scene)
    if settings.limits is not None:
        table = settings.limits.table
        place = str((path.parent / table).resolve()) if table.endswith(".toml") else table
        scene = scene.with_changes({"limits": {"table": place, "conditions": settings.limits.conditions}})
        scene = with_limits(scene)
    conditions = [r.condition for r in settings.runs]
    if twice := [c for c in dict.fromkeys(conditions) if conditions.count(c) > 1]:
        raise BadInput(f"{name}: runs", f"condition {twice[0]!r} twice", "a condition of its own for each run")
    scenes = {r.condition: scene.with_changes(r.changes) for r in settings.runs} or {scene.name: scene}
    only = next(iter(scenes)) if len(scenes) == 1 else ""  # what rows and curves without a condition are of
    rows = tuple(
        _in_run(r, scenes, f"{name}, row {i}")
        for i, r in enumerate(table_rows(name, [{"condition": only, **r} for r in given], settings.sources), 1)
    )
    curves = tuple(c.model_copy(update={"condition": c.condition or only}) for c in settings.curves)
    for curve in curves:
        _check_curve(curve, settings, scenes, path.parent, name)
    questions = []
    for condition, one in scenes.items():
        mine, drawn = tuple(r for r in rows if r.condition == condition), tuple(c for c in curves if c.condition == condition)
        measure = partial(_measure, condition, mine, drawn, settings.sources, path.parent, summarize)
        questions.append(Question(measure, partial(dict, {condition: _recording(one, mine, drawn)})))
    text = settings.text or f"The scene {settings.scene} against the ranges and curves of {path.name}."
    return Case(name, settings.title, text, tuple(questions), system=scene.analysis.system)


def _in_run(row: TableRow, scenes: dict[str, Scene], where: str) -> TableRow:
    """A row whose condition is one of the runs."""
    if row.condition not in scenes:
        raise BadInput(where, f"condition {row.condition!r}", "the condition of a run", nearest(row.condition, scenes))
    return row


def _check_curve(curve: CurveSettings, settings: CaseSettings, scenes: dict[str, Scene], folder: Path, name: str) -> None:
    where = f"{name}, curve {curve.file}"
    for what, value, known in (("condition", curve.condition, scenes), ("source", curve.source, settings.sources)):
        if value not in known:
            raise BadInput(where, f"{what} {value!r}", f"a {what} of the case", nearest(value, known))
    for kind, share in curve.tolerances.items():
        if share >= 1.0 and kind != "difference":
            raise BadInput(where, f"tolerance of {kind} = {share:g}", "a share below 1", "5 % is written 0.05.")
        if kind not in COMPARED:
            raise BadInput(where, f"tolerance of {kind!r}", "one of " + ", ".join(COMPARED), nearest(kind, COMPARED))
    read_curve(curve, folder, units_of(scenes[curve.condition]))


def _recording(scene: Scene, rows: tuple[TableRow, ...], curves: tuple[CurveSettings, ...]) -> Scene:
    """The scene with what its rows and curves need among its recorded signals; checks the signals."""
    needed = [s for c in curves for s in (c.signal, c.over) if s]
    recorded = [".".join(end) for end in scene.coupling.signals]
    if missing := [s for s in dict.fromkeys(needed) if s not in recorded]:
        scene = scene.with_changes({"record.signals": [*recorded, *missing]})
    kinds = [r.measure for r in rows if "," in r.measure]
    return recording(scene.with_changes({"study.quantities": kinds})) if kinds else scene


def _measure(
    condition: str,
    rows: tuple[TableRow, ...],
    curves: tuple[CurveSettings, ...],
    sources: dict[str, str],
    folder: Path,
    summarize: Summarize,
    runs: Runs,
) -> Evidence:
    """Of the run of a condition: its rows beside the numbers of its summary, its curves beside the measured ones."""
    result = runs[condition]
    numbers = summarize(result)
    comparisons = [compare_curve(curve, read_curve(curve, folder, result.measures), result) for curve in curves]
    curve_rows = (row for c in comparisons for row in _curve_rows(c, sources[c.curve.source]))
    judged = judge(result, numbers)
    limit_rows = (
        replace(row, reference=replace(row.reference, condition=": ".join(filter(None, (condition, row.reference.condition)))))
        for row in (judged[0].findings.rows if judged else ())
    )
    uncompared = [c.counted for c in comparisons if c.incomplete]
    notes = (*result.info["warnings"], *uncompared, *(judged[0].findings.notes if judged else ()))
    return Evidence(
        rows=(*compare(rows, named_numbers(rows, result, numbers)), *curve_rows, *limit_rows),
        charts=tuple(c.chart() for c in comparisons),
        shown=runs,
        notes=tuple(f"{condition}: {note}" for note in notes),
    )


def _curve_rows(comparison: Comparison, source: str) -> list[Row]:
    """A row for every tolerance of a curve: the simulated number in the range about the measured one."""
    curve = comparison.curve
    rows = []
    for kind, tolerance in curve.tolerances.items():
        measured, simulated, size = comparison.numbers[kind]
        half = tolerance * size
        low, high = (None, half) if kind == "difference" else (measured - half, measured + half)
        quantity = f"{curve.signal}: {'root mean square difference' if kind == 'difference' else kind}"
        row = TableRow(
            quantity,
            f"{curve.file} {kind}",
            curve.condition,
            comparison.unit or "1",
            low,
            high,
            "measured",
            f"{source} ({curve.file}, {100.0 * tolerance:g} %)",
        )
        rows.append(Row(row, simulated))
    return rows
