"""The meshes of a scene's components: parameters that are declared as such, and the same scene with coarser ones."""

from __future__ import annotations

from typing import Any, NamedTuple

from ...components.core.errors import BadInput
from ...components.core.variables import SEED, Kind
from ..units.component import make
from .scene import Scene


class Mesh(NamedTuple):
    """value: length of elements, m, or their number.  what: in words.  low, high: of the parameter."""

    value: float
    what: str
    low: float
    high: float
    by_length: bool


def meshes_of(scene: Scene, *, random: bool = False) -> dict[str, Mesh]:
    """Name of the parameter -> mesh of every component that uses one.

    random: instead of them numbers of random parts, seeds and tables, whose error no coarser mesh shows.
    """
    meshes = {}
    for name, cls in scene.component_classes.items():
        unit = scene.units[name]
        chosen = {n: v for n, v in cls.variables.items() if (_of_chance(v) if random else v.mesh in ("shorter", "more"))}
        if not any("." not in n or n.partition(".")[0] in unit.effects for n in chosen):
            continue
        component = make(name, unit)
        used = {n: v for n, v in chosen.items() if "." not in n or n.partition(".")[0] in component.on}
        for n in used.keys() - component.unused(used).keys():
            v = used[n]
            value = component.get(n) if v.kind is not Kind.TEXT else 0.0
            what = "the interpolation of a table" if v.kind is Kind.TEXT else v.structural
            meshes[f"{name}.{n}"] = Mesh(value, what, v.low, v.high, v.mesh == "shorter")
    return dict(sorted(meshes.items()))


def _of_chance(variable: Any) -> bool:
    return variable.mesh == "random" or variable.structural == SEED or (variable.kind is Kind.TEXT and "." in variable.name)


def coarser(scene: Scene, factor: int) -> dict[str, Any]:
    """Changes to elements so many times as long, or one so manieth of their number; raises `BadInput` where there are too few."""
    changes: dict[str, Any] = {}
    for place, mesh in meshes_of(scene).items():
        value = factor * mesh.value if mesh.by_length else int(mesh.value) // factor
        if not mesh.low <= value <= mesh.high:
            raise BadInput(place, f"{mesh.value:g}", "a mesh that can be coarser", "It is too coarse to tell its error.")
        changes[place] = value
    return changes


def coarsened(scene: Scene, changes: dict[str, Any]) -> float:
    """How many times as long elements get by changes; of several meshes the least."""
    return min(changes[p] / m.value if m.by_length else m.value / changes[p] for p, m in meshes_of(scene).items())
