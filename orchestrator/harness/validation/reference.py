"""Reference tables: ranges as data, each row with its provenance and its source, and rows beside what was measured.

A table is two files: `NAME.csv` with a row a line, and `NAME.toml`, that of its case, with its sources in words.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

from ....components.core.columns import Columns, read_table, table_of
from ....components.core.errors import BadInput, nearest, pick
from ...scene.files import shipped
from ...settings.ranges import OLD_STANDINGS, Range
from ..summary import with_errors_of
from .claims import CONSTRUCTION, ROLES, Claim, read_claims

STANDINGS = {
    "verbatim": "read in a public source",
    "measured": "measured, and given by the user with the case",
    "computed": "computed with an independent solver or a closed form",
    "inferred": "inferred from public material",
    "unconfirmed": "quoted from memory, not read again",
    "missing": "no range yet",
}
MISSING = "missing"  # standing of a row that is there to be filled in: nothing passes by it, nothing fails
PLACEHOLDER = (
    "to be replaced by the source of each range"  # ends the source that `cosimo new table` of 0.7 wrote for its own numbers
)
CONFIDENCES = ("high", "medium-high", "medium", "low")
UNCHANGED = "unchanged"  # half of the steps give the same number, no run is in it, or its steps are what is asked about
NOT_REPEATED = "not repeated"
COVERAGE = 2.0  # standard deviations of a parameter error that a row is to be inside by: 95 % of a normal distribution
FIELDS = ("quantity", "measure", "condition", "unit", "standing", "source")  # text every row has
NUMBERS = ("low", "high", "value", "tolerance")
OPTIONAL = (*NUMBERS, "confidence", "claim", "role")


@dataclass(frozen=True)
class TableRow(Range):
    """A range for one quantity under one condition; an end that is None is open.

    measure: the name under which a case gives the measured number, in `unit`.
    standing: one of `STANDINGS`; confidence belongs to unconfirmed rows.
    claim: number of the claim of a paper that the row is for; role: one of `ROLES`, what it says of the claim inside its range.
    """

    quantity: str
    measure: str
    condition: str
    unit: str
    low: float | None
    high: float | None
    standing: str
    source: str
    confidence: str = ""
    claim: str = ""
    role: str = "supports"

    @property
    def named(self) -> str:
        """The quantity, and what the row says of its claim where it does not support it."""
        if self.role == "supports":
            return self.quantity
        return f"{self.quantity} ({self.role}{'' if self.role == CONSTRUCTION else ' the claim'})"

    def __post_init__(self) -> None:
        where = f"reference row {self.quantity!r} ({self.condition})"
        if self.standing not in STANDINGS:
            raise BadInput(where, f"standing {self.standing!r}", "one of " + ", ".join(STANDINGS))
        if self.role not in ROLES:
            raise BadInput(where, f"role {self.role!r}", "one of " + ", ".join(ROLES))
        if self.standing == MISSING:
            if self.low is not None or self.high is not None:
                raise BadInput(
                    where,
                    "a range that is missing",
                    "standing and source of the range, or neither low nor high",
                    "Give standing = one of " + ", ".join(s for s in STANDINGS if s != MISSING) + ".",
                )
            return
        self.check_ends(where)
        if (self.standing == "unconfirmed") != (self.confidence in CONFIDENCES):
            raise BadInput(
                where, f"confidence {self.confidence!r}", f"one of {', '.join(CONFIDENCES)}; for unconfirmed rows only"
            )
        if not self.source.strip():
            raise BadInput(where, "no source", "where the range was read")
        if self.source.strip().endswith(PLACEHOLDER):
            raise BadInput(
                where, f"source {self.source!r}", "where the range was read", f'Or standing = "{MISSING}", without low and high.'
            )


@dataclass(frozen=True)
class Row:
    """A row of a reference table beside the number of a run, in the row's unit."""

    reference: TableRow
    simulated: float
    error: float = math.nan  # of the steps and meshes; NaN where it is not known
    why: str = ""  # why there is no error: `UNCHANGED`, or what kept the case from being repeated; "" where there is one
    parameters: float = math.nan  # standard deviation by the tolerances of the scenes' parameters; NaN without any

    @property
    def missing(self) -> bool:
        """Whether there is no range to judge by."""
        return self.reference.standing == MISSING

    @property
    def margin(self) -> float:
        """Distance to the nearer end of the range in the row's unit, negative outside; NaN if nothing was measured."""
        return math.nan if self.missing else self.reference.margin(self.simulated)

    @property
    def inside(self) -> bool:
        """Whether the measured number lies in the range, its ends included."""
        return bool(self.margin >= 0.0)  # the numbers may be those of NumPy

    @property
    def undecided(self) -> bool:
        """Whether an end of the range lies within the error of a number inside, or within two standard deviations by parameters."""
        return self.inside and bool(self.error > self.margin or COVERAGE * self.parameters > self.margin)

    @property
    def shown(self) -> str:
        """The measured number with its errors where these are known."""
        return with_errors_of(self.simulated, self.error, self.parameters, "numerical")

    @property
    def repeated(self) -> str:
        """`UNCHANGED` or `NOT_REPEATED` of a number without an error; "" of one that has an error."""
        return "" if math.isfinite(self.error) else UNCHANGED if self.why == UNCHANGED else NOT_REPEATED

    @property
    def answer(self) -> str:
        """ "yes", "NO", "undecided" or "not judged": whether the number is inside."""
        return "not judged" if self.missing else "undecided" if self.undecided else "yes" if self.inside else "NO"

    def to_json(self) -> dict[str, Any]:
        """The row of the machine-readable output."""
        r = self.reference
        return {
            "quantity": r.quantity,
            "condition": r.condition,
            "unit": r.unit,
            "measured": self.simulated if math.isfinite(self.simulated) else None,
            "error": self.error if math.isfinite(self.error) else None,
            "why": self.why or None,
            **({"parameters": self.parameters} if math.isfinite(self.parameters) else {}),
            "low": r.low,
            "high": r.high,
            "standing": r.standing,
            "confidence": r.confidence or None,
            "source": r.source,
            "inside": None if self.missing else self.inside,
            "undecided": self.undecided,
            **({"claim": r.claim, "role": r.role} if r.claim else {}),
        }


