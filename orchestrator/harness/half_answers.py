"""Quantities and figures that somebody asks for, and that are a part of what they should be about."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from contextlib import suppress

from ...components.core.errors import BadInput
from ..run.key_results import after_transient
from ..run.results import Result
from ..scene.scene import Scene
from ..scene.sums import parts_alone
from ..settings.study import wanted
from .summary import SummaryRow


def has_sums(scene: Scene) -> bool:
    """Whether a signal of the scene is a part of a sum."""
    return any(interface.sums for interface in scene.coupling.interfaces.values())


def half_answers(result: Result, names: Collection[str], numbers: Sequence[SummaryRow]) -> list[str]:
    """A sentence for each name, "unit.output, kind" or a figure, that is a part, where the whole is another number in this run.

    numbers: all figures of the run.
    """
    scene, kinds = result.scene, dict[tuple[str, ...], list[str]]()
    if not has_sums(scene):
        return []
    for name in names:
        with suppress(BadInput):  # a figure
            signal, *kind = wanted(name)
            kinds.setdefault(tuple(map(str, kind)), []).append(signal)
    kept = after_transient(result)
    of_kinds = [parts_alone(scene, signals, lambda name: result[name][kept]) for signals in kinds.values()]
    texts = list(dict.fromkeys(text for of_kind in of_kinds for text in of_kind))
    for row in (row for row in numbers if row.part and row.name in names):
        whole = next((other for other in numbers if not other.part and _key(scene, other) == _key(scene, row)), None)
        if whole is not None and whole.name not in names and whole.value != row.value:
            texts.append(
                f"{row.name} ({row.text}) is only a part: {whole.name} is another number in this run; name it where the whole is meant"
            )
    return texts


def _key(scene: Scene, row: SummaryRow) -> tuple[str, str]:
    """Unit and quantity, without the part of the unit."""
    return scene.split(row.name)[0], row.name.rpartition(".")[2]
