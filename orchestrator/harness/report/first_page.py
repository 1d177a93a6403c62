"""The first page of a run's report: what was simulated, with which inputs, and who answers for it."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from datetime import date
from fnmatch import fnmatch
from typing import TYPE_CHECKING

from ....components.core.errors import BadInput
from ....fmus.versions import version
from ...scene.names import declared
from ..charts.blocks import Block, Cells, Facts, Signatures
from ..charts.style import number
from ..preferred_units import preferred, written
from .used import in_use

if TYPE_CHECKING:
    from ...run.results import Result
    from ...settings.document import DocumentSettings
    from ..system import Systems

MOST_INPUTS = 12  # of the table; all of them are at the end of the report
SHORT = 60  # letters of a text among the key inputs
NUMERICAL = ("substep", "element", "method")  # ends of names: the errors are about these
_FURTHER = re.compile(r"\[(?!1\])")
Input = tuple[str, str, str]  # unit of the scene with what the input is, value, unit of measure


def blocks(result: Result, systems: Systems) -> list[Block]:
    """The document's data, the simulated objects and their key inputs."""
    return [*document(result, result.scene.document), *simulated({"": result}, systems)]


def document(result: Result, given: DocumentSettings) -> list[Block]:
    """What the report says of itself, with lines to sign on."""
    return [Facts("Document", list(_document(result, given)), beside=True), *signatures(given)]


def simulated(runs: Mapping[str, Result], systems: Systems) -> list[Block]:
    """The simulated objects and their key inputs, those apart in which runs differ; objects are those of the first run."""
    rows = {label: _inputs(result, systems) for label, result in runs.items()}
    first = next(iter(rows))
    common = [row for row in rows[first] if all(row in of for of in rows.values())]
    blocks: list[Block] = [_objects(runs[first])]
    if varied := list(dict.fromkeys(name for of in rows.values() for name, value in of if (name, value) not in common)):
        cells = [(name, *(dict(of).get(name, "") for of in rows.values())) for name in varied]
        blocks.append(Cells("Inputs in which the runs differ", ("input", *rows), cells))
    return [*blocks, *([Facts("Key inputs", common[:MOST_INPUTS], beside=True)] if common else [])]


def signatures(given: DocumentSettings) -> list[Block]:
    """Lines to sign on, of a report that says what it is."""
    return (
        [Signatures((("Prepared by", given.author), ("Checked by", ""), ("Released by", "")))] if given != type(given)() else []
    )


def _document(result: Result, given: DocumentSettings) -> Iterator[tuple[str, str]]:
    for label, text in (
        ("Object", given.object),
        ("Organisation", given.organisation),
        ("Author", given.author),
        ("Number", given.number),
    ):
        if text:
            yield label, text
    yield "Date", given.date or date.today().isoformat()
    packages = result.info.versions or {"cosimo": version("cosimo")}
    yield "Simulated with", f"cosimo {packages.get('cosimo', '')}, scene {result.scene.name}"


def _objects(result: Result) -> Cells:
    """Units of the scene, with the published data that they are made from and the effects that are on."""
    rows = []
    for name, unit in result.info.units.items():
        settings = result.scene.units.get(name)
        model = unit.title or unit.kind
        preset = f"{model}, {settings.preset}" if settings is not None and settings.preset else model
        noted = result.info.effects.get(name)
        rows.append((name, preset, ", ".join(e.replace("_", " ") for e in noted.on) if noted is not None else ""))
    alike: dict[tuple[str, str], list[str]] = {}
    for name, model, effects in rows:
        alike.setdefault((model, effects), []).append(name)
    return Cells(
        "What was simulated",
        ("unit", "model", "effects that are on"),
        [(f"{names[0]} … {names[-1]}" if len(names) > 2 else ", ".join(names), *what) for what, names in alike.items()],
    )


def _inputs(result: Result, systems: Systems) -> list[tuple[str, str]]:
    """The inputs that a reader of the system looks for, then others that the scene gives."""
    system = result.scene.analysis.system
    patterns = systems[system].inputs if system in systems else ()
    rows: dict[Input, list[str]] = {}
    for unit, name, value in sorted(_given(result, patterns), key=lambda one: _rank(one[1], patterns)):
        try:
            known = declared(result.scene, unit)
        except BadInput:  # of a scene that is read back without its files
            known = {}
        variable = known.get(name) or known.get(name.partition("[")[0])
        measure = getattr(variable, "unit", "1") or "1"
        text = getattr(variable, "text", "") or name
        shown, factor = preferred(measure, abs(value), name) if isinstance(value, float) else (written(measure), 1.0)
        cell = number(value * factor) if isinstance(value, float) else _shortened(str(value))
        rows.setdefault((text, cell, shown), []).append(unit)
    return [(f"{text}, {_listed(units)}", f"{value} {unit}".rstrip()) for (text, value, unit), units in rows.items()]


def _shortened(text: str) -> str:
    """A text for a cell: of a whole table its beginning, which has its title."""
    first = text.strip().partition("\n")[0].removeprefix("title = ").strip('"')
    return text if first == text and len(text) <= SHORT else f"{first[:SHORT]} … (whole at the end)"


def _listed(units: list[str]) -> str:
    return ", ".join(units) if len(units) < 3 else f"{units[0]} … {units[-1]}"


def _rank(name: str, patterns: tuple[str, ...]) -> int:
    return next((k for k, pattern in enumerate(patterns) if fnmatch(name, pattern)), len(patterns))


def _given(result: Result, patterns: tuple[str, ...]) -> Iterator[tuple[str, str, float | int | str]]:
    """(unit, parameter, value) of the inputs that are named for the system, or given by the scene; no numerics, no elements
    of arrays behind the first."""
    for unit, record in result.info.units.items():
        settings = result.scene.units.get(unit)
        given = settings.parameters if settings is not None else {}
        values = record.parameters or given
        for name in in_use(result.scene, unit, values):
            value = values[name]
            wanted = name in given or _rank(name, patterns) < len(patterns)
            if wanted and not name.endswith(NUMERICAL) and not isinstance(value, bool) and not _FURTHER.search(name):
                yield unit, name, value
