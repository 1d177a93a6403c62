"""The inputs of a deep groove bearing that its loads follow from, by name."""

from __future__ import annotations

DISPLACEMENT = ("displacement_x", "displacement_y", "displacement_z", "tilt_x", "tilt_y")
VELOCITY = ("velocity_x", "velocity_y", "velocity_z", "tilt_rate_x", "tilt_rate_y")
EVERYTHING = (*DISPLACEMENT, *VELOCITY, "speed", "thermal_growth.clearance_change")
