"""Underwater vehicle with six thrusters: what the harness knows of this system."""

from __future__ import annotations

from pydantic import Field

from ...harness.system import System
from ...settings.analysis import AnalysisKeys, Positive


class RovKeys(AnalysisKeys):
    """Figures of underwater vehicles."""

    headings: Positive | None = Field(default=None, description="s between marks of the heading on the track; else a twentieth")


SYSTEM = System("rov", "Underwater vehicle with six thrusters", __name__, RovKeys)
