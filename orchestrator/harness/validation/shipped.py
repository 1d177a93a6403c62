"""Cases that come with cosimo: a TOML file, the rows of its table, and modules with what cannot be said as data."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ....components.core.errors import BadInput
from ...scene.files import read_toml
from ...settings.case import QuestionSettings, ShippedCaseSettings
from ...settings.chart import ChartSettings
from ...settings.messages import validated
from .case import Case
from .limits_of_run import named_numbers
from .questions import Evidence, Question, Runs
from .reference import TableRow, load_table, table_files

if TYPE_CHECKING:
    from ...scene.scene import Scene

LoadScene = Callable[..., "Scene"]


def shipped_cases(package: str, system: str, load_scene: LoadScene) -> Iterator[Case]:
    """The cases of a system's folder, by name. package: of the system.  Modules are imported when a case is run."""
    folder = Path(str(import_module(package).__file__)).parent / "cases"
    for path in sorted(folder.glob("*.toml")):
        yield read_shipped(path, f"{package}.cases", system, load_scene)


def read_shipped(path: Path, package: str, system: str, load_scene: LoadScene) -> Case:
    """One case. package: of its modules.  Raises `BadInput` for what the file says and should not."""
    settings = validated(ShippedCaseSettings, read_toml(path, "table", "case"), path.stem)
    names = [q.measure for q in settings.questions]
    for chart in settings.charts:
        if chart.question not in names and (chart.question or len(names) > 1):
            raise BadInput(f"{path.stem}: chart {chart.title!r}", f"question {chart.question!r}", "one of " + ", ".join(names))
    asked = [(q, _question(q, settings.charts, package, path.stem, load_scene)) for q in settings.questions]
    questions = tuple(question for q, question in asked if not q.study)
    studies = tuple(question for q, question in asked if q.study)
    return Case(path.stem, settings.title, settings.text, questions, studies, system)


def _question(q: QuestionSettings, charts: Sequence[ChartSettings], package: str, name: str, load_scene: LoadScene) -> Question:
    return Question(
        partial(_measure, package, q) if q.measure else partial(_summarized, name),
        partial(_scenes, package, q, load_scene),
        q.may_fail,
        q.in_process,
        q.at_its_steps,
        q.claim,
        tuple(c for c in charts if c.question in ("", q.measure)),
        q.notes,
        q.show,
        partial(_rows, name),
    )


def _rows(name: str) -> dict[str, TableRow]:
    """Rows by "measure" and "condition: measure" of the case's table, and by "table: condition: measure" of all."""
    tables = {table: load_table(table).rows for table in table_files()}
    own = tables.get(name, ())
    named = {f"{table}: {r.condition}: {r.measure}": r for table, rows in tables.items() for r in rows}
    return named | {f"{r.condition}: {r.measure}": r for r in own} | {r.measure: r for r in own}


def _function(package: str, text: str, default: str) -> Any:
    """A function of a module of the package; None where a module without a function named has none of the default's name."""
    module, _, name = text.partition(":")
    loaded = import_module(f"{package}.{module}")
    return getattr(loaded, name) if name else getattr(loaded, default, None)


def _measure(package: str, q: QuestionSettings, runs: Runs) -> Evidence | Mapping[str, Any]:
    return _function(package, q.measure, "measure")(runs, **q.arguments)


def _summarized(name: str, runs: Runs) -> Mapping[str, Mapping[str, float]]:
    """Of each run whose label is a condition of the table the numbers of its summary."""
    rows = {label: [r for r in load_table(name).rows if r.condition == label] for label in runs}
    return {label: named_numbers(of, runs[label], runs[label].summary) for label, of in rows.items() if of}


def _scenes(package: str, q: QuestionSettings, load_scene: LoadScene) -> Mapping[Any, Scene]:
    if isinstance(q.scenes, dict):
        return {label: load_scene(s) if isinstance(s, str) else load_scene(s.scene, s.changes) for label, s in q.scenes.items()}
    given = _function(package, q.scenes or q.measure, "scenes") if q.scenes or ":" not in q.measure else None
    return given() if given is not None else {}
