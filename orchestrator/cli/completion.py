"""Completions of a shell: names of components, scenes, units, parameters. Typer completes commands and options by itself."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from tomllib import TOMLDecodeError, loads

from typer import Context

SCENE_FILES = (".toml", ".ssd", ".ssp", ".xml")
SYSTEMS = Path(__file__).parents[1] / "systems"


def _shipped(folder: str, suffix: str) -> dict[str, Path]:
    """Files of all systems by name; without the modules that check scenes, which take too long for a list."""
    return {path.stem: path for path in sorted(SYSTEMS.glob(f"*/{folder}/*{suffix}"))}


def _files(incomplete: str) -> Iterator[str]:
    """Folders and scene files of the folder that the incomplete text names; each starts with that folder as it was typed."""
    folder = incomplete[: incomplete.rfind("/") + 1]
    with suppress(OSError), os.scandir(folder or ".") as entries:
        for entry in entries:
            if entry.is_dir():
                yield f"{folder}{entry.name}/"
            elif entry.name.endswith(SCENE_FILES):
                yield folder + entry.name


def scene_files(incomplete: str) -> list[str]:
    """Scene files and folders."""
    return sorted(name for name in _files(incomplete) if name.endswith((".toml", "/")))


def kinds_and_systems() -> list[str]:
    """Of `cosimo list`."""
    return ["components", "fmus", "scenes", "cases", *sorted(folder.parent.name for folder in SYSTEMS.glob("*/scenes"))]


def components() -> list[str]:
    """Of the catalogue."""
    from ...components.catalogue import CATALOGUE

    return sorted(CATALOGUE)


def scenes(incomplete: str) -> list[str]:
    """Shipped scenes and scene files."""
    return sorted([*_shipped("scenes", ".toml"), *_files(incomplete)])


def cases() -> list[str]:
    """Validation cases that have a table. The others are known only after all cases have been loaded, which takes too long."""
    return ["papers", *_shipped("cases", ".csv")]


def anything(incomplete: str) -> list[str]:
    """Components, scenes and cases."""
    return [*components(), *scenes(incomplete), *cases()]


def _units(ctx: Context) -> dict[str, str]:
    """Unit -> component, of the scene that is the first argument; of a component alone "" -> its name."""
    from ...components.catalogue import CATALOGUE

    arguments = [p.name for p in ctx.command.params if p.param_type_name == "argument"]
    # behind an option without a value, the arguments before it are in `args`
    given = (ctx.params.get(arguments[0] or "") if arguments else None) or ctx.args
    name = str(given[0] if isinstance(given, list | tuple) and given else given)
    if name in CATALOGUE:
        return {"": name}
    try:
        units = loads(_shipped("scenes", ".toml").get(name, Path(name)).read_text(encoding="utf-8-sig")).get("units", {})
        return {unit: str(entry["component"]) for unit, entry in units.items() if entry.get("component") in CATALOGUE}
    except (OSError, ValueError, AttributeError, TOMLDecodeError):
        return {}


def parameters(ctx: Context) -> list[str]:
    """unit.parameter= of --set; inputs have start values."""
    from ...components.catalogue import component_class
    from ...components.core.variables import Causality

    classes = {unit: component_class(component) for unit, component in _units(ctx).items()}
    return sorted(
        f"{unit}.{name}=" if unit else f"{name}="
        for unit, cls in classes.items()
        for name, variable in cls.variables.items()
        if variable.causality is not Causality.OUTPUT
    )


def effects(ctx: Context) -> list[str]:
    """unit.effect of --effects."""
    from ...components.catalogue import component_class

    return sorted(
        f"{unit}.{effect}" if unit else effect
        for unit, component in _units(ctx).items()
        for effect in component_class(component).effects
    )


def presets(ctx: Context) -> list[str]:
    """unit=preset of --preset."""
    from ...components.catalogue import component_class

    return sorted(
        f"{unit}={preset}" if unit else preset
        for unit, component in _units(ctx).items()
        for preset in component_class(component).presets
    )
