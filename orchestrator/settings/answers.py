"""What is fitted to measurements, and what is designed: TOML files, or the same as plain data in Python.

    [vary]                                                            # a fit: bounds, and where the search starts
    "spring.stiffness" = { low = 50.0, high = 200.0, start = 80.0 }

    [[curves]]                                                        # as in a case of one's own
    signal = "mass.position"
    file = "measured.csv"
    time = "t"                                                        # columns
    column = "x"
    noise = "2 mm"                                                    # standard deviation of the measurement

    [[targets]]                                                       # measured numbers of a run
    quantity = "mass.position, maximum"
    value = 0.31
    deviation = 0.005

Of several runs, each has its measurements, and what is special to it:

    [[runs]]
    condition = "2 kg"
    changes = { "mass.mass" = "2 kg" }
    vary = { "mass.start_x" = { low = -0.1, high = 0.1 } }           # of this run alone; [vary] is common to all
    curves = [{ signal = "mass.position", file = "heavy.csv", noise = "2 mm" }]

A design has `minimise = "column"` or `maximise`, or lists of columns for a front, [constraints] with
"column" = { low = ..., high = ... }, and `rows` of a table.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, field_validator, model_validator

from ...components.core.errors import BadInput
from .case import CurveSettings, RunSettings
from .measured import Amount, MeasuredColumn
from .model import Model, Number, Positive, Truth
from .plan import KeepSettings, LimitSettings, RowsSettings

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
            raise BadInput(
                "", f"low = {self.low:g}, high = {self.high:g}, start = {self.start}", "low < high, a start between them"
            )
        return self


class FittedCurve(CurveSettings):
    """A measured curve with the standard deviation of its numbers."""

    source: str = Field(default="", description="source of the measurement")
    noise: Amount | None = Field(
        default=None, description='standard deviation of the measurement, "5 mm"; without it that of the fit\'s own residuals'
    )


class SpectrumSettings(MeasuredColumn):
    """A measured spectrum that the spectrum of a signal is compared with, both by the same estimator: Welch's."""

    frequency: str = Field(default="frequency", description="column of the frequency (Hz, or the unit of the header)")
    kind: Literal["power spectral density", "amplitude spectrum"] = Field(
        default="power spectral density", description="unit²/Hz, one-sided; or the amplitude of a sine, in the signal's unit"
    )
    segment: Positive | None = Field(default=None, description="s, length of Welch's segments; default: the whole record")
    overlap: Annotated[float, Field(strict=True, ge=0.0, lt=1.0)] = Field(default=0.5, description="overlap of segments, a share")
    window: Literal["hann", "hamming", "blackman", "flattop", "boxcar"] = Field(
        default="hann", description="window of each segment"
    )
    low: Annotated[float, Field(strict=True, ge=0.0, allow_inf_nan=False)] = Field(default=0.0, description="Hz, from here on")
    high: Positive | None = Field(default=None, description="Hz, up to here")
    logarithmic: Truth = Field(default=True, description="residuals of natural logarithms; false: of the numbers themselves")
    scale: Positive = Field(default=1.0, description="times the measured number gives the signal's unit")
    source: str = Field(default="", description="source of the measurement")
    noise: Positive | None = Field(
        default=None,
        description=(
            "standard deviation of the measured numbers, logarithmic: of their logarithm, that is relative; without it that of the "
            "fit's own residuals"
        ),
    )

    @property
    def estimator(self) -> str:
        """In words."""
        length = f"segments of {self.segment:g} s, overlap {100.0 * self.overlap:g} %" if self.segment else "the whole record"
        return f"Welch, {length}, window {self.window}, mean of each segment removed"


class TargetSettings(Model):
    """A measured number of a run."""

    quantity: str = Field(description='"unit.output, kind", or a figure of summary.json')
    value: Number
    deviation: Positive = Field(description="its standard deviation")


class MeasuredData(Model):
    """What was measured of one run."""

    curves: tuple[FittedCurve, ...] = ()
    spectra: tuple[SpectrumSettings, ...] = ()
    targets: tuple[TargetSettings, ...] = ()

    @property
    def measured(self) -> tuple[FittedCurve | SpectrumSettings, ...]:
        """Curves and spectra."""
        return (*self.curves, *self.spectra)


class MeasuredRun(RunSettings, MeasuredData):
    """One of several runs that are fitted together."""

    input: str = Field(default="", description="CSV over time, beside the plan: its columns drive the inputs of their names")
    vary: dict[str, RangeSettings] = Field(default={}, description="parameters of this run alone")


