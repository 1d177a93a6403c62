"""What the internal steps, tolerances and meshes of units contribute to the error of a run: each is refined by itself."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ...components.catalogue import component_class
from ...components.core.errors import BadInput
from ..results import Result
from ..run import run as run_once
from ..scene.scene import Scene
from ..units.component import make

FINER = {"substep": 0.5, "tolerance": 0.1}  # a tenth of a tolerance: components control the error of a step, not of the run
MESH = 0.5


def settings_inside(scene: Scene) -> dict[str, Any]:
    """Place in the scene -> finer value, of every internal step and tolerance in use and of what [study] names as mesh."""
    finer: dict[str, Any] = {}
    for name, unit in scene.units.items():
        if not unit.component:
            continue
        component, known = make(name, unit), component_class(unit.component, name).variables
        for parameter, factor in FINER.items():
            if parameter in known and not component.unused([parameter]):
                finer[f"units.{name}.parameters.{parameter}"] = factor * float(component.get(parameter))
    for mesh in scene.study.mesh:
        name, parameter = scene.split(mesh)
        finer[f"units.{name}.parameters.{parameter}"] = MESH * float(make(name, scene.units[name]).get(parameter))
    return finer


def finer_inside(result: Result) -> Iterator[tuple[str, Result]]:
    """Place of each internal setting, and the run with its refinement, recorded at the same times; those that can be run."""
    scene = result.scene
    interval = {"record.interval": scene.master.step} if scene.record.interval is None and not scene.master.control else {}
    for place, value in settings_inside(scene).items():
        try:
            finer = run_once(scene.with_changes({place: value, **interval}), in_process=True)
        except BadInput:  # a mesh that needs other settings as well
            continue
        if finer.outcome == "done":
            yield place, finer
