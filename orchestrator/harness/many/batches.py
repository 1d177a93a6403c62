"""A batch of points in one process, written as it comes: what was computed is on disk before anyone is told of it.

A part is an Arrow file that appears as a whole. A killed process loses at most the points of its last second. Arrow, not
Parquet: parts have few rows and many columns, of which Parquet takes ten times as long, to write and to read.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from signal import Signals
from time import perf_counter
from typing import Any

import numpy as np

from ...progress import Interrupt
from .measures import Row, Task, measure

WRITE_EVERY = 1.0  # s of work between two parts
SUFFIX = ".arrow"
COMPRESS_FROM = 1_000_000  # bytes: parts with signals
TIME, SECTION, SIGNAL = "time", "section", "signal "  # columns of lists; a signal's name follows
Point = tuple[int, dict[str, Any]]  # digest, values


@dataclass
class BatchReport:
    """What became of a batch. seconds: of real time in runs.  reasons: of points that are not done, with their numbers of points.

    stopped: number of the signal that has ended it early; what it has computed is written.
    """

    done: int = 0
    failed: int = 0
    seconds: float = 0.0
    reasons: dict[str, int] = field(default_factory=dict)
    stopped: int | None = None
    process: int = 0


def run_batch(task: Task, points: Sequence[Point], folder: str, give_up: Callable[[], bool] = lambda: False) -> BatchReport:
    """Run points and write their rows into the folder; `give_up`, asked between two points, ends it early."""
    report = BatchReport(process=os.getpid())
    scene = task.scene()
    rows: list[tuple[int, Row]] = []
    written = perf_counter()
    with Interrupt(lambda: None) as interrupt:  # between two runs; inside of one it has its own
        for digest, values in points:
            since = perf_counter()
            row = measure(scene, values, task)
            now = perf_counter()
            report.seconds += now - since
            stopped = row.stopped or interrupt.wanted
            if row.stopped is None:
                rows.append((digest, row))
                _count(report, row)
            if stopped is not None:
                report.stopped = int(stopped)
            if stopped is not None or give_up():
                break
            if now - written > WRITE_EVERY:
                write_part(folder, rows)
                rows, written = [], perf_counter()
    write_part(folder, rows)
    return report


def _count(report: BatchReport, row: Row) -> None:
    if row.outcome == "done":
        report.done += 1
    else:
        report.failed += 1
        report.reasons[row.reason] = report.reasons.get(row.reason, 0) + 1


def write_part(folder: str | Path, rows: Sequence[tuple[int, Row]]) -> None:
    """Rows as one Arrow file, named by its first point; nothing without rows. Units of measure are metadata of the fields."""
    if not rows:
        return
    import pyarrow
    from pyarrow import feather

    names = dict.fromkeys(n for _, row in rows for n in row.numbers)
    signals = dict.fromkeys(n for _, row in rows for n in row.signals)
    units = {n: u for _, row in rows for n, u in row.units.items()}
    columns: list[tuple[str, Any, Any, str]] = [
        ("digest", pyarrow.int64(), [d for d, _ in rows], ""),
        ("outcome", pyarrow.string(), [row.outcome for _, row in rows], ""),
        ("reason", pyarrow.string(), [row.reason for _, row in rows], ""),
        *((f"number {n}", pyarrow.float64(), [row.numbers.get(n, np.nan) for _, row in rows], units.get(n, "")) for n in names),
    ]
    lists: Iterable[tuple[str, list[np.ndarray], str]] = [
        (SECTION, [row.section for _, row in rows], ""),
        (TIME, [row.time for _, row in rows], "s"),
        *((SIGNAL + n, [row.signals.get(n, np.zeros(0)) for _, row in rows], units.get(n, "")) for n in signals),
    ]
    columns += [(n, pyarrow.list_(pyarrow.float64()), x, u) for n, x, u in lists if any(v.size for v in x)]
    schema = pyarrow.schema([pyarrow.field(n, t, metadata={"unit": u}) for n, t, _, u in columns])
    table = pyarrow.table([pyarrow.array(x, type=t) for _, t, x, _ in columns], schema=schema)
    path = Path(folder) / f"{rows[0][0] & (2**64 - 1):016x}-{len(rows)}{SUFFIX}"
    part = path.with_suffix(f".{os.getpid()}.part")
    try:
        feather.write_feather(table, str(part), compression="zstd" if table.nbytes > COMPRESS_FROM else "uncompressed")
        os.replace(part, path)
    finally:
        part.unlink(missing_ok=True)


def read_part(path: Path, columns: Sequence[str] | None = None) -> Any:
    """A part as a table of pyarrow, or some of its columns; whatever a damaged file raises."""
    from pyarrow import feather

    return feather.read_table(str(path), columns=columns, memory_map=False, use_threads=False)


def schema_of(path: Path) -> Any:
    """Names, types and units of a part's columns."""
    import pyarrow

    with pyarrow.OSFile(str(path)) as file:
        return pyarrow.ipc.open_file(file).schema


def write_outcome(folder: str | Path, digest: int, outcome: str, reason: str) -> None:
    """A point that gave nothing, such as one that has ended its process."""
    write_part(folder, [(digest, Row(outcome, reason))])


def signal_of(report: BatchReport) -> Signals | None:
    """The signal that has ended a batch."""
    return Signals(report.stopped) if report.stopped is not None else None
