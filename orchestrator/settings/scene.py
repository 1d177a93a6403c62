"""A whole scene, and its tables of connections, records, stiff contacts, faults and sweeps."""

from __future__ import annotations

from decimal import Decimal
from typing import Annotated, Any, Literal, Self

from pydantic import Field, PrivateAttr, SerializeAsAny, WithJsonSchema, field_serializer, model_validator

from ...components.core.errors import BadInput, nearest
from .analysis import AnalysisKeys
from .document import DocumentSettings
from .explore import ExploreSettings
from .master import MasterSettings
from .model import UNIT_NAME, Model, Number, Positive, Seconds, Sweep, Time, Truth, Whole
from .names import names_in
from .plan import RunLimits
from .study import RUNNING_KINDS, StudySettings
from .units import OrSubsystem, UnitSettings

MOST_STEPS = 1e12  # of a run
Endpoint = Annotated[str, Field(pattern=r"\S\..")]
ShownName = Annotated[str, Field(pattern=r"^[A-Za-z_]\w*$")]  # without a dot, which all other names of a scene's FMU have


class FaultSettings(Model):
    """One fault. Signals suffer it on their way: an output for all that it feeds, an input alone."""

    signal: str = Field(default="", description="unit.output (for all inputs it feeds) or unit.input")
    unit: str = Field(default="", description="lost only: the unit that stops; its outputs stay as they are")
    kind: Literal["override", "offset", "freeze", "drop", "lost"] = Field(
        description=(
            "override: the value instead; offset: the value added; freeze: what it was when the fault began; "
            "drop: the input's start value, as if not connected; lost: the unit takes no more steps"
        )
    )
    value: Number | None = Field(
        default=None, description="value of override and offset, in the unit of measure of the receiving input"
    )
    begin: Annotated[float, Field(strict=True, ge=0.0, allow_inf_nan=False)] = Field(default=0.0, description="s")
    end: Seconds | None = Field(default=None, description="s; default: to the end of the run")

    @model_validator(mode="after")
    def _fits(self) -> FaultSettings:
        if (self.kind == "lost") != bool(self.unit) or (self.kind != "lost") != bool(self.signal):
            raise BadInput(
                "", f"kind = {self.kind!r} with {'unit' if self.unit else 'signal'}", "unit with lost, signal with all others"
            )
        if (self.kind in ("override", "offset")) != (self.value is not None):
            raise BadInput(
                "value",
                "none" if self.value is None else f"{self.value:g}",
                f"{'a value' if self.value is None else 'no value'} for {self.kind}",
            )
        if self.end is not None and (self.kind == "lost" or self.end <= self.begin):
            if self.kind == "lost":
                raise BadInput("end", "a lost unit does not come back", "", "Remove it.")
            raise BadInput("end", f"{self.end:g} s", f"a time after begin, {self.begin:g} s")
        return self


class SideSettings(Model):
    """One of the bodies. Position, velocity, acceleration and force count in the same direction, the same for both bodies."""

    force: Endpoint = Field(description="unit.input that gets the contact's force")
    position: Endpoint = Field(description="unit.output")
    velocity: Endpoint | None = Field(default=None, description="unit.output; needed with inertia, and with damping of the law")
    acceleration: Endpoint | None = Field(
        default=None, description="unit.output, with inertia only: the other forces are then known at once, not by their effect"
    )
    compliance: Endpoint | None = Field(
        default=None, description="unit.output: what the position leaves out, in series with the law, m/N"
    )
    inertia: Positive | None = Field(default=None, description="kg the contact sets in motion, 1/(d acceleration / d force)")
    impedance: Positive | None = Field(default=None, description="or N.s/m, of a body that answers a force by a velocity: a wire")
    degree: Literal[0, 1, 2] | None = Field(
        default=None, description="degree of the polynomial of the other forces on the body; default: master.extrapolation"
    )

    @model_validator(mode="after")
    def _one_model(self) -> SideSettings:
        if (self.inertia is None) == (self.impedance is None):
            raise BadInput(
                "", "neither inertia nor impedance" if self.inertia is None else "both inertia and impedance", "one of them"
            )
        if self.inertia is not None and self.velocity is None:
            raise BadInput("velocity", "none", "the output with the velocity; a body with inertia needs it")
        if self.acceleration is not None and self.inertia is None:
            raise BadInput("acceleration", "no effect for a body with impedance", "", "Remove it.")
        return self


