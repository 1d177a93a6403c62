"""Wrist of two rows: what the harness knows of this system."""

from __future__ import annotations

from pydantic import Field

from ...harness.system import System
from ...settings.analysis import AnalysisKeys, NotNegative


class WristKeys(AnalysisKeys):
    """Figures of wrists and four-bar linkages."""

    postures: tuple[NotNegative, ...] = Field(
        default=(), description="s, instants at which the hand's posture is tabulated; else where its angles are largest"
    )


SYSTEM = System("wrist", "Wrist of two rows", __name__, WristKeys)
