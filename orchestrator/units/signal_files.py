"""Tables over time from files, as the classes of `components.core.signals`: CSV, Parquet, Arrow, MAT 5.

A CSV table is read in pieces, each by pyarrow; a piece that pyarrow does not take is read by `columns`, the one reader of such
tables, which knows all forms of numbers and says with line and column what is wrong.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import lru_cache, partial
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from ...components.core.columns import EMPTY, Columns, decoded, table_of
from ...components.core.errors import BadInput
from ...components.core.files import read_bytes, refuse_pipe
from ...components.core.measure import conversion_of, plain
from ...components.core.signals import Signals, signals_class
from ..loading import loading

TIME = ("time", "t", "zeit")  # names of the column of times; without one the first is
SUFFIXES = (".csv", ".txt", ".tsv", ".dat", ".parquet", ".arrow", ".feather", ".mat")
HEAD = 1 << 16  # bytes at the beginning of a CSV table that show its form
PIECE = 1 << 22  # bytes that are read at once behind them
LONG = 1 << 26  # bytes of a file from which on a terminal shows how far it is
Named = tuple[str, str, str]  # of a column: name, unit, and how messages call it
Place = Callable[[int], str]  # of a row of a piece, for messages


class Growing:
    """Rows that come in pieces, in one array, with the checks that all tables share."""

    def __init__(self, columns: Sequence[Named], where: str, size: int):
        """size: rows that are expected."""
        names = [name for name, _, _ in columns]
        if len(columns) < 2:
            raise BadInput(where, f"{len(columns)} column", "a column of times and one of values at least")
        for k, name in enumerate(names):
            if not name or name in names[:k]:
                raise BadInput(
                    where, f"column {name!r} twice" if name else f"column {k + 1} without a name", "names that are unique"
                )
        self.time = next((k for k, name in enumerate(names) if name.strip().lower() in TIME), 0)
        self.order = [self.time, *(k for k in range(len(columns)) if k != self.time)]
        self.columns, self.where, self.rows = [columns[k] for k in self.order], where, 0
        self.table = np.empty((max(size, 1), len(columns)))
        written = self.columns[0][1]
        self._of_time = (
            conversion_of(written, "s", f"{where}, column {self.columns[0][2]!r}", f"unit {written!r}")[0] if written else 1.0
        )

    def add(self, values: Sequence[np.ndarray], place: Place) -> None:
        """Columns of a piece, in the order of the file; place: of its rows. Raises `BadInput` for what no table may have."""
        n = len(values[0])
        if self.rows + n > len(self.table):
            self.table = np.concatenate((self.table[: self.rows], np.empty((max(n, self.rows // 2), self.table.shape[1]))))
        part = self.table[self.rows : self.rows + n]
        for k, source in enumerate(self.order):
            part[:, k] = values[source]
            if not np.isfinite(part[:, k]).all():
                bad = int(np.flatnonzero(~np.isfinite(part[:, k]))[0])
                shown = self.columns[k][2]
                if np.isnan(part[:, k]).all():
                    raise BadInput(
                        f"{self.where}, column {shown!r}", "no numbers", "a number in each row", "Delete the column, or fill it."
                    )
                raise BadInput(
                    f"{place(bad)}, column {shown!r}",
                    f"{part[bad, k]:g}".replace("nan", "no number"),
                    "a number",
                    "Delete the row, or fill it.",
                )
        part[:, 0] = seconds(part[:, 0], self._of_time)
        first = max(self.rows - 2, 0)
        times = self.table[first : self.rows + n, 0]
        shown = self.columns[0][2]
        if (falls := np.flatnonzero(np.diff(times) < 0.0)).size:
            at = int(falls[0]) + 1
            texts = f"{times[at]:.9g} s behind {times[at - 1]:.9g} s"
            raise BadInput(
                f"{place(at + first - self.rows)}, column {shown!r}", texts, "times that do not go back", "Sort the rows."
            )
        if (thrice := np.flatnonzero(times[2:] == times[:-2])).size:
            at = int(thrice[0]) + 2
            raise BadInput(
                f"{place(at + first - self.rows)}, column {shown!r}",
                f"{times[at]:.9g} s for the third time",
                "each time once, or twice for a jump",
            )
        self.rows += n

    def finished(self) -> type[Signals]:
        """The class of the whole table."""
        if not self.rows:
            raise BadInput(self.where, "a header alone", "rows below it")
        names, units = [name for name, _, _ in self.columns[1:]], [unit for _, unit, _ in self.columns[1:]]
        return signals_class(names, units, self.table[: self.rows], Path(self.where).name)


def seconds(times: np.ndarray, factor: float) -> np.ndarray:
    """Times in s. Where a number of ms is a decimal, that of s is the nearest one to it: then ticks of a clock stay long."""
    if factor == 1.0:
        return times
    converted = times / round(1.0 / factor) if factor < 1.0 else times * factor
    decimal = np.round(converted, 12)
    return np.where(np.abs(decimal - converted) <= 4.0 * np.spacing(np.abs(converted)), decimal, converted)


def read_signals(path: str | Path, where: str = "signals") -> type[Signals]:
    """The class of a table's file; read once as long as it stays the same. Raises `BadInput`, whose place is `where` without a file."""
    refuse_pipe(path, where)
    try:
        state = os.stat(path)
    except (OSError, ValueError) as error:
        raise BadInput(where, repr(str(path)), "a file that can be read", f"{getattr(error, 'strerror', error)}.") from None
    if Path(path).suffix.lower() not in SUFFIXES:
        raise BadInput(where, repr(str(path)), f"a table: {', '.join(SUFFIXES)}")
    return _read(os.path.abspath(path), state.st_mtime_ns, state.st_size)


