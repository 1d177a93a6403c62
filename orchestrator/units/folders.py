"""Folders of extracted FMUs, which one run after the other uses again.

Many libraries, all that C++ compilers make with unique symbols among them, stay in memory once they are loaded, one copy
for every path: a run that extracted its FMUs anew would leave some hundred kilobytes of each behind. Units that run at
the same time have folders of their own. All folders lie in one of the process, which is removed when the process ends; those of
processes that were killed are removed by the next one.
"""

from __future__ import annotations

import atexit
import errno
import os
import shutil
import tempfile
import zipfile
from collections import OrderedDict
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from threading import Lock
from time import time

from fmpy import extract

from ...components.core.folders import cache_root
from ..loading import check_archive
from ..output import lock_folder

MOST_UNUSED = 32  # folders that nobody uses; where there are more, the one used longest ago goes
PREFIX = "cosimo.run-"
BUILD, DAY = "cosimo-build-", 86400.0  # folders of builds of native FMUs; s: so old a one has no process any more
YOUNG = 60.0  # s: so old a folder has its lock, if its process lives
Key = tuple[str, int, int]
_own: tuple[int, str, Callable[[], None]] | None = None  # process, its folder, what gives up the lock
_free: OrderedDict[str, Key] = OrderedDict()  # folder -> FMU file, its time of change and size
_used: dict[str, Key] = {}
_lock = Lock()


def take(path: str) -> str:
    """A folder with the extracted FMU file, for one unit until `give`; raises what zipfile raises for a damaged file."""
    status = Path(path).stat()
    key = (str(Path(path).resolve()), status.st_mtime_ns, status.st_size)
    with _lock:
        for folder in [f for f, k in _free.items() if k == key]:
            del _free[folder]
            if Path(folder).is_dir():  # nobody has tidied up the temporary folder meanwhile
                _used[folder] = key
                return folder
    folder = _extracted(path)
    with _lock:
        _used[folder] = key
    return folder


def process_folder() -> str:
    """The folder for temporary files of this process.

    pythonfmu's library crashes the process where the path of an FMU has letters beyond ASCII, as those of Windows users may:
    then another place is taken.
    """
    global _own
    with _lock:
        if _own is None or _own[0] != os.getpid() or not Path(_own[1]).is_dir():
            first, *others = (*_bases(), tempfile.gettempdir())
            folder = tempfile.mkdtemp(prefix=PREFIX, dir=next(filter(_usable, (first, *others)), first))
            _own = os.getpid(), folder, lock_folder(Path(folder))
            _tidy(Path(folder).parent)
        return _own[1]


def _bases() -> Iterator[str]:
    """Folders for temporary files, as far as their names are of ASCII letters."""
    places = (tempfile.gettempdir(), os.path.join(cache_root(), "temporary"), "/tmp", "/var/tmp")
    return filter(str.isascii, places)


def _usable(folder: str) -> bool:
    with suppress(OSError):
        os.makedirs(folder, mode=0o700, exist_ok=True)
        return os.access(folder, os.W_OK)
    return False


def _tidy(base: Path) -> None:
    """Remove the folders of processes that have been killed: each living one holds a lock on its own."""
    for folder in base.glob(PREFIX + "*"):
        with suppress(OSError):
            status = folder.lstat()
            if time() - status.st_mtime > YOUNG and (not hasattr(os, "getuid") or status.st_uid == os.getuid()):
                lock_folder(folder)()
                shutil.rmtree(folder, ignore_errors=True)
    for folder in base.glob(BUILD + "*"):
        with suppress(OSError):
            status = folder.lstat()
            if time() - status.st_mtime > DAY and (not hasattr(os, "getuid") or status.st_uid == os.getuid()):
                shutil.rmtree(folder, ignore_errors=True)


def _extracted(path: str) -> str:
    """A new folder with all that is in the file; none is left behind where that fails."""
    folder = tempfile.mkdtemp(dir=process_folder())
    try:
        with zipfile.ZipFile(path) as file:
            if not folder.isascii() and "resources/slavemodule.txt" in file.namelist():
                raise OSError(
                    errno.EINVAL,
                    f"its library cannot read from {folder!r}, with letters beyond ASCII. Set TMPDIR to a folder without",
                )
            size, free = check_archive(file, path), shutil.disk_usage(folder).free
        if size > free:
            raise OSError(errno.ENOSPC, f"it unpacks to {size} bytes, and {folder} has {free} left")
        extract(path, unzipdir=folder)
    except BaseException:
        shutil.rmtree(folder, ignore_errors=True)
        raise
    return folder


def give(folder: str, *, again: bool = True) -> None:
    """The unit is closed; the folder waits for the next one, or goes where it shall not be used `again`."""
    old = []
    with _lock:
        key = _used.pop(folder)
        if again:
            _free[folder] = key
            old = [_free.popitem(last=False)[0] for _ in range(len(_free) - MOST_UNUSED)]
        else:
            old = [folder]
    for each in old:
        shutil.rmtree(each, ignore_errors=True)


@atexit.register
def _remove() -> None:
    if _own is not None and _own[0] == os.getpid():
        shutil.rmtree(_own[1], ignore_errors=True)
