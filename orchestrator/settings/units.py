"""The units of a scene: what is simulated, and how it is run."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Literal

from pydantic import Field, ModelWrapValidatorHandler, PrivateAttr, field_serializer, field_validator, model_validator

from ...components.core.errors import BadInput
from .model import Model, Parameters, Positive, Time, Tolerances

TABLE_KEYS = ("interpolation", "outside", "start")  # of a table of signals: parameters, which are written as keys of the unit
KIND_NAMES = {
    "component": "a component",
    "fmu": "an FMU given by its path",
    "signals": "a table of signals",
    "ardupilot": "an autopilot",
}  # by the key that says so
OF_KINDS = {  # other keys that have an effect for some of them only, and for which
    **dict.fromkeys(TABLE_KEYS, ("signals",)),
    "preset": ("component",),
    **dict.fromkeys(("effects", "every", "isolation"), ("component", "fmu")),
    "time_limit": ("component", "fmu", "ardupilot"),
    **dict.fromkeys(("interface", "solver", "tolerance"), ("fmu",)),
}


def without_home(text: str) -> str:
    """A text for files that are sent on, in which paths below the user's home directory begin with "~"."""
    home = os.path.expanduser("~").rstrip(os.sep)
    return text.replace(home + os.sep, f"~{os.sep}") if home else text


class UnitSettings(Model):
    """One unit: a component of the catalogue (or "module:Class", which always runs in process), any FMU, FMI 2.0 or 3.0, or a table."""

    component: str = Field(default="", description="name in the catalogue, or module:Class")
    fmu: str = Field(default="", description="path to an FMU, relative to the scene's file")
    signals: str = Field(
        default="", description="path to a table over time, whose columns are the outputs: CSV, Parquet, Arrow, MAT 5"
    )
    ardupilot: str = Field(
        default="", description="host and port, as in 127.0.0.1:9002, where packets of ArduPilot's JSON interface arrive"
    )
    interpolation: Literal["linear", "hold", "pchip"] | None = Field(
        default=None,
        description="interpolation of signals between two rows: linear (default), the earlier row, or a cubic without overshoot",
    )
    outside: Literal["refuse", "hold", "repeat"] | None = Field(
        default=None,
        description="values of signals outside the table: an error (default), the nearest row, or a repetition of the table",
    )
    start: Time | None = Field(
        default=None, description="time of the simulation at which the time of the table is 0, s; default: 0"
    )
    preset: str = Field(default="", description="published set of parameters of the component")
    effects: tuple[str, ...] = Field(default=(), description="optional physics to switch on")
    parameters: Parameters = Field(default={}, description="parameters, and values of inputs that no connection drives")
    tolerances: Tolerances = Field(
        default={},
        description='standard deviations of real parameters: "5 N", a number in the unit of the parameter, or "3 %" of it',
    )
    every: Annotated[int, Field(strict=True, ge=1, le=1_000_000_000)] = Field(
        default=1, description="steps with every n-th macro step only, over all n of them; for slow units"
    )
    isolation: Literal["none", "process", "restricted"] = Field(
        default="none",
        description="process: in a worker process of its own, for what may crash and to use several cores; "
        "restricted: there in the sandbox of bubblewrap, with limits, without network, and with files it can only read",
    )
    time_limit: Positive | None = Field(
        default=None,
        description="s of real time to wait: with isolation for the worker in a call, default as long as it takes; "
        "for a packet of an autopilot, default 30",
    )
    interface: Literal["co-simulation", "model-exchange"] | None = Field(
        default=None, description="interface of an FMU that has two; default: co-simulation if available"
    )
    solver: str | None = Field(default=None, description="model-exchange only: CVode, or a method of scipy's solve_ivp")
    tolerance: Positive | None = Field(default=None, description="relative tolerance for the FMU's solver")

    _shapes: dict[str, tuple[int, ...] | None] = PrivateAttr({})

    @property
    def shapes(self) -> Mapping[str, tuple[int, ...] | None]:
        """Shapes of the lists among the parameters, by name; None: rows of different lengths."""
        return self._shapes

    @field_validator("fmu", "signals")
    @classmethod
    def _from_home(cls, path: str) -> str:
        return os.path.expanduser(path)

    @field_serializer("fmu", "signals", when_used="json")
    def _below_home(self, path: str) -> str:
        return without_home(path)

    @model_validator(mode="wrap")
    @classmethod
    def _with_shapes(cls, data: Any, handler: ModelWrapValidatorHandler[UnitSettings]) -> UnitSettings:
        unit = handler(data)
        if isinstance(data, Mapping) and isinstance(parameters := data.get("parameters"), Mapping):
            unit._shapes = dict(_shapes(parameters))
        return unit

    def __eq__(self, other: object) -> bool:
        """Whether all settings are the same, however arrays were written."""
        return isinstance(other, UnitSettings) and self.__dict__ == other.__dict__

    @model_validator(mode="after")
    def _one_kind(self) -> UnitSettings:
        component = "" if self.signals else self.component  # that of a table is made when the scene is read
        given = [k for k, value in zip(KIND_NAMES, (component, self.fmu, self.signals, self.ardupilot), strict=True) if value]
        if len(given) != 1:
            actual = f"both {' and '.join(given)}" if given else "neither component nor fmu nor signals nor ardupilot"
            remedy = 'Write component = "Name", fmu = "path/to/file.fmu" or signals = "path/to/table.csv".'
            raise BadInput("", actual, "one of them", remedy)
        (kind,) = given
        for key, kinds in OF_KINDS.items():
            value = getattr(self, key)
            if kind not in kinds and value != type(self).model_fields[key].default:
                known = " or ".join(KIND_NAMES[k] for k in kinds)
                remedy = "Give its parameters instead." if (key, kind) == ("preset", "fmu") else "Remove it."
                given_value = f"{value!r} has " if isinstance(value, str) else ""
                raise BadInput(key, f"{given_value}no effect for {KIND_NAMES[kind]}, only for {known}", "", remedy)
        if self.isolation == "restricted" and not (self.fmu or ":" in self.component):
            raise BadInput(
                "isolation", "'restricted' for a component of the catalogue", "an FMU or module:Class", 'Write "process".'
            )
        return self


class SubsystemSettings(Model):
    """An entry of `units` that stands for the units, connections and contacts of another scene, as "entry.unit".

    What belongs to that scene's own runs is not taken over: stop time, master, records, faults, sweep, analysis, study.
    """

    scene: str = Field(description="name of a shipped scene, or path to a .toml, .ssd, .ssp or .xml file, relative to this one")
    parameters: Parameters = Field(default={}, description="unit.parameter of the scene, in the place of its own values")


class OrSubsystem:
    """For the JSON schema of a scene file: subsystems stand where units may; they are replaced before a scene is checked."""

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> dict[str, Any]:
        return {"if": {"required": ["scene"]}, "then": SubsystemSettings.model_json_schema(), "else": handler(schema)}


def _shapes(table: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, tuple[int, ...] | None]]:
    """Names of the lists in nested tables, as `flattened` has them, with their shapes."""
    for key, value in table.items():
        if isinstance(value, Mapping):
            yield from _shapes(value, f"{prefix}{key}.")
        elif isinstance(value, list | tuple):
            yield prefix + key, _shape(value)


def _shape(values: Any) -> tuple[int, ...] | None:
    """Of nested lists, None where they are no array."""
    if not isinstance(values, list | tuple):
        return ()
    inner = {_shape(v) for v in values}
    return None if len(inner) != 1 or None in inner else (len(values), *(inner.pop() or ()))
