"""Kinds of units: what an entry of a scene's [units] may be, each in a module of its own with all that others ask of it.

A new kind is a subclass of `UnitKind` in a module here, a line in `UNIT_KINDS`, and the keys of its entry in `settings.units`.
"""

from __future__ import annotations

from collections.abc import Mapping
from os.path import expanduser
from typing import Any

from ...settings import UnitSettings
from ...settings.units import TABLE_KEYS
from .ardupilot import ArduPilotKind
from .component import ComponentKind
from .fmu import FmuKind
from .kind import UnitKind
from .signals import SignalsKind

UNIT_KINDS: tuple[type[UnitKind], ...] = (
    SignalsKind,
    FmuKind,
    ArduPilotKind,
    ComponentKind,
)  # a table of signals has a component made of it
KEYS = tuple(kind.key for kind in UNIT_KINDS)  # of an entry of [units], of which one says what it is
OF_A_KIND = (*KEYS, *TABLE_KEYS)  # keys that another kind has no use for


def kind_of(settings: UnitSettings, where: str) -> UnitKind:
    """What a unit is; where: of the unit, for messages."""
    return next(kind for kind in UNIT_KINDS if getattr(settings, kind.key))(settings, where)


def kinds_of(units: Mapping[str, UnitSettings]) -> dict[str, UnitKind]:
    """The same of all units of a scene, by their names."""
    return {name: kind_of(settings, f"units.{name}") for name, settings in units.items()}


def kind_of_entry(entry: Any, where: str) -> UnitKind | None:
    """What an entry of [units] is before it is checked; None where it does not say so."""
    for kind in UNIT_KINDS if isinstance(entry, Mapping) else ():
        if (value := entry.get(kind.key)) and isinstance(value, str):
            given: Any = {key: entry[key] for key in KEYS if isinstance(entry.get(key), str)}
            return kind(UnitSettings.model_construct(**given | {kind.key: expanduser(value) if kind.is_file else value}), where)
    return None


def entry_of(text: str) -> dict[str, str]:
    """The entry of [units] for the name of a component, "module:Class", or the path of an FMU or a table."""
    return {next(kind.key for kind in UNIT_KINDS if kind.suffixes is None or text.endswith(kind.suffixes)): text}
