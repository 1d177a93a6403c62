"""Changes of a scene as assignments to attributes, which an interpreter completes."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import suppress
from typing import Any

from pydantic import BaseModel

from ...components.catalogue import component_class
from ...components.core.errors import BadInput, nearest
from ...components.core.variables import Causality

Scene = Any  # `scene.Scene`, which imports this module


class SceneEdit:
    """What `Scene.edit` gives: assign, then take `scene`.

        edit = scene.edit()
        edit.stop_time = 2.0
        edit.master.step = 5e-4
        edit.units.pantograph.speed = 83.3
        edit.units.pantograph.effects += ("bump_stops",)
        faster = edit.scene

    A unit has its parameters, those of an effect below the effect's name, and its settings; where a parameter has the name of a
    setting, it is below `parameters`. Raises `BadInput` with the near names for what a scene does not have.
    """

    def __init__(self, scene: Scene):
        self.__dict__.update(_scene=scene, _changes={}, _place="", _names=_fields(scene))

    def __dir__(self) -> Iterable[str]:
        return [*self._names, *(["scene", "changes"] if not self._place else [])]

    def __repr__(self) -> str:
        return f"<changes of {self._scene.name}: {self._changes or 'none'}>"

    @property
    def changes(self) -> dict[str, Any]:
        """Dotted place -> value, as `Scene.with_changes` takes them."""
        return dict(self._changes)

    @property
    def scene(self) -> Scene:
        """A new scene, checked, with the changes; the one that is edited stays as it is."""
        return self._scene.with_changes(self._changes)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_") or name not in self._names:
            raise AttributeError(f"{self._place or self._scene.name} has no {name!r}; {nearest(name, self._names)}")
        value, place = self._names[name]
        if isinstance(value, _Table):
            return _Node(self, name, value.names)
        return self._changes.get(place, value)

    def __setattr__(self, name: str, value: Any) -> None:
        if name not in self._names:
            raise BadInput(
                f"{self._scene.name}: change", repr(f"{self._place}{name}"), "a setting of the scene", nearest(name, self._names)
            )
        known, place = self._names[name]
        if isinstance(known, _Table):
            raise BadInput(
                f"{self._scene.name}: change",
                repr(f"{self._place}{name}"),
                "one of the settings in it",
                f"Such as {next(iter(known.names), name)!r}.",
            )
        self._changes[place] = value


class _Node(SceneEdit):
    """A table inside of a scene."""

    def __init__(self, above: SceneEdit, name: str, names: dict[str, tuple[Any, str]]):
        self.__dict__.update(_scene=above._scene, _changes=above._changes, _place=f"{above._place}{name}.", _names=names)


class _Table:
    """Settings by name, each with its value now and its dotted place."""

    def __init__(self, names: dict[str, tuple[Any, str]]):
        self.names = names


def _fields(scene: Scene) -> dict[str, tuple[Any, str]]:
    """Settings of a scene as a tree."""
    names = _model(scene, "")
    units: dict[str, tuple[Any, str]] = {}
    for name in scene.units:
        *tables, last = name.split(".")  # units of subsystems
        level = units
        for table in tables:
            level = level.setdefault(table, (_Table({}), ""))[0].names
        level[last] = (_Table(_unit(scene, name)), "")
    return {**names, "units": (_Table(units), "")}


def _model(model: BaseModel, prefix: str) -> dict[str, tuple[Any, str]]:
    names = {}
    for field in type(model).model_fields:
        value = getattr(model, field)
        place = f"{prefix}{field}"
        names[field] = (_Table(_model(value, f"{place}.")) if isinstance(value, BaseModel) else value, place)
    return names


def _unit(scene: Scene, name: str) -> dict[str, tuple[Any, str]]:
    unit, prefix = scene.units[name], f"units.{name}."
    parameters: dict[str, tuple[Any, str]] = {}
    values: dict[str, Any] = {}
    if unit.component:
        with suppress(BadInput):  # a module that is not here
            cls = component_class(unit.component, name)
            values = {n: v.start for n, v in cls.variables.items() if v.causality is not Causality.OUTPUT}
            values |= cls.presets[unit.preset].parameters if unit.preset else {}
    values |= unit.parameters
    for variable, value in values.items():
        array, bracket, _ = variable.partition("[")
        *groups, last = array.split(".")
        level = parameters
        for group in groups:
            table = level.setdefault(group, (_Table({}), ""))[0]
            level = table.names if isinstance(table, _Table) else {}
        place = f"{name}.{array}"
        if bracket:
            level[last] = ([*level[last][0], value] if last in level else [value], place)
        else:
            level[last] = (value, place)
    return {**parameters, **_model(unit, prefix), "parameters": (_Table(parameters), "")}
