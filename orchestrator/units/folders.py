"""Folders of extracted FMUs, which one run after the other uses again.

Many libraries, all that C++ compilers make with unique symbols among them, stay in memory once they are loaded, one copy
for every path: a run that extracted its FMUs anew would leave some hundred kilobytes of each behind. Units that run at
the same time have folders of their own. All folders are removed when the process ends.
"""

from __future__ import annotations

import atexit
import errno
import shutil
import tempfile
import zipfile
from collections import OrderedDict
from pathlib import Path
from threading import Lock

from fmpy import extract

MOST = 32  # folders that nobody uses; where there are more, the one used longest ago goes
Key = tuple[str, int, int]
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


def _extracted(path: str) -> str:
    """A new folder with all that is in the file; none is left behind where that fails."""
    folder = tempfile.mkdtemp(prefix="cosimo-")
    try:
        with zipfile.ZipFile(path) as file:
            size, free = sum(info.file_size for info in file.infolist()), shutil.disk_usage(folder).free
        if size > free:
            raise OSError(errno.ENOSPC, f"it unpacks to {size} bytes, and {tempfile.gettempdir()} has {free} left")
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
            old = [_free.popitem(last=False)[0] for _ in range(len(_free) - MOST)]
        else:
            old = [folder]
    for each in old:
        shutil.rmtree(each, ignore_errors=True)


@atexit.register
def _remove() -> None:
    for folder in (*_free, *_used):
        shutil.rmtree(folder, ignore_errors=True)
