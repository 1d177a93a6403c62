"""The working directory, which the threads of a process share.

FMPy goes to the folder of a library while it loads the library. Another thread that asked meanwhile would take that folder for
the user's.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from tempfile import TemporaryDirectory
from threading import RLock, current_thread, main_thread

_loading = RLock()


@contextmanager
def kept() -> Iterator[None]:
    """One thread at a time goes elsewhere; where it fails, it is brought back."""
    with _loading:
        here = os.getcwd()
        try:
            yield
        except BaseException:
            os.chdir(here)
            raise


def current() -> str:
    """The directory in which no library is being loaded; "" where it is gone."""
    with _loading:
        try:
            return os.getcwd()
        except OSError:
            return ""


@contextmanager
def of_its_own(wanted: bool) -> Iterator[None]:
    """Where it is wanted, a folder that is thrown away as the working directory: a unit may write files there.

    The main thread alone goes there, as it would take all others with it.
    """
    if not wanted or current_thread() is not main_thread() or not (here := current()):
        yield
        return
    with TemporaryDirectory(prefix="cosimo-again-") as folder:
        os.chdir(folder)
        try:
            yield
        finally:
            os.chdir(here)
