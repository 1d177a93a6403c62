"""Pantograph and catenary: what the harness knows of this system."""

from __future__ import annotations

from ...harness.system import System
from .keys import RailwayKeys

SYSTEM = System("railway", "Pantograph and catenary", __name__, RailwayKeys)
