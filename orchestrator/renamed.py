"""Names of earlier versions: of arguments, which one message replaces, and of keys of files, which are still read."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import wraps
from typing import Any, ParamSpec, TypeVar

from ..components.core.errors import BadInput

P = ParamSpec("P")
R = TypeVar("R")


def renamed(**names: str) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Let a function refuse keywords by which its arguments were called; names: old -> new."""

    def decorate(function: Callable[P, R]) -> Callable[P, R]:
        @wraps(function)
        def call(*args: P.args, **given: P.kwargs) -> R:
            for old in names.keys() & given.keys():
                raise BadInput(
                    f"cosimo.{function.__qualname__}", f"{old} = ...", f"{names[old]} = ...", "The argument has a new name."
                )
            return function(*args, **given)

        return call

    return decorate


def with_new_keys(table: Mapping[str, Any], names: Mapping[str, str]) -> dict[str, Any]:
    """A table of a file under the names of today; names: old -> new. Raises `BadInput` where it has a key under both."""
    for old in names.keys() & table.keys():
        if names[old] in table:
            raise BadInput(names[old], f"also as {old!r}", "each key once", f"{old!r} is its name of earlier versions.")
    return {names.get(key, key): value for key, value in table.items()}


OUTPUT = renamed(directory="output")  # where results go
