"""Rotors: what the harness knows of this system."""

from __future__ import annotations

from ...harness.system import System
from .keys import RotorKeys

SYSTEM = System("rotor", "Rotors", __name__, RotorKeys)
