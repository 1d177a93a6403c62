"""Scenes: what is coupled and how, read from TOML or SSP and checked down to every connection.

`load_scene` reads and checks; what it returns can be trusted by everything behind it. Every fault is one `BadInput`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from ...components.core.errors import BadInput, nearest
from ..engine.coupling import Coupling, resolve_coupling
from ..harness.keys import keys_of, unknown
from ..settings import SceneSettings
from ..settings.messages import one_message
from ..settings.study import wanted
from .files import SHIPPED, read_file, read_toml, scene_files, scene_path
from .include import expanded

__all__ = ["SHIPPED", "Scene", "load_scene", "read_scene", "read_toml", "scene_files"]


class Scene(SceneSettings):
    """Units, connections and master settings; checked when read by `load_scene`, `read_scene` or `with_changes`."""

    def with_changes(self, changes: Mapping[str, Any]) -> Scene:
        """A new, checked scene with some settings replaced, each by its dotted place.

        "stop_time", "master.step", "units.catenary.effects", "units.catenary.parameters.damping.alpha" ...
        """
        data = self.settings()
        for place, value in changes.items():
            *path, last = self._place(place)
            table = data
            for key in path:
                table = table.setdefault(key, {})
                if not isinstance(table, dict):
                    raise BadInput(f"{self.name}: change", repr(place), "the dotted place of a setting", 'Such as "master.step".')
            table[last] = value
        if added := data["units"].keys() - self.units.keys():
            raise BadInput(f"{self.name}: change", f"unit {min(added)!r}", "a unit of the scene", nearest(min(added), self.units))
        return read_scene(data, self.name, remarks=self.remarks)

    def _place(self, place: str) -> list[str]:
        """Keys down to a setting: names of units may hold dots, and those of parameters do."""
        first, _, rest = place.partition(".")
        if first != "units":
            return place.split(".", 2 if rest.startswith(("iteration.", "control.")) else 1)
        unit, within = self.split(rest)
        return ["units", unit, *within.split(".", 1)]

    def split(self, name: str) -> tuple[str, str]:
        """("unit", "rest") of "unit.rest": the longest name of a unit, which may hold dots, or else what the first dot ends."""
        unit = max((u for u in self.units if name.startswith(u + ".")), key=len, default=name.partition(".")[0])
        return unit, name[len(unit) + 1 :]


def load_scene(name_or_path: str | Path) -> Scene:
    """A shipped scene by its name, or a scene file by its path: .toml, .ssd or .ssp."""
    path = scene_path(name_or_path)
    data, remarks = read_file(path)
    return read_scene(data, path.stem, path.parent, remarks)


def read_scene(data: Mapping[str, Any], name: str = "scene", folder: Path | None = None, remarks: Sequence[str] = ()) -> Scene:
    """A scene from plain data, checked down to every connection. Paths of FMUs and of other scenes are relative to `folder`.

    `remarks`: what its file says in vain, for the warnings of its runs.
    """
    data, more = expanded(data, name, folder)
    try:
        scene = Scene.model_validate(data)
    except ValidationError as error:
        raise one_message(error, Scene, name) from None
    scene._name, scene._remarks = name, (*remarks, *more)
    _check_analysis(scene.analysis, name)
    _check_quantities(scene, resolve_coupling(scene))
    return scene


def _check_quantities(scene: Scene, coupling: Coupling) -> None:
    """Refuse quantities of interest that no run could have."""
    outputs = [f"{unit}.{n}" for unit, i in coupling.interfaces.items() for n in i.outputs] if scene.study.quantities else []
    for text in scene.study.quantities:
        if (signal := wanted(text).signal) not in outputs:
            raise BadInput(f"{scene.name}: study.quantities", repr(signal), "an output of a unit", nearest(signal, outputs))


def _check_analysis(analysis: Mapping[str, Any], name: str) -> None:
    try:
        model = keys_of(analysis)
        model.model_validate(dict(analysis))
    except ValidationError as error:
        finding = error.errors()[0]
        if finding["type"] == "extra_forbidden" and len(finding["loc"]) == 1:
            fault = unknown(model, str(finding["loc"][0]))
            raise BadInput(f"{name}: {fault.where}", fault.actual, fault.expected, fault.remedy) from None
        raise one_message(error, model, name, "analysis") from None
    except BadInput as error:
        raise BadInput(f"{name}: {error.where}", error.actual, error.expected, error.remedy) from None
