"""Where the rows of a run go: into tables in memory, or into its result directory as they come.

A directory holds the result of its last run that came to an end. What a run writes meanwhile is in its folder `unfinished`, and
takes the place of the earlier result at the end; after `kill -9` it is still there, readable up to the last chunk.
"""

from __future__ import annotations

import errno
import os
import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path
from time import perf_counter
from typing import Any

from ..engine.stepping.loop import BatchObserver
from ..output import HOLDER, PLOTLY, SAMPLES_ENDING, UNFINISHED
from ..units.fmu_messages import log_lines
from .recorders import Recorder
from .rows import PARQUET, STREAM, Rows, prepare
from .run_record import RunRecord

RESULT = "result"
TABLE, CSV, INFO, SNAPSHOTS = f"{RESULT}.parquet", f"{RESULT}.csv", "run.json", "snapshots"
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


class OutputFailed(Exception):
    """The rows of a run cannot be written."""


class ResultFiles(BatchObserver):
    """Writes the rows of a run into a directory as they come: an Arrow IPC stream, and the same as comma-separated values."""

    def __init__(self, directory: Path):
        prepare()  # before the units: one that ends the process from inside leaves results to be written
        self.directory = directory.absolute()  # wherever a unit goes
        self._folder = self.directory / UNFINISHED
        self._recorders: list[Recorder] = []
        self._tables: list[Rows] = []
        self._pause, self._due = FIRST_SECONDS, perf_counter() + FIRST_SECONDS

    def open(
        self, names: Sequence[str], texts: Sequence[str], units: Mapping[str, str], info: RunRecord, *, resumed: bool = False
    ) -> Rows:
        """Begin with nothing, and `info` of a run that has not ended; the table of the result. Raises `OSError`.

        `resumed`: rows that are there stay, until it is known whether the run goes on with them.
        """
        for name in (*DERIVED, TABLE, SNAPSHOTS, CSV, INFO):  # now, not after a long run
            _refuse_foreign(self.directory / name, name in (TABLE, SNAPSHOTS))
        for entry in self._folder.iterdir():
            if entry.name != HOLDER and not (resumed and entry.suffix == STREAM):
                shutil.rmtree(entry) if entry.is_dir() else entry.unlink()
        (self._folder / RESERVE).write_bytes(os.urandom(RESERVED))
        info.write(self._folder / INFO)
        self._resumed = resumed
        return self._table(names, texts, name=RESULT, units=units, title=info.scene["name"], with_csv=True)

    def snapshots(self, name: str, elements: Sequence[str]) -> Rows:
        """The table of the snapshots of an array."""
        return self._table(elements, name=f"{SNAPSHOTS}/{len(self._tables):03d}", title=name)

    def _table(self, *columns: Sequence[str], **named: Any) -> Rows:
        self._tables.append(Rows(*columns, directory=self.directory, **named))
        if not self._resumed:
            self._tables[-1].begin()
        return self._tables[-1]

    def watch(self, recorders: Sequence[Recorder]) -> None:
        """What is written from now on."""
        self._recorders = list(recorders)
        self._limits = [min(CHUNK_ROWS, max(CHUNK_VALUES // (1 + len(r.table.names)), 1)) for r in recorders]

    def __call__(self, tick: int, t: float) -> None:
        for recorder, limit in zip(self._recorders, self._limits, strict=True):
            if recorder.pending >= limit:
                self._flush(recorder)
        if perf_counter() >= self._due:
            self.flush()

    def flush(self) -> None:
        """Write what has come since the last chunk; raises `OutputFailed`."""
        self._pause = min(2.0 * self._pause, CHUNK_SECONDS)
        self._due = perf_counter() + self._pause
        for recorder in self._recorders:
            self._flush(recorder)

    def _flush(self, recorder: Recorder) -> None:
        try:
            recorder.flush()
        except OSError as error:
            raise self.failed(error) from None

    def failed(self, error: OSError) -> OutputFailed:
        """What to raise for rows that cannot be written."""
        return OutputFailed(f"the results cannot be written to {str(self.directory)!r}: {error.strerror or error}")

    def finish(self, info: RunRecord) -> None:
        """All rows are written: the result takes the place of an earlier one. Raises `OutputFailed`.

        Also where a run that was to go on has ended before it did: what the earlier one has left stays.
        """
        if not all(table.begun for table in self._tables):
            raise OutputFailed(f"the run has ended before it went on; in {str(self.directory)!r} nothing was changed")
        try:
            (self._folder / RESERVE).unlink(missing_ok=True)
            info.write(self._folder / INFO)
            if lines := log_lines(info.fmu_log):
                (self._folder / LOG).write_text("\n".join(lines) + "\n", encoding="utf-8")
            for table in self._tables:
                table.store()
            for name in (*DERIVED, LOG, TABLE, SNAPSHOTS, CSV, INFO):  # last what says that it is whole
                _move(self._folder / name, self.directory / name)
            for table in self._tables:
                table.stored()
        except OSError as error:
            raise self.failed(error) from None


def _refuse_foreign(path: Path, folder: bool) -> None:
    """Raises `OSError` where what the result would replace is none of its kind: a folder for a file, or somebody's folder."""
    if path.is_dir() and not folder:
        raise OSError(errno.EISDIR, f"{path.name} there is a folder")
    if path.is_dir() and any(entry.suffix != PARQUET for entry in path.iterdir()):
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
