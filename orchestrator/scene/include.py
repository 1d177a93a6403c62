"""Scenes inside scenes: an entry of `units` that names another scene is replaced by its units, connections and contacts."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import count
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from ...components.core.errors import BadInput, nearest
from ..loading import MOST_FILES
from ..settings import SceneSettings, SubsystemSettings
from ..settings.messages import one_message
from ..settings.names import TABLE_FORM, names_in, prefixed, split_name
from ..units.kinds import kind_of_entry
from .files import read_file, scene_path, table_text
from .modules import find_beside

PLACEHOLDER = 1.0  # s, for the stop time and step of a file that is a subsystem only; nothing runs by them


def expanded(
    data: Mapping[str, Any],
    name: str,
    folder: Path | None = None,
    above: tuple[Path, ...] = (),
    files: Iterator[int] | None = None,
) -> tuple[dict[str, Any], tuple[str, ...]]:
    """A scene's data with units, connections and contacts of its subsystems in the place of their entries, and remarks.

    Paths are relative to `folder`. `above`: the files that include this one; `files`: counts all files.
    What a unit of a subsystem is called in its own file stands behind the entry's name: "subsystem.unit". Stop time, master,
    records, interface, faults, sweep, analysis, study and explore of the included scene belong to its own runs and are not taken over.
    """
    if not isinstance(data.get("units"), Mapping):
        return dict(data), ()
    files = files or count(1)
    units: dict[str, Any] = {}
    added: dict[str, list[Any]] = {"connections": [], "contacts": []}
    remarks: list[str] = []
    correlations: dict[str, Any] = {}
    for entry, unit in data["units"].items():
        entries = {entry: _located(unit, folder)}
        if isinstance(unit, Mapping) and "scene" in unit:
            part, messages = _part(entry, unit, name, folder, above, files)
            entries = {f"{entry}.{n}": u for n, u in part["units"].items()}
            added["connections"] += (_prefixed(c, entry, part["units"], name) for c in part.get("connections", ()))
            added["contacts"] += (_touching(c, entry) for c in part.get("contacts", ()))
            pairs = {", ".join(f"{entry}.{n}" for n in names_in(p)): r for p, r in part.get("correlations", {}).items()}
            correlations |= pairs
            remarks += messages
        if twice := entries.keys() & units.keys():
            raise BadInput(f"{name}: units", f"two units {min(twice)!r}", "names that are unique")
        units |= entries
    joined: dict[str, Any] = {}
    for key, more in added.items():
        if more and isinstance(own := data.get(key, []), list | tuple):
            joined[key] = [*own, *more]
    if correlations and isinstance(own := data.get("correlations", {}), Mapping):
        given = [{*names_in(p)} for p in own]  # which the including scene says otherwise
        joined["correlations"] = {**{p: r for p, r in correlations.items() if {*names_in(p)} not in given}, **own}
    return {**data, **joined, "units": units}, tuple(remarks)


def _part(
    entry: str, unit: Mapping[str, Any], name: str, folder: Path | None, above: tuple[Path, ...], files: Iterator[int]
) -> tuple[dict[str, Any], tuple[str, ...]]:
    """Checked settings of an included scene, with the values that the entry gives, and remarks about its file."""
    try:
        settings = SubsystemSettings.model_validate(unit)
    except ValidationError as error:
        raise one_message(error, SubsystemSettings, name, "units", entry) from None
    where = f"{name}: units.{entry}"
    path = scene_path(settings.scene, f"{where}.scene", folder).resolve()
    if path in above:
        raise BadInput(f"{where}.scene", f"{path.name!r}, which includes this scene", "scenes that do not contain themselves")
    if next(files) > MOST_FILES:
        raise BadInput(
            f"{where}.scene", f"a scene of more than {MOST_FILES} files", "fewer", "Do they name one another many times?"
        )
    data, remarks = read_file(path)
    data, more = expanded(data, path.stem, path.parent, (*above, path), files)
    data.pop("analysis", None)  # of its own runs
    stop = data.setdefault("stop_time", PLACEHOLDER)
    data.setdefault("master", {"step": stop})
    try:
        part = SceneSettings.model_validate(data).settings()
    except ValidationError as error:
        raise one_message(error, SceneSettings, path.stem) from None
    for n, inside in part["units"].items():
        if "parameters" in data["units"][n]:  # with their lists, whose shapes are checked where the FMU's are known
            inside["parameters"] = dict(data["units"][n]["parameters"])
    for parameter, value in settings.parameters.items():
        inner, variable = split_name(parameter, part["units"])
        if inner not in part["units"]:
            raise BadInput(f"{where}.parameters", f"unit {inner!r}", f"a unit of {path.name}", nearest(inner, part["units"]))
        part["units"][inner].setdefault("parameters", {})[variable] = value
    return part, (*remarks, *more)


def _prefixed(connection: Any, entry: str, units: Mapping[str, Any], name: str) -> Any:
    """A connection of a subsystem as the scene around it names its ends."""
    if isinstance(connection, str):
        texts = prefixed(connection, entry, units)
        if len(texts) > 1:
            raise BadInput(f"{name}: units.{entry}", f"connection {connection!r}", "one that can be read in one way", TABLE_FORM)
        return texts[0] if texts else f"{entry}.{connection}"
    return connection | {end: f"{entry}.{connection[end]}" for end in ("source", "target")}


def _touching(contact: Mapping[str, Any], entry: str) -> dict[str, Any]:
    """A contact of a subsystem as the scene around it names what it touches: all texts of its sides are "unit.variable"."""
    sides = {s: {k: f"{entry}.{v}" if isinstance(v, str) else v for k, v in contact[s].items()} for s in ("first", "second")}
    return {**contact, **sides, "name": f"{entry}.{contact['name']}"}


def _located(unit: Any, folder: Path | None) -> Any:
    """A unit with absolute paths, and with the contents of the files that parameters name; its module, beside them, is found."""
    if folder is None or not isinstance(unit, Mapping):
        return unit
    if (kind := kind_of_entry(unit, "")) is not None:
        if kind.is_file:
            return {**unit, kind.key: str(folder.resolve() / kind.value)}
        if not kind.of_catalogue:
            find_beside(kind.value, folder, "component")
    if isinstance(parameters := unit.get("parameters"), Mapping):
        return {**unit, "parameters": _with_contents(parameters, folder)}
    return unit


def _with_contents(parameters: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """Parameters, those that name a table's file by its ending, .toml or .csv, replaced by its text."""

    def content(key: str, value: Any) -> Any:
        if isinstance(value, Mapping):
            return _with_contents(value, folder)
        return table_text(value, folder, key)

    return {key: content(key, value) for key, value in parameters.items()}
