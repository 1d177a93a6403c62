"""Ranges that columns of a run should keep: single ones, and the rows of a validation table.

rows = { table = "en50367", conditions = ["AC above 200 km/h", "AC above 250 km/h"] }   # or limits.toml

[limits]                                                          # of a plan; [constraints] of a design
"pantograph.std" = { high = 40.0 }
"""

from __future__ import annotations

from typing import Literal

from pydantic import Field, model_validator

from ...components.core.errors import BadInput
from .model import Model, Number


class LimitSettings(Model):
    """A column of a run that must stay between two numbers, one or both."""

    low: Number | None = None
    high: Number | None = None
    quantity: str = Field(default="", description="in words, with its condition")
    unit: str = Field(default="", description="of both numbers; one that the column does not have is refused")
    standing: Literal["", "verbatim", "measured", "computed", "inferred", "recalled"] = Field(
        default="", description="where the range comes from; a recalled one is named as such"
    )
    source: str = ""

    @model_validator(mode="after")
    def _limits(self) -> LimitSettings:
        if self.low is None and self.high is None:
            raise BadInput("", "neither low nor high", "one or both")
        if self.low is not None and self.high is not None and not self.low <= self.high:
            raise BadInput("", f"low = {self.low:g}, high = {self.high:g}", "low <= high")
        return self

    @property
    def size(self) -> float:
        """What its numbers are scaled by: the larger one, 1 where both are zero."""
        return max(abs(e) for e in (self.low, self.high) if e is not None) or 1.0

    def keeps(self, value: float, slack: float = 0.0) -> bool:
        """Whether a number lies in the range, its ends and `slack` included; NaN does not."""
        return (self.low is None or value >= self.low - slack) and (self.high is None or value <= self.high + slack)


class RowsSettings(Model):
    """Rows of a validation table."""

    table: str = Field(description="name of a shipped table, or a TOML file with sources and rows, such as a case of one's own")
    conditions: tuple[str, ...] = Field(default=(), description="those that hold; without them all rows of the table")
