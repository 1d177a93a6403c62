"""A measured signal as settings name it: of a case of a user's own, of a fit, of an estimate. One vocabulary for all three."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, TypeVar

import numpy as np
from pydantic import Field, model_validator

from ..renamed import with_new_keys
from .model import Model, Number, Time

NumberOrArray = TypeVar("NumberOrArray", float, np.ndarray)
Amount = float | str  # a number in the SI unit, or a text with its unit, or a share: "12 %"


class MeasuredColumn(Model):
    """A column of a CSV file, beside the plan or the case, and the signal that it has been measured of."""

    FORMER: ClassVar[Mapping[str, str]] = {"ordinate": "column", "deviation": "noise"}  # keys until 0.7

    signal: str = Field(description='"unit.output" of the scene')
    file: str = Field(description="CSV with one line of names, beside this file")
    column: str = Field(
        default="",
        description="column of the signal, in its unit or that of the header, as in F [kN]; default: the signal's name",
    )
    separator: Annotated[str, Field(max_length=1)] = Field(
        default="", description="separator of the columns; default: as in the header"
    )
    scale: Number = Field(
        default=1.0,
        description="times the measured number gives the signal's unit; without it the unit of the header leads there",
    )

    @model_validator(mode="before")
    @classmethod
    def _of_earlier_versions(cls, data: Any) -> Any:
        return with_new_keys(data, cls.FORMER) if isinstance(data, Mapping) else data


class MeasuredSeries(MeasuredColumn):
    """A signal over time."""

    time: str = Field(default="time", description="column of the time (s, or the unit of the header)")
    offset: Number = Field(default=0.0, description="added after the scale")
    shift: Number = Field(default=0.0, description="added to the time, s: the clock of the file starts elsewhere")
    delay: Time = Field(default=0.0, description="s: the sensor shows what was so long before")

    @property
    def lag(self) -> float:
        """How far the time of the file is behind that of the run, s."""
        return self.delay - self.shift

    def scaled(self, value: NumberOrArray) -> NumberOrArray:
        """Values of the signal, of those that were measured."""
        return self.scale * value + self.offset
