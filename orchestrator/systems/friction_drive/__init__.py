"""Friction-wheel servo drive: what the harness knows of this system."""

from __future__ import annotations

from ...harness.system import System
from .keys import FrictionDriveKeys

SYSTEM = System("friction_drive", "Friction-wheel servo drive", __name__, FrictionDriveKeys)
