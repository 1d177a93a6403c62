"""Signals that are a part of a sum, such as the force on one contact wire of two: what is compared with one is half an answer."""

from __future__ import annotations

from collections.abc import Callable, Collection
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from .scene import Scene


def sums_of(scene: Scene, signals: Collection[str]) -> dict[str, str]:
    """Signal -> its sum, "unit.output" both, of those of these signals that are a part, where neither the sum nor all parts are there."""
    of_parts = dict[str, str]()
    for unit, interface in scene.coupling.interfaces.items():
        for name, parts in interface.sums.items():
            whole, some = f"{unit}.{name}", [f"{unit}.{part}" for part in parts]
            if whole not in signals and not set(some) <= set(signals):
                of_parts |= {part: whole for part in some if part in signals}
    return of_parts


def parts_alone(scene: Scene, signals: Collection[str], column: Callable[[str], np.ndarray]) -> list[str]:
    """A sentence for each of these signals that is a part, where the rest of its sum is not zero throughout.

    column: of a run by "unit.output", (n,), the rows that count.
    """
    return [
        f"{part} is only a part: {whole} ({_text(scene, whole)}) is another number in this run; name it where the whole is meant"
        for part, whole in sums_of(scene, signals).items()
        if not np.array_equal(column(part), column(whole))
    ]


def _text(scene: Scene, signal: str) -> str:
    """What an output of a component is, in its words."""
    unit, name = scene.split(signal)
    return scene.component_classes[unit].variables[name].text
