"""Droppers of a line as a CSV table: the one that `cosimo railway line` writes for a crew, or one's own, read back.

With it a line has just its droppers. A row is one dropper: its position, and the wanted height of the contact wire there or the
cut length.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, replace
from typing import Any

from ...core.columns import table_of
from ...core.errors import BadInput
from .from_table import Resolved, resolved_sections
from .table import Dropper, Line, checked_number, read_line

OF_SECOND = "second "  # before the wire that the droppers of an auxiliary wire hang from, in every second section


def column_names() -> dict[str, str]:
    """Key of `Dropper` -> name of its column, with the unit."""
    return {
        f.name: f.name.replace("_", " ") + (f" [{unit}]" if (unit := f.metadata.get("unit", "1")) != "1" else "")
        for f in fields(Dropper)
    }


def line_of(values: Mapping[str, Any], where: str = "line") -> Line:
    """The line of parameters of `Catenary`: its table, and the droppers of `line_table.droppers` if there are some."""
    line = read_line(str(values["line_table.table"]), f"{where}: line_table.table")
    droppers = str(values.get("line_table.droppers", ""))
    return with_droppers(line, droppers, f"{where}: line_table.droppers") if droppers else line


def with_droppers(line: Line, text: str, where: str) -> Line:
    """The line with the droppers of a CSV table in the place of its own."""
    rows = _rows(text, where)
    sections = [_with_rows(s, i, rows) for i, s in enumerate(resolved_sections(line))]
    if rows:
        place, row = next(iter(rows.items()))
        above = f" that hangs from {row.hangs_from!r}" if row.hangs_from else ""
        raise BadInput(
            f"{where}, line {place}",
            f"a dropper of contact wire {row.contact_wire or 1:g} at {row.position:g} m{above}",
            "a place inside a span with that wire",
            "Positions count from the first support of the line.",
        )
    return replace(line, sections=tuple(sections))


def _with_rows(s: Resolved, index: int, rows: dict[int, Dropper]) -> Any:
    """A section with its spans one by one, each with its rows, which are taken out of `rows`."""
    spans = []
    twin, compound = s.section.second_contact_wire.tension is not None, s.section.auxiliary.tension is not None
    wires, beside = (1.0, 2.0) if twin else (1.0 + index % 2,), OF_SECOND if index % 2 else ""

    def within(row: Dropper) -> Dropper | None:
        """A row as the section's table has it, or None where it is one of another section."""
        if compound and row.contact_wire is None and row.hangs_from in (beside + "messenger", beside + "stitch"):
            return replace(row, hangs_from=row.hangs_from.removeprefix(beside))
        if (row.contact_wire or 1.0) not in wires or row.hangs_from.startswith(OF_SECOND):
            return None
        return replace(row, contact_wire=row.contact_wire if twin else 1.0 if compound else None)

    for a, b, span in zip(s.x[:-1], s.x[1:], s.spans, strict=True):
        own = []
        for place, row in list(rows.items()):
            if a < row.position < b and (mine := within(row)) is not None:
                del rows[place]
                own.append(replace(mine, position=row.position - float(a)))
        own.sort(key=lambda row: row.position)
        spans.append(
            replace(span, dropper_list=tuple(own), positions=None, second_positions=None, main_positions=None, heights=None)
        )
    return replace(s.section, spans=tuple(spans), span=type(s.section.span)())


def _rows(text: str, where: str) -> dict[int, Dropper]:
    """Number of the line in the text -> dropper."""
    table = table_of(text, where)
    kinds = {f.name.replace("_", " "): f for f in fields(Dropper)}
    table.only(kinds, "a column of droppers")
    columns: dict[str, Any] = {}
    for name, f in kinds.items():
        if f.metadata["kind"] == "words":
            columns |= {f.name: table.texts(name)} if table.place(name) is not None else {}
        elif name == "position" or table.place(name) is not None:
            columns[f.name] = table.numbers(name, f.metadata["unit"], asked=True)
    rows: dict[int, Dropper] = {}
    for i, (line, _) in enumerate(table.rows):
        given = {key: values[i] for key, values in columns.items()}
        rows[line] = _dropper({key: v for key, v in given.items() if v != "" and v == v}, f"{where}, line {line}")
    if not rows:
        raise BadInput(where, "no row", "a header, then a row for each dropper")
    return rows


def _dropper(given: dict[str, Any], where: str) -> Dropper:
    values: dict[str, Any] = {
        f.name: given[f.name]
        if f.metadata["kind"] == "words"
        else checked_number(f.metadata, float(given[f.name]), f"{where}, {f.name.replace('_', ' ')}")
        for f in fields(Dropper)
        if f.name in given
    }
    if "position" not in values:
        raise BadInput(where, "no position", "that of the dropper along the line, m")
    return Dropper(**values)
