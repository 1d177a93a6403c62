"""Drives: electric motors and their gears."""
