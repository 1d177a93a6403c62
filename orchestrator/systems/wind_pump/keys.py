"""Keys of [analysis] for scenes of the system wind_pump."""

from __future__ import annotations

from pydantic import Field

from ...settings.analysis import AnalysisKeys, NotNegative, Positive


class WindPumpKeys(AnalysisKeys):
    """Figures of wind pumps."""

    average: NotNegative = Field(default=0.0, description="s, moving mean of speeds and powers; none without it")
    standstill: Positive = Field(default=0.1, description="rad/s, below which a shaft counts as standing")
    pause: NotNegative = Field(default=10.0, description="s, a shorter standstill between two strokes is no stop")
