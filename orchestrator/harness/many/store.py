"""The rows of points on disk: a folder of Arrow files that one process appends, each named by the digest of its content.

A file appears as a whole and is compared with its name whenever it is read: a damaged one is removed, one that another user owns
or may write is left alone, and their points run again.
Arrow, because a part has few rows and many columns: of 158 columns Arrow writes one in 0.3 ms, Parquet in 4 ms, Zarr in 400 ms.
Other tools read a folder as one data set, `pyarrow.dataset.dataset(folder, format="arrow")`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from ....components.core.errors import BadInput
from ....components.core.store import digest_of, opened_trusted, replaced
from ...output import not_written
from .measures import PointResult, Task
from .plan import Points

WRITE_EVERY = 1.0  # s between two files
SUFFIX = ".arrow"
PIECE = 65536  # points that are in memory at a time
NUMBER, SIGNAL, SECTION, TIME = "number ", "signal ", "section", "time"  # columns; a name follows the first two


def table_of(rows: Sequence[tuple[int, PointResult]]) -> Any:
    """Rows with their digests as a table of pyarrow. Units of measure are metadata of the fields."""
    import pyarrow

    names = dict.fromkeys(n for _, row in rows for n in row.numbers)
    signals = dict.fromkeys(n for _, row in rows for n in row.signals)
    units = {n: u for _, row in rows for n, u in row.units.items()}
    texts, numbers, lists = pyarrow.string(), pyarrow.float64(), pyarrow.list_(pyarrow.float64())
    columns: list[tuple[str, Any, Sequence[Any], str]] = [
        ("digest", pyarrow.int64(), [digest for digest, _ in rows], ""),
        ("outcome", texts, [row.outcome for _, row in rows], ""),
        ("reason", texts, [row.reason for _, row in rows], ""),
        *((NUMBER + n, numbers, [row.numbers.get(n, np.nan) for _, row in rows], units.get(n, "")) for n in names),
    ]
    arrays: list[tuple[str, list[np.ndarray], str]] = [
        (SECTION, [row.section for _, row in rows], ""),
        (TIME, [row.time for _, row in rows], "s"),
        *((SIGNAL + n, [row.signals.get(n, np.zeros(0)) for _, row in rows], units.get(n, "")) for n in signals),
    ]
    columns += [(name, lists, values, unit) for name, values, unit in arrays if any(v.size for v in values)]
    schema = pyarrow.schema([pyarrow.field(n, t, metadata={"unit": u}) for n, t, _, u in columns])
    return pyarrow.table([pyarrow.array(x, type=t) for _, t, x, _ in columns], schema=schema)


def row_of(table: Any, k: int) -> PointResult:
    """A row of such a table; without the numbers that other rows alone have."""
    row = PointResult(table.column("outcome")[k].as_py(), table.column("reason")[k].as_py())
    for field in table.schema:
        if field.name.startswith(NUMBER):
            name = field.name.removeprefix(NUMBER)
            if (value := table.column(field.name)[k].as_py()) is not None:
                row.numbers[name], row.units[name] = value, unit_of_field(field)
        elif field.name.startswith(SIGNAL):
            name = field.name.removeprefix(SIGNAL)
            row.signals[name], row.units[name] = array_of(table, field.name, k), unit_of_field(field)
        elif field.name == TIME:
            row.time = array_of(table, TIME, k)
    return row


def array_of(table: Any, name: str, k: int) -> np.ndarray:
    """(m,) numbers of a row in a column of lists; none where there is no such column, or nothing in it."""
    values = table.column(name)[k].values if name in table.column_names else None
    return np.zeros(0) if values is None else values.to_numpy(zero_copy_only=False)


def unit_of_field(field: Any) -> str:
    """Unit of measure of a column."""
    return (field.metadata or {}).get(b"unit", b"").decode()


class Store:
    """Rows in a folder, which is created. Rows are numbered over all files; a point's row is looked for by its digest.

    columns: names of all columns, with their units of measure.  remarks: on damaged files.  Raises `BadInput` where nothing can be
    written.
    """

    def __init__(self, folder: Path):
        self.folder = folder
        self._files: list[Path] = []
        self._digests: list[np.ndarray] = []  # of each file's rows
        self._done: list[np.ndarray] = []
        self._pending: list[tuple[int, PointResult]] = []  # with their digests, not written yet
        self._since = perf_counter()
        self.columns: dict[str, str] = {}
        self.remarks: list[str] = []
        try:
            folder.mkdir(parents=True, exist_ok=True)
            for part in folder.glob("*.part"):  # what a killed process has left half written
                part.unlink(missing_ok=True)
            for path in sorted(folder.glob("*" + SUFFIX)):
                try:
                    table = _read(path)
                except OSError as error:
                    self.remarks.append(f"{path.name} in {folder.name} is not used: {error.strerror}; its points are run again")
                    continue
                if table is not None:
                    self._index(path, table)
                    continue
                path.unlink(missing_ok=True)
                self.remarks.append(f"{path.name} in {folder.name} was damaged and is removed: its points are run again")
        except OSError as error:
            raise not_written(folder, error) from None

    @classmethod
    def of(cls, task: Task, directory: Path) -> Store:
        """That of the runs of a task in a directory."""
        return cls(directory / "points" / task.base)

    @property
    def size(self) -> int:
        """How many rows there are."""
        return sum(part.size for part in self._digests)

    def append(self, rows: Sequence[tuple[int, PointResult]]) -> None:
        """Add rows with the digests of their points; they are on disk within a second of work, and after `flush`."""
        self._pending += rows
        if perf_counter() - self._since > WRITE_EVERY:
            self.flush()

    def flush(self) -> None:
        """Write what has been appended."""
        import pyarrow
        from pyarrow import feather

        self._since = perf_counter()
        if not self._pending:
            return
        table, self._pending = table_of(self._pending), []
        content = pyarrow.BufferOutputStream()
        feather.write_feather(table, content, compression="uncompressed")
        buffer = content.getvalue()
        path = self.folder / (_name(self.folder, buffer) + SUFFIX)
        try:
            with replaced(path, "wb", synchronized=False, private=True) as file:
                file.write(buffer)
        except OSError as error:
            raise not_written(self.folder, error) from None
        if path not in self._files:
            self._index(path, table)

    def _index(self, path: Path, table: Any) -> None:
        import pyarrow.compute as compute

        self._files.append(path)
        self._digests.append(table.column("digest").to_numpy())
        self._done.append(compute.equal(table.column("outcome"), "done").to_numpy())
        self.columns.update({field.name: unit_of_field(field) for field in table.schema})

    def find(self, digests: np.ndarray, retry: bool = False) -> np.ndarray:
        """(n,) numbers of the rows of points, -1 where there is none: of several the first that is done, else the first.

        `retry`: only rows that are done count.
        """
        import pyarrow
        import pyarrow.compute as compute

        if not self._files:
            return np.full(digests.size, -1)
        known, done = np.concatenate(self._digests), np.concatenate(self._done)
        order = np.argsort(~done, kind="stable")  # a point that was run again after it had failed has two rows
        order = order[: done.sum()] if retry else order
        first = compute.index_in(pyarrow.array(digests), value_set=pyarrow.array(known[order]))
        return np.append(order, -1)[first.fill_null(order.size).to_numpy()]

    def table(self, rows: np.ndarray, columns: Sequence[str] | None = None) -> Any:
        """The rows of these numbers, in this order; nulls where a number is -1, and where a row has no such column.

        Raises `BadInput` where a file has been damaged since the store was opened.
        """
        import pyarrow

        starts = np.cumsum([0, *(part.size for part in self._digests)])
        files = np.where(rows < 0, -1, np.searchsorted(starts, rows, side="right") - 1)
        tables, order = [table_of([]).select([] if columns is not None else [0, 1, 2])], np.full(rows.size, -1)
        taken = 0
        for k in dict.fromkeys(files[files >= 0].tolist()):  # columns in the order of the points, whoever has computed them
            table = _read(self._files[k])
            if table is None:
                raise BadInput(str(self._files[k]), "a damaged file", "the rows of points", "The same command runs them again.")
            if columns is not None:
                table = table.select([c for c in columns if c in table.column_names])
            members = np.flatnonzero(files == k)
            tables.append(table.take(rows[members] - starts[k]))
            order[members] = taken + np.arange(members.size)
            taken += members.size
        return pyarrow.concat_tables(tables, promote_options="default").take(pyarrow.array(order, mask=order < 0))


@dataclass(frozen=True)
class StoredPlan:
    """The points of a plan, the task of their runs, and the store that has the rows of some of them, and of other plans'."""

    task: Task
    plan: Points
    store: Store

    @cached_property
    def digests(self) -> np.ndarray:
        """(n,) of the points."""
        return self.plan.digests(self.task.base, self.task.scene)

    def missing(self, retry: bool = False) -> np.ndarray:
        """Places of points without a row, in the plan's order, equal points once; `retry`: a failed one counts as missing."""
        left = np.flatnonzero(self.store.find(self.digests, retry) < 0)
        return left[np.sort(np.unique(self.digests[left], return_index=True)[1])]

    def rows(self, places: Sequence[int]) -> dict[int, PointResult]:
        """The rows at places, by place; without those that the store does not have."""
        numbers = self.store.find(self.digests[np.array(places, dtype=int)])
        table = self.store.table(numbers)
        return {place: row_of(table, k) for k, place in enumerate(places) if numbers[k] >= 0}

    def pieces(self, columns: Sequence[str] | None = None, size: int = 0) -> Iterator[tuple[slice, Any]]:
        """Slices of the places with a table of the rows there, `size` at a time."""
        numbers, step = self.store.find(self.digests), size or PIECE
        for start in range(0, numbers.size, step):
            some = slice(start, min(start + step, numbers.size))
            yield some, self.store.table(numbers[some], columns)


def _name(folder: Path, content: Any) -> str:
    """What a file is called: by its content and the folder, which stands for the task."""
    return digest_of(folder.name, content)[:32]


def _read(path: Path) -> Any:
    """A file as a table; None where its content is not what its name says. Raises `OSError`, also for another user's file."""
    import pyarrow
    from pyarrow import feather

    with opened_trusted(path) as file:
        content = file.read()
    named = _name(path.parent, content) == path.stem
    return feather.read_table(pyarrow.BufferReader(content), memory_map=False) if named else None