@lru_cache(maxsize=8)
def _read(path: str, changed: int, size: int) -> type[Signals]:
    readers = {".parquet": _parquet, ".arrow": _arrow, ".feather": _arrow, ".mat": _mat}
    with loading(path, "a table"), _progress(path, size) as advance:
        return readers.get(Path(path).suffix.lower(), _csv)(path, size, advance)


@contextmanager
def _progress(path: str, size: int) -> Iterator[Callable[[int], None]]:
    """A function that is told how many bytes have been read: a bar on a terminal for a long file."""
    if size < LONG or not sys.stderr.isatty():
        yield lambda n: None
        return
    from rich.console import Console
    from rich.progress import Progress

    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(f"reading {Path(path).name}", total=size)
        yield partial(bar.advance, task)


# -- CSV --------------------------------------------------------------------------------------------------------------------------
def _csv(path: str, size: int, advance: Callable[[int], None]) -> type[Signals]:
    with open(path, "rb") as file:
        head = file.read(HEAD) + file.readline()
        if b"\0" in head[:200]:  # UTF-16
            head = read_bytes(path, path)
        first = table_of(decoded(head, path), path)
        named = [(name, plain(unit), shown) for name, unit, shown in zip(first.names, first.units, first.header, strict=True)]
        table = Growing(named, path, int(1.1 * len(first.rows) * size / max(len(head), 1)) + 1)
        _add(table, first)
        advance(len(head))
        begin = b"".join(head.splitlines(keepends=True)[: first.rows[0][0] - 1 if first.rows else 0])
        comma = first.separator != "," and any("," in cell for _, cells in first.rows for cell in cells)
        lines = head.count(b"\n") - begin.count(b"\n")
        while len(head) < size and (piece := file.read(PIECE) + file.readline()):
            read = partial(_columns, begin + piece, path, lines)
            if (columns := _quick(piece, first.separator, len(named), comma)) is None:
                _add(table, read())
            else:
                table.add(columns, lambda row, read=read: f"{path}, line {read().rows[row][0]}")  # type: ignore[misc]
            lines += piece.count(b"\n")
            advance(len(piece))
        return table.finished()


def _columns(text: bytes, path: str, skipped: int) -> Columns:
    return table_of(decoded(text, path), path, skipped=skipped)


def _add(table: Growing, columns: Columns) -> None:
    values = [columns.numbers(shown) for shown in columns.header]
    if columns.rows:
        table.add(values, lambda row: f"{columns.where}, line {columns.rows[row][0]}")


