"""Ball bearings and their heat: what the harness knows of this system."""

from __future__ import annotations

from ...harness.system import System
from .keys import BearingKeys

SYSTEM = System("bearings", "Ball bearings and their heat", __name__, BearingKeys)
