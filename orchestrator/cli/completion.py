"""What a shell completes: names of components, scenes, units and parameters, from a file in the cache that is made once.

Typer runs the command again at each press of Tab: nothing of components is imported here while that file is there.
"""

from __future__ import annotations

import json
import tomllib
from collections.abc import Iterable, Iterator
from contextlib import suppress
from hashlib import sha256
from pathlib import Path
from typing import Any

import typer

from ...fmus.files import replaced

ROOT = Path(__file__).parents[2]
SCENE_FILES = (".toml", ".ssd", ".ssp")


def catalogue() -> dict[str, Any]:
    """components: name -> effects, presets, parameters; scenes: name -> {unit: component}; cases; systems. Kept in the cache."""
    from ...components.core.folders import cache_root

    path = Path(cache_root()) / "completion" / f"{_state()}.json"
    with suppress(OSError, ValueError):
        return json.loads(path.read_text(encoding="utf-8"))
    names = _names()
    with suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        for old in path.parent.glob("*.json"):
            old.unlink(missing_ok=True)
        with replaced(path) as file:
            json.dump(names, file)
    return names


def _state() -> str:
    """Changes with every file that the names come from."""
    files = [*ROOT.glob("components/**/*.py"), *ROOT.glob("orchestrator/systems/*/*/*.toml")]
    states = sorted(f"{f.relative_to(ROOT)} {(s := f.stat()).st_mtime_ns} {s.st_size}" for f in files)
    return sha256("\n".join(states).encode()).hexdigest()[:16]


def _names() -> dict[str, Any]:
    from ...components.catalogue import CATALOGUE, component_class
    from ...components.core.variables import Causality
    from ..scene.scene import scene_files
    from ..systems import NAMES, cases

    classes = {name: component_class(name) for name in CATALOGUE}
    return {
        "components": {name: {
            "effects": list(cls.effects), "presets": list(cls.presets),
            "parameters": [n for n, v in cls.variables.items() if v.causality is not Causality.OUTPUT]}
            for name, cls in classes.items()},
        "scenes": {name: _units(path) for name, path in scene_files().items()}, "cases": list(cases()), "systems": list(NAMES)}


def _units(path: Path) -> dict[str, str]:
    """Units of a scene file that are components."""
    try:
        units = tomllib.loads(path.read_text(encoding="utf-8-sig")).get("units", {})
        return {name: str(unit["component"]) for name, unit in units.items() if "component" in unit}
    except (OSError, ValueError, AttributeError, TypeError):
        return {}


def _starting(names: Iterable[str], incomplete: str) -> list[str]:
    return sorted(name for name in names if name.startswith(incomplete))


def _files(incomplete: str) -> Iterator[str]:
    folder = Path(incomplete).parent if not incomplete.endswith("/") else Path(incomplete)
    with suppress(OSError):
        for entry in folder.iterdir():
            if entry.is_dir() or entry.suffix in SCENE_FILES:
                name = str(entry) if str(folder) != "." or incomplete.startswith("./") else entry.name
                yield name + ("/" if entry.is_dir() else "")


def kinds_and_systems(incomplete: str) -> list[str]:
    """Of `cosimo list`."""
    return _starting(["components", "fmus", "scenes", "cases", *catalogue()["systems"]], incomplete)


def components(incomplete: str) -> list[str]:
    """Of the catalogue."""
    return _starting(catalogue()["components"], incomplete)


def scenes(incomplete: str) -> list[str]:
    """Shipped scenes and scene files."""
    return _starting([*catalogue()["scenes"], *_files(incomplete)], incomplete)


def cases(incomplete: str) -> list[str]:
    """Validation cases."""
    return _starting(["papers", *catalogue()["cases"]], incomplete)


def anything(incomplete: str) -> list[str]:
    """Components, scenes and cases."""
    names = catalogue()
    return _starting([*names["components"], *names["scenes"], *names["cases"], *_files(incomplete)], incomplete)


def _in_question(context: typer.Context) -> dict[str, str]:
    """Unit -> component, of the scene that the command line names; of a component alone "" -> its name."""
    given = context.params.get("scene") or context.params.get("name") or ""
    if not given:  # behind an option without its value, arguments are not assigned yet
        given = next((text for text in context.args if not text.startswith("-")), "")
    name = str(given)
    names = catalogue()
    if name in names["components"]:
        return {"": name}
    return names["scenes"].get(name) or _units(Path(name))


def _of_units(context: typer.Context, key: str) -> Iterator[str]:
    known = catalogue()["components"]
    for unit, component in _in_question(context).items():
        for item in known.get(component, {}).get(key, ()):
            yield f"{unit}.{item}" if unit else item


def parameters(context: typer.Context, incomplete: str) -> list[str]:
    """unit.parameter= of --set."""
    return _starting((f"{name}=" for name in _of_units(context, "parameters")), incomplete)


def effects(context: typer.Context, incomplete: str) -> list[str]:
    """unit.effect of --effects."""
    return _starting(_of_units(context, "effects"), incomplete)


def presets(context: typer.Context, incomplete: str) -> list[str]:
    """unit=preset of --preset."""
    known = catalogue()["components"]
    return _starting((f"{unit}={preset}" if unit else preset for unit, component in _in_question(context).items()
                      for preset in known.get(component, {}).get("presets", ())), incomplete)
