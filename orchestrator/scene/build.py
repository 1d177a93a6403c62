"""Scenes written in Python: units from classes, names and files, as plain data that `read_scene` checks."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from ...components.catalogue import component_name
from ...components.core.component import Component
from ..units.kinds import entry_of
from .files import SCENES


def unit(
    what: str | Path | type[Component],
    *,
    effects: Iterable[str] = (),
    preset: str = "",
    settings: Mapping[str, Any] | None = None,
    **parameters: Any,
) -> dict[str, Any]:
    """A unit of `build_scene`: a component by its class, its name or "module:Class"; by its path an FMU, a table of signals or
    another scene.

    parameters: by name, those of an effect as a table: `bump_stops={"travel": 0.04}`; arrays as lists.
    settings: what else a unit of a scene may say, such as {"every": 2, "isolation": "process"}.
    """
    text = component_name(what) if isinstance(what, type) else str(what)
    entry = {"scene": text} if text.endswith(SCENES) else entry_of(text)
    given = {"effects": list(effects), "preset": preset, "parameters": parameters}
    return {**entry, **{key: value for key, value in given.items() if value}, **(settings or {})}


def scene_data(
    units: Mapping[str, Any],
    connections: Iterable[Any] | Mapping[str, str],
    stop_time: float,
    step: float,
    master: Mapping[str, Any],
    tables: Mapping[str, Any],
) -> dict[str, Any]:
    """Plain data of a scene; arguments as of `build_scene`."""
    if isinstance(connections, Mapping):
        connections = [f"{source} -> {target}" for source, target in connections.items()]
    entries = {name: entry if isinstance(entry, Mapping) else unit(entry) for name, entry in units.items()}
    return {
        "stop_time": float(stop_time),
        "units": entries,
        "connections": list(connections),
        "master": {**master, "step": float(step)},
        **tables,
    }


def snake_case(name: str) -> str:
    """ "ServoMotor" as "servo_motor"."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", "_", name).lower()
