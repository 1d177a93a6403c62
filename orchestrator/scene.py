"""Scenes: what is coupled and how, read from TOML into frozen, typed models.

`load_scene` reads and checks; what it returns can be trusted by everything behind it. Every fault is one `BadInput`.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, PrivateAttr, ValidationError, field_validator, model_validator

from components.core.errors import BadInput, nearest

SHIPPED = Path(__file__).parent / "scenes"
Seconds = Annotated[float, Field(strict=True, gt=0.0, allow_inf_nan=False)]
Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Value = bool | int | float | str


class _Model(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class UnitSettings(_Model):
    """One unit: a component of the catalogue (or "module:Class", which always runs in process), or any FMI 2.0 FMU."""

    component: str = Field(default="", description="name in the catalogue, or module:Class")
    fmu: str = Field(default="", description="path to an FMU, relative to the scene's file")
    preset: str = Field(default="", description="published set of parameters of the component")
    effects: tuple[str, ...] = Field(default=(), description="optional physics to switch on")
    parameters: dict[str, Value] = Field(default={}, description="parameters, and values of inputs that no connection drives")

    @field_validator("parameters", mode="before")
    @classmethod
    def _flat(cls, parameters: Any) -> Any:
        return dict(_flattened(parameters)) if isinstance(parameters, Mapping) else parameters

    @model_validator(mode="after")
    def _one_kind(self) -> UnitSettings:
        if bool(self.component) == bool(self.fmu):
            came = "both component and fmu" if self.fmu else "neither component nor fmu"
            raise BadInput("", came, "one of them", 'Write component = "Name" or fmu = "path/to/file.fmu".')
        if self.fmu and self.preset:
            raise BadInput("preset", repr(self.preset), "no preset for an FMU given by its path", "Give its parameters instead.")
        return self


def _flattened(table: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Nested tables and lists as the full names of variables: "effect.name", "name[1]"."""
    for key, value in table.items():
        if isinstance(value, Mapping):
            yield from _flattened(value, f"{prefix}{key}.")
        elif isinstance(value, list | tuple):
            yield from ((f"{prefix}{key}[{i}]", v) for i, v in enumerate(value, 1))
        else:
            yield prefix + key, value


RANGE = ("from", "to", "points")