class FitSettings(MeasuredData):
    """Parameters that are fitted, and what they are fitted to: the measurements of one run, or [[runs]] with theirs."""

    vary: dict[str, RangeSettings] = Field(default={}, description="parameters of all runs")
    runs: tuple[MeasuredRun, ...] = ()
    step: Share = Field(
        default=1e-4, description="step of differences where there are no exact derivatives, a share of the range"
    )
    starts: Starts = Field(default=1, description="searches: from `start`, and from points spread over the bounds")
    seed: Seed = Field(default=0, description="seed of the other starts")
    evaluations: Annotated[int, Field(strict=True, ge=1)] = Field(
        default=50, description="largest number of evaluations of the residuals for each start"
    )

    loss: Literal["linear", "soft_l1", "huber", "cauchy"] = Field(
        default="linear",
        description="of a residual beyond 1.345 standard deviations; all but linear, that is least squares, count outliers less",
    )
    profile: Truth = Field(
        default=False, description="95 % intervals by fits with each parameter held, in the place of those of the Jacobian"
    )

    @property
    def noise_known(self) -> bool:
        """Whether the standard deviations of all measurements are given."""
        return any(r.targets for r in self.each) or all(m.noise is not None for r in self.each for m in r.measured)

    @property
    def each(self) -> tuple[MeasuredRun, ...]:
        """The runs; a plan without [[runs]] is one."""
        return self.runs or (MeasuredRun(condition="", curves=self.curves, spectra=self.spectra, targets=self.targets),)

    @model_validator(mode="after")
    def _has_data(self) -> FitSettings:
        if self.runs and (self.measured or self.targets):
            raise BadInput("", "measurements beside [[runs]]", "each measurement in its run", "Put them into a run.")
        names = [r.condition for r in self.each]
        if twice := next((n for n in names if names.count(n) > 1), None):
            raise BadInput("runs", f"two of the condition {twice!r}", "a condition for each run")
        for run in self.each:
            where = f"runs: {run.condition}" if self.runs else ""
            if not run.measured and not run.targets:
                remedy = "Add [[curves]], [[spectra]] or [[targets]]."
                raise BadInput(where, "neither curves nor targets nor spectra", "measurements", remedy)
            if both := next((n for n in run.vary if n in self.vary), None):
                raise BadInput(f"{where}: vary", f"{both!r}, which [vary] has as well", "a parameter of all runs, or of this one")
        if not (self.vary or any(r.vary for r in self.runs)):
            raise BadInput("vary", "{}", "at least one")
        measured = [m for r in self.each for m in r.measured]
        if any(m.noise is None for m in measured) and (any(r.targets for r in self.each) or len(measured) > 1):
            raise BadInput(
                "runs" if self.runs else "curves" if self.curves else "spectra",
                "several measurements without the noise of each",
                "noise = ... of every one",
                "They have to be weighed against one another.",
            )
        if self.loss != "linear" and not self.noise_known:
            raise BadInput("loss", f"{self.loss!r} without the noise of the measurement", "noise = ...", "It tells outliers.")
        if self.loss != "linear" and self.profile:
            raise BadInput("profile", f"a profile with loss = {self.loss!r}", "loss = 'linear', which is a likelihood")
        return self


class DesignSettings(Model):
    """What is chosen, what is made small or large by it, and what must hold. Several aims make a front."""

    vary: Annotated[dict[str, RangeSettings], Field(min_length=1)]
    minimise: tuple[str, ...] = Field(default=(), description="a column, or a list of columns")
    maximise: tuple[str, ...] = Field(default=(), description="a column, or a list of columns")
    constraints: dict[str, LimitSettings] = {}
    rows: RowsSettings | None = Field(default=None, description="rows of a validation table that must hold as well")
    method: Literal["COBYQA", "SLSQP", "NSGA-II"] | None = Field(
        default=None, description=("COBYQA (default) needs no derivatives; SLSQP for smooth figures; NSGA-II for fronts")
    )
    evaluations: Annotated[int, Field(strict=True, ge=1)] | None = Field(
        default=None, description="runs at most, each start: 200; of a front: 1000"
    )
    population: Annotated[int, Field(strict=True, ge=8, le=10_000)] = Field(
        default=40, description="NSGA-II: runs a generation, and most points that it goes on with"
    )
    starts: Starts = Field(default=1, description="searches: from `start`, and from points spread over the bounds")
    seed: Seed = Field(default=0, description="seed of the other starts and of NSGA-II")
    step: Share = Field(
        default=1e-4, description="SLSQP: of differences where there are no exact derivatives, a share of the range"
    )
    accuracy: Positive = Field(default=1e-4, description="accuracy of the parameters, a share of the range between the bounds")
    keep: KeepSettings = KeepSettings()

    @field_validator("minimise", "maximise", mode="before")
    @classmethod
    def _one_or_several(cls, value: object) -> object:
        return (value,) if isinstance(value, str) else value

    @property
    def aims(self) -> tuple[str, ...]:
        """What is made small, then what is made large."""
        return self.minimise + self.maximise

    @model_validator(mode="after")
    def _has_aims(self) -> DesignSettings:
        if not self.aims:
            raise BadInput("", "neither minimise nor maximise", "one or more columns")
        if len(set(self.aims)) < len(self.aims):
            raise BadInput("", f"aims {', '.join(map(repr, self.aims))}", "each aim once")
        front = len(self.aims) > 1
        count = f"{len(self.aims)} aim{'s' * front}"
        if self.method is not None and front != (self.method == "NSGA-II"):
            raise BadInput("method", f"{self.method!r} with {count}", "'NSGA-II' for several aims, 'COBYQA' or 'SLSQP' for one")
        for key in ("starts", "step", "accuracy") if front else ("population",):
            if key in self.model_fields_set:
                raise BadInput(key, f"no effect with {count}", "", "Remove it.")
        return self
