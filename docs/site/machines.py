"""The drawing of a component or of a scene, from the module `machines` of its system."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from typing import Any

from cosimo.orchestrator.harness.machine import Machine
from cosimo.orchestrator.scene.scene import read_toml, scene_files
from cosimo.orchestrator.systems import SYSTEMS

MODULES = {name: import_module(f"{system.package}.machines") for name, system in SYSTEMS.items()}


def of_component(name: str) -> Machine:
    """Its drawing; KeyError where no system has one."""
    return next(module.MACHINES for module in MODULES.values() if name in module.MACHINES)[name]()


def of_scene(system: str, units: Mapping[str, Mapping[str, Any]]) -> Machine:
    """The drawing that stands for a scene of a system. Units that are scenes count as what is in the first of them."""
    first = next(iter(units.values()))
    if first.get("scene") in scene_files():
        return of_scene(system, read_toml(scene_files()[first["scene"]])["units"])
    used = {u.get("component") for u in units.values()}
    own = [m for m in (MODULES[system], *MODULES.values()) if used & set(m.MACHINES)]  # a scene may use components of another
    if hasattr(own[0], "scene"):
        return own[0].scene(units)
    return next(drawing for name, drawing in own[0].MACHINES.items() if name in used)()
