"""Files that a user names: what is no regular file is refused before it is opened."""

from __future__ import annotations

import os
import stat
from contextlib import suppress
from pathlib import Path

from .errors import BadInput

MOST = 1 << 30  # bytes of a table
STREAMS = ("/dev/fd/", "/dev/std", "/proc/self/fd/")  # pipes that a shell has opened for this process


def refuse_pipe(path: str | Path, where: str = "") -> None:
    """Raises `BadInput` for a named pipe, a device or a socket in the place of a file: to open one may wait for ever."""
    mode = stat.S_IFREG
    with suppress(OSError, ValueError):  # none there, or no path at all: what is to read it says so
        mode = os.stat(path).st_mode
    if not (stat.S_ISREG(mode) or stat.S_ISDIR(mode)) and not str(path).startswith(STREAMS):
        raise BadInput(f"{where} {str(path)!r}".lstrip(), "a pipe, a device or a socket", "a file or a folder")


def read_bytes(path: str | Path, where: str, most: int = MOST) -> bytes:
    """The content of a file; raises `BadInput` for one that cannot be read, is no regular file or is too long."""
    refuse_pipe(path, where)
    try:
        if (size := os.stat(path).st_size) > most:
            raise BadInput(str(path), f"a file of {size} bytes", f"at most {most} bytes")
        return Path(path).read_bytes()
    except BadInput:
        raise
    except (OSError, ValueError) as error:
        raise BadInput(where, repr(str(path)), "a file that can be read", f"{getattr(error, 'strerror', error)}.") from error