class ContactSettings(Model):
    """A contact: indentation = first position - second position - clearance; the first body presses against the second.

    The force pushes the second body in the direction its position counts, the first one in the opposite one. Every algorithm
    has the law; "interface-model" alone makes use of the bodies' inertia or impedance, of `degree` and of `leader`.
    """

    name: Annotated[str, Field(pattern=UNIT_NAME)] = Field(description="the contact's name; its outputs: force, indentation")
    law: Literal["spring", "unilateral", "hertz"] = Field(
        description=("spring: k g + d g'; unilateral: the same, but never pulling; hertz: k g^1.5 (1 + d g') where g > 0")
    )
    stiffness: Positive = Field(description="N/m; of hertz N/m^1.5")
    damping: Annotated[float, Field(strict=True, ge=0.0, allow_inf_nan=False)] = Field(
        default=0.0, description="N.s/m; of hertz s/m"
    )
    clearance: Number = Field(default=0.0, description="m")
    leader: Literal["first", "second"] | None = Field(
        default=None,
        description=(
            "the body that steps first; the other gets the force that follows from its answer, and what the leader has missed is "
            "handed over in the next step. Default: both at once, with the same force"
        ),
    )
    first: SideSettings
    second: SideSettings

    @model_validator(mode="after")
    def _rates_known(self) -> ContactSettings:
        for label, side in (("first", self.first), ("second", self.second)):
            if self.damping and side.velocity is None:
                raise BadInput(f"{label}.velocity", "none", "the output with the velocity; a law with damping needs it")
        return self


class ConnectionSettings(Model):
    """A connection that needs more than its two ends: input = factor * output + offset, in the input's unit of measure.

    The names of the ends are taken as they are written, whatever is in them. Between units of measure that nothing converts,
    because nobody defines them or because they are of different quantities, factor and offset are the whole of the conversion.
    """

    source: str = Field(pattern=r"\S\..", description="unit.output")
    target: str = Field(pattern=r"\S\..", description="unit.input")
    factor: Number = Field(default=1.0, description="times what the units of measure need")
    offset: Number = Field(default=0.0, description="in the input's unit of measure")
    convert_units: Truth = Field(default=True, description="false: the numbers are handed over whatever the units of measure say")
    map: Annotated[dict[str, bool | Whole | str], Field(min_length=1)] | None = Field(
        default=None,
        description="value of the output -> value of the input, of truth values, whole numbers or members of an enumeration",
    )

    @property
    def text(self) -> str:
        """The connection as a plain one is written."""
        return f"{self.source} -> {self.target}"

    @property
    def scales(self) -> bool:
        """Whether a factor or an offset is given, be they 1 and 0."""
        return bool(self.model_fields_set & {"factor", "offset"})

    @model_validator(mode="after")
    def _one_conversion(self) -> ConnectionSettings:
        if self.map is not None and (self.factor, self.offset) != (1.0, 0.0):
            raise BadInput("map", "map excludes factor and offset", "", "Remove one of them.")
        return self


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


class InterfaceSettings(Model):
    """What the FMU of the whole scene shows, beside what it shows of itself, or under another name."""

    inputs: dict[ShownName, Endpoint] = Field(default={}, description='name = "unit.input" that no connection drives')
    outputs: dict[ShownName, Endpoint] = Field(
        default={},
        description=(
            'name = "unit.output", or of all macro steps after the transient of [analysis] "unit.output, kind"; kinds: '
            + ", ".join(RUNNING_KINDS)
        ),
    )

    @model_validator(mode="after")
    def _fits(self) -> Self:
        if twice := self.inputs.keys() & self.outputs.keys():
            raise BadInput("inputs", f"{min(twice)!r}, an output, too", "names that are unique")
        if "time" in self.inputs or "time" in self.outputs:
            raise BadInput("", "'time'", "another name, as FMI 3.0 has a variable of this name")
        return self


