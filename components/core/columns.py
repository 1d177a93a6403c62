"""The one reader of CSV tables that users bring: measured curves, lines, points of a plan, rows of limits.

    span [mm];height (ft);force, kN                     header: names with their units; or a line of units below the names
    48,5;17,5;1,2                                       separated by semicolons, tabs or commas; decimals have a point or, unless
                                                        commas separate cells, a comma

Files are in UTF-8, UTF-16 or Windows-1252 (Latin-1). Lines that begin with # are comments.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Collection
from contextlib import suppress
from dataclasses import dataclass
from io import StringIO
from math import isfinite
from pathlib import Path

import numpy as np

from .errors import BadInput, counted, nearest
from .files import read_bytes
from .measure import OTHERWISE, bare_number, conversion_of, is_quantity, number_in, parse, plain

EMPTY = ("", "nan", "n/a", "na", "-")  # cells without a number, as loggers write them
COMMAS = "Decimal commas need semicolons between the cells."
CLOCK = "Dates and times of a clock are not read: write seconds since the start."
SHORT = ("in", "min")  # ends of names that are no units: input, minimum
THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2}([.,])\d{3}")  # of a number whose sign may be one of thousands, or of decimals
_NO_TEXT = re.compile("[\x00-\x08\x0e-\x1a\x1c-\x1f]")
_WITH_UNIT = re.compile(r"(.*?\S)(\s*)\[([^\[\]]*)\]|(.*?\S)\s*\(([^()]*)\)")


def decoded(data: bytes, where: str) -> str:
    """The text of a table's file; raises `BadInput` for bytes that are none."""
    head = data[:2]
    wide = "utf-16" if head in (b"\xff\xfe", b"\xfe\xff") else "utf-16-be" if head[:1] == b"\0" else "utf-16-le"
    for encoding in ("utf-8-sig", "cp1252") if b"\0" not in data[:200] else (wide,):
        with suppress(UnicodeDecodeError):
            text = data.decode(encoding)
            if not _NO_TEXT.search(text):
                return text
    raise BadInput(where, "bytes that are no text", "a CSV table in UTF-8, UTF-16 or Latin-1")


def read_table(path: str | Path, where: str = "table", separator: str = "") -> Columns:
    """The table of a file; raises `BadInput`, whose place is `where` if there is no file."""
    return table_of(decoded(read_bytes(path, where), str(path)), str(path), separator)


def table_of(text: str, where: str, separator: str = "", skipped: int = 0) -> Columns:
    """The table of a text. separator: of cells, where the header does not show it; skipped: rows of the file that are left out
    behind the header, for the numbers of lines."""
    text = text.removeprefix("\ufeff")
    if mark := re.match(r"sep=(.)\r?\n", text):  # of spreadsheets
        separator, text = separator or mark[1], f"#\n{text[mark.end() :]}"
    lines = list(StringIO(text, newline=""))
    start = next((k for k, line in enumerate(lines) if line.strip() and not line.startswith("#")), len(lines))
    first, comment = "".join(lines[start : start + 1]), [line.lstrip("# ") for line in lines[:start] if line.startswith("#")][-1:]
    unquoted = re.sub('"[^"]*"', "", first)
    separator = separator or next((d for d in (";", "\t") if d in unquoted), ",")
    source = csv.reader(("\n" if line.startswith("#") else line for line in lines), delimiter=separator)
    try:
        rows = [(source.line_num + skipped, cells) for cells in source if any(cell.strip() for cell in cells)]
    except csv.Error as error:
        raise BadInput(f"{where}, line {source.line_num + skipped}", f"no CSV ({error})", "a CSV table") from None
    if rows and comment and all(_is_number(cell) for cell in rows[0][1]):  # the names stand behind a #
        rows.insert(0, (rows[0][0] - 1, next(csv.reader(comment, delimiter=separator))))
    if not rows:
        raise BadInput(where, "nothing", "a header and rows")
    header = [cell.strip() for cell in rows.pop(0)[1]]
    while header and not header[-1]:
        header.pop()
    for line, cells in rows:
        if len(cells) < len(header) or any(cell.strip() for cell in cells[len(header) :]):
            remedy = COMMAS if len(cells) > len(header) and separator == "," else ""
            raise BadInput(f"{where}, line {line}", f"{counted(len(cells), 'cell')}", f"{len(header)}, as the header has", remedy)
    parts = [name_and_unit(text) for text in header]
    if rows and _are_units(rows[0][1]) and not any(unit for _, unit in parts):
        below = [cell.strip().strip("[]()") for cell in rows.pop(0)[1]]
        parts = [(name, unit) for (name, _), unit in zip(parts, below, strict=False)]
    names, units = tuple(name for name, _ in parts), tuple(unit for _, unit in parts)
    return Columns(where, tuple(header), names, units, separator, tuple(rows))


