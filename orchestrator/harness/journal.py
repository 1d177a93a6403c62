"""What a study has computed so far, piece by piece in its result directory: one that was stopped or killed goes on from there.

A piece is a run, a solution or a limit. Its key is what it depends on: the scene with its changes, the code of its components, the
settings of the study, the version of cosimo. A study that continues takes the same decisions with the same numbers, times included, as
without the interruption.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from pathlib import Path
from typing import Any, TypeVar

from ..interrupts import Interrupted, interruptible
from ..kept import Kept
from ..output import UNFINISHED, locked
from ..run.dependence import depends_on

T = TypeVar("T")
FOLDER = "study"  # in the folder of what is not finished


class Stopped(Interrupted):
    """A signal has ended a study. kept: how many pieces a further call need not compute."""

    kept = 0


class Journal:
    """The pieces in a folder."""

    def __init__(self, folder: Path, resume: bool):
        self._folder = folder
        if not resume:
            shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True, exist_ok=True)

    @property
    def kept(self) -> int:
        """How many pieces there are."""
        return sum(1 for _ in self._folder.iterdir())

    def close(self, done: bool) -> None:
        """Remove the pieces of a study that is done."""
        if done:
            shutil.rmtree(self._folder, ignore_errors=True)
        with suppress(OSError):  # where there are pieces, they stay
            self._folder.rmdir()

    def place(self, *of: Any) -> Kept:
        """Of the piece that depends on these."""
        return Kept(self._folder, depends_on(*of))


_journal: ContextVar[Journal | None] = ContextVar("journal", default=None)  # of the study that is under way


def once(kind: str, of: tuple[Any, ...], compute: Callable[[], T], record: type | None = None) -> T:
    """A piece of a study: the kept one where the study has a journal with it, else `compute()`, which is kept.

    of: what it depends on, scenes, components of the catalogue and plain data.  record: the dataclass of a piece, None, or a list
    of them; its fields are numbers, texts, arrays, and lists, tuples and mappings of them, as a piece without a record is.
    """
    journal = _journal.get()
    return compute() if journal is None else journal.place(kind, *of).once(compute, record)


@contextmanager
def kept_study(directory: str | Path, *, resume: bool = False) -> Iterator[Path]:
    """The result directory of a study, locked, which keeps its pieces there until it is done.

    Ctrl-C, SIGTERM and SIGHUP end it with `Stopped`. `resume`: pieces of an earlier call that did not end are used. Raises
    `BadInput` where another process writes into the directory.
    """
    with locked(directory) as path:
        journal = Journal(path / UNFINISHED / FOLDER, resume)
        token, done = _journal.set(journal), False
        try:
            with interruptible():
                yield path
            done = True
        except Interrupted as one:
            stopped = one if isinstance(one, Stopped) else Stopped(one.signal)
            stopped.kept = journal.kept
            raise stopped from None
        finally:
            _journal.reset(token)
            journal.close(done)
