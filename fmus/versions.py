"""Versions of packages, in threads, too.

An FMU of pythonfmu changes `sys.path` while other threads look for a package in it, and FMPy changes the working directory, to
which relative entries refer, while it loads a library.
"""

from __future__ import annotations

import os
import sys
from functools import lru_cache
from importlib.metadata import Distribution, PackageNotFoundError, distributions


@lru_cache(maxsize=64)
def distribution(name: str) -> Distribution:
    """An installed package; raises `PackageNotFoundError`."""
    path = [entry for entry in list(sys.path) if os.path.isabs(entry)]  # a copy: a list that shrinks under an iterator skips
    for first in distributions(name=name, path=path):
        return first
    raise PackageNotFoundError(name)


@lru_cache(maxsize=64)  # a package parses its description each time
def version(name: str) -> str:
    """Of an installed package; raises `PackageNotFoundError`."""
    return distribution(name).version