def _quick(piece: bytes, separator: str, n: int, comma: bool) -> list[np.ndarray] | None:
    """Columns of numbers, (rows,) each; None for a piece with anything else."""
    import pyarrow as arrow
    from pyarrow import csv

    names = [str(k) for k in range(n)]
    try:
        rows = csv.read_csv(
            BytesIO(piece),
            csv.ReadOptions(column_names=names, use_threads=False, block_size=len(piece) + 1),
            csv.ParseOptions(delimiter=separator),
            csv.ConvertOptions(
                column_types=dict.fromkeys(names, arrow.float64()),
                decimal_point="," if comma else ".",
                null_values=[*EMPTY, "NaN"],
            ),
        )
    except (arrow.ArrowInvalid, UnicodeDecodeError):
        return None
    values = [column.to_numpy() for column in rows.columns]
    return values if values and len(values[0]) and not any(np.isinf(column).any() for column in values) else None


# -- others -----------------------------------------------------------------------------------------------------------------------
def _parquet(path: str, size: int, advance: Callable[[int], None]) -> type[Signals]:
    from pyarrow import parquet

    file = parquet.ParquetFile(path, memory_map=True)
    return _batches(path, file.schema_arrow, file.iter_batches(), file.metadata.num_rows, advance)


def _arrow(path: str, size: int, advance: Callable[[int], None]) -> type[Signals]:
    import pyarrow as arrow

    with arrow.memory_map(path) as source:
        try:
            file = arrow.ipc.open_file(source)
            batches: Iterator[Any] = (file.get_batch(k) for k in range(file.num_record_batches))
        except arrow.ArrowInvalid:
            source.seek(0)
            file = batches = arrow.ipc.open_stream(source)
        return _batches(path, file.schema, batches, 1, advance)


def _batches(path: str, schema: Any, batches: Iterator[Any], rows: int, advance: Callable[[int], None]) -> type[Signals]:
    import pyarrow as arrow

    named: list[Named] = []
    for field in schema:
        kind = field.type
        if not (arrow.types.is_integer(kind) or arrow.types.is_floating(kind) or arrow.types.is_boolean(kind)):
            raise BadInput(f"{path}, column {field.name!r}", f"values of type {kind}", "numbers", "Delete the column.")
        read = table_of(field.name, path) if field.name.strip() and not set(field.name) & set('\r\n"#;\t,') else None
        unit = (field.metadata or {}).get(b"unit") or (field.metadata or {}).get(b"units") or b""
        name = read.names[0] if read else field.name
        named.append((name, plain(unit.decode(errors="replace") or (read.units[0] if read else "")), field.name))
    table = Growing(named, path, rows)
    for batch in batches:
        columns = [column.cast(arrow.float64()).to_numpy(zero_copy_only=False) for column in batch.columns]
        if batch.num_rows:
            table.add(columns, lambda row, before=table.rows: f"{path}, row {before + row + 1}")  # type: ignore[misc]
        advance(batch.nbytes)
    return table.finished()


def _mat(path: str, size: int, advance: Callable[[int], None]) -> type[Signals]:
    """Vectors of one length; columns of a matrix are name[1], name[2] ... A struct `units` has the units of the variables."""
    from scipy.io import loadmat

    content = {name: np.asarray(value) for name, value in loadmat(path).items() if not name.startswith("__")}
    units = dict[str, str]()
    if "units" in content and (fields := content["units"].dtype.names) and content["units"].size == 1:
        struct = content.pop("units")
        units = {name: "".join(map(str, np.ravel(struct[name].item()))) for name in fields}
    named: list[Named] = []
    values: list[np.ndarray] = []
    lengths = {max(value.shape) for name, value in content.items() if value.ndim == 2 and name.lower() in TIME}
    for name, value in content.items():
        where = f"{path}, variable {name!r}"
        if value.dtype.kind not in "biuf" or value.ndim != 2:
            raise BadInput(
                where, f"an array of shape {value.shape} and type {value.dtype}", "vectors of numbers", "Save without it."
            )
        matrix = value.T if value.shape[0] == 1 else value
        if lengths and matrix.shape[0] not in lengths:
            raise BadInput(where, f"{matrix.shape[0]} values", f"{max(lengths)}, as there are times")
        lengths = lengths or {matrix.shape[0]}
        for k, column in enumerate(matrix.T, 1):
            one = name if matrix.shape[1] == 1 else f"{name}[{k}]"
            named.append((one, units.get(name, ""), one))
            values.append(column.astype(float))
    table = Growing(named, path, len(values[0]) if values else 1)
    if values and len(values[0]):
        table.add(values, lambda row: f"{path}, row {row + 1}")
    advance(size)
    return table.finished()
