"""Parameters that have a part in what a unit computes: a report shows no other."""

from __future__ import annotations

from collections.abc import Collection

from ....components.core.errors import BadInput
from ...scene.scene import Scene
from ...units.component import make


def in_use(scene: Scene, unit: str, names: Collection[str]) -> list[str]:
    """Of a unit's parameters those that have a part, in their order: none in whose place a table or an effect stands.

    Of a component that cannot be made, such as one whose files are gone, those that the scene gives.
    """
    settings = scene.units.get(unit)
    if settings is None or not settings.component:
        return list(names)
    try:
        unused: Collection[str] = make(unit, settings).unused(names)
    except BadInput:
        unused = set(names) - set(settings.parameters)
    return [name for name in names if name not in unused]
