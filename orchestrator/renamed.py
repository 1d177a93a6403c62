"""Arguments that had another name in an earlier version: one message says the new one."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import ParamSpec, TypeVar

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


OUTPUT = renamed(directory="output")  # where results go
