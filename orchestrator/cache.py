"""What the program keeps in the user's cache: how much there is, and what can go. All of it is made again when it is needed."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from time import time

from ..components.core.errors import BadInput, nearest
from ..components.core.folders import cache_root

# of the folders in the cache: nothing else there is looked at, which the user may have pointed anywhere
CACHED = {
    "kernels": "machine code of components",
    "fmus": "FMUs of components",
    "bundles": "sources of FMUs, unpacked",
    "native": "native FMUs of components",
    "zig": "what the compiler of native FMUs has compiled",
    "ssp": "FMUs out of .ssp files",
    "sources": "FMUs whose sources were compiled here",
    "fronts": "measured accuracy of scenes",
    "effects": "sets of effects of scenes",
    "meshes": "errors that meshes of scenes make",
    "code": "digests of the code of components",
    "states": "numbers of states of components",
    "lists": "names and titles of all components, scenes and cases",
}
LEFT_BEHIND = 3600.0  # s: a file that is being written is younger
TIDIED, DAY = "tidied", 86400.0  # the file that says when it was done last; s


@dataclass(frozen=True)
class Entry:
    """One kind of what is kept: its folder, the number of files, their size in bytes."""

    kind: str
    meaning: str
    files: int
    size: int


def root() -> Path:
    """The cache's folder."""
    return Path(cache_root())


def entries() -> list[Entry]:
    """What there is, kind by kind."""
    return [
        Entry(kind, meaning, len(sizes), sum(sizes))
        for kind, meaning in CACHED.items()
        for sizes in [[status.st_size for _, status in _files(root() / kind)]]
    ]


def clear(kinds: Iterable[str] = ()) -> int:
    """Remove all of some kinds, or of all kinds; returns the bytes that went. Raises `BadInput` for an unknown kind."""
    kinds = list(kinds)
    for kind in kinds:
        if kind not in CACHED:
            raise BadInput("cache", repr(kind), "a kind of what is kept", nearest(kind, CACHED))
    before = _size()
    for kind in kinds or CACHED:
        shutil.rmtree(root() / kind, ignore_errors=True)
    return before - _size()


def prune(days: float) -> int:
    """Remove what was neither used nor written for so many days, and what processes that were killed have left behind.

    Returns the bytes that went.
    """
    before, now = _size(), time()
    for kind in CACHED:
        for unit in _units(root() / kind):
            files = [*_files(unit)] if unit.is_dir() else [(unit, unit.stat())]
            if all(now - max(s.st_mtime, s.st_atime) > 86400.0 * days for _, s in files):
                shutil.rmtree(unit, ignore_errors=True) if unit.is_dir() else unit.unlink(missing_ok=True)
    tidy()
    return before - _size()


def tidy() -> None:
    """Remove what processes that were killed have left behind: files that were never put in place."""
    now = time()
    for kind in CACHED:
        for path, status in _files(root() / kind):
            if now - status.st_mtime > LEFT_BEHIND and (path.suffix == ".part" or ".tmp." in path.name):
                with suppress(OSError):
                    path.unlink()
        for folder in (root() / kind).glob("tmp*"):  # in which a bundle was unpacked
            with suppress(OSError):
                if now - folder.stat().st_mtime > LEFT_BEHIND and folder.is_dir():
                    shutil.rmtree(folder, ignore_errors=True)


def tidy_daily() -> None:
    """The same where it was not done for a day; a file in the cache says when it was. Nothing where there is no cache."""
    stamp = root() / TIDIED
    with suppress(OSError):
        if root().is_dir() and (not stamp.exists() or time() - stamp.stat().st_mtime > DAY):
            stamp.touch()
            tidy()


def _units(folder: Path) -> Iterator[Path]:
    """What goes or stays as a whole: the folder of a digest, or a file; machine code is one level deeper."""
    with suppress(OSError):
        for path in sorted(folder.iterdir()):
            if folder.name == "kernels" and path.is_dir():
                yield from _units(path)
            else:
                yield path


def _files(folder: Path) -> Iterator[tuple[Path, os.stat_result]]:
    for path in sorted(folder.rglob("*")):
        with suppress(OSError):
            if path.is_file() and not path.is_symlink():
                yield path, path.stat()


def _size() -> int:
    return sum(entry.size for entry in entries())
