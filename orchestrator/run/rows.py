"""Rows of recorded signals: in memory, or in an Arrow IPC stream that grows in a result directory and is a Parquet file at the end.

Every chunk of a stream that is whole can be read after `kill -9`; a file of Parquet or HDF5 that is still open has no index.
"""

from __future__ import annotations

import csv
import errno
import hashlib
import io
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np

from ...components.core.errors import BadInput
from ..output import UNFINISHED

TIME = "time"
STREAM, PARQUET, CSV = ".arrows", ".parquet", ".csv"
CSV_ROWS = 5_000  # that are texts at a time

Chunk = tuple[np.ndarray, np.ndarray, np.ndarray]  # time (n,) s, values (n, numbers), texts (n, texts)


def prepare() -> None:
    """Write a table into memory, so that all is there that Arrow makes at its first use.

    C's `exit` undoes what was registered last first: what Arrow registers after a handler is gone when the handler is called.
    """
    import pyarrow
    import pyarrow.parquet as parquet

    rows = Rows((), ("text",))
    table = rows._batch(np.zeros(1), np.zeros((1, 0)), np.array([["a"]], dtype=object))
    table.serialize()
    with parquet.ParquetWriter(pyarrow.BufferOutputStream(), table.schema, **rows._options) as writer:
        writer.write_batch(table)


