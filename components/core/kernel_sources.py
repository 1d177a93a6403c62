"""What machine code of kernels follows from: their sources, and the folder that it is kept in. Nothing here needs the compiler."""

from __future__ import annotations

import os
import re
import sys
import sysconfig
import tempfile
from contextlib import suppress
from functools import lru_cache
from pathlib import Path

from .closure import Imported, closure
from .folders import cache_root
from .store import digest_of, private, temporary_root

_PACKAGE = __name__.partition(".")[0]
BUNDLE = re.compile(r"cosimo|bundle_[0-9a-f]{16}")  # packages with components of cosimo: its own, and that of an FMU
SHARED = "components"  # what stands for their names
_LIBRARIES = tuple(sysconfig.get_path(name) for name in ("stdlib", "purelib", "platlib"))
_SEEN: Imported = {}  # of the sources that this process asked for
_INSTALLED = re.compile(r"[/\\](site|dist)-packages[/\\]")  # of the user, of the system, of the environment below this one


def _own_module(name: str) -> Path | None:
    """The file of a loaded module that is this package's or the user's; None for libraries."""
    file = getattr(sys.modules.get(name), "__file__", None)
    if file is None or not file.endswith(".py"):
        return None
    return Path(file) if name.partition(".")[0] == _PACKAGE or not is_library(file) else None


def is_library(file: str) -> bool:
    """Whether a source belongs to Python or to an installed package."""
    return file.startswith(_LIBRARIES) or _INSTALLED.search(file) is not None


@lru_cache(maxsize=1024)
def sources_digest(*files: str) -> str:
    """Digest of the import closures of source files; the same for a copy of them in another place."""
    parts = list[str]()
    for file in files:
        start = Path(file).resolve()
        digests = closure(start, _own_module, _SEEN)
        for path in sorted(digests, key=lambda p: os.path.relpath(p, start.parent)):
            parts += [path.name, digests[path]]
    return digest_of(*parts)


@lru_cache(maxsize=1)
def private_root() -> Path | None:
    """A folder for machine code that belongs to the user and can be written; None where there is none.

    NUMBA_CACHE_DIR, or `kernels` in the cache of cosimo, or a folder in that for temporary files. The files there are executed:
    one that another user owns or may write is not taken.
    """
    asked = os.environ.get("NUMBA_CACHE_DIR")
    for folder in (lambda: Path(asked or Path(cache_root()) / "kernels"), lambda: temporary_root() / "kernels"):
        with suppress(OSError):
            root = folder()
            if private(root.parent if not asked else root) and private(root):
                tempfile.TemporaryFile(dir=root).close()
                return root
    return None


def private_folder(name: str) -> Path | None:
    """A folder in `private_root`; None where there is none, or others may write it."""
    with suppress(OSError):
        if (root := private_root()) is not None and private(root / name):
            return root / name
    return None


def packages(module: str) -> tuple[str, str]:
    """The package of a module, and what stands for it in the names of machine code that it shares with others."""
    own = module.partition(".")[0]
    return own, SHARED if BUNDLE.fullmatch(own) and module.startswith(f"{own}.components.") else own
