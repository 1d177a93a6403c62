"""Wind pump with a self-adjusting transmission: what the harness knows of this system."""

from __future__ import annotations

from ...harness.system import System
from .keys import WindPumpKeys

SYSTEM = System("wind_pump", "Wind pump with a self-adjusting transmission", __name__, WindPumpKeys)
