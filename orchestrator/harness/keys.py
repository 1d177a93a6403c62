"""What a scene's [analysis] may say. A key that nothing reads would have no effect, and is an error like a bad value."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from ...components.core.errors import BadInput, nearest
from ..settings import Model, Number

Positive = Annotated[float, Field(strict=True, gt=0.0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(strict=True, ge=0.0, allow_inf_nan=False)]
Span = tuple[Number, Number]


class SectionKeys(Model):
    """Points of a motion each time an angle passes a multiple of a turn over `turns`."""

    signal: str = Field(default="", description="unit.output, the signal that a sweep keeps")
    angle: str = Field(description="unit.output, an angle in rad")
    turns: Annotated[float, Field(strict=True, gt=0.0, le=1e6)] = Field(default=1.0, description="points a turn of the angle")


class RecurrenceKeys(Model):
    """Settings of the recurrence plot and its measures."""

    threshold: Positive = Field(default=1.0, description="distance, standard deviations")
    theiler: Annotated[int, Field(strict=True, ge=0)] = Field(default=1, description="samples beside the main diagonal left out")
    interval: Positive | None = Field(default=None, description="time between states; default: some twenty a passing ball")


class AnalysisKeys(Model):
    """What every system reads."""

    system: str = Field(default="", description=(
        "which figures the report has: railway, bearings, rotor, rov, friction_drive, pipe_robot, two_axis_joint, wind_pump or "
        "wrist"))
    transient: NotNegative = Field(default=0.0, description="time from the start left out of spectra, orbits, measures, sections")
    section: SectionKeys | None = Field(default=None, description="of a sweep, and in phase planes")


class RailwayKeys(AnalysisKeys):
    """Figures of pantographs under a catenary."""

    window: Span | None = Field(default=None, description="[from, to] in m along the track, for the statistics")
    span: Positive | None = Field(default=None, description="length of a span, m, for marks in the figures")
    droppers: tuple[Number, ...] = Field(default=(), description="positions of the droppers in a span, m")


class BearingKeys(AnalysisKeys):
    """Figures of bearings."""

    bearing: str | tuple[str, ...] = Field(default=(), description="the bearings to show; all of them without it")
    marks: tuple[Literal["outer", "inner", "ball", "cage", "shaft"], ...] = Field(default=(), description="lines in spectra")
    highest_frequency: Positive | None = Field(default=None, description="end of the spectra's axes, Hz")
    envelope_band: Span | None = Field(default=None, description="[from, to] in Hz; the most impulsive band without it")
    recurrence: RecurrenceKeys | None = Field(default=None, description="recurrence plot and measures")


class RotorKeys(AnalysisKeys):
    """Figures of rotors."""

    orders: tuple[Positive, ...] = Field(default=(1.0, 2.0), min_length=1, description="multiples of the speed to draw")
    orbit_windows: tuple[Span, ...] = Field(default=(), description="[[from, to], ...] in s")
    critical_speeds: tuple[Positive, ...] = Field(default=(), description="rad/s, to mark; else from the rotor's matrices")
    campbell_speed: Positive | None = Field(default=None, description="end of the Campbell diagram, rad/s")

    @model_validator(mode="after")
    def _windows_rise(self) -> RotorKeys:
        for low, high in self.orbit_windows:
            if not low < high:
                raise BadInput("orbit_windows", f"[{low:g}, {high:g}]", "an end after the start")
        return self


class WindPumpKeys(AnalysisKeys):
    """Figures of wind pumps."""

    average: NotNegative = Field(default=0.0, description="s, moving mean of speeds and powers; none without it")
    standstill: Positive = Field(default=0.1, description="rad/s, below which a shaft counts as standing")
    pause: NotNegative = Field(default=10.0, description="s, a shorter standstill between two strokes is no stop")


class PipeRobotKeys(AnalysisKeys):
    """Figures of pipe robots."""

    average: NotNegative = Field(default=0.0, description="s, of mean speeds; without it the exciter's period")
    detail: Span | None = Field(default=None, description="[from, to] in s, shown in detail; else the last four periods")

    @model_validator(mode="after")
    def _detail_rises(self) -> PipeRobotKeys:
        if self.detail is not None and not self.detail[0] < self.detail[1]:
            raise BadInput("detail", f"[{self.detail[0]:g}, {self.detail[1]:g}]", "an end after the start")
        return self


class WristKeys(AnalysisKeys):
    """Figures of wrists and four-bar linkages."""

    postures: tuple[NotNegative, ...] = Field(default=(), description=(
        "s, instants at which the hand's posture is tabulated; else where its angles are largest"))


class FrictionDriveKeys(AnalysisKeys):
    """Figures of friction-wheel drives."""

    feed_band: Positive = Field(default=1e-4, description="m, error within which a move of the feed counts as settled")
    rotation_band: Positive = Field(default=0.01, description="rad, the same of the rotation")


class RovKeys(AnalysisKeys):
    """Figures of underwater vehicles."""

    headings: Positive | None = Field(default=None, description="s between marks of the heading on the track; else a twentieth")


KEYS: dict[str, type[AnalysisKeys]] = {
    "railway": RailwayKeys,
    "bearings": BearingKeys,
    "rotor": RotorKeys,
    "rov": RovKeys,
    "wind_pump": WindPumpKeys,
    "friction_drive": FrictionDriveKeys,
    "pipe_robot": PipeRobotKeys,
    "two_axis_joint": AnalysisKeys,
    "wrist": WristKeys,
}


def keys_of(analysis: Mapping[str, Any]) -> type[AnalysisKeys]:
    """The model for this table; raises `BadInput` for a system that is not known."""
    system = analysis.get("system", "")
    if not isinstance(system, str) or system not in {"", *KEYS}:
        raise BadInput("analysis.system", repr(system), "one of " + ", ".join(KEYS), nearest(str(system), KEYS))
    return KEYS.get(system, AnalysisKeys)


def unknown(model: type[Model], key: str) -> BadInput:
    """The message for a key that is not read there."""
    others = [s for s, keys in KEYS.items() if key in keys.model_fields and not issubclass(model, keys)]
    remedy = f"It belongs to system = {' or '.join(map(repr, others))}." if others else nearest(key, model.model_fields)
    return BadInput("analysis", f"key {key!r}", "a key that is read", remedy)
