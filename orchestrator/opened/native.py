"""The components of a scene as native FMUs: built for its effects and parameters, and for the inputs that its run begins with."""

from __future__ import annotations

from collections.abc import Callable, Collection
from contextlib import ExitStack
from functools import partial
from typing import Any

from ...components.core.component import Component
from ...components.core.errors import BadInput
from ...fmus.native.build import built, own_target
from ..engine.stepping.faults import Faults
from ..scene.scene import Scene
from ..units.component import make
from ..units.native import NativeFmu
from .open_scene import OpenScene


def initial_inputs(scene: Scene) -> dict[str, dict[str, float]]:
    """Values of all inputs with which each component is initialized in process; with feed-through they change behind it."""
    alone = {
        f"units.{n}.{key}": value
        for n, kind in scene.kinds.items()
        if kind.component_class and kind.in_worker
        for key, value in (("isolation", "none"), ("time_limit", None))
    }
    scene = scene.with_changes(alone) if alone else scene
    with ExitStack() as stack:
        open_scene = OpenScene(scene, stack, in_process=True)
        Faults(scene.faults, scene.coupling, open_scene.master, open_scene.clock).before_start()
        open_scene.master.initialize_units(scene.start_time)
        components = {n: u.component for n, u in open_scene.units.items() if u.component is not None}
        return {n: dict(zip(c.inputs, c.u[0].tolist(), strict=True)) for n, c in components.items()}


def makers(scene: Scene, wanted: Collection[str] = ()) -> dict[str, Callable[[], Component]]:
    """Functions that make a scene's components, or the wanted ones, with its initial inputs."""

    def maker(unit: str, starts: dict[str, float]) -> Component:
        component = make(unit, scene.units[unit])
        for port, value in starts.items():
            component.set(port, value)
        return component

    return {unit: partial(maker, unit, starts) for unit, starts in initial_inputs(scene).items() if not wanted or unit in wanted}


def native_fmus(scene: Scene) -> dict[str, NativeFmu]:
    """A native FMU for each component of the scene, from the cache or built.

    `BadInput` for a component that has no native form, with the line that prevents it, for a missing compiler and for a machine
    that is no target.
    """
    if not own_target():
        raise BadInput("--native", "this machine", "Linux on x86-64 or ARM64, Windows on x86-64", "Remove --native.")
    fmus, kinds = {}, scene.kinds
    for unit, maker in makers(scene).items():
        if not kinds[unit].has_native_form:
            continue
        component = maker()
        try:
            path = built(type(component).__name__, maker, [own_target()])
        except BadInput as error:
            where = f"{scene.name}: units.{unit}, {error.where}"
            raise BadInput(where, error.actual, error.expected, error.remedy) from None
        fmus[unit] = NativeFmu(str(path), dict(zip(component.inputs, component.u[0].tolist(), strict=True)))
    return fmus


def with_native_fmus(scene: Scene) -> Scene:
    """The scene with its components replaced by their native FMUs, which hold its effects, parameters and initial inputs."""
    # an FMU does not say which of its variables are a port
    changes: dict[str, Any] = {"connections": scene.info()["connections"]}
    for name, fmu in native_fmus(scene).items():
        unit = scene.units[name]
        inputs = {n: value for n, value in unit.parameters.items() if n in fmu.starts}
        replaced = {"preset": "", "effects": (), "fmu": fmu.path, "parameters": inputs}
        changes |= {f"units.{name}.{key}": value for key, value in replaced.items()}
    return scene.with_changes(changes)
