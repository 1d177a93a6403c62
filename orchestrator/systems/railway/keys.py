"""Keys of [analysis] for scenes of the system railway."""

from __future__ import annotations

from pydantic import Field

from ...settings.analysis import AnalysisKeys, Positive, Span
from ...settings.model import Number


class RailwayKeys(AnalysisKeys):
    """Figures of pantographs under a catenary."""

    window: Span | None = Field(default=None, description="[from, to] in m along the track, for the statistics")
    span: Positive | None = Field(default=None, description="length of a span, m, for marks in the figures")
    droppers: tuple[Number, ...] = Field(default=(), description="positions of the droppers in a span, m")
