"""Rows of recorded signals: in memory, or in a directory of Parquet parts that are put in place one by one.

Of the formats tried under `kill -9`, parts were the one whose every completed chunk was readable after each kill; a file of
Parquet or HDF5 that is still open has no index, and none of it is.
"""

from __future__ import annotations

import hashlib
import os
import shutil
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Protocol

import numpy as np

TIME = "time"
PART = "part-{:06d}.parquet"
INTERNAL = ".part"  # suffix of a file that is not whole


class Table(Protocol):
    """Columns of numbers and of texts over time, to which rows are added."""

    names: Sequence[str]
    texts: Sequence[str]

    def append(self, time: np.ndarray, values: np.ndarray, texts: np.ndarray) -> None:
        """Add n rows. time: (n,) s; values: (n, numbers); texts: (n, texts)."""

    def chunks(self) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
        """What was added, in pieces of the same three."""

    @property
    def rows(self) -> int:
        """How many rows there are."""


class MemoryTable:
    """Rows in memory."""

    def __init__(self, names: Sequence[str], texts: Sequence[str] = ()):
        self.names, self.texts, self.rows = names, texts, 0
        self._chunks: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = []

    def append(self, time: np.ndarray, values: np.ndarray, texts: np.ndarray) -> None:
        """As in `Table`."""
        self._chunks.append((time, values, texts))
        self.rows += time.size

    def chunks(self) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
        """As in `Table`."""
        return iter(self._chunks)

    def clear(self) -> None:
        """Forget all rows."""
        self._chunks.clear()
        self.rows = 0


def prepare() -> None:
    """Write a table into memory, so that all is there that Arrow makes at its first use.

    C's `exit` undoes what was registered last first: what Arrow registers after a handler is gone when the handler is called.
    """
    import pyarrow
    import pyarrow.parquet as parquet

    table = pyarrow.table({TIME: arrow_array(np.zeros(1)), "text": arrow_array(np.array(["a"], dtype=object))})
    parquet.write_table(
        table, pyarrow.BufferOutputStream(), compression="zstd", use_dictionary=["text"], use_byte_stream_split=[TIME]
    )


class StoredTable:
    """Rows in a folder of Parquet files, which other programs read as one table; units of measure are metadata of its fields."""

    def __init__(
        self,
        folder: Path,
        names: Sequence[str],
        texts: Sequence[str] = (),
        units: Mapping[str, str] | None = None,
        title: str = "",
    ):
        """A new table in `folder`, which is created."""
        self.folder, self.names, self.texts, self.rows = folder, names, texts, 0
        self._units, self._title, self._parts = units or {}, title, 0
        self._chain, self._synced = b"", 0
        self.begun = False  # has rows of its own, or goes on with those of another
        folder.mkdir(parents=True, exist_ok=True)

    @classmethod
    def read(cls, folder: Path) -> StoredTable:
        """The table in a folder, as far as it was written; raises `OSError` or `ValueError` for what is none."""
        import pyarrow
        import pyarrow.parquet as parquet

        paths = sorted(folder.glob(PART.replace("{:06d}", "*")))
        if not paths:
            raise ValueError(f"{folder} holds no parts of a table")
        schema = parquet.read_schema(paths[0])
        fields = [f for f in schema if f.name != TIME]
        table = cls.__new__(cls)
        table.folder, table._parts = folder, len(paths)
        table._chain, table._synced, table.begun = b"", len(paths), True  # it is only read
        table.names = [f.name for f in fields if pyarrow.types.is_floating(f.type)]
        table.texts = [f.name for f in fields if not pyarrow.types.is_floating(f.type)]
        table._units = {f.name: (f.metadata or {}).get(b"unit", b"").decode() for f in fields}
        table._title = (schema.metadata or {}).get(b"title", b"").decode()
        table.rows = sum(parquet.read_metadata(p).num_rows for p in paths)
        return table

    @property
    def title(self) -> str:
        """What the rows are of."""
        return self._title

    @property
    def units(self) -> Mapping[str, str]:
        """Units of measure by column."""
        return self._units

    def append(self, time: np.ndarray, values: np.ndarray, texts: np.ndarray) -> None:
        """As in `Table`: one more file, which appears as a whole; raises `OSError` where it cannot be written."""
        import pyarrow
        import pyarrow.parquet as parquet

        self.begun = True
        if not time.size:
            return
        schema = self._schema()
        columns = [time, *values.T, *texts.T]
        arrays = [arrow_array(c) for c in columns]
        path = self.folder / PART.format(self._parts)
        part = path.with_name(path.name + INTERNAL)
        try:
            parquet.write_table(
                pyarrow.Table.from_arrays(arrays, schema=schema),
                part,
                compression="zstd",
                compression_level=1,
                use_dictionary=list(self.texts),
                use_byte_stream_split=[TIME, *self.names],
            )
            os.replace(part, path)
        except BaseException:
            part.unlink(missing_ok=True)
            raise
        self._parts += 1
        self.rows += time.size
        self._chain = _linked(self._chain, path)

    def mark(self) -> dict[str, Any]:
        """What is there now, on the disk for good: numbers of parts and rows, and one digest over all parts, for `go_on`."""
        for k in range(self._synced, self._parts):
            with open(self.folder / PART.format(k), "rb+") as part:
                os.fsync(part.fileno())
        self._synced = self._parts
        return {"parts": self._parts, "rows": self.rows, "digest": self._chain}

    @staticmethod
    def has(folder: Path, mark: Mapping[str, Any]) -> bool:
        """Whether a folder holds the parts that were there at a `mark`, undamaged; there may be more."""
        chain = b""
        try:
            for k in range(mark["parts"]):
                chain = _linked(chain, folder / PART.format(k))
        except OSError:
            return False
        return chain == mark["digest"]

    def go_on(self, folder: Path, mark: Mapping[str, Any]) -> None:
        """Be the table that was in a folder, which may be the own one, at a `mark`: its parts, and none that came later.

        Parts are never changed, so that two folders may share one.
        """
        kept = {PART.format(k) for k in range(mark["parts"])}
        same = folder.resolve() == self.folder.resolve()
        for path in self.folder.iterdir():
            if not (same and path.name in kept):
                path.unlink()
        for name in sorted(kept) if not same else ():
            try:
                os.link(folder / name, self.folder / name)
            except OSError:  # another disk, or a file system without links
                shutil.copyfile(folder / name, self.folder / (name + INTERNAL))
                os.replace(self.folder / (name + INTERNAL), self.folder / name)
        self._parts, self.rows, self._chain = mark["parts"], mark["rows"], mark["digest"]
        self._synced, self.begun = 0, True

    def _schema(self) -> Any:
        import pyarrow

        numbers = [pyarrow.field(n, pyarrow.float64(), metadata={"unit": self._units.get(n, "")}) for n in self.names]
        texts = [pyarrow.field(n, pyarrow.string()) for n in self.texts]
        return pyarrow.schema(
            [pyarrow.field(TIME, pyarrow.float64(), metadata={"unit": "s"}), *numbers, *texts],
            metadata={"title": self._title, "format": "cosimo result 1"},
        )

    def _each(self, names: Sequence[str]) -> Iterator[list[np.ndarray]]:
        """Columns of one part after the other."""
        import pyarrow.parquet as parquet

        for k in range(self._parts):
            with parquet.ParquetFile(self.folder / PART.format(k)) as file:
                part = file.read(list(names), use_threads=False)  # more than those where one name starts another
            yield [_values(part.column(n), n in self.texts) for n in names]

    def column(self, name: str) -> np.ndarray:
        """A column, (rows,)."""
        if name not in self.texts and name != TIME and name not in self.names:
            raise KeyError(name)
        whole = np.empty(self.rows, dtype=object if name in self.texts else float)
        first = 0
        for (values,) in self._each([name]):
            whole[first : first + values.size] = values
            first += values.size
        return whole

    def chunks(self) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
        """As in `Table`."""
        n = len(self.names)
        for time, *columns in self._each([TIME, *self.names, *self.texts]):
            texts = np.array(columns[n:], dtype=object).reshape(-1, time.size).T
            yield time, np.array(columns[:n], dtype=float).reshape(-1, time.size).T, texts

    def extremes(self, name: str) -> tuple[float, float, float]:
        """Smallest, largest and last value of a column of numbers."""
        low, high, last = np.inf, -np.inf, np.nan
        for (values,) in self._each([name]):
            low, high, last = np.minimum(low, values.min()), np.maximum(high, values.max()), values[-1]
        return float(low), float(high), float(last)


