"""Keys of [analysis] for scenes of the system wrist."""

from __future__ import annotations

from pydantic import Field

from ...settings.analysis import AnalysisKeys, NotNegative


class WristKeys(AnalysisKeys):
    """Figures of wrists and four-bar linkages."""

    postures: tuple[NotNegative, ...] = Field(
        default=(), description=("s, instants at which the hand's posture is tabulated; else where its angles are largest")
    )
