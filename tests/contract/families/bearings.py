"""Bearings and their heat."""

from __future__ import annotations

from . import Facts

FACTS: dict[str, Facts] = {}