class Rows:
    """Columns of numbers and of texts over time, to which rows are added; units of measure are metadata of their fields."""

    def __init__(
        self,
        names: Sequence[str],
        texts: Sequence[str] = (),
        *,
        directory: Path | None = None,
        name: str = "",
        units: Mapping[str, str] | None = None,
        title: str = "",
        with_csv: bool = False,
    ):
        """directory: where the rows are stored, by this name; None: in memory.  with_csv: as comma-separated values, too."""
        self.names, self.texts, self.units, self.title = names, texts, units or {}, title
        self.rows, self.begun = 0, False
        self._directory, self._name = directory, name
        self._file: Any = None if directory is None else _stream(directory, name)  # a path
        self._csv = directory / UNFINISHED / (name + CSV) if directory is not None and with_csv else None
        self._chunks: list[Chunk] = []

    @classmethod
    def read(cls, file: Path) -> Rows:
        """The rows in a file, of a stream as far as it was written; raises `OSError` or `ValueError` for what is none."""
        import pyarrow
        import pyarrow.parquet as parquet

        if file.suffix == STREAM:
            with pyarrow.memory_map(str(file)) as content, pyarrow.ipc.open_stream(content) as stream:
                schema = stream.schema
        else:
            schema = parquet.read_schema(_parts(file)[0])
        fields = [f for f in schema if f.name != TIME]
        numbers = [f.name for f in fields if pyarrow.types.is_floating(f.type)]
        units = {f.name: (f.metadata or {}).get(b"unit", b"").decode() for f in fields}
        title = (schema.metadata or {}).get(b"title", b"").decode()
        rows = cls(numbers, [f.name for f in fields if f.name not in numbers], units=units, title=title)
        rows._file = file
        rows.rows = sum(piece.num_rows for piece in _pieces(file, [TIME]))
        return rows

    @property
    def on_disk(self) -> bool:
        """Whether they are not in memory."""
        return self._file is not None

    # -- rows come ---------------------------------------------------------------------------------------------------
    def begin(self) -> None:
        """With no rows, in the place of what was there. Raises `OSError`."""
        self.rows, self.begun, self._chunks, self._sums = 0, True, [], (hashlib.sha256(), hashlib.sha256())
        if self._file is not None:
            self._file.write_bytes(self._schema.serialize())
        if self._csv is not None:
            self._csv.write_bytes(b"")
            with _behind(self._csv) as write:
                write(_csv_lines([["time", *self.names, *self.texts]]))

    def append(self, time: np.ndarray, values: np.ndarray, texts: np.ndarray) -> None:
        """Add n rows, see `Chunk`. Raises `OSError` where they cannot be stored: then none of them are."""
        if not time.size:
            return
        if self._file is None:
            self._chunks.append((time, values, texts))
        else:
            with _behind(self._file) as write, _behind(self._csv) as write_csv:
                write(self._batch(time, values, texts).serialize())
                for first in range(0, time.size if self._csv else 0, CSV_ROWS):
                    some = slice(first, first + CSV_ROWS)
                    columns = [time[some].tolist(), *values[some].T.tolist(), *texts[some].T.tolist()]
                    write_csv(_csv_lines(zip(*columns, strict=True)))
            _add(self._sums, time, values, texts)
        self.rows += time.size

    def copy_rows(self, source: Rows, rows: int) -> None:
        """Hold the first rows of another table, or of this one, and drop all later ones. Raises `OSError`."""
        chunks, target = source.chunks(), self._file
        self._file = target and target.with_suffix(".new")
        self.begin()
        for chunk in chunks:
            n = min(rows - self.rows, chunk[0].size)
            self.append(*(column[:n] for column in chunk))
        if self._file is not None and target is not None:
            os.replace(self._file, target)
            self._file = target

    def state(self) -> dict[str, Any]:
        """Where the rows so far are stored, on the disk for good, and their digest, or where they are in memory the rows."""
        if self._file is None:
            time, values, texts = joined(self)
            return {"time": time, "values": values, "texts": texts.tolist()}
        with open(self._file, "rb+") as file:
            os.fsync(file.fileno())
        return {"directory": str(self._directory), "name": self._name, "rows": self.rows, "digest": _digest(self._sums)}

    def go_on(self, state: Mapping[str, Any], beside: Path | None) -> None:
        """Go on from a `state`; raises `BadInput` where the rows are not stored where they were any more.

        beside: folder of the checkpoint, where they may be whatever its name was.
        """
        if "directory" not in state:
            source, time, values = Rows(self.names, self.texts), state["time"], state["values"]
            if values.shape != (time.size, len(self.names)):
                raise ValueError(f"rows of shape {values.shape}, expected {time.size, len(self.names)}")
            source.append(time, values, np.array(state["texts"], dtype=object).reshape(time.size, len(self.texts)))
            self.copy_rows(source, time.size)
            return
        directories = [d for d in (beside, Path(state["directory"])) if d is not None]
        files = [file for d in directories for file in (_stream(d, state["name"]), d / (state["name"] + PARQUET))]
        for file in files:
            with suppress(OSError, ValueError):
                source = Rows.read(file)
                if source._digest_of(state["rows"]) == state["digest"]:
                    break
        else:
            raise BadInput(
                "resume",
                f"a checkpoint whose {state['rows']} rows are not in {state['directory']!r} any more",
                "the result directory of its run, unchanged",
                "Another run has written there, or it is damaged.",
            )
        self.copy_rows(source, state["rows"])

    def _digest_of(self, rows: int) -> bytes:
        """Of the first rows; the same in whatever chunks and format they are stored."""
        sums, seen = (hashlib.sha256(), hashlib.sha256()), 0
        for chunk in self.chunks():
            n = min(rows - seen, chunk[0].size)
            _add(sums, *(column[:n] for column in chunk))
            seen += n
        return _digest(sums)

    # -- at the end --------------------------------------------------------------------------------------------------
    def store(self) -> None:
        """Write the Parquet file, beside the stream. Raises `OSError`."""
        import pyarrow.parquet as parquet

        path = self._file.parent / (self._name + PARQUET)
        path.parent.mkdir(exist_ok=True)
        with parquet.ParquetWriter(path, self._schema, **self._options) as writer:
            for piece in _pieces(self._file):
                writer.write_table(piece)

    def stored(self) -> None:
        """The Parquet file is in its place: the stream goes."""
        self._file.unlink()
        self._file = self._file.parent.parent / (self._name + PARQUET)

    # -- for Arrow ---------------------------------------------------------------------------------------------------
    @property
    def _schema(self) -> Any:
        import pyarrow

        numbers = [pyarrow.field(n, pyarrow.float64(), metadata={"unit": self.units.get(n, "")}) for n in self.names]
        texts = [pyarrow.field(n, pyarrow.string()) for n in self.texts]
        return pyarrow.schema(
            [pyarrow.field(TIME, pyarrow.float64(), metadata={"unit": "s"}), *numbers, *texts],
            metadata={"title": self.title, "format": "cosimo result 1"},
        )

    def _batch(self, time: np.ndarray, values: np.ndarray, texts: np.ndarray) -> Any:
        import pyarrow

        return pyarrow.RecordBatch.from_arrays([_arrow(c) for c in (time, *values.T, *texts.T)], schema=self._schema)

    @property
    def _options(self) -> dict[str, Any]:
        numbers = [TIME, *self.names]
        return {
            "compression": "zstd",
            "compression_level": 1,
            "use_dictionary": list(self.texts),
            "use_byte_stream_split": numbers,
        }

    # -- rows are read -----------------------------------------------------------------------------------------------
    def chunks(self) -> Iterator[Chunk]:
        """All rows, in pieces."""
        return iter(self._chunks) if self._file is None else self._read_chunks(self._file)

    def _read_chunks(self, file: Path) -> Iterator[Chunk]:
        n = len(self.names)
        for time, *columns in self._read(file, [TIME, *self.names, *self.texts]):
            texts = np.array(columns[n:], dtype=object).reshape(-1, time.size).T
            yield time, np.array(columns[:n], dtype=float).reshape(-1, time.size).T, texts

    def _read(self, file: Path, names: Sequence[str]) -> Iterator[list[np.ndarray]]:
        """Columns of one piece after the other."""
        for piece in _pieces(file, names):  # it has more than those where one name starts another
            yield [_values(piece.column(n), n in self.texts) for n in names]

    def column(self, name: str) -> np.ndarray:
        """A column of stored rows, (rows,)."""
        if name not in (TIME, *self.names, *self.texts):
            raise KeyError(name)
        whole = np.empty(self.rows, dtype=object if name in self.texts else float)
        first = 0
        for (values,) in self._read(self._file, [name]):
            whole[first : first + values.size] = values
            first += values.size
        return whole

    def extremes(self, name: str) -> tuple[float, float, float]:
        """Smallest, largest and last value of a stored column of numbers."""
        low, high, last = np.inf, -np.inf, np.nan
        for (values,) in self._read(self._file, [name]):
            low, high, last = np.minimum(low, values.min()), np.maximum(high, values.max()), values[-1]
        return float(low), float(high), float(last)


