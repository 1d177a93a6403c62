"""Scenes: what is coupled and how, read from TOML and checked down to every connection.

`load_scene` reads and checks; what it returns can be trusted by everything behind it. Every fault is one `BadInput`.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from components.core.errors import BadInput, nearest

from .analysis.keys import keys_of, unknown
from .coupling import settle
from .messages import one_message
from .settings import SceneSettings

SHIPPED = Path(__file__).parent / "scenes"


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
        return read_scene(data, self.name)

    def _place(self, place: str) -> list[str]:
        """Keys down to a setting: names of units may hold dots, and those of parameters do."""
        first, _, rest = place.partition(".")
        if first != "units":
            return place.split(".", 2 if rest.startswith(("iteration.", "control.")) else 1)
        unit = max((u for u in self.units if rest.startswith(u + ".")), key=len, default=rest.partition(".")[0])
        return ["units", unit, *rest.removeprefix(unit + ".").split(".", 1)]


def scene_files() -> dict[str, Path]:
    """Shipped scenes by name."""
    return {p.stem: p for p in sorted(SHIPPED.glob("*.toml"))}


def load_scene(name_or_path: str | Path) -> Scene:
    """A shipped scene by its name, or a scene file by its path."""
    path = Path(name_or_path)
    if path.suffix != ".toml":
        files = scene_files()
        if str(name_or_path) not in files:
            raise BadInput("scene", repr(str(name_or_path)), "a shipped scene or the path of a .toml file",
                           nearest(str(name_or_path), files))
        path = files[str(name_or_path)]
    return read_scene(read_toml(path), path.stem, path.parent)


def read_toml(path: Path) -> dict[str, Any]:
    """The file's tables; a missing file or a syntax error is one `BadInput` with file and line."""
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise BadInput("scene", repr(str(path)), "a file that can be read", f"{error.strerror}.") from None
    except UnicodeDecodeError:
        raise BadInput(str(path), "bytes that are no UTF-8", "a TOML file in UTF-8") from None
    except tomllib.TOMLDecodeError as error:
        text, line = str(error), re.search(r"line (\d+)", str(error))
        raise BadInput(f"{path}:{line[1]}" if line else str(path), f"a syntax error: {text}", "TOML") from None


def read_scene(data: Mapping[str, Any], name: str = "scene", folder: Path | None = None) -> Scene:
    """A scene from plain data, checked down to every connection. FMU paths are relative to `folder`."""
    if folder is not None and isinstance(data.get("units"), dict):
        data = {**data, "units": {n: _located(u, folder) for n, u in data["units"].items()}}
    try:
        scene = Scene.model_validate(data)
    except ValidationError as error:
        raise one_message(error, Scene, name) from None
    scene._name = name
    _check_analysis(scene.analysis, name)
    settle(scene)
    return scene


def _check_analysis(analysis: Mapping[str, Any], name: str) -> None:
    try:
        model = keys_of(analysis)
        model.model_validate(dict(analysis))
    except ValidationError as error:
        finding = error.errors()[0]
        if finding["type"] == "extra_forbidden" and len(finding["loc"]) == 1:
            fault = unknown(model, str(finding["loc"][0]))
            raise BadInput(f"{name}: {fault.where}", fault.came, fault.expected, fault.remedy) from None
        raise one_message(error, model, name, "analysis") from None
    except BadInput as error:
        raise BadInput(f"{name}: {error.where}", error.came, error.expected, error.remedy) from None


def _located(unit: Any, folder: Path) -> Any:
    if isinstance(unit, dict) and isinstance(unit.get("fmu"), str):
        return {**unit, "fmu": str(folder.resolve() / unit["fmu"])}
    return unit