def _swept(table: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Nested tables of a sweep as full names of parameters, each with its values; ranges as evenly spaced ones."""
    for key, value in table.items():
        name = prefix + key
        if not isinstance(value, Mapping):
            yield name, value
        elif not value.keys() & set(RANGE):
            yield from _swept(value, name + ".")
        else:
            first, last, points = (value.get(k) for k in RANGE)
            numbers = all(isinstance(v, int | float) for v in (first, last))
            if len(value) != 3 or not numbers or not isinstance(points, int) or points < 2:
                raise BadInput(name, repr(dict(value)), "{ from = first value, to = last value, points = 2 or more }")
            yield name, np.linspace(float(first), float(last), points).tolist()  # type: ignore[arg-type]


class MasterSettings(_Model):
    """The algorithm that steps the units and hands values over."""

    algorithm: Literal["jacobi", "gauss-seidel"] = "gauss-seidel"
    step: Seconds = Field(description="macro step, s; the last one is shorter where it does not divide the run")
    extrapolation: Literal[0, 1, 2] = Field(default=1, description="degree of the inputs' polynomial: held, linear, quadratic")
    feedthrough: Literal["fresh", "stale"] = Field(default="fresh", description="do outputs follow inputs within an instant?")
    order: tuple[str, ...] = Field(default=(), description="gauss-seidel only: all units in the order of stepping")

    @model_validator(mode="after")
    def _order_matters(self) -> MasterSettings:
        if self.order and self.algorithm != "gauss-seidel":
            raise BadInput("order", "an order of units", "none; the units of jacobi step all at once", "Remove it.")
        return self


class RecordSettings(_Model):
    """What is kept. Samples are taken at the first macro step not before each multiple of the interval, and at the end."""

    signals: tuple[str, ...] | None = Field(
        default=None, description="unit.output, or unit.array for all its elements; default: all scalar outputs outside arrays")
    interval: Seconds | None = Field(default=None, description="s; default: every macro step")
    snapshots: tuple[str, ...] = Field(default=(), description="unit.array, kept as whole arrays")
    snapshot_interval: Seconds | None = Field(default=None, description="s; default: every macro step")

    @model_validator(mode="after")
    def _interval_has_effect(self) -> RecordSettings:
        if self.snapshot_interval is not None and not self.snapshots:
            raise BadInput("snapshot_interval", f"{self.snapshot_interval:g} s without snapshots", "snapshots = [...] as well")
        return self


class Scene(_Model):
    """Units, connections and master settings; checked when read by `load_scene`, `read_scene` or `with_changes`."""

    title: str = ""
    stop_time: Seconds = Field(description="s; every run starts at 0")
    connections: tuple[str, ...] = Field(
        default=(), description='"unit.output -> unit.input"; * at both ends: all of the same name')
    units: dict[Annotated[str, Field(pattern="^[A-Za-z][A-Za-z0-9_]*$")], UnitSettings] = Field(min_length=1)
    master: MasterSettings
    record: RecordSettings = RecordSettings()
    sweep: dict[str, Annotated[tuple[int | Number, ...], Field(min_length=1)]] = Field(
        default={}, description="unit.parameter = [values] or { from, to, points }; cosimo sweep runs every combination")
    analysis: dict[str, Any] = Field(default={}, description="free table for the analysis of the results")
    _name: str = PrivateAttr("scene")

    @property
    def name(self) -> str:
        """Stem of the file the scene came from."""
        return self._name

    @field_validator("sweep", mode="before")
    @classmethod
    def _by_full_name(cls, sweep: Any) -> Any:
        return dict(_swept(sweep)) if isinstance(sweep, Mapping) else sweep

    @model_validator(mode="after")
    def _lengths_fit(self) -> Scene:
        step, stop, record = self.master.step, self.stop_time, self.record
        if step > stop:
            raise BadInput("master.step", f"{step:g} s", f"at most the length of the run, {stop:g} s")
        for label, interval in (("interval", record.interval), ("snapshot_interval", record.snapshot_interval)):
            if interval is not None and not step <= interval <= stop:
                expected = f"between the macro step, {step:g} s, and stop_time, {stop:g} s"
                raise BadInput(f"record.{label}", f"{interval:g} s", expected)
        return self

    def settings(self) -> dict[str, Any]:
        """What was given, as plain data; `read_scene` of it gives the scene again."""
        return self.model_dump(exclude_unset=True)

    def with_changes(self, changes: Mapping[str, Any]) -> Scene:
        """A new, checked scene with some settings replaced, each by its dotted place.

        "stop_time", "master.step", "units.catenary.effects", "units.catenary.parameters.damping.alpha" ...
        """
        data = self.settings()
        for place, value in changes.items():
            # the name of a parameter may hold dots itself; only the first three are places
            *path, last = place.split(".", 3 if place.startswith("units.") else 1)
            table = data
            for key in path:
                table = table.setdefault(key, {})
                if not isinstance(table, dict):
                    raise BadInput(f"{self.name}: change", repr(place), "the dotted place of a setting", 'Such as "master.step".')
            table[last] = value
        if added := data["units"].keys() - self.units.keys():
            raise BadInput(f"{self.name}: change", f"unit {min(added)!r}", "a unit of the scene", nearest(min(added), self.units))
        return read_scene(data, self.name)


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
    from .coupling import settle

    if folder is not None and isinstance(data.get("units"), dict):
        data = {**data, "units": {n: _located(u, folder) for n, u in data["units"].items()}}
    try:
        scene = Scene.model_validate(data)
    except ValidationError as error:
        raise _one_message(error, name) from None
    scene._name = name
    settle(scene)
    return scene


def _located(unit: Any, folder: Path) -> Any:
    if isinstance(unit, dict) and isinstance(unit.get("fmu"), str):
        return {**unit, "fmu": str((folder / unit["fmu"]).resolve())}
    return unit


_EXPECTED = {
    "missing": "a value", "float_type": "a number", "string_type": "a text", "finite_number": "a finite number",
    "dict_type": "a table", "model_type": "a table", "tuple_type": "a list", "too_short": "at least one",
    "string_pattern_mismatch": "a name of letters, digits and _",
}


def _one_message(error: ValidationError, name: str) -> BadInput:
    """Pydantic's first finding in the form of all other messages."""
    finding = error.errors()[0]
    kind, place, context = finding["type"], [str(p) for p in finding["loc"] if p != "[key]"], finding.get("ctx", {})
    cause = context.get("error")
    if isinstance(cause, BadInput):
        where = ".".join(filter(None, [*place, cause.where]))
        return BadInput(f"{name}: {where}", cause.came, cause.expected, cause.remedy)
    where, last = f"{name}: {'.'.join(place)}", place[-1]
    if kind == "extra_forbidden":
        models: dict[str, type[_Model]] = {"units": UnitSettings, "master": MasterSettings, "record": RecordSettings}
        model = models[place[0]] if len(place) > 1 else Scene
        table = ".".join(place[:-1])
        where = f"{name}: {table}" if table else name
        return BadInput(where, f"unknown key {last!r}", "a known key", nearest(last, model.model_fields))
    if kind == "literal_error":
        came, expected = finding["input"], context["expected"]
        choices = re.findall("'(.*?)'", expected)
        return BadInput(where, repr(came), expected, nearest(came, choices) if isinstance(came, str) else "")
    if kind == "missing":
        return BadInput(where, "nothing", "a value", f"Add {last} = ...")
    if kind in ("greater_than", "greater_than_equal"):
        return BadInput(where, repr(finding["input"]), f"a number greater than {next(iter(context.values())):g}")
    if "parameters" in place:
        return BadInput(f"{name}: {'.'.join(place[:3])}", repr(finding["input"]), "a number, a text or a truth value")
    return BadInput(where, repr(finding["input"]), _EXPECTED.get(kind, finding["msg"]))