def compare(rows: tuple[TableRow, ...], measured: Mapping[str, float | Mapping[str, float]]) -> tuple[Row, ...]:
    """Rows beside the numbers of their `measure`, which may be those of their condition; NaN, and so not inside, for none."""
    return tuple(Row(row, float(_numbers(row, measured).get(row.measure, math.nan))) for row in rows)


def check_numbers(table: str, rows: tuple[TableRow, ...], measured: Mapping[str, float | Mapping[str, float]]) -> None:
    """Raises `BadInput` for the first row whose measure is not among the numbers of its condition."""
    for i, row in enumerate(rows, 1):
        if row.measure not in (numbers := _numbers(row, measured)):
            actual = f"measure {row.measure!r} of condition {row.condition!r}"
            near = nearest(row.measure, sorted(k for k, v in numbers.items() if not isinstance(v, Mapping)))
            raise BadInput(f"table {table}, row {i}", actual, "a number that a question of the case gives", near)


def _numbers(row: TableRow, measured: Mapping[str, float | Mapping[str, float]]) -> Mapping[str, Any]:
    """The numbers of a row's condition, or those of all where conditions have none of their own."""
    of_condition = measured.get(row.condition)
    return of_condition if isinstance(of_condition, Mapping) else measured


@dataclass(frozen=True)
class Table:
    """A reference table; `rows` in the order of the source. title: that of its file, or the name of the table."""

    name: str
    title: str
    text: str
    rows: tuple[TableRow, ...]
    claims: tuple[Claim, ...] = ()  # of a paper
    measures: str = ""  # "module:function" that gives the rows' measures of any run, where there is one
    rules: str = ""  # "module:function" that says of a run which conditions hold for which of its objects (`limits_of_run.Rules`)
    scene_conditions: str = (
        ""  # "module:function" that says which hold for all runs of a scene but for what varies, none if they differ
    )
    objects: str = (
        ""  # "module:function" that names the objects of a scene, each with the rows; measures of each begin with its name
    )
    check: str = ""  # "module:function" that refuses a scene whose runs have nothing to compare, where that can be known

    def under(self, condition: str) -> tuple[TableRow, ...]:
        """The rows of one condition, such as "250 km/h"."""
        rows = tuple(r for r in self.rows if r.condition == condition)
        if not rows:
            known = {r.condition for r in self.rows}
            raise BadInput(f"table {self.name}", f" {condition!r}", "a condition of it", nearest(condition, sorted(known)))
        return rows


def parse_table(name: str, text: str, lines: str) -> Table:
    """A table from its TOML text and the CSV of its rows; raises `BadInput` for missing or unknown fields and unknown sources."""
    data = tomllib.loads(text)
    if not data.get("sources"):
        raise BadInput(f"table {name}", "no 'sources'", "[sources], the text of each key in the column source")
    rows = table_rows(name, read_rows(table_of(lines, f"table {name}")), data["sources"])
    claims = read_claims(name, data.get("claims", ()))
    numbers = {claim.number for claim in claims}
    for i, row in enumerate(rows, 1):
        if (row.claim or claims) and row.claim not in numbers:
            raise BadInput(
                f"table {name}, row {i}",
                f"claim {row.claim!r}",
                "the number of a claim of this table",
                nearest(row.claim, sorted(numbers)),
            )
    if missing := [c.number for c in claims if c.kind == "finding" and c.number not in {r.claim for r in rows}]:
        raise BadInput(f"table {name}", f"no row for {', '.join(missing)}", "at least one measured row a finding")
    return Table(name, data.get("title", name), data.get("about", ""), rows, claims, **functions(data))


