"""The drawing of a component or of a scene, from the module `machines` of its system."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from cosimo.orchestrator.harness.machine import Machine
from cosimo.orchestrator.scene.scene import read_toml, scene_files
from cosimo.orchestrator.systems import SYSTEMS

MODULES = {name: module for name, system in SYSTEMS.items() if (module := system.module("machines")) is not None}


def of_component(name: str) -> Machine | None:
    """Its drawing; None where no system has one."""
    return next((module.MACHINES[name]() for module in MODULES.values() if name in module.MACHINES), None)


def of_scene(system: str, units: Mapping[str, Mapping[str, Any]]) -> Machine | None:
    """The drawing that stands for a scene of a system, if there is one. Of units that are scenes the first counts."""
    first = next(iter(units.values()))
    if first.get("scene") in scene_files():
        return of_scene(system, read_toml(scene_files()[first["scene"]])["units"])
    used = {u.get("component") for u in units.values()}
    of_system = [MODULES[system]] if system in MODULES else []
    own = [m for m in (*of_system, *MODULES.values()) if used & set(m.MACHINES)]  # a scene may use components of another
    if not own:
        return None
    if hasattr(own[0], "scene"):
        return own[0].scene(units)
    return next(drawing for name, drawing in own[0].MACHINES.items() if name in used)()
