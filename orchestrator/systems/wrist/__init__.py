"""Wrist of two rows: what the harness knows of this system."""

from __future__ import annotations

from ...harness.system import System
from .keys import WristKeys

SYSTEM = System("wrist", "Wrist of two rows", __name__, WristKeys)
