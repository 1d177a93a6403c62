"""Ball bearings and their heat: what the harness knows of this system."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from ...harness.system import System
from ...settings.analysis import AnalysisKeys, Positive, Span
from ...settings.model import Model


class RecurrenceKeys(Model):
    """Settings of the recurrence plot and its measures."""

    threshold: Positive = Field(default=1.0, description="Euclidean distance, standard deviations")
    theiler: Annotated[int, Field(strict=True, ge=0)] = Field(default=1, description="samples beside the main diagonal left out")
    interval: Positive | None = Field(default=None, description="time between states; default: some twenty a passing ball")


class BearingKeys(AnalysisKeys):
    """Figures of bearings."""

    bearing: str | tuple[str, ...] = Field(default=(), description="the bearings to show; all of them without it")
    marks: tuple[Literal["outer", "inner", "ball", "cage", "shaft"], ...] = Field(default=(), description="lines in spectra")
    highest_frequency: Positive | None = Field(default=None, description="end of the spectra's axes, Hz")
    envelope_band: Span | None = Field(default=None, description="[from, to] in Hz; the most impulsive band without it")
    recurrence: RecurrenceKeys | None = Field(default=None, description="recurrence plot and measures")


SYSTEM = System("bearings", "Ball bearings and their heat", __name__, BearingKeys)
