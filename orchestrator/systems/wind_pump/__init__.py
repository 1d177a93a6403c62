"""Wind pump with a self-adjusting transmission: what the harness knows of this system."""

from __future__ import annotations

from pydantic import Field

from ...harness.system import System
from ...settings.analysis import AnalysisKeys, NotNegative, Positive


class WindPumpKeys(AnalysisKeys):
    """Figures of wind pumps."""

    average: NotNegative = Field(default=0.0, description="s, moving mean of speeds and powers; none without it")
    standstill: Positive = Field(default=0.1, description="rad/s, below which a shaft counts as standing")
    pause: NotNegative = Field(default=10.0, description="s, a shorter standstill between two strokes is no stop")


SYSTEM = System("wind_pump", "Wind pump with a self-adjusting transmission", __name__, WindPumpKeys)
