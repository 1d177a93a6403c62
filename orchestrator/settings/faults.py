"""Faults on purpose: what a signal or a unit suffers in a window of time."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from ...components.core.errors import BadInput
from .model import Model, Number, Seconds


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
    value: Number | None = Field(default=None, description="of override and offset, in the receiving input's unit of measure")
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
            raise BadInput(
                "end",
                f"{self.end:g} s",
                "none; a lost unit does not come back" if self.kind == "lost" else f"a time after begin, {self.begin:g} s",
            )
        return self
