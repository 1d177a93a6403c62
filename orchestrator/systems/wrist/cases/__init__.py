"""Validation cases of the system, each beside its table; what is listed here is run by `cosimo validate`."""

from __future__ import annotations

from . import four_bar, paper_wrist, rules, stiffness

CASES = tuple(module.CASE for module in (rules, four_bar, stiffness, paper_wrist))
