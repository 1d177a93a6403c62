"""What a scene may say, as frozen, typed models: each fault of a single setting is found here."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import isfinite
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, PrivateAttr, field_validator, model_validator

from components.core.errors import BadInput

Seconds = Annotated[float, Field(strict=True, gt=0.0, allow_inf_nan=False)]
Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Value = bool | int | float | str


class Model(BaseModel):
    """Frozen, and closed to keys it does not know."""

    model_config = ConfigDict(frozen=True, extra="forbid")


class UnitSettings(Model):
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
            numbers = all(isinstance(v, int | float) and not isinstance(v, bool) and isfinite(v) for v in (first, last))
            if len(value) != 3 or not numbers or not isinstance(points, int) or points < 2:
                raise BadInput(name, repr(dict(value)), "{ from = first value, to = last value, points = 2 or more }")
            yield name, np.linspace(float(first), float(last), points).tolist()  # type: ignore[arg-type]


class MasterSettings(Model):
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


class RecordSettings(Model):
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


class SceneSettings(Model):
    """Units, connections, master, records. `scene.Scene` is what they are once checked against the units."""

    title: str = ""
    stop_time: Seconds = Field(description="s; every run starts at 0")
    connections: tuple[str, ...] = Field(
        default=(), description='"unit.output -> unit.input"; * at both ends: all of the same name')
    units: dict[Annotated[str, Field(pattern="^[A-Za-z][A-Za-z0-9_]*$")], UnitSettings] = Field(min_length=1)
    master: MasterSettings
    record: RecordSettings = RecordSettings()
    sweep: dict[str, Annotated[tuple[Number, ...], Field(min_length=1)]] = Field(
        default={}, description="unit.parameter = [values] or { from, to, points }; cosimo sweep runs every combination")
    analysis: dict[str, Any] = Field(default={}, description="for sweeps and reports; keys in orchestrator/analysis/keys.py")
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
    def _lengths_fit(self) -> Self:
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
