"""Where the rows of a run go: into tables in memory, or into its result directory as they come.

A directory holds the result of its last run that came to an end. What a run writes meanwhile is in its folder `unfinished`, and
takes the place of the earlier result at the end; after `kill -9` it is still there, readable up to the last chunk.
"""

from __future__ import annotations

import csv
import errno
import os
import shutil
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from fractions import Fraction
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import IO, TYPE_CHECKING, Any

import numpy as np

from ...components.core.errors import BadInput
from ..engine.stepping.loop import BatchObserver
from ..output import HOLDER, PLOTLY, SAMPLES_ENDING, UNFINISHED, write_json
from ..units.fmu_messages import log_lines
from .recorders import Recorder, TextRecorder, reading
from .tables import INTERNAL, MemoryTable, StoredTable, Table, joined, prepare

if TYPE_CHECKING:
    from ..engine.algorithms.master import Master
    from ..engine.coupling import Coupling
    from ..units import Simulator

TABLE, CSV, INFO, SNAPSHOTS = "result.parquet", "result.csv", "run.json", "snapshots"
LOG = "fmu.log"  # what foreign FMUs have said
DERIVED = (
    "report.html",
    "report.pdf",
    "report" + SAMPLES_ENDING,
    PLOTLY,
    "summary.json",
    "summary.csv",
    "validation.json",
    "validation.csv",
)  # made of a result, and gone with it
RESERVE = "reserve"  # a file to be removed where the disk is full, so that the outcome can still be written
RESERVED = 1 << 16  # bytes
CHUNK_ROWS, CHUNK_VALUES, CHUNK_SECONDS = 100_000, 1_000_000, 5.0  # a chunk is written when it has reached one of them
FIRST_SECONDS = 0.2  # a run that is killed early leaves something, too; then twice as long each time
CSV_ROWS = 5_000  # that are texts at a time


class OutputFailed(Exception):
    """The rows of a run cannot be written."""


