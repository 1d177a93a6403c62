"""What is kept on disk: digests that name it, files that appear as a whole, and contents that are checked before they are used.

One rule holds for all of it. A file is used if it shows that it is whole, that it is what its place says (name and content are in
one digest), and that nobody but this user and the administrator could have written it. All else is made again, as is what is
missing or cannot be written: nothing in the cache is needed. No lock is taken, because processes that make the same thing at once
put the same content in place.
"""

from __future__ import annotations

import atexit
import errno
import hashlib
import os
import shutil
import stat
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from io import BufferedReader
from pathlib import Path
from typing import IO, Any

from .folders import cache_root, trusted

CHECK = hashlib.sha256().digest_size  # bytes at the start of a checked file
PART = ".part"  # how files that are being written end
SEAL = ".seal"  # behind the name of a file that is used by its path: where its digest is kept


def digest_of(*parts: str | bytes | memoryview) -> str:
    """SHA-256, 64 hexadecimal digits, of the SHA-256 of each part."""
    total = hashlib.sha256()
    for part in parts:
        total.update(hashlib.sha256(part.encode() if isinstance(part, str) else part).digest())
    return total.hexdigest()


@contextmanager
def opened_trusted(file: str | Path) -> Iterator[BufferedReader]:
    """A file to read that nobody else can have written. Raises `PermissionError` for another one, `OSError` for none."""
    # without O_NONBLOCK, to open a pipe in the place of a file would wait for ever
    handle = os.open(file, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    try:
        status = os.fstat(handle)
        if not stat.S_ISREG(status.st_mode):
            raise OSError(errno.EINVAL, "it is no file")
        if not trusted(status):
            raise PermissionError(errno.EPERM, "another user owns it, or may write it")
    except OSError:
        os.close(handle)
        raise
    with open(handle, "rb") as content:
        yield content


def read_kept(file: Path) -> bytes | None:
    """The content that `write_kept` has put into a file; None where it is missing, damaged, another file or another user's."""
    with suppress(OSError), opened_trusted(file) as whole:
        content = whole.read()
        if _check(file, content[CHECK:]) == content[:CHECK]:
            return content[CHECK:]
    return None


def write_kept(file: Path, content: bytes) -> None:
    """Put a content with its digest in place, in a folder that is there; not done where nothing can be written."""
    with suppress(OSError), replaced(file, "wb", synchronized=False, private=True) as whole:
        whole.write(_check(file, content) + content)


def _check(file: Path, content: bytes) -> bytes:
    """Of a content in its place: folder and name. Where all folders are moved together, it stays what it is."""
    return hashlib.sha256(f"{file.parent.name}/{file.name}\0".encode("utf-8", "surrogateescape") + content).digest()


def private(folder: Path) -> bool:
    """Create the folder if it is missing; whether nobody else may write there. Raises `OSError`."""
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    return trusted(folder.stat())


def temporary_root() -> Path:
    """What stands in for the cache where others may write that."""
    return Path(tempfile.gettempdir()) / f"cosimo-{os.getuid() if hasattr(os, 'getuid') else os.getlogin()}"


def cache_folder(*names: str) -> Path | None:
    """A folder of the cache, created, which nobody else may write or exchange; None where there is none."""
    for root in (lambda: Path(cache_root()), temporary_root):
        with suppress(OSError):
            folders = [root()]
            folders += [folders[0].joinpath(*names[: k + 1]) for k in range(len(names))]
            if all(map(private, folders)):
                return folders[-1]
    return None


@contextmanager
def replaced(path: str | Path, mode: str = "w", *, synchronized: bool = True, private: bool = False) -> Iterator[IO[Any]]:
    """A file to write, "w" text or "wb" bytes, that takes the place of `path` when it is whole. Raises `OSError`.

    After an error `path` is as it was. synchronized: it is on the disk before it is in place.  private: others may not write it,
    whatever the process allows them.
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
        os.chmod(part, 0o666 & ~_umask() & (~0o022 if private else ~0))
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


def kept(kind: str, digest: str, name: str, make: Callable[[Path], Path]) -> Path:
    """A file of the cache that is used by its path; `make` writes it where there is none, or one that the rule refuses.

    Where the cache cannot be written, it is made in a folder for temporary files that goes with this process.
    """
    if (folder := cache_folder(kind, digest[:16])) is not None:
        path = folder / name
        seal = path.with_name(name + SEAL)
        with suppress(OSError):
            if (known := read_kept(seal)) is not None and known == _sum(path):
                return path
        with suppress(OSError):
            path = make(path)
            os.chmod(path, path.stat().st_mode & ~0o022)
            write_kept(seal, _sum(path))
            return path
    aside = _aside() / kind / digest[:16] / name
    return aside if aside.is_file() else make(aside)


def _sum(path: Path) -> bytes:
    """SHA-256 of a file that nobody else can have written. Raises `OSError`."""
    with opened_trusted(path) as content:
        return hashlib.file_digest(content, "sha256").digest()


@cache
def _aside() -> Path:
    folder = tempfile.mkdtemp(prefix="cosimo-")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return Path(folder)
