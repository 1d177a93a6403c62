"""Validation cases of the system, each beside its table; what is listed here is run by `cosimo validate`."""

from __future__ import annotations

from . import added_mass, allocation, closed_forms, paper_underwater_vehicle

CASES = tuple(module.CASE for module in (closed_forms, allocation, added_mass, paper_underwater_vehicle))
