"""Underwater vehicle with six thrusters: what the harness knows of this system."""

from __future__ import annotations

from ...harness.system import System
from .keys import RovKeys

SYSTEM = System("rov", "Underwater vehicle with six thrusters", __name__, RovKeys)