class SceneSettings(Model):
    """Units, connections, master, records. `scene.Scene` is what they are once checked against the units."""

    title: str = Field(default="", description="title of reports")
    stop_time: Time = Field(description="s")
    start_time: Time = Field(default=0.0, description="s; of the first row, and what units are told")
    connections: tuple[str | ConnectionSettings, ...] = Field(
        default=(), description='"unit.output -> unit.input", * at both ends for all of the same name, or a table with a factor'
    )
    units: dict[Annotated[str, Field(pattern=UNIT_NAME)], Annotated[UnitSettings, OrSubsystem()]] = Field(
        min_length=1, description="components, FMUs and other scenes, by name", json_schema_extra={"additionalProperties": False}
    )
    master: MasterSettings
    record: RecordSettings = RecordSettings()
    interface: InterfaceSettings = Field(
        default=InterfaceSettings(), description="inputs and outputs of the FMU that cosimo build --native makes of the scene"
    )
    contacts: tuple[ContactSettings, ...] = Field(default=(), description="stiff contacts between two units")
    correlations: dict[str, Annotated[float, Field(strict=True, ge=-1.0, le=1.0)]] = Field(
        default={},
        description='correlations of tolerances: "unit.parameter, unit.parameter" = coefficient, as a fit gives; others are independent',
    )
    faults: tuple[FaultSettings, ...] = Field(default=(), description="faults on purpose, to test controllers")
    limits: RunLimits = Field(
        default=None,
        description='a table that runs are judged by, "en50367" or a TOML file with sources and rows, or { table, conditions }',
    )
    sweep: Sweep = Field(
        default={}, description="unit.parameter = [values] or { from, to, points }; cosimo sweep runs every combination"
    )
    analysis: Annotated[SerializeAsAny[AnalysisKeys], WithJsonSchema({"type": "object"})] = Field(
        default=AnalysisKeys(), description="settings of key results, sweeps and reports; the keys depend on `system`"
    )
    study: StudySettings = Field(default=StudySettings(), description="settings of cosimo accuracy, stability and effects")
    document: DocumentSettings = Field(default=DocumentSettings(), description="title, author, number of the report")
    explore: ExploreSettings = Field(default=ExploreSettings(), description="sliders and switches of the page of cosimo explore")
    _name: str = PrivateAttr("scene")
    _remarks: tuple[str, ...] = PrivateAttr(())

    @property
    def name(self) -> str:
        """Stem of the scene's file."""
        return self._name

    @property
    def remarks(self) -> tuple[str, ...]:
        """What in the scene's file has no effect: parameters that fit nothing, a step that had to be chosen ..."""
        return self._remarks

    @field_serializer("analysis")
    def _as_given(self, analysis: AnalysisKeys) -> dict[str, Any]:
        return analysis.model_dump(exclude_unset=True)

    @model_validator(mode="after")
    def _lengths_fit(self) -> Self:
        step, length, record = self.master.step, self.duration, self.record
        if not length > 0.0:
            raise BadInput("stop_time", f"{self.stop_time:g} s", f"a time after start_time, {self.start_time:g} s")
        if step > length:
            raise BadInput("master.step", f"{step:g} s", f"at most the length of the run, {length:g} s")
        if length > MOST_STEPS * step:
            raise BadInput("master.step", f"{step:g} s", f"at least {length / MOST_STEPS:g} s, which makes {MOST_STEPS:g} steps")
        if (latest := max(abs(self.start_time), abs(self.stop_time))) > MOST_STEPS * step:
            where, least = "master.step", f"at least {latest / MOST_STEPS:g} s"
            raise BadInput(where, f"{step:g} s", least, f"Times of {latest:g} s have no digits for shorter steps.")
        for label, interval in (("interval", record.interval), ("snapshot_interval", record.snapshot_interval)):
            if interval is not None and interval > length:
                raise BadInput(f"record.{label}", f"{interval:g} s", f"at most the length of the run, {length:g} s")
        return self

    @model_validator(mode="after")
    def _tolerances_correlate(self) -> Self:
        known = [f"{unit}.{name}" for unit, settings in self.units.items() for name in settings.tolerances]
        before: list[set[str]] = []
        for pair in self.correlations:
            names = names_in(pair)
            if set(names) in before:
                raise BadInput("correlations", f"{pair!r} twice", "each pair once, in one order", "Remove one.")
            before.append(set(names))
            if len(names) != 2 or names[0] == names[1] or not set(names) <= set(known):
                raise BadInput(
                    "correlations", repr(pair), '"unit.parameter, unit.parameter", two with tolerances', nearest(pair, known)
                )
        return self

    @property
    def duration(self) -> float:
        """Length of the run, s: the number that the decimals of its start and its end give."""
        return float(Decimal(repr(self.stop_time)) - Decimal(repr(self.start_time)))

    @property
    def counts_from(self) -> float:
        """Time from which on figures count, s: the start and the transient of [analysis] behind it."""
        return self.start_time + self.analysis.transient

    def settings(self) -> dict[str, Any]:
        """What was given, as plain data; `read_scene` of it gives the scene again."""
        data = self.model_dump(exclude_unset=True)
        for unit in data["units"].values():
            if unit.get("signals"):  # of which the component is made again
                unit.pop("component", None)
        return data
