"""Recorded signals as files of other programs: CSV of a dialect, a workbook (.xlsx), MAT 5 (.mat)."""

from __future__ import annotations

import csv
import re
from collections.abc import Callable, Iterable, Iterator
from math import isfinite
from pathlib import Path
from typing import IO, Any

import numpy as np

from ...components.core.errors import BadInput, visible
from ...components.core.store import replaced
from ..output import not_written
from . import Recorded
from .data import library

SEPARATORS, DECIMALS = (",", ";", "\t"), (".", ",")
SHEET_ROWS, SHEET_COLUMNS = 1_048_576, 16_384  # of a sheet, with header and times (specifications and limits of Excel)
MAT_BYTES = 2**31  # of a variable of MAT 5
MAT_NAME = 63  # characters that MATLAB reads of a name
COMMAS = 'Decimal commas need semicolons between the cells: --separator ";" --decimal ",".'


def export(
    result: Recorded, path: str | Path, signals: str | Iterable[str] | None = None, separator: str = ",", decimal: str = "."
) -> Path:
    """Write signals over time into `path`, in the format of its ending; returns the path.

    Headers have the units of measure, as in "arm.angle [rad]", so that a scene reads the file as signals. Numbers keep every bit.
    separator: of cells, "," or ";" or a tab; decimal: sign of decimals, "." or ",": both of CSV only. A workbook leaves the cell of
    a number that is not finite empty. MAT 5: "arm.angle" is the variable arm_angle, an array a matrix with a row for each time,
    some of its elements a variable each, and the struct `units` has their units. Raises `BadInput` for another ending, an unknown
    signal, a dialect that cannot be read again, more than the format holds, and where nothing can be written.
    """
    path = Path(path)
    writer = WRITERS.get(path.suffix.lower())
    if writer is None:
        raise BadInput("export", repr(path.name), f"a name that ends in {', '.join(WRITERS)}", "result.parquet is there already.")
    if separator not in SEPARATORS or decimal not in DECIMALS or separator == decimal:
        dialect = f"separator {separator!r}, decimal sign {decimal!r}"
        raise BadInput("export", dialect, "two different signs: , ; or a tab, and . or ,", COMMAS)
    if (separator, decimal) != (",", ".") and writer is not _csv:
        raise BadInput("export", f"a dialect for {path.name!r}", "one for .csv only", "Leave out --separator and --decimal.")
    names = result.signals(signals)
    try:
        with replaced(path, "wb") as file:
            writer(file, result, names, separator, decimal)
    except OSError as error:
        raise not_written(path.parent, error) from None
    return path


def _titles(result: Recorded, names: list[str]) -> list[str]:
    measures = [result.measures.get(n, "") for n in names]
    return ["time [s]", *(f"{n} [{u}]" if u and n in result.columns else n for n, u in zip(names, measures, strict=True))]


def _rows(result: Recorded, names: list[str]) -> Iterator[tuple[Any, ...]]:
    yield from zip(*(column.tolist() for column in (result.time, *(result[n] for n in names))), strict=True)


def _csv(file: IO[bytes], result: Recorded, names: list[str], separator: str, decimal: str) -> None:
    from io import TextIOWrapper

    def number(value: Any) -> str:
        return repr(value).replace(".", decimal) if isinstance(value, float) else value

    text = TextIOWrapper(file, "utf-8", newline="")
    table = csv.writer(text, delimiter=separator, lineterminator="\n")
    table.writerow(_titles(result, names))
    table.writerows(map(number, row) for row in _rows(result, names))
    text.detach()  # writes what it holds, and leaves the file open


def _xlsx(file: IO[bytes], result: Recorded, names: list[str], *_: str) -> None:
    if result.rows >= SHEET_ROWS:
        raise BadInput("export", f"{result.rows} rows", f"at most {SHEET_ROWS - 1} of a sheet", "Write .csv or .mat.")
    if len(names) >= SHEET_COLUMNS:
        raise BadInput("export", f"{len(names)} signals", f"at most {SHEET_COLUMNS - 1} of a sheet", "Name some, or write .csv.")
    book = library("openpyxl", "export").Workbook(write_only=True)
    from openpyxl.cell import WriteOnlyCell

    sheet = book.create_sheet(re.sub(r"[\\/*?:\[\]]", "-", result.scene.name or "signals")[:31])  # names of sheets have no others
    sheet.freeze_panes = "B2"

    def text(value: str) -> Any:  # "=1+1" of foreign code is no formula
        cell = WriteOnlyCell(sheet, visible(value))
        cell.data_type = "s"
        return cell

    sheet.append([*map(text, _titles(result, names))])
    for row in _rows(result, names):
        sheet.append([text(v) if isinstance(v, str) else v if isfinite(v) else None for v in row])
    book.save(file)


def _mat(file: IO[bytes], result: Recorded, names: list[str], *_: str) -> None:
    from scipy.io import savemat

    arrays = dict[str, list[str]]()
    for name in names:
        arrays.setdefault(name.partition("[")[0], []).append(name)
    for array, elements in [*arrays.items()]:  # some elements, or in another order, would be columns that nobody can tell apart
        if elements not in ([array], [f"{array}[{k}]" for k in range(1, 1 + len(elements))]):
            del arrays[array]
            arrays |= {name: [name] for name in elements}
    content, units, source = dict[str, Any](time=result.time), {"time": "s"}, {"time": "time"}
    for array, elements in arrays.items():
        name = re.sub(r"\W", "_", array.removesuffix("]"), flags=re.ASCII)[:MAT_NAME]
        if name in source:
            raise BadInput(
                "export", f"{array} and {source[name]}, both {name} in MATLAB", "different names", "Export one of both."
            )
        columns = [result[n] for n in elements]
        if result.rows * len(columns) * 8 >= MAT_BYTES:
            raise BadInput("export", f"{array} of {result.rows} rows", "less than 2 GB for each variable of MAT 5", "Write .csv.")
        content[name] = columns[0] if elements == [array] else np.column_stack(columns)
        units[name], source[name] = result.measures.get(elements[0], ""), array
    savemat(file, {**content, "units": units}, long_field_names=True, oned_as="column")


WRITERS: dict[str, Callable[..., None]] = {".csv": _csv, ".xlsx": _xlsx, ".mat": _mat}
