"""Scenes: what is coupled and how, read from TOML or SSP and checked down to every connection.

`load_scene` reads and checks; other modules need not check again. Every fault is one `BadInput`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from html import escape
from pathlib import Path
from typing import Any, TypeVar

import tomli_w
from pydantic import PrivateAttr, ValidationError

from ...components.core.component import Component
from ...components.core.errors import BadInput, nearest
from ...components.core.variables import port_of
from ..engine.coupling import Coupling, expanded_connection, resolve_coupling
from ..loading import loading
from ..output import ensure_directory
from ..settings import AnalysisKeys, ConnectionSettings, MasterSettings, SceneSettings
from ..settings.messages import one_message
from ..settings.names import ARROW, connection, readings, split_name
from ..settings.study import wanted
from ..units.kinds import UnitKind, kind_of_entry, kinds_of
from ..units.signal_files import read_signals
from .drawing import Arrow, Box, Drawing, draw
from .files import SHIPPED, read_file, read_toml, scene_files, scene_path
from .include import expanded
from .names import changed_settings, check_effects, is_setting
from .written_units import with_numbers

__all__ = ["SHIPPED", "Scene", "load_scene", "read_scene", "read_toml", "scene_files"]
Keys = TypeVar("Keys", bound=AnalysisKeys)

Models = Mapping[str, type[AnalysisKeys]]  # of [analysis], by the name of a system


@dataclass(frozen=True)
class KnownSystems:
    """What scenes and results know of systems: the models of [analysis], and summaries, reports and plots (`results.Views`)."""

    models: Models = field(default_factory=dict)
    views: Any = None


NO_SYSTEMS = KnownSystems()


class Scene(SceneSettings):
    """Units, connections and master settings; checked when read by `load_scene`, `read_scene` or `with_changes`."""

    _coupling: Coupling | None = PrivateAttr(None)
    _systems: KnownSystems = PrivateAttr(NO_SYSTEMS)

    @property
    def coupling(self) -> Coupling:
        """The checked graph of units and connections, resolved once."""
        if self._coupling is None:
            self._coupling = resolve_coupling(self)
        return self._coupling

    @property
    def views(self) -> Any:
        """What sums up and draws results of this scene: `results.Views`; None where it was read without knowledge of systems."""
        return self._systems.views

    @property
    def systems(self) -> KnownSystems:
        """What the scene was read with."""
        return self._systems

    @property
    def kinds(self) -> dict[str, UnitKind]:
        """What each unit is, by its name."""
        return kinds_of(self.units)

    @property
    def component_classes(self) -> dict[str, type[Component]]:
        """The classes of the units that are components, by the names of the units; raises `BadInput` where one is not found."""
        return {name: cls for name, kind in self.kinds.items() if (cls := kind.component_class) is not None}

    @property
    def arrows(self) -> tuple[str, ...]:
        """Every connection as "unit.output -> unit.input", joined ports by their members."""
        return tuple(f"{source} -> {target}" for source, target in self.ends)

    @cached_property
    def ends(self) -> tuple[tuple[str, str], ...]:
        """("unit.output", "unit.input") of every connection, joined ports by their members."""
        return tuple(pair for connection in self.connections for pair in self.ends_of(connection))

    def ends_of(self, connection: str | ConnectionSettings) -> list[tuple[str, str]]:
        """Of all that one connection stands for; * stays as it is."""
        if not isinstance(connection, str):
            return [(connection.source, connection.target)]
        known = readings(connection, [*self.units, *(contact.name for contact in self.contacts)])
        if len(known) == 1 and known[0].arrow == ARROW:  # asks no unit: the files of a result may be gone
            return [(known[0].source, known[0].target)]
        pairs = expanded_connection(connection, self.coupling.interfaces)
        return [(".".join(source), ".".join(target)) for source, target in pairs]

    def info(self) -> dict[str, Any]:
        """All settings, as run.json has them: ports by their members."""
        settings = self.model_dump(mode="json")
        named: list[Any] = []
        for given, table in zip(self.connections, settings["connections"], strict=True):
            named += [connection(*ends, self.units) for ends in self.ends_of(given)] if isinstance(given, str) else [table]
        return {"name": self.name, **settings, "connections": named}

    def show(self) -> Drawing:
        """Units and connections as SVG: a notebook shows it, `save(path)` writes it to a file."""
        interfaces = self.coupling.interfaces
        signals: dict[tuple[str, str], list[str]] = {}
        ports: dict[tuple[str, str], set[str]] = {}
        for link in (*self.coupling.links, *self.coupling.texts):
            names = (link.source[1], link.target[1])
            signals.setdefault((link.source[0], link.target[0]), []).append(
                names[0] if names[0] == names[1] else " to ".join(names)
            )
            ports.setdefault((link.source[0], link.target[0]), set()).add(
                next(filter(None, (port_of(n, interfaces[u].ports) for u, n in (link.source, link.target))), "")
            )
        boxes = [Box(contact.name, (f"contact, {contact.law}",)) for contact in self.contacts]
        for name, kind in self.kinds.items():
            effects = [e for e, why in interfaces[name].effects.items() if why]
            hint = "\n".join((f"{name}: {interfaces[name].title or kind.label}", *(f"effect {e}" for e in effects)))
            boxes.append(Box(name, (kind.label, ", ".join(effects)), hint))
        return draw(
            boxes,
            (
                Arrow(a, b, tuple(names), "".join(ports[a, b]) if len(ports[a, b]) == 1 else "")
                for (a, b), names in signals.items()
            ),
            self.title or self.name,
        )

    def _repr_html_(self) -> str:
        return f"<b>{escape(self.title or self.name)}</b><br>{self.show()}"

    def __repr__(self) -> str:
        return (
            f"<Scene {self.name}: {', '.join(self.units)}; {len(self.connections)} connections; "
            f"{self.master.algorithm}, step {self.master.step:g} s, "
            f"{f'{self.start_time:g} ' if self.start_time else ''}to {self.stop_time:g} s>"
        )

    __str__ = __repr__

    def analysis_as(self, model: type[Keys]) -> Keys:
        """[analysis] with the keys of one system; where the scene has another, what all systems share and defaults."""
        if isinstance(self.analysis, model):
            return self.analysis
        return model(**{key: getattr(self.analysis, key) for key in AnalysisKeys.model_fields})

    def load_other(self, name_or_path: str | Path) -> Scene:
        """Another scene, which this one names."""
        return load_scene(name_or_path, self.systems)

    def with_changes(self, changes: Mapping[str, Any]) -> Scene:
        """A new, checked scene with some settings replaced, each by its name, see `scene.names`.

        "catenary.damping.alpha", "catenary.effects.steady_arm", "stop_time", "master.step", "units.catenary.preset" ...
        """
        changed = read_scene(changed_settings(self, changes), self.name, remarks=self.remarks, systems=self.systems)
        check_effects(changed, changes, self)
        return changed

    def with_input(self, path: str | Path, *, whole: bool = False) -> Scene:
        """The scene with the columns of a table over time joined to the inputs of their names that nothing drives.

        whole: over the time of the table. Columns and inputs without a partner are a remark. Raises `BadInput`.
        """
        from .inputs import with_columns

        data, remark = with_columns(self, path)
        if whole:
            table = read_signals(path).table
            data |= {"start_time": float(table[0, 0]), "stop_time": float(table[-1, 0])}
        remarks = (*self.remarks, remark) if remark else self.remarks
        return read_scene(data, self.name, remarks=remarks, systems=self.systems)

    def split(self, name: str) -> tuple[str, str]:
        """("unit", "rest") of "unit.rest", see `settings.names`."""
        return split_name(name, self.units)


def load_scene(name_or_path: str | Path, systems: KnownSystems = NO_SYSTEMS, changes: Mapping[str, Any] | None = None) -> Scene:
    """A shipped scene by its name, or a scene file by its path: .toml, .ssd, .ssp or .xml. `systems`: see `read_scene`.

    changes: by name, as of `Scene.with_changes`; those outside of units are judged with what the file says.
    """
    path = scene_path(name_or_path)
    data, remarks = read_file(path, changes or ())
    with loading(str(path), "a scene"):
        return read_changed(data, changes or {}, path.stem, path.parent, remarks, systems)


def read_changed(
    data: Mapping[str, Any],
    changes: Mapping[str, Any],
    name: str,
    folder: Path | None = None,
    remarks: Sequence[str] = (),
    systems: KnownSystems = NO_SYSTEMS,
) -> Scene:
    """As `read_scene`, with changes by name: settings outside of units are judged with what the data say, others after it."""
    own = {key: value for key, value in changes.items() if is_setting(key)}
    scene = read_scene(with_settings(data, own), name, folder, remarks, systems)
    others = {key: value for key, value in changes.items() if key not in own}
    return scene.with_changes(others) if others else scene


def with_settings(data: Mapping[str, Any], changes: Mapping[str, Any]) -> Mapping[str, Any]:
    """Plain data of a scene with settings outside of [units] by their dotted places; None: the default."""
    changed = dict(data)
    for place, value in changes.items():
        *path, last = place.split(".")
        table = changed
        for key in path:
            if not isinstance(inner := table.get(key, {}), Mapping):
                return data  # which is refused when it is read
            table[key] = table = dict(inner)
        if value is None:
            table.pop(last, None)
        else:
            table[last] = value
    return changed


def read_scene(
    data: Mapping[str, Any],
    name: str = "scene",
    folder: Path | None = None,
    remarks: Sequence[str] = (),
    systems: KnownSystems = NO_SYSTEMS,
) -> Scene:
    """A scene from plain data, checked down to every connection. Paths of FMUs and of other scenes are relative to `folder`.

    `remarks`: what its file says that is ignored, for the warnings of its runs.
    `systems`: those that its [analysis] may name.
    """
    data, more = expanded(data, name, folder)
    data = _with_place_of_limits(with_numbers(_prepared(data, name), name), folder)
    try:
        scene = Scene.model_validate({**data, "analysis": _analysis(data.get("analysis", {}), name, systems.models)})
    except ValidationError as error:
        raise one_message(error, Scene, name) from None
    if "analysis" not in data:
        scene.__pydantic_fields_set__.discard("analysis")
    scene._name, scene._remarks, scene._systems = name, (*remarks, *more), systems
    _check_quantities(scene)
    for kind in scene.kinds.values():
        kind.refuse_run(scene.start_time, scene.stop_time, name)
    return scene if scene.limits is None or scene.views is None else scene.views.with_limits(scene)


def _prepared(data: Mapping[str, Any], scene: str) -> Mapping[str, Any]:
    """The data of a scene with what the kinds of its units make of their entries."""
    if not isinstance(units := data.get("units"), Mapping):
        return data
    kinds = {name: kind_of_entry(entry, f"{scene}: units.{name}") for name, entry in units.items()}
    return {**data, "units": {name: units[name] if kind is None else kind.prepared(units[name]) for name, kind in kinds.items()}}


def _with_place_of_limits(data: Mapping[str, Any], folder: Path | None) -> Mapping[str, Any]:
    """The data with the whole path of a table of limits beside the scene."""
    limits = data.get("limits")
    table = limits.get("table") if isinstance(limits, Mapping) else limits
    if folder is None or not isinstance(table, str) or not table.endswith(".toml"):
        return data
    return {**data, "limits": {**(limits if isinstance(limits, Mapping) else {}), "table": str(folder.resolve() / table)}}


def recorded_scene(data: Mapping[str, Any], systems: KnownSystems = NO_SYSTEMS) -> Scene:
    """The scene of which run.json says all settings, for its result: the files that it names may be gone, and are not read."""
    settings, name = dict(data), str(data.get("name"))
    settings.pop("name", None)
    if isinstance(given := settings.get("master"), Mapping):  # a default that is given would be refused where it has no effect
        usual = MasterSettings(step=1.0).model_dump(mode="json", exclude={"step"})
        settings["master"] = {key: value for key, value in given.items() if key not in usual or value != usual[key]}
    try:
        scene = Scene.model_validate({**settings, "analysis": _analysis(settings.get("analysis", {}), name, systems.models)})
    except ValidationError as error:
        raise one_message(error, Scene, name) from None
    scene._name, scene._systems = name, systems
    return scene


def _check_quantities(scene: Scene) -> None:
    """Refuse quantities of interest that no run could have."""
    interfaces = scene.coupling.interfaces
    if not scene.study.quantities:
        return
    outputs = [f"{unit}.{n}" for unit, i in interfaces.items() for n, s in i.outputs.items() if not s.is_text]
    for text in scene.study.quantities:
        if (signal := wanted(text).signal) not in outputs:
            raise BadInput(f"{scene.name}: study.quantities", repr(signal), "an output of a unit", nearest(signal, outputs))


def _analysis(table: Any, name: str, models: Models) -> Any:
    """The table as the model of its system; a key that nothing reads would have no effect, and is an error like a bad value."""
    if not isinstance(table, Mapping):
        return table  # an instance, or what the scene's own model refuses
    system = table.get("system", "")
    if not isinstance(system, str) or system not in {"", *models}:
        raise BadInput(f"{name}: analysis.system", repr(system), "one of " + ", ".join(models), nearest(str(system), models))
    model = models.get(system, AnalysisKeys)
    try:
        return model.model_validate(dict(table))
    except ValidationError as error:
        finding = error.errors()[0]
        if finding["type"] == "extra_forbidden" and len(finding["loc"]) == 1:
            raise _unknown(str(finding["loc"][0]), name, model, models) from None
        raise one_message(error, model, name, "analysis") from None


def _unknown(key: str, name: str, model: type[AnalysisKeys], models: Models) -> BadInput:
    """The message for a key that is not read there."""
    others = [s for s, keys in models.items() if key in keys.model_fields and not issubclass(model, keys)]
    remedy = f"It belongs to system = {' or '.join(map(repr, others))}." if others else nearest(key, model.model_fields)
    return BadInput(f"{name}: analysis", f"key {key!r}", "a key that is read", remedy)


def write_scene(scene: Scene, path: str | Path, remarks: Sequence[str] = ()) -> Path:
    """Write the scene to a .toml file, which `load_scene` reads as the same scene; the remarks stand above it as comments."""
    path = Path(path)
    ensure_directory(path.parent)
    path.write_text(scene_text(scene.settings(), remarks), encoding="utf-8")
    return path


def scene_text(data: Mapping[str, Any], remarks: Sequence[str] = ()) -> str:
    """Settings of a scene as TOML, below the remarks as comments."""
    comments = "".join(f"# {line}\n" for remark in remarks for line in remark.splitlines())
    return comments + ("\n" if remarks else "") + tomli_w.dumps(_without_none(data))


def _without_none(value: Any) -> Any:
    """Tables without the keys that have no value, for which TOML has no word."""
    if isinstance(value, Mapping):
        return {key: _without_none(item) for key, item in value.items() if item is not None}
    return [_without_none(item) for item in value] if isinstance(value, list | tuple) else value
