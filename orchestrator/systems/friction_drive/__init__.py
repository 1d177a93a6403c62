"""Friction-wheel servo drive: what the harness knows of this system."""

from __future__ import annotations

from pydantic import Field

from ...harness.system import System
from ...settings.analysis import AnalysisKeys, Positive


class FrictionDriveKeys(AnalysisKeys):
    """Figures of friction-wheel drives."""

    feed_band: Positive = Field(default=1e-4, description="m, error within which a move of the feed counts as settled")
    rotation_band: Positive = Field(default=0.01, description="rad, the same of the rotation")


SYSTEM = System("friction_drive", "Friction-wheel servo drive", __name__, FrictionDriveKeys)
