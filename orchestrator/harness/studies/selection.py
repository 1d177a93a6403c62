"""The search for the smallest set of effects that keeps a tolerance. What is searched are sets of effects to leave out."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Generic, TypeVar

T = TypeVar("T")


@dataclass(frozen=True)
class Selection(Generic[T]):
    """dropped: what can be left out together.  error: without all of it.  breaking: what stays -> the error without it, too."""

    dropped: frozenset[T]
    error: float
    breaking: Mapping[T, float]


def select(
    sizes: Mapping[T, float], groups: Mapping[T, frozenset[T]], error: Callable[[frozenset[T]], float], tolerance: float
) -> Selection[T]:
    """Leave out as much as the tolerance allows, what matters least first.

    sizes: error without each alone.  groups: each with what cannot be without it, and goes with it.  error: of a set that is
    left out; it is asked once for every set. Of what stays nothing can be left out alone: that is what `breaking` shows. Sets
    that would be smaller still, by two errors that cancel, are not looked for.
    """
    known: dict[frozenset[T], float] = {frozenset(): 0.0}

    def of(dropped: frozenset[T]) -> float:
        if dropped not in known:
            known[dropped] = error(dropped)
        return known[dropped]

    order = sorted(sizes, key=lambda name: sizes[name])
    small = [name for name in order if sizes[name] <= tolerance]
    least, most = 0, len(small)
    while least < most:  # all of the smallest ones together, as many as go
        middle = (least + most + 1) // 2
        least, most = (middle, most) if of(_joined(groups, small[:middle])) <= tolerance else (least, middle - 1)
    dropped = _joined(groups, small[:least])
    while True:  # then one by one, until a round leaves nothing out
        before = dropped
        for name in order:
            if name not in dropped and of(dropped | groups[name]) <= tolerance:
                dropped |= groups[name]
        if dropped == before:
            return Selection(dropped, of(dropped), {n: of(dropped | groups[n]) for n in order if n not in dropped})


def _joined(groups: Mapping[T, frozenset[T]], names: list[T]) -> frozenset[T]:
    return frozenset().union(*(groups[name] for name in names))
