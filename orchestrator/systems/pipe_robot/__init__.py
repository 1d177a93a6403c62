"""Vibration-driven pipe robot: what the harness knows of this system."""

from __future__ import annotations

from ...harness.system import System
from .keys import PipeRobotKeys

SYSTEM = System("pipe_robot", "Vibration-driven pipe robot", __name__, PipeRobotKeys)
