"""Whether kernels are compiled in this process, told without loading the compiler where that is known."""

from __future__ import annotations

import os
import sys
from contextlib import suppress
from functools import lru_cache
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

from .kernel_sources import private_folder
from .store import digest_of, read_kept, write_kept

LIBRARIES = ("numba", "llvmlite", "numpy")  # what machine code is made by


@lru_cache(maxsize=1)
def libraries() -> str:
    """Digest of the versions of what machine code is made by, and of the options of Numba; "" where one is missing."""
    parts = [sys.version, *sorted(f"{k}={v}" for k, v in os.environ.items() if k.startswith("NUMBA_") and k != "NUMBA_CACHE_DIR")]
    for name in LIBRARIES:
        try:
            spec = find_spec(name)
        except ImportError:  # the host refuses it
            return ""
        if spec is None or spec.origin is None:
            return ""
        folder = Path(spec.origin).parent
        parts.append(f"{name} {folder.name}")
        with suppress(OSError):
            parts.append((folder / ("version.py" if name == "numpy" else "_version.py")).read_text(encoding="utf-8"))
    return digest_of(*parts)


def compiles() -> bool:
    """Whether Numba is there, works with the other libraries, and is not switched off."""
    if os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0") or not (digest := libraries()):
        return False
    folder = private_folder("compilers")
    if folder is not None and read_kept(folder / digest) is not None:
        return True
    try:
        import_module("numba")  # refuses libraries that it does not work with
    except ImportError:
        return False
    if folder is not None:
        write_kept(folder / digest, b"")
    return True
