"""FMUs without Python: what is built, from names or from the units of a scene."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from ...components.catalogue import CATALOGUE, component_class
from ...components.core.component import Component
from ...components.core.errors import BadInput, nearest
from ...fmus.native.build import build_native, own_target
from ...fmus.native.machine_code import TARGETS
from .common import listed, parameters_of, preset_of, scene_of


def build_native_fmus(
    names: Sequence[str],
    output: Path,
    target: str,
    fmi: str,
    effects: str,
    values: Sequence[str],
    presets: Sequence[str] | None,
    scene: str,
    derivatives: bool,
) -> None:
    """Build native FMUs and print their paths; arguments as of the command `build`."""
    targets = listed("--target", [target]) if target else [own_target()]
    if not targets[0]:
        raise BadInput("build --native", "this machine, which is no target", "one of " + ", ".join(TARGETS), "Give --target.")
    versions = listed("--fmi", [fmi]) if fmi else ["2"]
    if unknown := [v for v in versions if v not in ("2", "3")]:
        raise BadInput("--fmi", repr(unknown[0]), "2, 3 or 2,3")
    if scene and (effects or values):
        raise BadInput("build", "--effects or --set with --scene", "one of them: the scene says what is on")
    on = listed("--effects", [effects]) if effects else []
    units = (
        scene_units(scene, presets, names)
        if scene
        else {
            name.rpartition(":")[2]: partial(_component, name, on, parameters_of(values), preset_of(presets))
            for name in names or CATALOGUE
        }
    )
    refused: list[BadInput] = []
    for name, maker in units.items():
        try:
            for path in build_native(name, maker, output, targets, [int(v) for v in versions], derivatives):
                print(path)
        except BadInput as error:
            if len(units) == 1 or error.where == "build --native":
                raise
            refused.append(error)
            print(f"refused: {error}")
    if refused:
        raise BadInput(
            "build --native",
            f"{len(refused)} of {len(units)} components that have no native form",
            "components whose steps are kernels",
            "The lines above name what prevents it.",
        )


def _component(name: str, effects: Sequence[str], values: dict[str, Any], preset: str) -> Component:
    return component_class(name, "build")(effects, values, preset=preset)


def scene_units(name: str, presets: Sequence[str] | None, wanted: Sequence[str]) -> dict[str, Callable[[], Component]]:
    """Makers of a scene's components, or of those that are wanted, at the inputs with which the scene's run begins."""
    from ..native import makers

    scene = scene_of(name, None, presets)
    components = [unit for unit, settings in scene.units.items() if settings.component]
    for unit in wanted:
        if unit not in components:
            raise BadInput("build --scene", f"unit {unit!r}", f"a component of the scene {scene.name}", nearest(unit, components))
    return makers(scene, wanted)
