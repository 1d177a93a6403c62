"""Files that are written for the user: directories, tables of comma-separated values."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Sequence
from pathlib import Path

from ..components.core.errors import BadInput


def ensure_directory(directory: str | Path) -> Path:
    """The directory for results, created if it is missing; raises `BadInput` where that is impossible."""
    try:
        Path(directory).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise not_written(directory, error) from None
    return Path(directory)


def write_table(directory: str | Path, name: str, header: Sequence[str], rows: Iterable[Sequence[float | int | str]]) -> Path:
    """A file of comma-separated values in the directory, which is created; numbers keep every bit, texts stand in quotes."""
    path = ensure_directory(directory) / name
    try:
        with open(path, "w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file, quoting=csv.QUOTE_NONNUMERIC, lineterminator="\n")
            writer.writerow(header)
            writer.writerows(rows)
    except OSError as error:
        raise not_written(directory, error) from None
    return path


def not_written(directory: str | Path, error: OSError) -> BadInput:
    """The message for a place that cannot be written."""
    return BadInput("output directory", repr(str(directory)), "a place that can be written", f"{error.strerror}.")
