"""accuracy.csv: the points of an accuracy study, one row each, and what is known of the measurement in every row.

A table that ships has no times: errors and counted work are the same on every machine, seconds are not.
"""

from __future__ import annotations

import csv
import json
from collections.abc import Iterable, Mapping
from io import StringIO
from math import isnan, nan
from pathlib import Path
from typing import Any

from ....components.core.errors import BadInput
from ...output import write_table
from .accuracy import Accuracy, Point
from .trial import WORK

COLUMNS = {  # of a point: field -> column
    "series": "series",
    "axis": "axis",
    "size": "size, s or tolerance",
    "outcome": "outcome",
    "reason": "reason",
    "error": "error",
    "error_with_finer": "error with finer settings",
    "largest": "largest distance",
    "seconds": "CPU time, s",
    "median": "median CPU time, s",
    "scatter": "scatter of the CPU time",
}
TIMES = ("seconds", "median", "scatter")
NUMBERS = ("size", "error", "error_with_finer", "largest", *TIMES)
ABOUT = {
    "reference": "reference",
    "second_solution": "second solution",
    "shares": "shared with the reference",
    "machine": "machine",
    "versions": "versions",
}
ERROR_OF = "error of "
AGREEMENT, MESH = "agreement of the reference", "mesh error of the reference"  # series of the last two rows


def write_points(measured: Accuracy, directory: str | Path, name: str = "accuracy.csv", *, times: bool = True) -> Path:
    """Write the table and return its path; `times`: with CPU times, and the machine that they were measured on.

    The last two rows, of the series "agreement of the reference" and "mesh error of the reference", have these of each quantity
    in the place of its error.
    """
    names = list(measured.agreement)
    columns = {key: column for key, column in COLUMNS.items() if times or key not in TIMES}
    about = {column: getattr(measured, key) for key, column in ABOUT.items() if times or key != "machine"}
    about |= dict(measured.marks)
    header = [*columns.values(), "changes", *WORK, *(ERROR_OF + n for n in names), *about]
    rows = [
        [
            *(_rounded(getattr(p, key)) for key in columns),
            json.dumps(p.changes),
            *(p.work.get(n, "") for n in WORK),
            *(_rounded(p.errors.get(n, nan)) for n in names),
            *about.values(),
        ]
        for p in measured.points
    ]
    blank = ["" for _ in range(len(columns) - 1)]
    for series, values in ((AGREEMENT, measured.agreement), (MESH, measured.mesh_error)):
        numbers = (_rounded(values.get(n, 0.0)) for n in names)
        rows.append([series, *blank, "{}", *("" for _ in WORK), *numbers, *about.values()])
    return write_table(directory, name, header, rows)


def _rounded(value: Any) -> Any:
    return float(f"{value:.6g}") if isinstance(value, float) else value


def read_points(path: Path, text: str | None = None) -> Accuracy:
    """What `write_points` wrote, its text if it is at hand; raises `BadInput` for a file that is none of these."""
    try:
        rows = list(csv.DictReader(StringIO(path.read_text(encoding="utf-8") if text is None else text, newline="")))
        (agreement,), (mesh,) = ([r for r in rows if r["series"] == series] for series in (AGREEMENT, MESH))
        names = [c.removeprefix(ERROR_OF) for c in agreement if c.startswith(ERROR_OF)]
        points = tuple(_point(r, names) for r in rows if r["series"] not in (AGREEMENT, MESH))
        known = {*COLUMNS.values(), "changes", *WORK, *(ERROR_OF + n for n in names), *ABOUT.values()}
        marks = {c: text for c, text in agreement.items() if c not in known}
        numbers = [{n: float(row[ERROR_OF + n]) for n in names} for row in (agreement, mesh)]
        about = {key: agreement.get(column, "") for key, column in ABOUT.items()}
    except (OSError, ValueError, KeyError, TypeError, AttributeError, csv.Error) as error:
        raise BadInput(
            str(path),
            f"no table of accuracy ({type(error).__name__}: {error})",
            "one that cosimo accuracy wrote",
            "Remove it and measure again.",
        ) from None
    return Accuracy(path.stem, path.stem, points, agreement=numbers[0], mesh_error=numbers[1], marks=marks, **about)


def _point(row: Mapping[str, str], names: Iterable[str]) -> Point:
    fields: dict[str, Any] = {
        key: float(row[column]) if key in NUMBERS else row[column] for key, column in COLUMNS.items() if column in row
    }
    return Point(
        **fields,
        changes=json.loads(row["changes"]),
        work={n: int(row[n]) for n in WORK if row[n]},
        errors={n: v for n in names if not isnan(v := float(row[ERROR_OF + n]))},
    )
