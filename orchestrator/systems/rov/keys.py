"""Keys of [analysis] for scenes of the system rov."""

from __future__ import annotations

from pydantic import Field

from ...settings.analysis import AnalysisKeys, Positive


class RovKeys(AnalysisKeys):
    """Figures of underwater vehicles."""

    headings: Positive | None = Field(default=None, description="s between marks of the heading on the track; else a twentieth")