def arrow_array(values: np.ndarray) -> Any:
    """Numbers as floats, objects as texts, (n,), for Arrow. What Arrow has for it imports pandas, half a second."""
    import pyarrow

    if values.dtype != object:
        return pyarrow.Array.from_buffers(pyarrow.float64(), values.size, [None, pyarrow.py_buffer(np.ascontiguousarray(values))])
    texts = [text.encode() for text in values]
    ends = np.cumsum([0, *map(len, texts)])
    if ends[-1] >= 2**31:  # Arrow makes chunks of them
        return pyarrow.array(values.tolist(), pyarrow.string())
    buffers = [None, pyarrow.py_buffer(ends.astype(np.int32)), pyarrow.py_buffer(b"".join(texts))]
    return pyarrow.Array.from_buffers(pyarrow.string(), values.size, buffers)


def _values(column: Any, texts: bool) -> np.ndarray:
    """What a column of Arrow holds, (n,), without its own way over pandas."""
    if texts:
        return np.array(column.to_pylist(), dtype=object)
    if column.null_count:
        return column.to_numpy()
    pieces = [np.frombuffer(part.buffers()[1], count=len(part), offset=8 * part.offset) for part in column.chunks if len(part)]
    return np.concatenate([np.zeros(0), *pieces])


def _linked(chain: bytes, path: Path) -> bytes:
    """The digest of a chain of files with one more at its end."""
    with open(path, "rb") as file:
        return hashlib.sha256(chain + hashlib.file_digest(file, "sha256").digest()).digest()


def joined(table: Table) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """All rows: time (n,), values (n, numbers), texts (n, texts)."""
    chunks = list(table.chunks())
    if len(chunks) == 1:
        return chunks[0]
    empty = np.zeros(0), np.zeros((0, len(table.names))), np.zeros((0, len(table.texts)), dtype=object)
    return tuple(np.concatenate([e, *c]) for e, *c in zip(empty, *chunks, strict=True))  # type: ignore[return-value]


class StoredColumns(Mapping[str, np.ndarray]):
    """Columns that are read when they are asked for, and not kept."""

    def __init__(self, table: StoredTable, names: Sequence[str]):
        self.table, self._names = table, dict.fromkeys(names)

    def __getitem__(self, name: str) -> np.ndarray:
        if name not in self._names:
            raise KeyError(name)
        return self.table.column(name)

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)