class Spool:
    """Recorders of the same rows and the table these go to; takes part in checkpoints."""

    def __init__(
        self,
        recorder: Recorder,
        table: Table,
        columns: Sequence[int] | None = None,
        texts: TextRecorder | None = None,
        beside: Path | None = None,
    ):
        """`columns`: those of the recorder that the table has; default: all. `texts`: records the same rows.

        `beside`: folder of the checkpoint from which the run goes on, where its result may be whatever its name was.
        """
        self.recorder, self.table, self.texts = recorder, table, texts
        self._columns, self._beside = columns, beside
        self.write: Callable[[], None] = self.flush  # with the messages of who writes the files

    @property
    def recorders(self) -> list[Recorder]:
        """All of them, that of the texts first: an interrupt leaves it no row behind."""
        return [*([self.texts] if self.texts is not None else []), self.recorder]

    @property
    def last(self) -> float:
        """Time of the last row, s; without one, minus infinity."""
        return self.recorder.last

    def drain(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Rows that are not in the table yet; the recorders keep them no longer."""
        rows = self.recorder.rows if self.texts is None else min(self.recorder.rows, self.texts.rows)
        time, values = self.recorder.drain(rows)
        texts = np.zeros((rows, 0), dtype=object) if self.texts is None else self.texts.drain(rows)[1]
        return time, values if self._columns is None else values[:, self._columns], texts

    def flush(self) -> None:
        """Rows that are not in the table yet go there."""
        self.table.append(*self.drain())

    def forget(self, t: float) -> None:
        """Drop the rows behind t, s: the run has been taken back to there. For rows in memory."""
        self.flush()
        time, values, texts = joined(self.table)
        rows = int(np.searchsorted(time, t, side="right"))
        assert isinstance(self.table, MemoryTable)
        self.table.clear()
        self.table.append(time[:rows], values[:rows], texts[:rows])
        for recorder in self.recorders:
            recorder.go_back()

    def state(self) -> dict[str, Any]:
        """Where the rows so far are stored, or where they are in memory the rows, for a checkpoint."""
        self.write()
        recorders = [r.state() for r in self.recorders]
        if isinstance(self.table, StoredTable):
            folder = self.table.folder.parents[self.table.folder.parts[::-1].index(UNFINISHED)]
            stored = {"directory": str(folder), "table": self.table.folder.relative_to(folder / UNFINISHED).as_posix()}
            return {"stored": stored | self.table.mark(), "recorders": recorders}
        time, values, texts = joined(self.table)
        return {"time": time, "values": values, "texts": texts.tolist(), "recorders": recorders}

    def take(self, state: Mapping[str, Any]) -> None:
        """Go on from a `state`; raises `BadInput` where the rows are not stored where they were any more."""
        for recorder, own in zip(self.recorders, state["recorders"], strict=True):
            recorder.take(own)
        if "stored" in state:
            self._take_stored(state["stored"])
            return
        time, values = state["time"], state["values"]
        texts = np.array(state["texts"], dtype=object).reshape(time.size, len(self.table.texts))
        if values.shape != (time.size, len(self.table.names)):
            raise ValueError(f"rows of shape {values.shape}, expected {time.size, len(self.table.names)}")
        if isinstance(self.table, StoredTable):
            self.table.go_on(self.table.folder, {"parts": 0, "rows": 0, "digest": b""})
        self.table.append(time, values, texts)

    def _take_stored(self, stored: Mapping[str, Any]) -> None:
        directories = [d for d in (self._beside, Path(stored["directory"])) if d is not None]
        folders = [Path(d, *between, stored["table"]) for d in directories for between in ([UNFINISHED], [])]
        source = next((folder for folder in folders if StoredTable.has(folder, stored)), None)
        if source is None:
            raise BadInput(
                "resume",
                f"a checkpoint whose {stored['rows']} rows are not in {stored['directory']!r} any more",
                "the result directory of its run, unchanged",
                "Another run has written there, or it is damaged.",
            )
        if isinstance(self.table, StoredTable):
            self.table.go_on(source, stored)
        elif stored["parts"]:
            rest = stored["rows"]
            for time, values, texts in StoredTable.read(source).chunks():
                if rest:
                    self.table.append(time, values, texts)
                rest -= min(rest, time.size)


def signals_spool(
    master: Master,
    units: Mapping[str, Simulator],
    coupling: Coupling,
    table: Table,
    every: Fraction,
    end: int,
    beside: Path | None = None,
) -> Spool:
    """The spool of all signals and texts that a scene records; every, end: ticks."""
    # what the master reads in every step anyway is kept as a whole; picking columns can wait to the end of the run
    ends, texts = list(master.positions), coupling.recorded_texts
    signals = Recorder(master.sample, len(ends), every, end, of_master=True)
    of_texts = TextRecorder(reading(units, texts, texts=True), len(texts), every, end) if texts else None
    places = {end: k for k, end in enumerate(ends)}
    return Spool(signals, table, [places[signal] for signal in coupling.signals], of_texts, beside)


class ResultFiles(BatchObserver):
    """Writes the rows of a run into a directory as they come: Parquet parts, and the same as comma-separated values."""

    def __init__(self, directory: Path):
        prepare()  # before the units: one that ends the process from inside leaves results to be written
        self.directory = directory.absolute()  # wherever a unit goes
        self._folder = self.directory / UNFINISHED
        self._spools: list[Spool] = []
        self._tables: list[StoredTable] = []
        self._csv: IO[str] | None = None
        self._pause, self._due = FIRST_SECONDS, perf_counter() + FIRST_SECONDS
        self.failure = ""  # why nothing more is written

    def open(
        self,
        names: Sequence[str],
        texts: Sequence[str],
        units: Mapping[str, str],
        info: Mapping[str, Any],
        *,
        resumed: bool = False,
    ) -> Table:
        """Begin with nothing, and `info` of a run that has not ended; the table of the result. Raises `OSError`.

        `resumed`: tables that are there stay, until it is known whether the run goes on with them.
        """
        for name in (*DERIVED, TABLE, SNAPSHOTS, CSV, INFO):  # now, not after a long run
            _refuse_foreign(self.directory / name, name in (TABLE, SNAPSHOTS))
        for entry in self._folder.iterdir():
            if entry.name != HOLDER and not (resumed and entry.name in (TABLE, SNAPSHOTS)):
                shutil.rmtree(entry) if entry.is_dir() else entry.unlink()
        (self._folder / RESERVE).write_bytes(os.urandom(RESERVED))
        write_json(self._folder / INFO, info)
        self._csv = open(self._folder / CSV, "w", encoding="utf-8", newline="")  # noqa: SIM115 - open for the whole run
        self._writer = csv.writer(self._csv, quoting=csv.QUOTE_NONNUMERIC, lineterminator="\n")
        self._writer.writerow(["time", *names, *texts])
        self._csv.flush()
        self._whole = os.fstat(self._csv.fileno()).st_size  # bytes of whole chunks
        self._resumed = resumed
        table = _WithCsv(self._folder / TABLE, names, texts, units, title=info["scene"]["name"], write=self._write_rows)
        self._tables.append(table)
        return table

    def snapshots(self, name: str, elements: Sequence[str]) -> Table:
        """The table of the snapshots of an array."""
        self._tables.append(StoredTable(self._folder / SNAPSHOTS / f"{len(self._tables):03d}.parquet", elements, title=name))
        return self._tables[-1]

    def watch(self, spools: Sequence[Spool]) -> None:
        """What is written from now on."""
        self._spools = list(spools)
        for spool in spools:
            spool.write = partial(self._write_out, spool)
        self._limits = [min(CHUNK_ROWS, max(CHUNK_VALUES // (1 + len(s.table.names)), 1)) for s in spools]

    def __call__(self, tick: int, t: float) -> None:
        for spool, limit in zip(self._spools, self._limits, strict=True):
            if spool.recorder.pending >= limit:
                self._flush(spool)
        if perf_counter() >= self._due:
            self.flush()

    def flush(self) -> None:
        """Write what has come since the last chunk; raises `OutputFailed`."""
        self._pause = min(2.0 * self._pause, CHUNK_SECONDS)
        self._due = perf_counter() + self._pause
        for spool in self._spools:
            self._flush(spool)

    def finish(self, info: Mapping[str, Any]) -> None:
        """All rows are written: the result takes the place of an earlier one. Raises `OutputFailed`.

        Also where a run that was to go on has ended before it did: what the earlier one has left stays.
        """
        if self._resumed and not all(table.begun for table in self._tables):
            raise OutputFailed(f"the run has ended before it went on; in {str(self.directory)!r} nothing was changed")
        try:
            (self._folder / RESERVE).unlink(missing_ok=True)
            write_json(self._folder / INFO, info)
            if lines := log_lines(info.get("fmu_log", {})):
                (self._folder / LOG).write_text("\n".join(lines) + "\n", encoding="utf-8")
            self.close()
            for name in (*DERIVED, LOG, TABLE, SNAPSHOTS, CSV, INFO):  # last what says that it is whole
                _move(self._folder / name, self.directory / name)
            for table in self._tables:
                table.folder = self.directory / table.folder.relative_to(self._folder)
        except OSError as error:
            raise OutputFailed(self._text(error)) from None

    def close(self) -> None:
        """Let go of the CSV file, with whole chunks only."""
        if self._csv is None or self._csv.closed:
            return
        with suppress(OSError):
            self._csv.close()
        if self.failure:
            os.truncate(self._folder / CSV, self._whole)

    def _write_out(self, spool: Spool) -> None:
        """Write what a checkpoint relies on."""
        self._flush(spool)
        if self.failure:
            raise OutputFailed(self.failure)

    def _flush(self, spool: Spool) -> None:
        if self.failure:
            return
        try:
            spool.flush()
        except OSError as error:
            self.failure = self._text(error)
            raise OutputFailed(self.failure) from None

    def _write_rows(self, time: np.ndarray, values: np.ndarray, texts: np.ndarray) -> None:
        assert self._csv is not None
        for first in range(0, time.size, CSV_ROWS):
            some = slice(first, first + CSV_ROWS)
            columns = [time[some].tolist(), *values[some].T.tolist(), *texts[some].T.tolist()]
            self._writer.writerows(zip(*columns, strict=True))
        self._csv.flush()
        self._whole = os.fstat(self._csv.fileno()).st_size

    def _text(self, error: OSError) -> str:
        return f"the results cannot be written to {str(self.directory)!r}: {error.strerror or error}"


class _WithCsv(StoredTable):
    """Writes the same rows elsewhere as well."""

    def __init__(self, *arguments: Any, write: Any, **named: Any):
        super().__init__(*arguments, **named)
        self._write = write

    def append(self, time: np.ndarray, values: np.ndarray, texts: np.ndarray) -> None:
        super().append(time, values, texts)
        self._write(time, values, texts)

    def go_on(self, folder: Path, mark: Mapping[str, Any]) -> None:
        super().go_on(folder, mark)
        for rows in self.chunks():
            self._write(*rows)


def _refuse_foreign(path: Path, folder: bool) -> None:
    """Raises `OSError` where what the result would replace is none of its kind: a file for a folder, or somebody's folder."""
    if path.exists() and path.is_dir() != folder:
        code = errno.ENOTDIR if folder else errno.EISDIR
        raise OSError(code, f"{path.name} there is {'a file' if folder else 'a folder'}")
    if folder and path.is_dir() and any(entry.suffix not in (".parquet", INTERNAL) for entry in path.iterdir()):
        raise OSError(errno.EEXIST, f"the folder {path.name} there has other files than those of a result")


def _move(new: Path, old: Path) -> None:
    """Put a file or folder in the place of another one; without a new one, the old one goes."""
    if old.is_dir():
        aside = new.with_name(f"old-{new.name}")
        os.replace(old, aside)
        if new.exists():
            os.replace(new, old)
        shutil.rmtree(aside, ignore_errors=True)
    elif new.exists():
        os.replace(new, old)
    else:
        old.unlink(missing_ok=True)
