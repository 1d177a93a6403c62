"""Cases of users: a scene of theirs, against ranges and measured curves of theirs."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from importlib.util import find_spec, module_from_spec, spec_from_file_location
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from ....components.core.errors import BadInput, nearest, pick
from ...loading import loading
from ...scene.files import read_toml
from ...scene.measured import read_curve, units_of
from ...settings.case import COMPARED, CaseSettings, CurveSettings
from ...settings.chart import ChartSettings
from ...settings.messages import one_message
from ..half_answers import half_answers
from ..studies.quantities import recording
from .case import Case, Row, compare
from .curves import CurveComparison, compare_curve
from .limits_of_run import judge, named_numbers
from .questions import Evidence, Question, Runs
from .reference import TableRow, rows_of, table_rows

if TYPE_CHECKING:
    from ...run.results import Result
    from ...scene.scene import Scene
    from ..charts.chart import Chart
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
    function = _function(settings.measure, path.parent, name) if settings.measure else None
    whole = settings.charts or function  # what looks at all runs at once
    ranges = {key: r for r in rows for key in (r.measure, f"{r.condition}: {r.measure}")}
    recorded = {
        c: _recording(one, [r for r in rows if r.condition == c], [v for v in curves if v.condition == c], settings.charts)
        for c, one in scenes.items()
    }
    measure = partial(_measure, function, rows, curves, settings.sources, path.parent, summarize)
    questions = [
        Question(measure, partial(dict, {c: recorded[c] for c in group}), charts=settings.charts, rows=partial(dict, ranges))
        for group in ([list(scenes)] if whole else [[condition] for condition in scenes])
    ]
    text = settings.text or f"The scene {settings.scene} against the ranges and curves of {path.name}."
    document = settings.document if settings.document.model_fields_set else scene.document
    return Case(name, settings.title, text, tuple(questions), system=scene.analysis.system, document=document)


def _in_run(row: TableRow, scenes: dict[str, Scene], where: str) -> TableRow:
    """A row whose condition is one of the runs."""
    pick(row.condition, scenes, where, "the condition of a run", "condition")
    return row


def _check_curve(curve: CurveSettings, settings: CaseSettings, scenes: dict[str, Scene], folder: Path, name: str) -> None:
    where = f"{name}, curve {curve.file}"
    for what, value, known in (("condition", curve.condition, scenes), ("source", curve.source, settings.sources)):
        if value not in known:
            raise BadInput(where, f"{what} {value!r}", f"a {what} of the case", nearest(value, known))
    for kind, share in curve.tolerances.items():
        if share >= 1.0 and kind != "difference":
            raise BadInput(where, f"tolerance of {kind} = {share:g}", "a share below 1", "5 % is written 0.05.")
        pick(kind, COMPARED, where, "one of " + ", ".join(COMPARED), "tolerance of")
    read_curve(curve, folder, units_of(scenes[curve.condition]))


def _function(text: str, folder: Path, name: str) -> Callable[[Runs], Mapping[str, Any]]:
    """The function that measures, of a module beside the case or of an installed one."""
    module, _, function = text.partition(":")
    with loading(f"{name}: measure", "module:function of a module that can be imported"):
        beside = folder / f"{module}.py"
        spec = spec_from_file_location(module, beside) if beside.is_file() else find_spec(module)
        if spec is None or spec.loader is None:
            raise BadInput(f"{name}: measure", repr(text), f"module:function, of {beside} or of an installed module")
        loaded = module_from_spec(spec)
        spec.loader.exec_module(loaded)
    known = {n: f for n, f in vars(loaded).items() if callable(f)}
    return pick(function, known, f"{name}: measure", f"a function of {module}")


def _recording(scene: Scene, rows: Sequence[TableRow], curves: Sequence[CurveSettings], charts: Sequence[ChartSettings]) -> Scene:
    """The scene with what its rows, curves and charts need among its recorded signals; checks the signals."""
    lines = [line for chart in charts for panel in chart.panels for line in panel.series]
    overs = [line.over for chart in charts for line in (chart, *chart.panels)]
    overs += [s for line in lines for s in (line.signal, line.over)] + [s for curve in curves for s in (curve.signal, curve.over)]
    needed = [s for s in overs if s not in ("", "time")]
    recorded = [".".join(end) for end in scene.coupling.signals]
    if missing := [s for s in dict.fromkeys(needed) if s not in recorded]:
        scene = scene.with_changes({"record.signals": [*recorded, *missing]})
    kinds = [r.measure for r in rows if "," in r.measure]
    return recording(scene.with_changes({"study.quantities": kinds})) if kinds else scene


def _measure(
    function: Callable[[Runs], Mapping[str, Any]] | None,
    rows: tuple[TableRow, ...],
    curves: tuple[CurveSettings, ...],
    sources: dict[str, str],
    folder: Path,
    summarize: Summarize,
    runs: Runs,
) -> Evidence:
    """Of each run its rows beside the numbers of its summary and of the case's function, its curves beside the measured ones."""
    own = function(runs) if function is not None else {}
    own_rows: list[Row] = []
    charts: list[Chart] = []
    notes: list[str] = []
    doubts: list[str] = []
    figures: dict[str, float] = {}
    for condition, result in runs.items():
        mine = [r for r in rows if r.condition == condition]
        numbers, given = summarize(result), own.get(condition, own)
        figures |= {f"{condition}: {n.name}": n.value for n in numbers} | {n.name: n.value for n in numbers if len(runs) == 1}
        of_function = {r.measure: given[r.measure] for r in mine if r.measure in given}
        named = named_numbers([r for r in mine if r.measure not in of_function], result, numbers)
        own_rows += compare(tuple(mine), {**named, **of_function})
        comparisons = [
            compare_curve(curve, read_curve(curve, folder, result.measures), result)
            for curve in curves
            if curve.condition == condition
        ]
        own_rows += [row for c in comparisons for row in _curve_rows(c, sources[c.curve.source])]
        charts += [c.chart() for c in comparisons]
        judged = judge(result, numbers)
        doubts += [f"{condition}: {text}" for text in judged[0].findings.doubts] if judged else []
        for row in judged[0].findings.rows if judged else ():
            label = ": ".join(filter(None, (condition, row.reference.condition)))
            own_rows.append(replace(row, reference=replace(row.reference, condition=label)))
        doubts += [f"{condition}: {c.alone}" for c in comparisons if c.alone]
        asked = [r.measure for r in mine if r.measure not in of_function]
        doubts += [f"{condition}: {text}" for text in half_answers(result, asked, numbers)]
        uncompared = [c.counted for c in comparisons if c.incomplete]
        texts = (*result.info.warnings, *uncompared, *(judged[0].findings.notes if judged else ()))
        notes += [f"{condition}: {text}" for text in texts]
    return Evidence(
        rows=tuple(own_rows), charts=tuple(charts), shown=runs, notes=tuple(notes), doubts=tuple(doubts), data={**figures, **own}
    )


def _curve_rows(comparison: CurveComparison, source: str) -> list[Row]:
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
