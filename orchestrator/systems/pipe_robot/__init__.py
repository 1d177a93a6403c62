"""Vibration-driven pipe robot: what the harness knows of this system."""

from __future__ import annotations

from pydantic import Field, model_validator

from ....components.core.errors import BadInput
from ...harness.system import System
from ...settings.analysis import AnalysisKeys, NotNegative, Span


class PipeRobotKeys(AnalysisKeys):
    """Figures of pipe robots."""

    average: NotNegative = Field(default=0.0, description="s, of mean speeds; without it the exciter's period")
    detail: Span | None = Field(default=None, description="[from, to] in s, shown in detail; else the last four periods")

    @model_validator(mode="after")
    def _detail_rises(self) -> PipeRobotKeys:
        if self.detail is not None and not self.detail[0] < self.detail[1]:
            raise BadInput("detail", f"[{self.detail[0]:g}, {self.detail[1]:g}]", "an end after the start")
        return self


SYSTEM = System("pipe_robot", "Vibration-driven pipe robot", __name__, PipeRobotKeys)
