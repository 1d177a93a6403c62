"""A whole scene, and what it says of connections, records and sweeps."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Self

from pydantic import Field, PrivateAttr, SerializeAsAny, WithJsonSchema, field_serializer, field_validator, model_validator

from ...components.core.errors import BadInput
from .analysis import AnalysisKeys
from .contacts import ContactSettings
from .faults import FaultSettings
from .master import MasterSettings
from .model import UNIT_NAME, Model, Number, Seconds, Sweep, Truth
from .ranges import ranged
from .study import StudySettings
from .units import OrSubsystem, UnitSettings

MOST_STEPS = 1e12  # of a run


class ConnectionSettings(Model):
    """A connection that needs more than its two ends: input = factor * output + offset, in the input's unit of measure."""

    source: str = Field(description="unit.output")
    target: str = Field(description="unit.input")
    factor: Number = Field(default=1.0, description="times what the units of measure need")
    offset: Number = Field(default=0.0, description="in the input's unit of measure")
    convert_units: Truth = Field(default=True, description="false: the numbers are handed over whatever the units of measure say")

    @property
    def text(self) -> str:
        """The connection as a plain one is written."""
        return f"{self.source} -> {self.target}"


class RecordSettings(Model):
    """What is kept. Samples are taken at the first macro step not before each multiple of the interval, and at the end.

    A macro step longer than the interval gives one sample each.
    """

    signals: tuple[str, ...] | None = Field(
        default=None, description="unit.output, or unit.array for all its elements; default: all numbers but long arrays"
    )
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

    title: str = Field(default="", description="what reports are headed with")
    stop_time: Seconds = Field(description="s; every run starts at 0")
    connections: tuple[str | ConnectionSettings, ...] = Field(
        default=(), description='"unit.output -> unit.input", * at both ends for all of the same name, or a table with a factor'
    )
    units: dict[Annotated[str, Field(pattern=UNIT_NAME)], Annotated[UnitSettings, OrSubsystem()]] = Field(
        min_length=1, description="by name; components, FMUs and other scenes", json_schema_extra={"additionalProperties": False}
    )
    master: MasterSettings
    record: RecordSettings = RecordSettings()
    contacts: tuple[ContactSettings, ...] = Field(default=(), description="stiff contacts between two units")
    faults: tuple[FaultSettings, ...] = Field(default=(), description="faults on purpose, to test controllers")
    sweep: Sweep = Field(
        default={}, description="unit.parameter = [values] or { from, to, points }; cosimo sweep runs every combination"
    )
    analysis: Annotated[SerializeAsAny[AnalysisKeys], WithJsonSchema({"type": "object"})] = Field(
        default=AnalysisKeys(), description="for sweeps and reports; its keys depend on its `system`"
    )
    study: StudySettings = Field(default=StudySettings(), description="for cosimo accuracy, stability and effects")
    _name: str = PrivateAttr("scene")
    _remarks: tuple[str, ...] = PrivateAttr(())

    @property
    def name(self) -> str:
        """Stem of the file the scene came from."""
        return self._name

    @property
    def remarks(self) -> tuple[str, ...]:
        """What in the scene's file has no effect: parameters that fit nothing, a step that had to be chosen ..."""
        return self._remarks

    @property
    def arrows(self) -> tuple[str, ...]:
        """Every connection as "unit.output -> unit.input"."""
        return tuple(c if isinstance(c, str) else c.text for c in self.connections)

    @field_validator("sweep", mode="before")
    @classmethod
    def _by_full_name(cls, sweep: Any) -> Any:
        return dict(ranged(sweep)) if isinstance(sweep, Mapping) else sweep

    @field_serializer("analysis")
    def _as_given(self, analysis: AnalysisKeys) -> dict[str, Any]:
        return analysis.model_dump(exclude_unset=True)

    @model_validator(mode="after")
    def _lengths_fit(self) -> Self:
        step, stop, record = self.master.step, self.stop_time, self.record
        if step > stop:
            raise BadInput("master.step", f"{step:g} s", f"at most the length of the run, {stop:g} s")
        if stop > MOST_STEPS * step:
            raise BadInput("master.step", f"{step:g} s", f"at least {stop / MOST_STEPS:g} s, which makes {MOST_STEPS:g} steps")
        for label, interval in (("interval", record.interval), ("snapshot_interval", record.snapshot_interval)):
            if interval is not None and interval > stop:
                raise BadInput(f"record.{label}", f"{interval:g} s", f"at most stop_time, {stop:g} s")
        return self

    def settings(self) -> dict[str, Any]:
        """What was given, as plain data; `read_scene` of it gives the scene again."""
        return self.model_dump(exclude_unset=True)
