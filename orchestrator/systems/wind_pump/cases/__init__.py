"""Validation cases of the system, each beside its table; what is listed here is run by `cosimo validate`."""

from __future__ import annotations

from . import closed_forms, equilibrium, inertial_converter, paper_wind_pump, start

CASES = tuple(module.CASE for module in (equilibrium, start, closed_forms, inertial_converter, paper_wind_pump))
