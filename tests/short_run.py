"""What the short run takes of long lists, the rest of which is marked `full`, and what the complete run takes of all scenes."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import Any

import pytest
from cosimo.components.catalogue import CATALOGUE, component_class
from cosimo.orchestrator.scene.scene import scene_files
from cosimo.orchestrator.systems import load_scene

ONE_A_SYSTEM = tuple({component_class(name).system: name for name in CATALOGUE}.values())


def full_but(kept: Collection[Any], cases: Iterable[Any]) -> list[Any]:
    """Parameters of a test: all but the kept ones only in the complete run. A case is a value, or a tuple of values."""
    return [case if case in kept else pytest.param(*(case if isinstance(case, tuple) else (case,)), marks=pytest.mark.full)
            for case in cases]


def covering_scenes() -> list[str]:
    """Scenes that together have every component and every master algorithm of the shipped ones, in the order of their names.

    Each time that with most of what is still missing for its number of units is taken.
    """
    scenes = {name: load_scene(name) for name in scene_files()}
    parts = {name: {scene.master.algorithm, *(u.component for u in scene.units.values())} for name, scene in scenes.items()}
    missing, taken = set().union(*parts.values()), []
    while missing:
        taken.append(max(scenes, key=lambda name: len(parts[name] & missing) / (1 + len(parts[name]))))
        missing -= parts[taken[-1]]
    return sorted(taken)
