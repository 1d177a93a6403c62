"""Files that are written for the user: directories, their locks, texts and tables that are replaced by whole ones only."""

from __future__ import annotations

import csv
import errno
import json
import os
import platform
import re
import shutil
import sys
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from datetime import UTC, datetime
from pathlib import Path
from time import time
from typing import Any

from ..components.core.errors import BadInput
from ..components.core.store import replaced

PLOTLY = "plotly.min.js"  # beside the pages of a directory, which draw their figures with it
SAMPLES_ENDING = ".samples.js"  # beside a page, with its name: what its lines show where one zooms in
UNFINISHED = "unfinished"  # in a result directory: what a run is writing, or was writing when it was killed
HOLDER = "holder.json"  # in it: who writes
LEFT = re.compile(r"\..+\.[a-z0-9_]{8}\.part")  # names that `replaced` and checkpoints take
YOUNG = 60.0  # s: where a file system has no locks, what is younger may be another process's
FULL = (errno.ENOSPC, errno.EDQUOT)  # of a disk, or of what a user may have of one
_held: dict[str, int] = {}  # directories that this process writes into, and the thread that does


def ensure_directory(directory: str | Path) -> Path:
    """The directory for results, created if it is missing; raises `BadInput` where that is impossible."""
    try:
        str(directory).encode()
    except UnicodeError:  # formats of results have names in UTF-8
        raise BadInput("output directory", ascii(str(directory)), "a name in UTF-8") from None
    try:
        Path(directory).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise not_written(directory, error) from None
    return Path(directory)


def write_json(path: str | Path, content: Any) -> None:
    """Numbers, texts, lists and mappings as a JSON file, in place when it is whole."""
    with replaced(path) as file:
        json.dump(content, file, indent=2)
        file.write("\n")


def write_table(
    directory: str | Path, name: str, header: Sequence[str], rows: Iterable[Sequence[float | int | str | None]]
) -> Path:
    """A file of comma-separated values in the directory, which is created; numbers keep every bit, texts and None stand in quotes."""
    path = ensure_directory(directory) / name
    try:
        with replaced(path) as file:
            writer = csv.writer(file, quoting=csv.QUOTE_NONNUMERIC, lineterminator="\n")
            writer.writerow(header)
            writer.writerows(rows)
    except OSError as error:
        raise not_written(directory, error) from None
    return path


class NoSpace(BadInput):
    """A full disk: the message of a place that cannot be written, which is nothing that the user gave."""


def not_written(directory: str | Path, error: OSError) -> BadInput:
    """The message for a place that cannot be written."""
    kind = NoSpace if error.errno in FULL else BadInput
    return kind("output directory", repr(str(directory)), "a place that can be written", f"{error.strerror or error}.")


@contextmanager
def locked(directory: str | Path) -> Iterator[Path]:
    """The directory, created and reserved for this thread until the context ends; raises `BadInput` that names the holder.

    The operating system keeps the lock and frees it however the process ends. Where a file system has no locks, other processes
    are not kept out. Entered once more by the same thread, it is one lock; another thread is refused as another process is.
    """
    new = not Path(directory).exists()
    path = ensure_directory(directory)
    key = str(path.resolve())
    me = threading.get_ident()
    if _held.get(key) == me:
        yield path
        return
    try:
        if _held.setdefault(key, me) != me:
            raise BlockingIOError
        release = lock_folder(path)
    except BlockingIOError:
        if _held.get(key) == me:  # another process has it
            del _held[key]
        raise BadInput(
            "output directory",
            f"{str(directory)!r}, into which {_holder(path)} writes",
            "one of its own for each run",
            "Wait for it, or give another directory.",
        ) from None
    except OSError as error:
        del _held[key]
        raise not_written(directory, error) from None
    _tidy(path)
    earlier = (path / UNFINISHED).exists()
    try:
        with suppress(OSError):  # the message of another run would be less precise
            (path / UNFINISHED).mkdir(exist_ok=True)
            write_json(
                path / UNFINISHED / HOLDER,
                {"process": os.getpid(), "host": platform.node(), "since": datetime.now(UTC).isoformat(timespec="seconds")},
            )
        yield path
    except BadInput:  # leaves nothing behind, but what an earlier run has left
        if not earlier:
            shutil.rmtree(path / UNFINISHED, ignore_errors=True)
        if new:
            with suppress(OSError):
                path.rmdir()
        raise
    finally:
        del _held[key]
        with suppress(OSError):
            (path / UNFINISHED / HOLDER).unlink()
        with suppress(OSError):  # not where a run has left its rows there
            (path / UNFINISHED).rmdir()
        release()


def _tidy(path: Path) -> None:
    """Remove files that a process which was killed has not put in place; whoever holds the lock is the only one who writes."""
    for part in path.glob(".*.part"):
        with suppress(OSError):
            if LEFT.fullmatch(part.name) and time() - part.stat().st_mtime > YOUNG:
                part.unlink()


def is_locked(directory: Path) -> bool:
    """Whether a process writes into the directory now."""
    if str(directory.resolve()) in _held:
        return True
    try:
        lock_folder(directory)()
    except BlockingIOError:
        return True
    except OSError:
        pass
    return False


def _holder(path: Path) -> str:
    try:
        holder = json.loads((path / UNFINISHED / HOLDER).read_text(encoding="utf-8"))
        return f"process {holder['process']} on {holder['host']} (since {holder['since']})"
    except (OSError, ValueError, KeyError, TypeError):
        return "another process"


if sys.platform == "win32":

    def lock_folder(path: Path) -> Callable[[], None]:
        try:  # a file that the system removes with its last user
            handle = os.open(path / ".lock", os.O_CREAT | os.O_EXCL | os.O_RDWR | os.O_TEMPORARY)
        except (FileExistsError, PermissionError):
            raise BlockingIOError from None
        return lambda: os.close(handle)
else:
    import fcntl

    def lock_folder(path: Path) -> Callable[[], None]:
        """Lock a folder for this process; returns what gives it up. Raises `BlockingIOError` where another one holds it."""
        handle = os.open(path, os.O_RDONLY)  # the directory itself: there is no file to be left behind
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            os.close(handle)
            raise
        except OSError:  # a file system without locks
            pass
        return lambda: os.close(handle)
