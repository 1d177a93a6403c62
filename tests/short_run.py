"""What the short run takes of long lists, the rest of which is marked `full`, and what the complete run takes of all scenes."""

import functools
from collections.abc import Callable, Collection, Iterable, Mapping
from typing import Any

import numpy as np
import pytest
from cosimo.components.catalogue import CATALOGUE, component_class
from cosimo.orchestrator.scene.scene import Scene, scene_files
from cosimo.orchestrator.systems import load_scene
from scipy.optimize import Bounds, LinearConstraint, milp

ONE_A_SYSTEM = tuple({component_class(name).system: name for name in CATALOGUE}.values())
FIRST_OF_SYSTEM = {file.parent.parent.name: name for name, file in reversed(scene_files().items())}  # system -> its first scene


@functools.cache
def shipped_scenes() -> Mapping[str, Scene]:
    """All shipped scenes by their names, read once in a process: lists of parameters ask for them."""
    return {name: load_scene(name) for name in sorted(scene_files())}


def full_but(kept: Collection[Any], cases: Iterable[Any]) -> list[Any]:
    """Parameters of a test: all but the kept ones only in the complete run. A case is a value, or a tuple of values."""
    return [
        case if case in kept else pytest.param(*(case if isinstance(case, tuple) else (case,)), marks=pytest.mark.full)
        for case in cases
    ]


def price(scene: Scene) -> float:
    """What a scene asks of the compiler: one for each component and each effect of a combination; a little for each unit."""
    combinations = {(unit.component, frozenset(unit.effects)) for unit in scene.units.values()}
    return sum(1.0 + len(effects) for _, effects in combinations) + 0.1 * len(scene.units)


def covering(scenes: Mapping[str, Scene], parts: Callable[[Scene], set[Any]]) -> tuple[str, ...]:
    """The names of the cheapest scenes that together have all that `parts` names of any of them."""
    each = [parts(scene) for scene in scenes.values()]
    has = np.array([[part in own for own in each] for part in sorted(set().union(*each))], dtype=float)
    prices = [price(scene) for scene in scenes.values()]
    chosen = milp(prices, constraints=LinearConstraint(has, lb=1.0), integrality=np.ones(len(scenes)), bounds=Bounds(0.0, 1.0))
    assert chosen.success, chosen.message
    return tuple(name for name, taken in zip(scenes, chosen.x, strict=True) if taken > 0.5)


@functools.cache
def covering_scenes(but: frozenset[str] = frozenset()) -> tuple[str, ...]:
    """The cheapest scenes that together have every component and every master algorithm of the shipped ones, by their names.

    but: components that need no scene.
    """
    return covering(shipped_scenes(), lambda scene: {scene.master.algorithm, *(u.component for u in scene.units.values())} - but)