def joined(rows: Rows) -> Chunk:
    """All rows as one chunk."""
    chunks = list(rows.chunks())
    if len(chunks) == 1:
        return chunks[0]
    empty = np.zeros(0), np.zeros((0, len(rows.names))), np.zeros((0, len(rows.texts)), dtype=object)
    return tuple(np.concatenate([e, *c]) for e, *c in zip(empty, *chunks, strict=True))  # type: ignore[return-value]


def _stream(directory: Path, name: str) -> Path:
    return directory / UNFINISHED / (name.replace("/", "-") + STREAM)


def _parts(file: Path) -> list[Path]:
    """The file; those of an earlier version, which stored the chunks of a table as files in a folder."""
    parts = sorted(file.glob("*" + PARQUET)) if file.is_dir() else [file]
    if not parts:
        raise ValueError(f"{file} holds no parts of a table")
    return parts


def _pieces(file: Path, names: Sequence[str] | None = None) -> Iterator[Any]:
    """Tables of Arrow, one after the other, with at least the named columns."""
    import pyarrow
    import pyarrow.parquet as parquet

    if file.suffix != PARQUET:
        whole = suppress(StopIteration, pyarrow.ArrowInvalid, OSError)  # a last chunk that is not
        with pyarrow.memory_map(str(file)) as content, pyarrow.ipc.open_stream(content) as stream, whole:
            while True:
                yield pyarrow.Table.from_batches([stream.read_next_batch()])
        return
    for path in _parts(file):
        with parquet.ParquetFile(path) as part:
            for k in range(part.num_row_groups):
                yield part.read_row_group(k, names, use_threads=False)


@contextmanager
def _behind(file: Path | None) -> Iterator[Callable[[bytes], None]]:
    """A function that writes behind the end of a file; after an error the file is as it was."""
    if file is None:
        yield lambda _: None
        return
    with open(file, "ab", buffering=0) as out:
        end = out.tell()

        def write(content: Any) -> None:
            rest = memoryview(content)
            while rest:
                rest = rest[out.write(rest) :]

        try:
            yield write
        except BaseException:
            with suppress(OSError):
                out.truncate(end)
            raise


def _csv_lines(rows: Any) -> bytes:
    lines = io.StringIO()
    csv.writer(lines, quoting=csv.QUOTE_NONNUMERIC, lineterminator="\n").writerows(rows)
    return lines.getvalue().encode()


def _add(sums: Any, time: np.ndarray, values: np.ndarray, texts: np.ndarray) -> None:
    """Add rows to the digests of all numbers and of all texts."""
    sums[0].update(np.ascontiguousarray(np.column_stack((time, values))))
    sums[1].update("".join(f"{text}\0" for text in texts.ravel()).encode())


def _digest(sums: Any) -> bytes:
    return sums[0].digest() + sums[1].digest()


def _arrow(values: np.ndarray) -> Any:
    """Numbers as floats, objects as texts, (n,), for Arrow. What Arrow has for it imports pandas, half a second."""
    import pyarrow

    if values.dtype != object:
        return pyarrow.Array.from_buffers(pyarrow.float64(), values.size, [None, pyarrow.py_buffer(np.ascontiguousarray(values))])
    texts = [text.encode() for text in values]
    ends = np.cumsum([0, *map(len, texts)])
    if ends[-1] >= 2**31:
        raise OSError(errno.EFBIG, "texts of more than 2 GB in one chunk")
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
