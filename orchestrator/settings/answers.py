"""What is fitted to measurements, and what is designed: TOML files, or the same as plain data in Python.

    [vary]                                                            # a fit: bounds, and where the search starts
    "spring.stiffness" = { low = 50.0, high = 200.0, start = 80.0 }

    [[curves]]                                                        # as in a case of one's own
    signal = "mass.position"
    file = "measured.csv"
    abscissa = "t"
    ordinate = "x"
    deviation = 0.002                                                 # standard deviation of the measurement

    [[targets]]                                                       # measured numbers of a run
    quantity = "mass.position, maximum"
    value = 0.31
    deviation = 0.005

A design has `minimise = "column"` or `maximise`, [constraints] with "column" = { low = ..., high = ... }, and `rows` of a table.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from ...components.core.errors import BadInput
from .case import CurveSettings
from .limits import LimitSettings, RowsSettings
from .model import Model, Number, Positive
from .plan import KeepSettings

Share = Annotated[float, Field(strict=True, gt=0.0, lt=0.5)]
Starts = Annotated[int, Field(strict=True, ge=1, le=10_000)]
Seed = Annotated[int, Field(strict=True, ge=0)]


class RangeSettings(Model):
    """Bounds of a parameter, and where a search starts: at `start`, else at the scene's own value, else in the middle."""

    low: Number
    high: Number
    start: Number | None = None

    @model_validator(mode="after")
    def _in_order(self) -> RangeSettings:
        if not self.low < self.high or (self.start is not None and not self.low <= self.start <= self.high):
            raise BadInput("", f"low = {self.low:g}, high = {self.high:g}, start = {self.start}",
                           "low < high, a start between them")
        return self


class FittedCurve(CurveSettings):
    """A measured curve with the standard deviation of its numbers."""

    source: str = Field(default="", description="where the measurement comes from")
    deviation: Positive | None = Field(default=None, description=(
        "standard deviation of the measured numbers, in the signal's unit; without it that of the fit's own residuals"))


class TargetSettings(Model):
    """A measured number of a run."""

    quantity: str = Field(description='"unit.output, kind", or a figure of summary.json')
    value: Number
    deviation: Positive = Field(description="its standard deviation")


class FitSettings(Model):
    """Parameters that are fitted, and what they are fitted to."""

    vary: Annotated[dict[str, RangeSettings], Field(min_length=1)]
    curves: tuple[FittedCurve, ...] = ()
    targets: tuple[TargetSettings, ...] = ()
    step: Share = Field(default=1e-4, description="of differences, a share of the range between the bounds")
    starts: Starts = Field(default=1, description="searches: from `start`, and from points spread over the bounds")
    seed: Seed = Field(default=0, description="of the other starts")
    evaluations: Annotated[int, Field(strict=True, ge=1)] = Field(default=50, description="of the residuals, at most, each start")

    @model_validator(mode="after")
    def _has_data(self) -> FitSettings:
        if not self.curves and not self.targets:
            raise BadInput("", "neither curves nor targets", "measurements", "Add [[curves]] or [[targets]].")
        if any(c.deviation is None for c in self.curves) and (self.targets or len(self.curves) > 1):
            raise BadInput("curves", "several measurements without the deviation of each", "deviation = ... of every curve",
                           "They have to be weighed against one another.")
        return self


class DesignSettings(Model):
    """What is chosen, what is made small or large by it, and what must hold."""

    vary: Annotated[dict[str, RangeSettings], Field(min_length=1)]
    minimise: str = ""
    maximise: str = ""
    constraints: dict[str, LimitSettings] = {}
    rows: RowsSettings | None = Field(default=None, description="rows of a validation table that must hold as well")
    method: Literal["COBYQA", "SLSQP"] = Field(
        default="COBYQA", description="COBYQA needs no derivatives; SLSQP for smooth figures")
    evaluations: Annotated[int, Field(strict=True, ge=1)] = Field(default=200, description="at most, each start")
    starts: Starts = Field(default=1, description="searches: from `start`, and from points spread over the bounds")
    seed: Seed = Field(default=0, description="of the other starts")
    step: Share = Field(default=1e-4, description="SLSQP: of differences, a share of the range between the bounds")
    accuracy: Positive = Field(default=1e-4, description="of the parameters, a share of the range between the bounds")
    keep: KeepSettings = KeepSettings()

    @model_validator(mode="after")
    def _one_aim(self) -> DesignSettings:
        if bool(self.minimise) == bool(self.maximise):
            raise BadInput("", "both minimise and maximise" if self.minimise else "neither minimise nor maximise", "one of them")
        return self