def functions(data: Mapping[str, Any]) -> dict[str, str]:
    """The functions that a table names."""
    return {key: str(data.get(key, "")) for key in ("measures", "rules", "scene_conditions", "objects", "check")}


def named_function(text: str) -> Callable[..., Any]:
    """That of "module:function"."""
    module, _, name = text.partition(":")
    return getattr(import_module(module), name)


def read_rows(table: Columns) -> list[dict[str, Any]]:
    """Rows from a CSV table: an empty cell is none; numbers in `NUMBERS`, text elsewhere. Raises `BadInput` with line and column."""
    table.only(FIELDS + OPTIONAL, "a column of a reference table")
    if not table.rows:
        raise BadInput(table.where, "no rows", "at least one line behind the names of the columns")
    columns: dict[str, Any] = {}
    for column in FIELDS + OPTIONAL:
        if (k := table.place(column)) is None:
            continue
        if table.units[k] and column != "tolerance":
            raise BadInput(table.where, f"column {table.header[k]!r}", f"{column!r}; units of ranges stand in the column 'unit'")
        unit = "1" if column == "tolerance" else ""
        columns[column] = table.numbers(column, unit).tolist() if column in NUMBERS else table.texts(column)
    return [{n: v for n, values in columns.items() if (v := values[i]) != "" and v == v} for i in range(len(table.rows))]


def rows_of(name: str, data: Mapping[str, Any], folder: Path) -> Sequence[Mapping[str, Any]]:
    """Rows of a table of a user's: `rows` is their list, or the name of a CSV file in the folder."""
    rows = data.get("rows", ())
    if not isinstance(rows, str):
        return rows
    return read_rows(read_table(folder / rows, f"{name}: rows"))


def table_rows(name: str, rows: Sequence[Mapping[str, Any]], sources: Mapping[str, str]) -> tuple[TableRow, ...]:
    """Rows of a table as data, with their sources in words; raises `BadInput` with the number of the row."""
    return tuple(_row(name, i, row, sources) for i, row in enumerate(rows, 1))


def _row(table: str, number: int, row: Mapping[str, Any], sources: Mapping[str, str]) -> TableRow:
    where = f"table {table}, row {number}"
    for key in row:
        pick(key, FIELDS + OPTIONAL, where, "a field of a reference row", "field")
    for key in NUMBERS:
        if isinstance(value := row.get(key, 0.0), bool) or not isinstance(value, int | float):
            raise BadInput(where, f"{key} = {value!r}", "a number")
    missing = row.get("standing") == MISSING
    for key in FIELDS:
        if not isinstance(row.get(key, "" if missing and key == "source" else None), str):
            raise BadInput(where, f"{key} = {row.get(key)!r}", "a text")
    if not missing and row["source"] not in sources:
        raise BadInput(where, f"source {row['source']!r}", "a key of [sources]", nearest(row["source"], sources))
    if "value" in row:
        if "tolerance" not in row or "low" in row or "high" in row:
            raise BadInput(where, "a value", "a relative tolerance beside it, and neither low nor high")
        if not 0.0 <= row["tolerance"] <= 1.0:
            raise BadInput(where, f"tolerance = {row['tolerance']:g}", "a share of the value, at most 1", "5 % is written 0.05.")
        half = abs(row["value"]) * row["tolerance"]
        low, high = row["value"] - half, row["value"] + half
    else:
        low, high = row.get("low"), row.get("high")
    return TableRow(
        row["quantity"],
        row["measure"],
        row["condition"],
        row["unit"],
        low,
        high,
        OLD_STANDINGS.get(row["standing"], row["standing"]),
        "" if missing else sources[row["source"]],
        row.get("confidence", ""),
        row.get("claim", ""),
        row.get("role", "supports"),
    )


def load_table(name: str) -> Table:
    """A shipped table by name, the stem of its file beside the case of its system."""
    tables = table_files()
    pick(name, tables, "reference table", "a shipped table")
    texts = (tables[name].with_suffix(suffix).read_text(encoding="utf-8") for suffix in (".toml", ".csv"))
    return parse_table(name, *texts)


def table_files() -> dict[str, Path]:
    """Shipped tables by name."""
    return shipped("cases", ".csv")
