"""Parameters of a component from a row of a table of the trade: a catalogue of bearings, a data sheet of motors, masses of a walker.

designation;Z;Dw [mm];Dpw [mm];C [kN]        columns: names of parameters, or the symbols that the component says (`symbols`)
6306;8;11,9;51;28,1                          of several rows the first column names the one that is meant
"""

from __future__ import annotations

import re
from collections.abc import Collection
from typing import Any

from ...components.core.columns import EMPTY, Columns, read_table
from ...components.core.component import Component
from ...components.core.errors import BadInput, counted, nearest
from ...components.core.variables import Causality, Kind

FILE = re.compile(r"(.+\.(?:csv|tsv|txt))(?::(.*))?", re.IGNORECASE)


def names_a_file(text: str) -> bool:
    """Whether a preset is "file.csv" or "file.csv:row", and not one of the component's own."""
    return FILE.fullmatch(text) is not None


def sheet_parameters(text: str, cls: type[Component], on: Collection[str]) -> tuple[dict[str, Any], list[str]]:
    """({parameter: value in its unit}, remarks on what was set aside or kept) of "file.csv" or "file.csv:row"; on: effects.

    Raises `BadInput` for a file without such a row, and for a number whose unit is not said.
    """
    matched = FILE.fullmatch(text)
    assert matched is not None
    table = read_table(matched[1], "--preset")
    k = _row(table, (matched[2] or "").strip())
    values: dict[str, Any] = {}
    unknown, without = [], []
    for written in table.names:
        name = cls.symbols.get(written, written)
        known = cls.variables.get(name.partition("[")[0])
        effect = name.rpartition(".")[0]
        if known is None or known.causality is not Causality.PARAMETER:
            unknown += [written] if written != table.names[0] else []
        elif table.texts(written)[k].lower() in EMPTY:
            continue
        elif effect and effect not in on:
            without.append(f"{written} ({effect})")
        elif name in values:
            raise BadInput(table.where, f"{name} twice", "each parameter once")
        else:
            given = (
                table.texts(written) if known.kind in (Kind.TEXT, Kind.CHOICE) else table.numbers(written, known.unit, asked=True)
            )
            value = given[k] if isinstance(given[k], str) else float(given[k])
            values[name] = int(value) if known.kind is Kind.INTEGER and value == int(value) else value
    if not values:
        raise BadInput(table.where, "no column that is a parameter", f"parameters of {cls.__name__}", nearest("", cls.symbols))
    kept = [name for name in cls.symbols.values() if "." not in name and name not in values]
    noted = {
        f"no parameters of {cls.__name__}": unknown,
        "set aside, as their effects are off": without,
        "not in the row, so they stay as they were": kept,
    }
    return values, [f"{text}: {what}: {', '.join(names)}" for what, names in noted.items() if names]


def _row(table: Columns, wanted: str) -> int:
    if not wanted and len(table.rows) == 1:
        return 0
    named = table.texts(table.header[0])
    if named.count(wanted) != 1:
        actual = f"{counted(len(named), 'row')}" if not wanted else f"{counted(named.count(wanted), 'row')} {wanted!r}"
        raise BadInput(
            table.where, actual, "one row", f"Write {table.where}:{named[0] if named else 'row'}. " + nearest(wanted, named)
        )
    return named.index(wanted)
