"""What is estimated from which measurements: a plan, a TOML file or the same as plain data in Python.

    [[measured]]
    signal = "mass.base_x"                            # a recorded output
    file = "position.csv"                             # beside the plan
    column = "position"
    noise = "5 mm"                                    # standard deviation; without it, it is estimated

    [estimated]                                       # parameters, and inputs that nothing drives
    "spring.stiffness" = { deviation = "12 %" }
    "mass.base_force_x" = { deviation = "1 N", walk = "2 N" }

    [states]                                          # of a state: how far it is unknown at first, and disturbed later
    "mass.base_velocity_x" = { deviation = "1 m/s", walk = "0.5 m/s" }

A deviation is one standard deviation: of what is known before the measurement. A walk is the standard deviation of a random walk
after one second; it grows with the square root of time.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from ...components.core.errors import BadInput
from .answers import RangeSettings, Share
from .measured import Amount, MeasuredSeries
from .model import Model, Positive, Truth


class MeasuredSettings(MeasuredSeries):
    """A signal that a sensor has measured."""

    file: str = Field(default="", description="CSV with a line of names, beside the plan; none where data come from Python")
    noise: Amount | None = Field(
        default=None, description='standard deviation of the measurement, "5 mm"; without it, it is estimated'
    )


class EstimatedSettings(Model):
    """A parameter, or an input that nothing drives."""

    start: Amount | None = Field(default=None, description="expected value; default: the scene's")
    deviation: Amount = Field(description='standard deviation of what is expected: in its unit, or a share, "12 %"')
    walk: Amount = Field(default=0.0, description="how far it wanders in 1 s: standard deviation of a random walk; 0: constant")
    memory: Positive | None = Field(
        default=None, description="s: with a walk, the time after which it has forgotten its value and is near its start again"
    )
    low: Amount | None = Field(default=None, description="it stays above; default: what the parameter declares")
    high: Amount | None = Field(default=None, description="it stays below")

    @model_validator(mode="after")
    def _forgets(self) -> EstimatedSettings:
        if self.memory is not None and not self.walk:
            raise BadInput("memory", f"{self.memory:g} s without a walk", "a walk as well")
        return self


class StateSettings(Model):
    """A state, by its name or by an output that is this state alone."""

    deviation: Amount = Field(
        default=0.0, description="standard deviation of its value at the start, beside what parameters make"
    )
    walk: Amount = Field(default=0.0, description="process noise: standard deviation of what is added to it in 1 s")


class EstimateSettings(Model):
    """A plan of `cosimo estimate`."""

    measured: Annotated[tuple[MeasuredSettings, ...], Field(min_length=1)]
    estimated: dict[str, EstimatedSettings] = Field(default={}, description='"unit.parameter" or "unit.input"')
    states: dict[str, StateSettings] = Field(default={}, description='"unit.x[3]", or "unit.output"')
    suspected: tuple[str, ...] | None = Field(
        default=None,
        description='parameters and inputs that the verdict doubts, also "unit.*"; default: those that the measurement sees most',
    )
    figures: tuple[str, ...] = Field(
        default=(), description='"unit.output, kind" beside the headline figures, such as "mass.base_x, maximum"; if smoothed'
    )
    filter: Literal["", "extended", "unscented", "ensemble"] = Field(
        default="", description="default: extended; ensemble where a scene has too many states for it"
    )
    members: Annotated[int, Field(strict=True, ge=8, le=10_000)] = Field(default=60, description="of an ensemble")
    inflation: Annotated[float, Field(strict=True, ge=1.0, le=2.0)] = Field(
        default=1.01, description="of an ensemble: its deviations are multiplied by so much at every update"
    )
    seed: Annotated[int, Field(strict=True, ge=0)] = Field(default=0, description="of an ensemble")
    smooth: Truth = Field(default=True, description="estimates at an instant by the measurements behind it, too")

    @model_validator(mode="after")
    def _once(self) -> EstimateSettings:
        names = [m.signal for m in self.measured]
        if twice := sorted({n for n in names if names.count(n) > 1}):
            raise BadInput("measured", f"{', '.join(twice)} more than once", "each signal once")
        if not (self.estimated or self.states):
            raise BadInput("", "neither [estimated] nor [states]", "something that is not known", "Add a parameter or a state.")
        if self.filter == "ensemble":
            for name, one in self.estimated.items():
                if not one.walk:
                    raise BadInput(
                        f"estimated.{name}",
                        "a constant with an ensemble, whose members would soon agree on a wrong value",
                        "a walk, or another filter",
                    )
        return self


class LikelihoodSettings(EstimateSettings):
    """A plan of `cosimo.likelihood` with process noise: numbers that vary, and the rest as a filter takes it."""

    vary: Annotated[dict[str, RangeSettings], Field(min_length=1)]
    step: Share = Field(default=1e-4, description="of differences, a share of the range")
