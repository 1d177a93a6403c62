"""Drives: electric motors, and what turns their torque into motion."""