@dataclass(frozen=True)
class Columns:
    """A table as it stands in its file. header: of each column all its text, `names` of it without its unit, `units` as written.
    rows: number of the line in the file and cells, of each."""

    where: str
    header: tuple[str, ...]
    names: tuple[str, ...]
    units: tuple[str, ...]
    separator: str
    rows: tuple[tuple[int, list[str]], ...]

    def place(self, name: str) -> int | None:
        """The column of a name, by all its text, else without its unit, else without regard to case and _; None without one."""
        for wanted, known in ((name, self.header), (name, self.names), (_alike(name), tuple(map(_alike, self.names)))):
            if (count := known.count(wanted)) > 1:
                raise BadInput(self.where, f"column {wanted!r} {count} times", "each column once")
            if count:
                return known.index(wanted)
        return None

    def only(self, names: Collection[str], expected: str) -> None:
        """Raises `BadInput` for a column of none of the names, and for one that stands there twice."""
        known = {_alike(name) for name in names}
        for text, name in zip(self.header, self.names, strict=True):
            if _alike(name) not in known:
                raise BadInput(self.where, f"column {text!r}", expected, nearest(name, names))
            self.place(name)

    def texts(self, name: str) -> list[str]:
        """(n,) cells of a column, which raises `BadInput` where it is missing."""
        if (k := self.place(name)) is None:
            raise BadInput(self.where, f"no column {name!r}", "a column of its header", nearest(name, self.names))
        return [cells[k].strip() for _, cells in self.rows]

    def numbers(self, name: str, unit: str = "", *, asked: bool = False) -> np.ndarray:
        """(n,) numbers of a column in a unit, by the unit of its header; NaN of an empty cell. `asked`: that unit must be there.

        Raises `BadInput` with line and column.
        """
        cells, k = self.texts(name), self.place(name)
        assert k is not None
        where = f"{self.where}, column {self.header[k]!r}"
        written = self.unit(name, unit)
        if asked and not written and unit not in ("", "1"):
            other = OTHERWISE.get(unit, "")
            question = f"{unit} or {other}? " if other else ""
            raise BadInput(where, "no unit", "a name with its unit", f"{question}Write {f'{name} [{unit}]'!r}.")
        factor, offset = conversion_of(written, unit, where, f"unit {written!r}") if written and unit else (1.0, 0.0)
        self._refuse_thousands(k, cells)
        with suppress(ValueError):  # nearly always
            values = np.array([bare_number(cell) for cell in cells])
            if not np.isinf(values).any():
                return factor * values + offset
        signs: dict[str, int] = {}  # decimal sign -> first line with it
        values = np.full(len(cells), np.nan)
        for i, ((line, _), cell) in enumerate(zip(self.rows, cells, strict=True)):
            if cell.lower() in EMPTY:
                continue
            place = f"{self.where}, line {line}, column {self.header[k]!r}"
            with_unit = unit and is_quantity(cell)
            values[i] = number_in(cell, unit, place) if with_unit else factor * self._number(cell, unit, place) + offset
            signs |= {sign: line for sign in ",." if sign in cell and sign not in signs}
        if len(signs) > 1:
            both = " and ".join(f"{sign!r} in line {line}" for sign, line in signs.items())
            raise BadInput(where, f"decimals with {both}", "one decimal sign", "Thousands have no sign of their own.")
        return values

    def _refuse_thousands(self, k: int, cells: list[str]) -> None:
        """Raise `BadInput` where all decimals of column k look like thousands, and other columns have the other decimal sign."""
        signed = ((row, cell) for row, cell in enumerate(cells) if "." in cell or "," in cell)
        if self.separator == "," or (first := next(signed, None)) is None:
            return
        row, cell = first
        match = THOUSANDS.fullmatch(cell)
        if match is None or not all(THOUSANDS.fullmatch(other) for _, other in signed):
            return
        sign = ",."[match[1] == ","]
        decimals = re.compile(rf"[+-]?\d+[{sign}]\d+")
        for line, others in self.rows:
            for other in others:
                if decimals.fullmatch(other.strip()):
                    raise BadInput(
                        f"{self.where}, line {self.rows[row][0]}, column {self.header[k]!r}",
                        f"{cell!r} beside {other.strip()!r} in line {line}",
                        "one decimal sign",
                        f"Write {cell.replace(match[1], '')} or {cell.replace(match[1], sign)}: they differ by a factor of 1000.",
                    )

    def unit(self, name: str, wanted: str = "") -> str:
        """The unit of a column as the converter takes it, "" without one. wanted: its dimension lets names end with it: force_kN."""
        k = self.place(name)
        written = plain(self.units[k]) if k is not None else ""
        if not written and k is not None and wanted:
            _, line, suffix = self.names[k].rpartition("_")
            with suppress(BadInput):
                written = suffix if line and suffix not in SHORT and parse(suffix).exponents == parse(wanted).exponents else ""
        return {"-": "1", "–": "1"}.get(written, written)

    def _number(self, cell: str, unit: str, where: str) -> float:
        try:
            value = bare_number(cell.replace(",", ".") if self.separator != "," else cell)
        except ValueError:
            remedy = CLOCK if ":" in cell else COMMAS if "," in cell and self.separator == "," else ""
            raise BadInput(
                where, repr(cell)[:80], "a number" + (f" in {unit}" if unit not in ("", "1") else ""), remedy
            ) from None
        if not isfinite(value):
            raise BadInput(where, "a number that is not finite", "finite numbers")
        return value


def name_and_unit(text: str) -> tuple[str, str]:
    """A name and its unit as a header has them, "span [mm]" or "span (mm)"; without one, the text and ""."""
    if match := _WITH_UNIT.fullmatch(text):
        is_element = match[3] is not None and not match[2] and re.fullmatch(r"[\d,\s*:]+", match[3])
        return (text, "") if is_element else (match[1] or match[4], (match[3] if match[1] else match[5]).strip())
    name, comma, unit = text.rpartition(",")
    return (name.strip(), unit.strip()) if comma and name.strip() and "]" not in unit else (text, "")


def _are_units(cells: list[str]) -> bool:
    """Whether a row below the names has their units: no number, and all that is not empty can be one."""
    return all(map(_is_unit, filter(None, (cell.strip() for cell in cells))))


def _is_unit(cell: str) -> bool:
    if re.fullmatch(r"\[.*\]|\(.*\)|-", cell):
        return True
    with suppress(BadInput):
        return not _is_number(cell) and bool(parse(plain(cell)))
    return False


def _is_number(cell: str) -> bool:
    try:
        bare_number(cell.replace(",", "."))
    except ValueError:
        return False
    return True


def _alike(name: str) -> str:
    return " ".join(name.replace("_", " ").split()).casefold()
