"""Versions of packages, in threads, too: an FMU of pythonfmu changes `sys.path` while other threads look for a package in it."""

from __future__ import annotations

import sys
from functools import lru_cache
from importlib.metadata import Distribution, PackageNotFoundError, distributions


@lru_cache(maxsize=64)
def distribution(name: str) -> Distribution:
    """An installed package; raises `PackageNotFoundError`."""
    for first in distributions(
        name=name, path=list(sys.path)
    ):  # a copy: a list that shrinks under an iterator leaves out entries
        return first
    raise PackageNotFoundError(name)


def version(name: str) -> str:
    """Of an installed package; raises `PackageNotFoundError`."""
    return distribution(name).version
