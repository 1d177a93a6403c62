"""Files that appear as a whole or not at all."""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, Any


@contextmanager
def replaced(path: str | Path, mode: str = "w") -> Iterator[IO[Any]]:
    """A file to write, "w" text or "wb" bytes, that takes the place of `path` when it is whole. Raises `OSError`.

    After an error `path` is as it was.
    """
    path = Path(path)
    handle, part = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.", suffix=".part")
    text = {} if "b" in mode else {"encoding": "utf-8", "newline": ""}
    try:
        with os.fdopen(handle, mode, **text) as file:  # type: ignore[call-overload]
            yield file
            file.flush()
            os.fsync(handle)
        os.chmod(part, 0o666 & ~_umask())
        os.replace(part, path)
    except BaseException:  # a second Ctrl-C, too
        with suppress(OSError):
            os.unlink(part)
        raise


def _umask() -> int:
    """Of this process; the system has no call that only reads it."""
    if sys.platform == "win32":
        return 0
    mask = os.umask(0o077)
    os.umask(mask)
    return mask
