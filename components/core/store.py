"""What is kept on disk: digests that name it, files that appear as a whole, and contents that are checked before they are used.

Nothing in the cache is needed: what is missing, damaged, or cannot be written is made again. No lock is taken, because processes
that make the same thing at once put the same content in place.
"""

from __future__ import annotations

import atexit
import hashlib
import os
import shutil
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import IO, Any

CHECK = hashlib.sha256().digest_size  # bytes at the start of a checked file
PART = ".part"  # how files that are being written end


def digest_of(*parts: str | bytes) -> str:
    """SHA-256, 64 hexadecimal digits, of the SHA-256 of each part."""
    total = hashlib.sha256()
    for part in parts:
        total.update(hashlib.sha256(part.encode() if isinstance(part, str) else part).digest())
    return total.hexdigest()


def read_kept(file: Path) -> bytes | None:
    """The content that `write_kept` has put into a file; None where it is missing or damaged."""
    with suppress(OSError):
        content = file.read_bytes()
        if hashlib.sha256(content[CHECK:]).digest() == content[:CHECK]:
            return content[CHECK:]
    return None


def write_kept(file: Path, content: bytes) -> None:
    """Put a content with its digest in place, in a folder that is there; not done where nothing can be written."""
    with suppress(OSError), replaced(file, "wb", synchronized=False) as whole:
        whole.write(hashlib.sha256(content).digest() + content)


@contextmanager
def replaced(path: str | Path, mode: str = "w", *, synchronized: bool = True) -> Iterator[IO[Any]]:
    """A file to write, "w" text or "wb" bytes, that takes the place of `path` when it is whole. Raises `OSError`.

    After an error `path` is as it was. synchronized: it is on the disk before it is in place.
    """
    path = Path(path)
    handle, part = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.", suffix=PART)
    text = {} if "b" in mode else {"encoding": "utf-8", "newline": ""}
    try:
        with os.fdopen(handle, mode, **text) as file:  # type: ignore[call-overload]
            yield file
            file.flush()
            if synchronized:
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


def kept(path: Path, intact: Callable[[Path], bool], make: Callable[[Path], Path]) -> Path:
    """A file of the cache: an intact one is used, one that is missing or damaged is made anew.

    Where the cache cannot be written, it is made in a folder for temporary files that goes with this process.
    """
    with suppress(OSError):
        if path.is_file() and intact(path):
            return path
    try:
        return make(path)
    except OSError:
        aside = _aside() / path.parent.name / path.name
        return aside if aside.is_file() else make(aside)


@cache
def _aside() -> Path:
    folder = tempfile.mkdtemp(prefix="cosimo-")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return Path(folder)
